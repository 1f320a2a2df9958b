//! Deaths of a run's processes: what ended them, how soon that was noticed, how soon they were
//! back.

use crate::usage::schedstat;
use serde::{Deserialize, Serialize};

/// One death, over all lives of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeathRow {
    /// Of the partition, as in `PartitionId::text`.
    pub partition: String,
    /// The life that ended: 0 is the first.
    pub epoch: u32,
    /// Of the process that ended.
    pub pid: u32,
    /// `signal N`, `exit code N`, `hang` (found and killed), or `taken down, ...`.
    pub cause: String,
    /// Since the start of the run \[s\].
    pub t_s: f64,
    /// When it was noticed (`CLOCK_MONOTONIC`) \[ns\].
    pub noticed_ns: u64,
    /// From the death until it was noticed; of a hang from its last sign of life \[ms\]. `None`
    /// where the kernel does not count waiting times.
    pub detect_ms: Option<f64>,
    /// From then until the partition had done its first frame of samples that were sent after its
    /// restart \[ms\]; `None` when it never came to that.
    pub recover_ms: Option<f64>,
}

/// All deaths of a run.
#[derive(Debug, Default)]
pub struct DeathLog {
    rows: Vec<DeathRow>,
}

impl DeathLog {
    /// Notes a death.
    pub fn note(&mut self, row: DeathRow) {
        self.rows.push(row);
    }

    /// Life `epoch` of `partition` did its first fresh frame at `fresh_ns`: whoever died before is
    /// back.
    pub fn recovered(&mut self, partition: &str, epoch: u32, fresh_ns: u64) {
        let waiting = |row: &&mut DeathRow| {
            row.partition == partition && row.epoch < epoch && row.recover_ms.is_none() && row.noticed_ns < fresh_ns
        };
        for row in self.rows.iter_mut().filter(waiting) {
            row.recover_ms = Some((fresh_ns - row.noticed_ns) as f64 * 1e-6);
        }
    }

    /// In the order in which they were noticed.
    #[must_use]
    pub fn rows(&self) -> &[DeathRow] {
        &self.rows
    }
}

/// How long the warden was late to notice a death: what it waited for a processor since the death
/// woke it, and what it did since it ran.
#[derive(Debug, Default)]
pub struct Alertness {
    waited_ns: Option<u64>,
    late_ns: u64,
    awake_ns: u64,
}

impl Alertness {
    const OWN: &'static str = "/proc/self/schedstat";

    /// Called before the warden sleeps.
    pub fn sleeps(&mut self) {
        self.waited_ns = schedstat(Self::OWN).map(|(_, waited_ns)| waited_ns);
    }

    /// Called when it wakes.
    pub fn wakes(&mut self, now_ns: u64) {
        let waited_ns = schedstat(Self::OWN).map(|(_, waited_ns)| waited_ns);
        self.late_ns = waited_ns.zip(self.waited_ns).map_or(0, |(now, before)| now.saturating_sub(before));
        self.awake_ns = now_ns;
    }

    /// What is noticed at `now_ns` happened so long ago \[ms\].
    #[must_use]
    pub fn delay_ms(&self, now_ns: u64) -> Option<f64> {
        self.waited_ns.map(|_| (self.late_ns + now_ns.saturating_sub(self.awake_ns)) as f64 * 1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::{DeathLog, DeathRow};

    fn death(partition: &str, epoch: u32, noticed_ns: u64) -> DeathRow {
        DeathRow {
            partition: partition.into(),
            epoch,
            pid: 1,
            cause: "signal 9".into(),
            t_s: 0.0,
            noticed_ns,
            detect_ms: None,
            recover_ms: None,
        }
    }

    #[test]
    fn a_partition_is_back_with_the_first_fresh_frame_of_a_later_life_however_often_it_died_before() {
        let mut log = DeathLog::default();
        log.note(death("slosh-id", 0, 1_000_000));
        log.note(death("modal-id", 0, 1_000_000));
        log.recovered("slosh-id", 0, 2_000_000);
        log.note(death("slosh-id", 1, 3_000_000));
        log.recovered("slosh-id", 2, 9_000_000);
        log.recovered("slosh-id", 2, 11_000_000);
        assert_eq!(log.rows().iter().map(|row| row.recover_ms).collect::<Vec<_>>(), [Some(8.0), None, Some(6.0)]);
    }
}
