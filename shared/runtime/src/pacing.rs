//! When a simulated or replayed source may open its next frame (architecture D5).
//!
//! Frame k is opened when every required partition has checkpointed frame k − W. Pacing belongs to
//! the simulated clock, not to the link: `send` never blocks.

use crate::config::RunConfig;
use telemetry::{Command, Delivery, PartitionId, Progress, TOPICS, TOPICS_MAX};

/// Opcode of the command that removes a partition from the required ones.
pub const GIVEN_UP: u32 = 1;

/// The partition that `command` gives up; `None` for another opcode or an unknown partition.
#[must_use]
pub fn given_up(command: &Command) -> Option<PartitionId> {
    let id = u16::try_from(command.argument).ok().and_then(PartitionId::from_code);
    id.filter(|_| command.opcode == GIVEN_UP)
}

/// Required partitions and the frames that they have checkpointed.
pub struct Pacing {
    window: u64,
    required: [bool; PartitionId::COUNT],
    checkpointed: [Option<u64>; PartitionId::COUNT],
    out_seq: [u64; TOPICS_MAX],
}

impl Pacing {
    /// Waits for the required partitions of `run`; none has checkpointed a frame yet.
    #[must_use]
    pub fn new(run: &RunConfig) -> Self {
        let mut required = [false; PartitionId::COUNT];
        for &partition in &run.partitions {
            required[usize::from(partition.code())] = run.is_required(partition);
        }
        Pacing {
            window: run.window_frames,
            required,
            checkpointed: [None; PartitionId::COUNT],
            out_seq: [0; TOPICS_MAX],
        }
    }

    /// Takes a progress report of a required partition. What is checkpointed stays so over
    /// restarts.
    pub fn hear(&mut self, progress: &Progress) {
        let partition = progress.partition as usize;
        let Some(checkpointed) = self.checkpointed.get_mut(partition).filter(|_| self.required[partition]) else {
            return;
        };
        *checkpointed = (*checkpointed).max(Some(progress.frames_checkpointed));
        for (topic, info) in TOPICS.iter().enumerate() {
            if info.delivery == Delivery::Feedback {
                self.out_seq[topic] = self.out_seq[topic].max(progress.out_seq[topic]);
            }
        }
    }

    /// A partition that was given up is not waited for any more, nor are its samples.
    pub fn obey(&mut self, command: &Command) {
        if let Some(lost) = given_up(command) {
            self.lose(lost);
        }
    }

    /// As [`Pacing::obey`], for a partition known to be lost.
    pub fn lose(&mut self, lost: PartitionId) {
        self.required[usize::from(lost.code())] = false;
        for (topic, info) in TOPICS.iter().enumerate() {
            if info.producers == lost.text() {
                self.out_seq[topic] = 0;
            }
        }
    }

    /// Sequence numbers that frame `number` must find, or `None` while a required partition is too
    /// far behind.
    #[must_use]
    pub fn permit(&self, number: u64) -> Option<[u64; TOPICS_MAX]> {
        let ready = |(required, checkpointed): (&bool, &Option<u64>)| {
            !required || checkpointed.is_some_and(|frames| frames.saturating_add(self.window) > number)
        };
        self.required.iter().zip(&self.checkpointed).all(ready).then_some(self.out_seq)
    }
}

#[cfg(test)]
mod tests {
    use super::{GIVEN_UP, Pacing, given_up};
    use crate::config::tests::toy_run;
    use telemetry::PartitionId::{InertialId, Recorder, SensorSim, SloshId};
    use telemetry::{Command, ESTIMATE_SLOSH, HOUSEKEEPING, IMU, PartitionId, Progress, Sample};

    const WINDOW: u64 = 20;

    fn pacing() -> Pacing {
        let mut run = toy_run();
        run.window_frames = WINDOW;
        run.partitions = vec![SensorSim, InertialId, SloshId];
        Pacing::new(&run)
    }

    fn progress(partition: PartitionId, frames_checkpointed: u64) -> Progress {
        Progress { partition: partition.code().into(), frames_checkpointed, ..Progress::zeroed_at(0) }
    }

    fn newest_permitted(pacing: &Pacing) -> Option<u64> {
        (0..1000).filter(|&frame| pacing.permit(frame).is_some()).max()
    }

    #[test]
    fn frame_k_is_opened_when_everybody_has_checkpointed_frame_k_minus_w() {
        let mut pacing = pacing();
        assert_eq!(newest_permitted(&pacing), None, "nobody has been heard");
        pacing.hear(&progress(InertialId, 50));
        assert_eq!(newest_permitted(&pacing), None);
        pacing.hear(&progress(SloshId, 0));
        assert_eq!(newest_permitted(&pacing), Some(WINDOW - 1));
        pacing.hear(&progress(SloshId, 1)); // frame 0 is checkpointed
        assert_eq!(newest_permitted(&pacing), Some(WINDOW));
        pacing.hear(&progress(SloshId, 90));
        assert_eq!(newest_permitted(&pacing), Some(50 + WINDOW - 1), "the slowest decides");
    }

    #[test]
    fn what_was_checkpointed_stays_so_and_strangers_are_not_waited_for() {
        let mut pacing = pacing();
        pacing.hear(&progress(InertialId, 50));
        pacing.hear(&progress(SloshId, 50));
        pacing.hear(&progress(SloshId, 10));
        pacing.hear(&progress(Recorder, 0));
        pacing.hear(&Progress { partition: 4711, ..Progress::zeroed_at(0) });
        assert_eq!(newest_permitted(&pacing), Some(50 + WINDOW - 1));
    }

    #[test]
    fn who_is_given_up_is_waited_for_no_more_and_neither_are_its_results() {
        let mut pacing = pacing();
        pacing.hear(&progress(InertialId, 50));
        let mut last = progress(SloshId, 10);
        last.out_seq[ESTIMATE_SLOSH.id] = 7;
        pacing.hear(&last);
        assert_eq!(pacing.permit(0).map(|seq| seq[ESTIMATE_SLOSH.id]), Some(7));
        pacing.obey(&Command { opcode: GIVEN_UP + 1, argument: u32::from(SloshId.code()), ..Command::zeroed_at(0) });
        assert_eq!(newest_permitted(&pacing), Some(10 + WINDOW - 1), "another command changes nothing");
        pacing.obey(&Command { opcode: GIVEN_UP, argument: u32::from(SloshId.code()), ..Command::zeroed_at(0) });
        assert_eq!(newest_permitted(&pacing), Some(50 + WINDOW - 1));
        assert_eq!(pacing.permit(0).map(|seq| seq[ESTIMATE_SLOSH.id]), Some(0));
        // What it said before its death may still arrive, and history repeats it.
        pacing.hear(&last);
        assert_eq!(pacing.permit(0).map(|seq| seq[ESTIMATE_SLOSH.id]), Some(0), "late progress of who was given up");
    }

    #[test]
    fn a_report_of_the_last_frame_that_there_is_permits_every_frame() {
        let mut pacing = pacing();
        pacing.hear(&progress(InertialId, u64::MAX));
        pacing.hear(&progress(SloshId, u64::MAX));
        assert!(pacing.permit(u64::MAX - 1).is_some());
    }

    #[test]
    fn only_results_are_waited_for_by_sequence_number() {
        let mut pacing = pacing();
        pacing.hear(&progress(InertialId, 5));
        let mut said = progress(SloshId, 5);
        said.out_seq = [9; telemetry::TOPICS_MAX];
        pacing.hear(&said);
        let seq = pacing.permit(0).unwrap();
        assert_eq!((seq[IMU.id], seq[HOUSEKEEPING.id], seq[ESTIMATE_SLOSH.id]), (0, 0, 9));
    }

    #[test]
    fn a_command_names_who_is_given_up_only_with_its_opcode_and_a_known_number() {
        let command = |opcode, argument| Command { opcode, argument, ..Command::zeroed_at(0) };
        assert_eq!(given_up(&command(GIVEN_UP, 2)), Some(SloshId));
        assert_eq!(given_up(&command(GIVEN_UP, 99)), None);
        assert_eq!(given_up(&command(GIVEN_UP, 1 << 16 | 2)), None);
        assert_eq!(given_up(&command(0, 2)), None);
    }
}
