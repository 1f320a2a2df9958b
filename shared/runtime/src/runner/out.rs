//! What leaves a partition: outputs, checkpoints, progress, status samples.

use super::{HALF_PERMILLE, RunError, Runner};
use crate::checkpoint::{CheckpointParts, Entries};
use crate::config::{Fault, KillPoint};
use crate::inbox::SEQ_ANEW;
use crate::link::Link;
use crate::partition::Outputs;
use crate::trace::Mark;
use telemetry::{Delivery, EVENT, Header, PROGRESS, PartitionId, Progress, Stamps, TICK, TOPICS, Tick, TopicId};
use zerocopy::{FromBytes, IntoBytes};

impl<L: Link> Runner<L> {
    /// Heart-beat: reports progress although nothing happened, and wakes nobody for it.
    ///
    /// # Errors
    /// When the link refuses.
    pub fn beat(&mut self) -> Result<(), RunError> {
        self.link.refresh()?;
        self.report_progress()
    }

    /// Sends a status sample of this partition (command, housekeeping, event).
    ///
    /// # Errors
    /// When the link refuses.
    pub fn publish_status<T: telemetry::Sample>(
        &mut self,
        topic: telemetry::Topic<T>,
        sample: &T,
    ) -> Result<(), RunError> {
        let mut sample = *sample;
        self.send(topic.id, sample.as_mut_bytes(), None)?;
        Ok(())
    }

    pub(super) fn send_outputs(&mut self, tick: &Tick, ended: bool) -> Result<(), RunError> {
        let mut outputs = core::mem::replace(&mut self.outputs, Outputs::without_memory());
        let mut result = Ok(());
        outputs.for_each(|topic, payload| {
            if result.is_ok() {
                result = match topic == EVENT.id {
                    true => self.offer_published(payload),
                    false => self.send(topic, payload, Some(tick.frame)),
                };
            }
        });
        self.outputs = outputs;
        result?;
        if self.pacing.is_some() {
            let mut tick = *tick;
            tick.flags = u64::from(ended);
            for (topic, info) in TOPICS.iter().enumerate() {
                if info.delivery == Delivery::Source {
                    tick.last_seq[topic] = self.seq[topic];
                }
            }
            tick.last_seq[TICK.id] = 0;
            let frame = tick.frame;
            self.send(TICK.id, tick.as_mut_bytes(), Some(frame))?;
        }
        Ok(())
    }

    /// Completes the header and sends; outputs of a frame (not status samples) are kept for a
    /// restart.
    pub(super) fn send(&mut self, topic: TopicId, payload: &mut [u8], frame: Option<u64>) -> Result<(), RunError> {
        if self.began_anew && self.seq[topic] == 0 {
            self.seq[topic] = u64::from(self.epoch) * SEQ_ANEW;
        }
        self.seq[topic] += 1;
        let (header, _) = Header::mut_from_prefix(payload).expect("every sample begins with a header");
        header.layout = TOPICS[topic].layout;
        header.source = self.id.code();
        header.seq = self.seq[topic];
        if let Some(frame) = frame {
            self.outbox.keep(frame, topic, payload);
        }
        let stamps = self.stamps(payload);
        self.corrupt_first(topic, frame, &stamps, payload)?;
        self.link.publish(topic, &stamps, payload)?;
        self.bytes_sent += payload.len() as u64;
        if let Some(log) = self.event_log.as_mut().filter(|_| topic == EVENT.id) {
            log.write(&stamps, payload);
        }
        let is_sensor = TOPICS[topic].delivery == Delivery::Source && topic != TICK.id;
        if let Some(trace) = self.trace.as_mut().filter(|_| !is_sensor) {
            trace.mark(Mark::Send, topic as u64, stamps.sent_ns, self.link.now_ns());
        }
        Ok(())
    }

    pub(super) fn stamps(&self, payload: &[u8]) -> Stamps {
        Stamps { epoch: self.epoch, crc32: telemetry::crc32(payload), sent_ns: self.link.now_ns() }
    }

    pub(super) fn resend(&mut self) -> Result<(), RunError> {
        let outbox = core::mem::take(&mut self.outbox);
        for entry in outbox.entries() {
            let payload = entry.payload();
            let stamps = self.stamps(&payload);
            self.link.publish(entry.topic, &stamps, &payload)?;
        }
        self.outbox = outbox;
        Ok(())
    }

    pub(super) fn checkpoint(&mut self) -> Result<(), RunError> {
        let begin_ns = self.link.now_ns();
        let torn = self.fault_at(KillPoint::Checkpoint, self.frames_done.saturating_sub(1), self.checkpoint_frames);
        if let Some(store) = &mut self.store {
            self.state.clear();
            let partition = self.partition.as_mut().expect("no work is away");
            partition.save(&mut self.state)?;
            let journal = partition.journal();
            store.append(journal)?;
            let checkpoint = CheckpointParts {
                frames: self.frames_done,
                ended: self.finished,
                given_up: &self.given_up,
                seq: &self.seq,
                cursors: self.inbox.cursors(),
                orders: &self.desk.orders,
                outbox: Entries(&self.outbox),
                state: &self.state,
                journal: journal.len() as u64,
            };
            if let (Some(fault), Some(hook)) = (torn, self.fault_hook) {
                let permille = if let Fault::Tear { permille, .. } = fault { permille } else { HALF_PERMILLE };
                store.save_torn(&checkpoint, permille)?;
                hook(&fault);
            }
            store.save(&checkpoint)?;
            if let Some(trace) = &mut self.trace {
                trace.mark(Mark::Checkpoint, self.frames_done, begin_ns, self.link.now_ns());
            }
        }
        self.frames_checkpointed = self.frames_done;
        self.seq_checkpointed = self.seq;
        self.progress_due = true;
        self.send_released()
    }

    /// Of a checkpoint, for which the source may wait.
    pub(super) fn report_checkpoint(&mut self) -> Result<(), RunError> {
        self.report_progress()?;
        if self.pacing.is_none() {
            self.link.wake(PartitionId::SensorSim);
        }
        Ok(())
    }

    fn report_progress(&mut self) -> Result<(), RunError> {
        self.progress_due = false;
        let mut progress = Progress {
            header: Header::at(self.frames_done * self.period_ns),
            partition: self.id.code().into(),
            epoch: self.epoch,
            cycles: self.cycles,
            frames_processed: self.frames_done,
            frames_checkpointed: self.frames_checkpointed,
            working: self.away.is_some().into(),
            out_seq: self.seq_checkpointed,
        };
        self.send(PROGRESS.id, progress.as_mut_bytes(), None)
    }
}
