//! Configuration of a run: written once by the process that starts it, read by every partition.

use crate::feed::FeedConfig;
use crate::health::HealthRow;
use crate::orders::StoredCommand;
use crate::recordings::{RecordingLimits, RemovedRecordings};
use crate::rules::EventRule;
use crate::table_store::StoredTable;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use telemetry::{Domain, PartitionId, TopicId};

/// Switches a safeguard off, to show that the tests detect its absence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sabotage {
    #[default]
    None,
    /// A frame takes whatever has arrived instead of what its tick covers.
    DrainByTopic,
    /// A consumer takes sequence numbers it has seen before.
    NoDedupe,
    /// A restarted partition does not send its last outputs again.
    NoOutbox,
    /// A consumer does not check the CRC.
    SkipCrc,
    /// Partitions keep every right that they were started with.
    NoHardening,
}

impl Sabotage {
    /// Values of the command line's option; without it nothing is switched off.
    pub const NAMES: &'static [(&'static str, Sabotage)] = &[
        ("drain-by-topic", Sabotage::DrainByTopic),
        ("no-dedupe", Sabotage::NoDedupe),
        ("no-outbox", Sabotage::NoOutbox),
        ("skip-crc", Sabotage::SkipCrc),
        ("no-hardening", Sabotage::NoHardening),
    ];
}

/// Where in its life a partition is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KillPoint {
    /// Before it has opened a service.
    Connect,
    /// Inside `frame`, before its outputs are sent.
    Frame,
    /// After its outputs were sent, before a checkpoint.
    Publish,
    /// With half a checkpoint written.
    Checkpoint,
}

impl KillPoint {
    /// Values of the command line's option.
    pub const NAMES: &'static [(&'static str, KillPoint)] = &[
        ("connect", KillPoint::Connect),
        ("frame", KillPoint::Frame),
        ("publish", KillPoint::Publish),
        ("checkpoint", KillPoint::Checkpoint),
    ];
}

/// Faults of a drill.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// The partition ends itself with SIGKILL in its first life.
    Kill { partition: PartitionId, frame: u64, point: KillPoint },
    /// The partition stops itself with SIGSTOP in its first life: a hang.
    Hang { partition: PartitionId, frame: u64 },
    /// The partition ends itself with SIGKILL in every life, until it is given up.
    KillAlways { partition: PartitionId, frame: u64 },
    /// The partition ends itself with a segmentation fault in its first life.
    Crash { partition: PartitionId, frame: u64 },
    /// The partition ends itself with a checkpoint of which so many thousandths are written.
    Tear { partition: PartitionId, frame: u64, permille: u32 },
    /// A damaged copy goes out before the good sample: of every inertial sample of that frame, or
    /// of the first one of `topic` from that frame on.
    Corrupt { frame: u64, topic: Option<TopicId> },
    /// The partition reports so many events in every frame.
    Flood { partition: PartitionId, events: u32 },
    /// The partition tries what it has no right to, in its first life.
    Probe { partition: PartitionId },
}

/// A recording, and what can be identified from it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReplayConfig {
    /// File of the recording.
    pub path: PathBuf,
    /// Channel map, as TOML text.
    pub channel_map: Option<String>,
    /// Length of the recording in frames.
    pub frames: u64,
    /// What can be identified from it, with what the scenario knows.
    pub domains: Vec<Domain>,
}

impl ReplayConfig {
    /// Whether the recording has the channels, and the scenario the known values, that `domain`
    /// needs.
    #[must_use]
    pub fn identifies(&self, domain: Domain) -> bool {
        self.domains.contains(&domain)
    }
}

/// One run: a scenario, a seed, and how it is carried out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunConfig {
    /// Text of the scenario: handed on to the partitions, never read here.
    pub scenario: String,
    /// Texts of the files that the scenario names.
    pub files: BTreeMap<String, String>,
    /// Name of the scenario.
    pub name: String,
    /// Length of a frame \[ns\].
    pub period_ns: u64,
    /// Of all noise streams.
    pub seed: u64,
    /// A recording to replay instead of a simulation.
    pub replay: Option<ReplayConfig>,
    /// Real sensors instead of a simulation; `replay` then says for how many frames.
    pub feed: Option<FeedConfig>,
    /// Where the recorder writes.
    pub record: PathBuf,
    /// Where everything is recorded to `record`: results alone go here too, so that a full disk
    /// costs the recording and not the run.
    pub results: Option<PathBuf>,
    /// Everything is recorded, not only results.
    pub record_all: bool,
    /// Folder in which every life of a partition leaves its markers.
    pub trace: Option<PathBuf>,
    /// The warden gives every partition the CPU window of the table of limits: in real time alone.
    #[serde(default)]
    pub windows: bool,
    /// Bound on simulated over real time; `None`: as fast as the slowest partition.
    pub speed: Option<f64>,
    /// Pacing window W \[frames\].
    pub window_frames: u64,
    /// A checkpoint every so many frames.
    pub checkpoint_frames: u64,
    /// Those that the run starts, the source included.
    pub partitions: Vec<PartitionId>,
    /// When the warden restarts a partition, and when it gives one up.
    pub limits: Limits,
    /// Tables in force from the beginning, in the place of declared defaults.
    #[serde(default)]
    pub tables: Vec<StoredTable>,
    /// Folder that keeps activated tables and the reset log beyond the run.
    #[serde(default)]
    pub keep: Option<PathBuf>,
    /// Older recordings that were removed for this one.
    #[serde(default)]
    pub removed: RemovedRecordings,
    /// A stored sequence of commands, in the order of their frames.
    #[serde(default)]
    pub commands: Vec<StoredCommand>,
    /// For tests: the safeguard that is switched off.
    pub sabotage: Sabotage,
    /// For tests: faults that partitions inject into themselves.
    pub faults: Vec<Fault>,
}

/// The warden's table of limits and actions (`deploy/partitions.toml`).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Version of the file's format.
    pub format: u32,
    /// A run that makes no progress this long is ended as failed \[s\].
    pub stall_s: u64,
    /// One row per partition, in any order.
    #[serde(rename = "partition")]
    pub partitions: Vec<PartitionLimits>,
    /// Events that become commands.
    #[serde(default, rename = "rule")]
    pub rules: Vec<EventRule>,
    /// Errors that are worth more than a restart.
    #[serde(default)]
    pub health: Vec<HealthRow>,
    /// What a recording may take.
    #[serde(default)]
    pub recording: RecordingLimits,
}

/// One partition's row.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartitionLimits {
    /// Partition of this row.
    pub name: PartitionId,
    /// Its execution counter stands still this long: it is killed and restarted \[ms\].
    pub hang_ms: u64,
    /// More deaths than this: it is given up ...
    pub restarts_max: u32,
    /// ... when they fall into this time \[s\].
    pub restarts_within_s: u64,
    /// Waits after the first, second, ... life in a row that came to no fresh frame \[ms\]; the
    /// last one repeats. After a life that worked the first one holds.
    pub back_off_ms: Vec<u64>,
    /// What becomes of the run once it is given up.
    pub given_up: GivenUp,
    /// Budget, measured by `obsid budget`; what is not stated is not compared. The partition works
    /// once in this time \[ms\] ...
    pub period_ms: Option<f64>,
    /// ... and takes at most so much of a processor \[µs\].
    pub runtime_us: Option<f64>,
    /// From the moment a frame is due until its outputs are sent \[ms\].
    pub deadline_ms: Option<f64>,
    /// Resident memory \[MB\].
    pub memory_mb: Option<f64>,
    /// Open descriptors.
    pub descriptors: Option<u64>,
}

/// What becomes of a run that has lost a partition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GivenUp {
    /// Its domain is abandoned, the mode table decides.
    GoOn,
    EndRun,
}

impl Limits {
    /// A table whose partitions are all treated alike: five deaths in a minute, then the run goes
    /// on without.
    #[must_use]
    pub fn alike(hang_ms: u64) -> Self {
        let row = |&name: &PartitionId| PartitionLimits {
            name,
            hang_ms,
            restarts_max: 5,
            restarts_within_s: 60,
            back_off_ms: vec![0],
            given_up: GivenUp::GoOn,
            period_ms: None,
            runtime_us: None,
            deadline_ms: None,
            memory_mb: None,
            descriptors: None,
        };
        Limits {
            format: 1,
            stall_s: 60,
            partitions: PartitionId::ALL.iter().map(row).collect(),
            rules: Vec::new(),
            health: Vec::new(),
            recording: RecordingLimits::default(),
        }
    }

    /// The row of `partition`.
    ///
    /// # Panics
    /// When the table has no row for it: callers check [`Limits::missing`] before a run.
    #[must_use]
    pub fn of(&self, partition: PartitionId) -> &PartitionLimits {
        self.partitions.iter().find(|row| row.name == partition).expect("checked before the run")
    }

    /// Time in which a frame of `partition` is to be done \[ns\]; without a row or a deadline,
    /// never missed.
    #[must_use]
    pub fn deadline_ns(&self, partition: PartitionId) -> u64 {
        let row = self.partitions.iter().find(|row| row.name == partition);
        row.and_then(|row| row.deadline_ms).map_or(u64::MAX, |deadline_ms| (deadline_ms * 1e6) as u64)
    }

    /// Why a row of the health table cannot be used.
    ///
    /// # Errors
    /// Names the row, and why it is wrong or never reached.
    pub fn check_health(&self) -> Result<(), String> {
        for row in &self.health {
            row.check()?;
            let is_reached = |own: &PartitionLimits| row.count <= own.restarts_max;
            let mut concerned = self.partitions.iter().filter(|own| row.is_of(own.name)).peekable();
            if concerned.peek().is_some() && !concerned.any(is_reached) {
                let HealthRow { action, level, count, .. } = row;
                return Err(format!(
                    "health row '{action}' of level {level}: count = {count} is never reached: restarts_max is smaller"
                ));
            }
        }
        Ok(())
    }

    /// A partition of the run without a row.
    #[must_use]
    pub fn missing(&self, partitions: &[PartitionId]) -> Option<PartitionId> {
        partitions.iter().copied().find(|id| !self.partitions.iter().any(|row| row.name == *id))
    }
}

impl RunConfig {
    /// Whether the source waits for `partition`.
    #[must_use]
    pub fn is_required(&self, partition: PartitionId) -> bool {
        partition != PartitionId::SensorSim && self.partitions.contains(&partition)
    }

    /// Checks that no consumer can lose samples that pacing allows (architecture D5).
    ///
    /// # Errors
    /// Names the topic whose buffer is too small and the greatest window it allows.
    pub fn check_depths(&self) -> Result<(), String> {
        for topic in telemetry::TOPICS.iter().filter(|topic| topic.per_frame > 0) {
            let window_max = topic.depth as u64 / 2 / topic.per_frame as u64;
            if self.window_frames > window_max {
                return Err(format!(
                    "pacing window of {} frames: topic {} holds {} samples and carries up to {} a frame, so at most {window_max} frames",
                    self.window_frames, topic.name, topic.depth, topic.per_frame
                ));
            }
        }
        if self.checkpoint_frames == 0 || self.checkpoint_frames > self.window_frames {
            return Err(format!(
                "a checkpoint every {} frames: must be 1 to {} (the pacing window), else the source waits for ever",
                self.checkpoint_frames, self.window_frames
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{Fault, KillPoint, Limits, RemovedRecordings, ReplayConfig, RunConfig, Sabotage};
    use std::collections::BTreeMap;
    use telemetry::Domain;
    use telemetry::PartitionId::{InertialId, ModalId, SensorSim, SloshId};

    /// A run of two partitions over an empty scenario.
    pub(crate) fn toy_run() -> RunConfig {
        RunConfig {
            scenario: String::new(),
            files: BTreeMap::new(),
            name: "toy".into(),
            period_ns: 10_000_000,
            seed: 1,
            replay: None,
            feed: None,
            record: "nowhere.mcap".into(),
            record_all: false,
            results: None,
            trace: None,
            windows: false,
            speed: None,
            window_frames: 100,
            checkpoint_frames: 25,
            partitions: vec![SensorSim, InertialId],
            limits: Limits::alike(5000),
            tables: Vec::new(),
            keep: None,
            removed: RemovedRecordings::default(),
            commands: Vec::new(),
            sabotage: Sabotage::None,
            faults: Vec::new(),
        }
    }

    #[test]
    fn a_window_that_a_buffer_cannot_hold_is_refused_with_the_topic_and_the_largest_window() {
        // 2048 samples, 10 a frame: half the buffer is 102 frames (architecture D5).
        assert_eq!(RunConfig { window_frames: 102, ..toy_run() }.check_depths(), Ok(()));
        let refusal = RunConfig { window_frames: 103, ..toy_run() }.check_depths().unwrap_err();
        assert!(refusal.contains("imu") && refusal.contains("at most 102 frames"), "{refusal}");
    }

    #[test]
    fn a_checkpoint_rarer_than_the_window_is_refused() {
        for (checkpoint_frames, good) in [(0, false), (1, true), (100, true), (101, false)] {
            let verdict = RunConfig { checkpoint_frames, ..toy_run() }.check_depths();
            assert_eq!(verdict.is_ok(), good, "{checkpoint_frames}: {verdict:?}");
        }
    }

    #[test]
    fn the_source_waits_for_everybody_who_takes_part_but_not_for_itself() {
        let run = toy_run();
        assert!(run.is_required(InertialId) && !run.is_required(SensorSim) && !run.is_required(SloshId));
    }

    #[test]
    fn what_one_process_writes_another_reads_equal() {
        let run = RunConfig {
            seed: u64::MAX,
            replay: Some(ReplayConfig {
                path: "in.csv".into(),
                channel_map: Some("a = \"b\"".into()),
                frames: 7,
                domains: vec![Domain::Inertial, Domain::Modal],
            }),
            speed: Some(0.1),
            sabotage: Sabotage::NoOutbox,
            faults: vec![
                Fault::Kill { partition: ModalId, frame: 3, point: KillPoint::Checkpoint },
                Fault::Hang { partition: SloshId, frame: 4 },
                Fault::KillAlways { partition: SloshId, frame: 5 },
                Fault::Crash { partition: SloshId, frame: 5 },
                Fault::Tear { partition: ModalId, frame: 5, permille: 999 },
                Fault::Corrupt { frame: 6, topic: Some(3) },
            ],
            ..toy_run()
        };
        let text = serde_json::to_string(&run).unwrap();
        let back: RunConfig = serde_json::from_str(&text).unwrap();
        assert_eq!(format!("{back:?}"), format!("{run:?}"));
    }

    #[test]
    fn scenario_and_files_come_through_the_configuration_byte_for_byte() {
        // Processes read them from this file, lockstep from memory: their numbers must be the same.
        let text = (0..128_u8).map(char::from).chain("\u{85}\u{2028}\u{feff}µ°€𝄞\r\n".chars()).collect::<String>();
        let files = BTreeMap::from([(text.clone(), text.clone()), ("tank".into(), "0.1 + 0.2".into())]);
        let run = RunConfig { scenario: text, files, ..toy_run() };
        let back: RunConfig = serde_json::from_str(&serde_json::to_string(&run).unwrap()).unwrap();
        assert_eq!((back.scenario, back.files), (run.scenario, run.files));
    }

    #[test]
    fn names_of_sabotage_and_kill_points_are_those_of_the_file() {
        for (name, sabotage) in Sabotage::NAMES {
            assert_eq!(serde_json::to_string(sabotage).unwrap(), format!("\"{name}\""));
        }
        for (name, point) in KillPoint::NAMES {
            assert_eq!(serde_json::to_string(point).unwrap(), format!("\"{name}\""));
        }
    }

    #[test]
    fn a_key_that_does_not_exist_is_refused() {
        assert!(serde_json::from_str::<Limits>(r#"{"hang_s":3}"#).is_err());
    }
}
