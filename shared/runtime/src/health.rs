//! The health table: what is done about an error, by its kind and by how many there were.
//!
//! As in ARINC 653 an error counts by itself (level process), with the errors of its partition, or
//! with those of the whole run (module). Who ends is restarted; a row makes more of it: a cold
//! restart, the mode SAFE, the end of the partition or of the run. A row that has acted counts anew
//! after its cool-down, and acts so often at most: what comes then rises to the next row.

use serde::{Deserialize, Serialize};
use telemetry::{HealthAction, HealthError, HealthLevel, PartitionId, Severity};

const NS_PER_S: f64 = 1e9;
/// A row remembers so many errors.
const COUNT_MAX: u32 = 1000;
/// Longest time of a row: eleven days.
const SECONDS_MAX: f64 = 1e6;

/// A row `[[health]]` of the table of limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HealthRow {
    /// What an error is counted with.
    pub level: HealthLevel,
    /// Whose; without it the row holds for each partition by itself.
    pub partition: Option<PartitionId>,
    /// Which; without it any.
    pub error: Option<HealthError>,
    /// So many of them ...
    #[serde(default = "one")]
    pub count: u32,
    /// ... within this time \[s\].
    #[serde(default = "minute")]
    pub within_s: f64,
    /// What is done then.
    pub action: HealthAction,
    /// Until the row counts again \[s\].
    #[serde(default)]
    pub cool_down_s: f64,
    /// The row acts at most so often in a run.
    pub acts_max: Option<u32>,
}

const fn one() -> u32 {
    1
}

const fn minute() -> f64 {
    60.0
}

/// Whether a partition holds nothing but knowledge, which priors can replace. The source has the
/// run's time, the supervisor its decisions, the recorder its file.
#[must_use]
pub const fn can_restart_cold(id: PartitionId) -> bool {
    use PartitionId::{Diagnosis, InertialId, ModalId, Recorder, SensorSim, SloshId, Supervisor};
    match id {
        InertialId | SloshId | ModalId | Diagnosis => true,
        SensorSim | Supervisor | Recorder => false,
    }
}

impl HealthRow {
    /// Why it cannot be used.
    ///
    /// # Errors
    /// Names the key, the value and what it may be.
    pub fn check(&self) -> Result<(), String> {
        use HealthAction::{ColdRestart, GiveUp, Restart, SafeMode};
        let HealthRow { level, action, count, .. } = *self;
        let wrong = |why: String| Err(format!("health row '{action}' of level {level}: {why}"));
        if action == Restart {
            return wrong("every error has it without a row".into());
        }
        if level == HealthLevel::Module {
            if self.partition.is_some() {
                return wrong("no partition: the row counts the errors of all".into());
            }
            if matches!(action, ColdRestart | GiveUp) {
                return wrong(format!("the action must be '{SafeMode}' or '{}'", HealthAction::EndRun));
            }
        } else if self.error == Some(HealthError::Stall) {
            return wrong("a stall is an error of the module".into());
        }
        if let Some(id) = self.partition.filter(|id| action == ColdRestart && !can_restart_cold(*id)) {
            return wrong(format!("{id} holds what no prior replaces"));
        }
        let counts = if level == HealthLevel::Process { 1..=1 } else { 1..=COUNT_MAX };
        if !counts.contains(&count) {
            return wrong(format!("count = {count}: must be {} to {}", counts.start(), counts.end()));
        }
        if self.acts_max == Some(0) {
            return wrong("acts_max = 0: must be 1 or more".into());
        }
        for (name, value, is_valid) in [
            ("within_s", self.within_s, self.within_s > 0.0 && self.within_s <= SECONDS_MAX),
            ("cool_down_s", self.cool_down_s, self.cool_down_s >= 0.0 && self.cool_down_s <= SECONDS_MAX),
        ] {
            if !is_valid {
                return wrong(format!("{name} = {value}: must be at most 1e6 s, and not negative"));
            }
        }
        Ok(())
    }

    /// Whether errors of `partition` by themselves make the row act.
    pub(crate) fn is_of(&self, partition: PartitionId) -> bool {
        let can_act = self.action != HealthAction::ColdRestart || can_restart_cold(partition);
        self.level != HealthLevel::Module && self.partition.is_none_or(|id| id == partition) && can_act
    }
}

/// A row at work: for one partition, or for the module.
struct Watched {
    row: HealthRow,
    /// Of errors, the oldest first \[ns\].
    times: Vec<u64>,
    armed_ns: u64,
    acts: u32,
}

impl Watched {
    fn new(row: &HealthRow, partition: Option<PartitionId>) -> Self {
        Watched { row: HealthRow { partition, ..row.clone() }, times: Vec::new(), armed_ns: 0, acts: 0 }
    }

    /// Counts an error; whether the row acts on it.
    fn hear(&mut self, partition: Option<PartitionId>, error: HealthError, now_ns: u64) -> bool {
        let row = &self.row;
        let concerned = (row.level == HealthLevel::Module || row.partition == partition)
            && row.error.is_none_or(|of_row| of_row == error)
            && now_ns >= self.armed_ns
            && row.acts_max.is_none_or(|most| self.acts < most);
        if concerned {
            let window_ns = (row.within_s * NS_PER_S) as u64;
            self.times.retain(|then_ns| now_ns.saturating_sub(*then_ns) < window_ns);
            self.times.push(now_ns);
        }
        concerned && self.times.len() >= row.count as usize
    }

    fn act(&mut self, now_ns: u64) {
        self.times.clear();
        (self.armed_ns, self.acts) = (now_ns + (self.row.cool_down_s * NS_PER_S) as u64, self.acts + 1);
    }
}

/// The rows of one run, and what they have counted.
pub struct Ladder(Vec<Watched>);

impl Ladder {
    /// Nothing is counted yet.
    #[must_use]
    pub fn new(rows: &[HealthRow], partitions: &[PartitionId]) -> Self {
        let of_partition = |row: &'_ HealthRow, id: &PartitionId| row.is_of(*id).then(|| Watched::new(row, Some(*id)));
        let watched = rows.iter().flat_map(|row| match row.level {
            HealthLevel::Module => vec![Watched::new(row, None)],
            _ => partitions.iter().filter_map(|id| of_partition(row, id)).collect(),
        });
        Ladder(watched.collect())
    }

    /// Counts an error of `partition` (of the run without one) at `now_ns`, and says what is done:
    /// of all rows that act on it the gravest alone.
    pub fn judge(&mut self, partition: Option<PartitionId>, error: HealthError, now_ns: u64) -> HealthAct {
        let acting = self.0.iter_mut().filter_map(|row| row.hear(partition, error, now_ns).then_some(row));
        let (action, level) = match acting.max_by_key(|watched| watched.row.action) {
            Some(watched) => {
                watched.act(now_ns);
                (watched.row.action, watched.row.level)
            }
            None if partition.is_none() => (HealthAction::Restart, HealthLevel::Module),
            None => (HealthAction::Restart, HealthLevel::Process),
        };
        HealthAct { action, error, level, partition }
    }
}

/// What was done about an error, as the warden says it to the supervisor, which reports the event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HealthAct {
    /// What was done ...
    pub action: HealthAction,
    /// ... about what.
    pub error: HealthError,
    /// Of the row that said so.
    pub level: HealthLevel,
    /// Whose error; `None` for a run that stands still.
    pub partition: Option<PartitionId>,
}

impl HealthAct {
    /// Arguments of its event, and how many of them count.
    #[must_use]
    pub fn arguments(&self) -> ([f64; 4], usize) {
        let partition = self.partition.map_or(0.0, |id| id.code().into());
        let codes = [self.action.code(), self.error.code(), self.level.code()].map(f64::from);
        ([codes[0], codes[1], codes[2], partition], if self.partition.is_some() { 4 } else { 3 })
    }

    /// An alarm from the mode SAFE on.
    #[must_use]
    pub fn severity(&self) -> Severity {
        if self.action >= HealthAction::SafeMode { Severity::Alarm } else { Severity::Warning }
    }

    /// Its codes, as a line of the warden's pipe.
    #[must_use]
    pub fn line(&self) -> String {
        let (codes, used) = self.arguments();
        codes[..used].iter().fold("HEALTH".into(), |line, code| format!("{line} {code}"))
    }

    /// `None` for another line.
    #[must_use]
    pub fn parse(line: &str) -> Option<Self> {
        let mut codes = line.strip_prefix("HEALTH ")?.split(' ').map(|code| code.parse::<u16>().ok());
        let mut next = || codes.next().flatten();
        let (action, error) = (HealthAction::from_code(next()?)?, HealthError::from_code(next()?)?);
        let level = HealthLevel::from_code(next()?)?;
        Some(HealthAct { action, error, level, partition: next().and_then(PartitionId::from_code) })
    }
}

impl core::fmt::Display for HealthAct {
    /// `slosh-id killed: cold restart (partition)`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let who = self.partition.map_or("run", PartitionId::text);
        write!(f, "{who} {}: {} ({})", self.error, self.action, self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use HealthAction::{ColdRestart, EndRun, GiveUp, Restart, SafeMode};
    use HealthError::{Hang, Kill, Stall};
    use PartitionId::{InertialId, SensorSim, SloshId};

    const SECOND: u64 = 1_000_000_000;

    fn row(level: HealthLevel, count: u32, action: HealthAction) -> HealthRow {
        HealthRow {
            level,
            partition: None,
            error: None,
            count,
            within_s: 10.0,
            action,
            cool_down_s: 0.0,
            acts_max: None,
        }
    }

    fn ladder(rows: &[HealthRow]) -> Ladder {
        Ladder::new(rows, &[SensorSim, InertialId, SloshId])
    }

    /// What is done about kills of slosh-id at these seconds.
    fn acts(rows: &[HealthRow], at_s: &[u64]) -> Vec<HealthAction> {
        let mut ladder = ladder(rows);
        at_s.iter().map(|second| ladder.judge(Some(SloshId), Kill, second * SECOND).action).collect()
    }

    #[test]
    fn errors_of_one_partition_rise_from_rung_to_rung_while_they_fall_into_the_time() {
        let of = |count, action| row(HealthLevel::Partition, count, action);
        let rows = [of(2, ColdRestart), of(3, SafeMode), of(4, GiveUp)];
        assert_eq!(acts(&rows, &[1, 2, 3, 4]), [Restart, ColdRestart, SafeMode, GiveUp]);
        assert_eq!(acts(&rows, &[1, 11, 22, 33]), [Restart; 4], "too far apart");
        assert_eq!(acts(&rows, &[1, 2, 12, 13]), [Restart, ColdRestart, Restart, ColdRestart]);
    }

    #[test]
    fn a_row_pauses_for_its_cool_down_and_acts_so_often_at_most() {
        let cold = row(HealthLevel::Process, 1, ColdRestart);
        let cooled = HealthRow { cool_down_s: 5.0, ..cold.clone() };
        assert_eq!(acts(&[cooled], &[1, 2, 5, 6]), [ColdRestart, Restart, Restart, ColdRestart]);
        let limited = HealthRow { acts_max: Some(2), ..cold };
        assert_eq!(acts(&[limited], &[1, 2, 3]), [ColdRestart, ColdRestart, Restart]);
    }

    #[test]
    fn a_row_without_a_partition_counts_for_each_by_itself_and_one_of_the_module_for_all() {
        for (level, expected) in [(HealthLevel::Partition, Restart), (HealthLevel::Module, SafeMode)] {
            let mut ladder = ladder(&[row(level, 2, SafeMode)]);
            assert_eq!(ladder.judge(Some(SloshId), Kill, 1).action, Restart);
            let act = ladder.judge(Some(InertialId), Hang, 2);
            assert_eq!((act.action, act.partition), (expected, Some(InertialId)));
        }
    }

    #[test]
    fn only_the_error_of_the_row_counts_and_a_stall_is_of_the_module() {
        let mut ladder = ladder(&[
            HealthRow { error: Some(Hang), ..row(HealthLevel::Process, 1, ColdRestart) },
            HealthRow { error: Some(Stall), ..row(HealthLevel::Module, 2, EndRun) },
        ]);
        assert_eq!(ladder.judge(Some(SloshId), Kill, 1).action, Restart);
        assert_eq!(ladder.judge(Some(SloshId), Hang, 2).action, ColdRestart);
        assert_eq!(ladder.judge(Some(SensorSim), Hang, 3).action, Restart, "the source has the run's time");
        let stalls = [4, 5].map(|now_ns| ladder.judge(None, Stall, now_ns).action);
        assert_eq!(stalls, [Restart, EndRun]);
    }

    #[test]
    fn a_row_that_cannot_work_is_refused_with_the_reason() {
        let cold = || row(HealthLevel::Partition, 2, ColdRestart);
        assert_eq!(cold().check(), Ok(()));
        let wrong = [
            (row(HealthLevel::Partition, 2, Restart), "without a row"),
            (HealthRow { partition: Some(SensorSim), ..cold() }, "no prior replaces"),
            (HealthRow { error: Some(Stall), ..cold() }, "of the module"),
            (row(HealthLevel::Module, 2, GiveUp), "the action must be"),
            (HealthRow { partition: Some(SloshId), ..row(HealthLevel::Module, 2, SafeMode) }, "no partition"),
            (row(HealthLevel::Process, 2, SafeMode), "count = 2: must be 1 to 1"),
            (row(HealthLevel::Partition, 0, SafeMode), "count = 0: must be 1 to 1000"),
            (HealthRow { acts_max: Some(0), ..cold() }, "acts_max = 0"),
            (HealthRow { within_s: f64::NAN, ..cold() }, "within_s = NaN"),
            (HealthRow { cool_down_s: -1.0, ..cold() }, "cool_down_s = -1"),
        ];
        for (row, says) in wrong {
            let refusal = row.check().unwrap_err();
            assert!(refusal.contains(says), "{refusal}");
        }
    }

    #[test]
    fn what_was_done_comes_through_the_pipe() {
        for partition in [None, Some(SloshId)] {
            let act = HealthAct { action: SafeMode, error: Hang, level: HealthLevel::Module, partition };
            assert_eq!(HealthAct::parse(&act.line()), Some(act));
        }
        assert_eq!(HealthAct::parse("LOST slosh-id"), None);
        assert_eq!(HealthAct::parse("HEALTH 99 0 0 0"), None);
    }
}
