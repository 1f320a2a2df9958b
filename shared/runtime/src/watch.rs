//! The supervisor's process as health monitor: hangs by execution counter, and its pipe to the
//! warden.
//!
//! Lines to the warden (standard output): `READY`, `STATUS frame mode`,
//! `HANG partition epoch silent_ms`, `SILENT partition` (never heard), `WAITS who waits for whom`,
//! `WORKS partition` (a frame left it work: no frame is done, and nothing is wrong).
//! Lines from it (standard input): `LOST partition`, `STARVED partition` (no hang: it got no
//! processor), `RENEWED partition` (a new life has begun that has not been heard), `HEALTH codes`
//! (what was done about an error), `SAFE` (the vehicle is to be made safe). Wall-clock only:
//! nothing here enters an estimate, and nothing waits on a partition.

use crate::RunConfig;
use crate::health::HealthAct;
use crate::sys::LineWriter;
use crossbeam::channel::{Receiver, unbounded};
use std::fmt::Write;
use std::io::BufRead;
use std::time::{Duration, Instant};
use telemetry::{PartitionId, Progress};

/// Less than a beat, so that every waking says something: three missed ones are the supervisor's
/// own hang.
const STATUS_EVERY: Duration = Duration::from_millis(40);
/// No partition did a frame for so long: who waits for whom is said, and again each time.
const STILL: Duration = Duration::from_secs(1);

/// Of a line to the warden.
const LINE_BYTES: usize = 1024;

struct Pulse {
    id: PartitionId,
    cycles: u64,
    epoch: u32,
    changed: Instant,
    reported: bool,
    heard: bool,
    lost: bool,
    limit: Duration,
    frames: u64,
    checkpointed: u64,
    working: bool,
}

/// What the warden has said since the last turn.
#[derive(Debug, Default)]
pub struct Told {
    /// Partitions that were given up.
    pub lost: Vec<PartitionId>,
    /// What was done about errors.
    pub acts: Vec<HealthAct>,
    /// The vehicle is to be made safe.
    pub safe: bool,
}

/// Watches the execution counters of all partitions.
pub struct HangWatch {
    pulses: Vec<Pulse>,
    last_status: Instant,
    /// When a partition last did a frame, or its standing still was last said.
    moved: Instant,
    line: String,
    orders: Receiver<String>,
    pipe: LineWriter,
}

impl HangWatch {
    /// Watches every partition of `run` but the supervisor, with its `hang_ms` as the limit, and
    /// starts a thread that reads the warden's orders from standard input.
    #[must_use]
    pub fn new(run: &RunConfig) -> Self {
        let (sender, orders) = unbounded();
        // A thread, because standard input blocks; it owns nothing but the channel.
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        let now = Instant::now();
        let pulse = |&id: &PartitionId| Pulse {
            id,
            cycles: 0,
            epoch: 0,
            changed: now,
            reported: false,
            heard: false,
            lost: false,
            limit: Duration::from_millis(run.limits.of(id).hang_ms),
            frames: 0,
            checkpointed: 0,
            working: false,
        };
        let others = run.partitions.iter().filter(|id| **id != PartitionId::Supervisor);
        HangWatch {
            pulses: others.map(pulse).collect(),
            last_status: now,
            moved: now,
            line: String::with_capacity(LINE_BYTES),
            orders,
            pipe: LineWriter::default(),
        }
    }

    /// Reports to the warden that all services exist, so that it starts the other partitions.
    pub fn say_ready(&mut self) {
        self.pipe.say("READY", false);
    }

    /// Takes the progress reports `heard`; reports hangs and status; returns what the warden has
    /// said since.
    pub fn turn(&mut self, heard: &[Progress], frame: u64, mode: &str) -> Told {
        for progress in heard {
            self.hear(progress);
        }
        for pulse in &mut self.pulses {
            if pulse.reported || pulse.lost || pulse.changed.elapsed() < pulse.limit {
                continue;
            }
            if pulse.heard {
                pulse.reported = true;
                let silent_ms = pulse.changed.elapsed().as_secs_f64() * 1e3;
                let line = written(&mut self.line, format_args!("HANG {} {} {silent_ms:.1}", pulse.id, pulse.epoch));
                self.pipe.say(line, false);
            } else {
                // Starting, or hanging since before this supervisor came: the warden knows how long
                // it has lived.
                pulse.changed = Instant::now();
                self.pipe.say(written(&mut self.line, format_args!("SILENT {}", pulse.id)), false);
            }
        }
        if self.last_status.elapsed() >= STATUS_EVERY {
            self.last_status = Instant::now();
            self.pipe.say(written(&mut self.line, format_args!("STATUS {frame} {mode}")), true);
            for worker in workers(&self.pulses) {
                self.pipe.say(written(&mut self.line, format_args!("WORKS {worker}")), true);
            }
        }
        if self.moved.elapsed() >= STILL {
            self.moved = Instant::now();
            let mut line = core::mem::take(&mut self.line);
            self.pipe.say(self.who_waits(frame, &mut line), true);
            self.line = line;
        }
        self.told()
    }

    /// Takes the lines of the warden that have come.
    pub fn told(&mut self) -> Told {
        let mut told = Told::default();
        for line in self.orders.try_iter() {
            told.lost.extend(line.strip_prefix("LOST ").and_then(PartitionId::named));
            told.acts.extend(HealthAct::parse(&line));
            told.safe |= line == "SAFE";
            let starved = line.strip_prefix("STARVED ").and_then(PartitionId::named);
            let renewed = line.strip_prefix("RENEWED ").and_then(PartitionId::named);
            for pulse in &mut self.pulses {
                if [starved, renewed].contains(&Some(pulse.id)) {
                    (pulse.reported, pulse.changed) = (false, Instant::now());
                    pulse.heard &= renewed != Some(pulse.id);
                }
            }
        }
        for pulse in &mut self.pulses {
            pulse.lost |= told.lost.contains(&pulse.id);
        }
        told
    }

    /// The source waits for the slowest checkpoint, everybody behind the source for its samples.
    fn who_waits<'a>(&self, own_frame: u64, text: &'a mut String) -> &'a str {
        let source = self.pulses.iter().find(|pulse| pulse.id == PartitionId::SensorSim);
        let opened = source.map_or(own_frame, |pulse| pulse.frames);
        let others = || self.pulses.iter().filter(|pulse| pulse.id != PartitionId::SensorSim && !pulse.lost);
        text.clear();
        text.push_str("WAITS");
        if let Some(slowest) = others().min_by_key(|pulse| pulse.checkpointed) {
            let _ = write!(
                text,
                " sensor-sim at frame {opened} waits for {}, checkpointed to frame {}",
                slowest.id, slowest.checkpointed
            );
        }
        for behind in others().filter(|pulse| pulse.frames < opened) {
            let _ = write!(text, "; {} at frame {} waits for samples", behind.id, behind.frames);
        }
        if own_frame < opened {
            let _ = write!(text, "; supervisor at frame {own_frame} waits for samples");
        }
        text
    }

    fn hear(&mut self, progress: &Progress) {
        let Some(pulse) = self.pulses.iter_mut().find(|pulse| u32::from(pulse.id.code()) == progress.partition) else {
            return;
        };
        if progress.frames_processed != pulse.frames {
            self.moved = Instant::now();
        }
        (pulse.frames, pulse.checkpointed) = (progress.frames_processed, progress.frames_checkpointed);
        pulse.working = progress.working == 1;
        if (progress.epoch, progress.cycles) > (pulse.epoch, pulse.cycles) || !pulse.heard {
            pulse.reported &= progress.epoch == pulse.epoch;
            (pulse.epoch, pulse.cycles, pulse.heard, pulse.changed) =
                (progress.epoch, progress.cycles, true, Instant::now());
        }
    }
}

/// Who does work that a frame left.
fn workers(pulses: &[Pulse]) -> impl Iterator<Item = PartitionId> {
    pulses.iter().filter(|pulse| pulse.working && !pulse.lost).map(|pulse| pulse.id)
}

/// `text` in the room of `line`.
fn written<'a>(line: &'a mut String, text: std::fmt::Arguments<'_>) -> &'a str {
    line.clear();
    let _ = line.write_fmt(text);
    line
}

#[cfg(test)]
mod tests {
    use super::{HangWatch, workers};
    use crate::config::tests::toy_run;
    use std::time::Duration;
    use telemetry::PartitionId::{InertialId, SensorSim};
    use telemetry::{PartitionId, Progress, Sample};

    /// A watch with no patience: whoever does not advance between two turns hangs.
    fn watch() -> HangWatch {
        let mut run = toy_run();
        run.limits.partitions.iter_mut().for_each(|row| row.hang_ms = 0);
        HangWatch::new(&run)
    }

    fn be_patient(watch: &mut HangWatch, limit: Duration) {
        watch.pulses.iter_mut().for_each(|pulse| pulse.limit = limit);
    }

    fn beat(partition: PartitionId, epoch: u32, cycles: u64) -> Progress {
        Progress { partition: partition.code().into(), epoch, cycles, ..Progress::zeroed_at(0) }
    }

    /// Who has been reported, after a turn in which `heard` came.
    fn reported(watch: &mut HangWatch, heard: &[Progress]) -> Vec<PartitionId> {
        assert!(watch.turn(heard, 0, "").lost.is_empty());
        watch.pulses.iter().filter(|pulse| pulse.reported).map(|pulse| pulse.id).collect()
    }

    #[test]
    fn who_was_never_heard_is_starting_and_does_not_hang() {
        assert_eq!(reported(&mut watch(), &[]), []);
    }

    #[test]
    fn an_execution_counter_that_stands_still_is_a_hang_and_its_repetition_is_no_sign_of_life() {
        let mut watch = watch();
        watch.hear(&beat(InertialId, 0, 5));
        be_patient(&mut watch, Duration::from_secs(3600));
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 5)]), []);
        be_patient(&mut watch, Duration::ZERO);
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 5), beat(InertialId, 0, 4)]), [InertialId]);
    }

    #[test]
    fn a_restarted_partition_is_watched_anew_although_its_counter_is_small() {
        let mut watch = watch();
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 500)]), [InertialId]);
        be_patient(&mut watch, Duration::from_secs(3600));
        assert_eq!(reported(&mut watch, &[beat(InertialId, 1, 1)]), []);
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 501)]), [], "an old life says nothing");
        be_patient(&mut watch, Duration::ZERO);
        assert_eq!(reported(&mut watch, &[]), [InertialId]);
    }

    #[test]
    fn who_got_no_processor_is_reported_again_when_it_stays_silent() {
        let mut watch = watch();
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 5)]), [InertialId]);
        let (sender, orders) = crossbeam::channel::unbounded();
        watch.orders = orders;
        sender.send("STARVED inertial-id".into()).unwrap();
        be_patient(&mut watch, Duration::from_secs(3600));
        assert_eq!(reported(&mut watch, &[]), []);
        be_patient(&mut watch, Duration::ZERO);
        assert_eq!(reported(&mut watch, &[]), [InertialId]);
    }

    #[test]
    fn who_hung_in_a_life_that_is_over_is_starting_again_and_its_silence_is_said() {
        let mut watch = watch();
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 5)]), [InertialId]);
        let (sender, orders) = crossbeam::channel::unbounded();
        watch.orders = orders;
        sender.send("RENEWED inertial-id".into()).unwrap();
        assert_eq!(reported(&mut watch, &[]), []);
        assert!(!watch.pulses.iter().any(|pulse| pulse.heard), "the warden decides by the age of that life");
        assert_eq!(reported(&mut watch, &[beat(InertialId, 1, 1)]), [InertialId]);
    }

    #[test]
    fn a_run_that_stands_still_says_who_waits_for_whom() {
        let mut watch = watch();
        watch.hear(&Progress { frames_processed: 130, ..beat(SensorSim, 0, 1) });
        watch.hear(&Progress { frames_processed: 40, frames_checkpointed: 30, ..beat(InertialId, 0, 1) });
        assert_eq!(
            watch.who_waits(130, &mut String::new()),
            "WAITS sensor-sim at frame 130 waits for inertial-id, checkpointed to frame 30; \
             inertial-id at frame 40 waits for samples"
        );
    }

    #[test]
    fn who_works_beside_its_loop_says_so_until_it_is_done() {
        let mut watch = watch();
        watch.hear(&Progress { working: 1, ..beat(InertialId, 0, 1) });
        assert_eq!(workers(&watch.pulses).collect::<Vec<_>>(), [InertialId]);
        watch.hear(&beat(InertialId, 0, 2));
        assert_eq!(workers(&watch.pulses).count(), 0);
    }

    #[test]
    fn who_is_given_up_is_watched_no_more() {
        let mut watch = watch();
        watch.pulses.iter_mut().find(|pulse| pulse.id == InertialId).unwrap().lost = true;
        assert_eq!(reported(&mut watch, &[beat(InertialId, 0, 1), beat(SensorSim, 0, 1)]), [SensorSim]);
    }
}
