//! Sums of a drill, by fault and in all, and what is required of them.

use super::injector::{Flown, Killed};
use super::plan::Kind;
use runtime::deaths::DeathRow;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Greatest times on a computer that is otherwise idle \[ms\]: three beats of 50 ms for a hang.
const CRASH_DETECT_MS_P99: f64 = 5.0;
const HANG_DETECT_MS_P99: f64 = 150.0;
const RECOVER_MS_P99: f64 = 250.0;
/// Between two looks of the supervisor at the others: one beat.
const LOOK_MS: f64 = 50.0;

/// How a run compares with the undisturbed one.
pub struct Verdict {
    pub digest_differs: bool,
    pub undeclared_lost: u64,
    pub torn: u64,
    pub failure: Option<String>,
    pub declared: Vec<String>,
}

/// Counts of one kind of fault, or of all.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Of all faults: of those alone that leave the warden its processor.
    pub is_sum: bool,
    pub runs: u64,
    pub struck: u64,
    pub kills: u64,
    pub digests_differing: u64,
    pub undeclared_lost: u64,
    pub torn: u64,
    pub wedged: u64,
    pub leaks: u64,
    pub failed: u64,
    pub degraded: u64,
    pub log_disagreements: u64,
    pub cuts: u64,
    pub cuts_taken: u64,
    /// Of crashes from the signal, and from the end of the process, which the kernel ends when it
    /// comes to a processor; of hangs; to the first fresh frame \[ms\].
    pub detect_ms: Vec<f64>,
    pub notice_ms: Vec<f64>,
    pub hang_ms: Vec<f64>,
    pub recover_ms: Vec<f64>,
    /// Why runs failed or differed, a few.
    pub reasons: Vec<String>,
}

const REASONS_MAX: usize = 5;

impl Tally {
    /// Adds one run that was for `kind`.
    pub fn add(&mut self, kind: Kind, flown: &Flown, verdict: &Verdict) {
        let deaths = &flown.end.deaths;
        self.runs += 1;
        self.struck += flown.struck.len() as u64;
        self.kills += (flown.killed.len() + own_kills(deaths, &flown.killed)) as u64;
        self.digests_differing += u64::from(verdict.digest_differs);
        self.undeclared_lost += verdict.undeclared_lost;
        self.torn += verdict.torn;
        self.wedged += u64::from(flown.wedged);
        self.leaks += flown.leaks;
        self.failed += u64::from(verdict.failure.is_some());
        self.degraded += u64::from(!verdict.declared.is_empty());
        self.log_disagreements += disagreements(kind, deaths, &flown.killed);
        self.cuts += flown.cuts;
        self.cuts_taken += flown.cuts_taken;
        let reasons =
            verdict.failure.iter().chain(&verdict.declared).map(|reason| format!("{}: {reason}", kind.word()));
        let room = REASONS_MAX.saturating_sub(self.reasons.len());
        self.reasons.extend(reasons.take(room));
        // What stops the warden itself, or the whole computer, says nothing of its times.
        if matches!(kind, Kind::Clock | Kind::Hog | Kind::Shm | Kind::Rogue) && self.is_sum {
            return;
        }
        self.detect_ms.extend(deaths.iter().filter(|row| row.cause.starts_with("signal")).filter_map(|row| {
            let sent = flown.killed.iter().find(|killed| killed.pid == row.pid);
            sent.map_or(row.detect_ms, |killed| Some(row.noticed_ns.saturating_sub(killed.at_ns) as f64 * 1e-6))
        }));
        let by_signal = deaths.iter().filter(|row| row.cause.starts_with("signal"));
        self.notice_ms.extend(by_signal.filter_map(|row| row.detect_ms));
        self.hang_ms.extend(deaths.iter().filter(|row| row.cause == "hang").filter_map(|row| row.detect_ms));
        let crashed = |row: &&DeathRow| row.cause.starts_with("signal");
        self.recover_ms.extend(
            deaths.iter().filter(crashed).filter_map(|row| Some(row.recover_ms? + row.detect_ms.unwrap_or(0.0))),
        );
    }

    /// As an object; `kind` is the word of a fault.
    pub fn json(&self) -> Value {
        json!({
            "runs": self.runs, "struck": self.struck, "kills": self.kills, "digests_differing": self.digests_differing,
            "undeclared_lost": self.undeclared_lost, "torn": self.torn, "wedged": self.wedged, "leaks": self.leaks,
            "failed": self.failed, "degraded": self.degraded, "log_disagreements": self.log_disagreements,
            "checkpoint_cuts": self.cuts, "checkpoint_cuts_taken": self.cuts_taken,
            "detect_ms": of_order(&self.detect_ms), "notice_ms": of_order(&self.notice_ms), "hang_detect_ms": of_order(&self.hang_ms),
            "recover_ms": of_order(&self.recover_ms), "reasons": self.reasons,
        })
    }

    /// What a drill must show: name, measured, whether it is met. Times count only where `idle`.
    pub fn requirements(&self, idle: bool) -> Vec<(&'static str, f64, bool)> {
        let none = |name, count: u64| (name, count as f64, count == 0);
        let mut all = vec![
            none("digests_differing", self.digests_differing),
            none("undeclared_lost", self.undeclared_lost),
            none("torn", self.torn),
            none("wedged", self.wedged),
            none("leaks", self.leaks),
            none("failed", self.failed),
            none("log_disagreements", self.log_disagreements),
            none("checkpoint_cuts_taken", self.cuts_taken),
        ];
        if idle {
            let times = [
                ("detect_ms_p99", &self.detect_ms, CRASH_DETECT_MS_P99),
                ("hang_detect_ms_p99", &self.hang_ms, HANG_DETECT_MS_P99 + LOOK_MS),
                ("recover_ms_p99", &self.recover_ms, RECOVER_MS_P99),
            ];
            let judged = |(name, values, limit): (_, &Vec<f64>, f64)| {
                let p99 = order_statistic(values, 0.99)?;
                Some((name, p99, p99 <= limit))
            };
            all.extend(times.into_iter().filter_map(judged));
        }
        all
    }
}

/// Kills by signal that partitions were to inflict on themselves.
fn own_kills(deaths: &[DeathRow], killed: &[Killed]) -> usize {
    let by_signal = deaths.iter().filter(|row| row.cause.starts_with("signal"));
    by_signal.filter(|row| !killed.iter().any(|killed| killed.pid == row.pid)).count()
}

/// Kills of ours that the warden did not log, and deaths in its log that nothing of ours explains.
fn disagreements(kind: Kind, deaths: &[DeathRow], killed: &[Killed]) -> u64 {
    let unlogged = killed.iter().filter(|killed| !deaths.iter().any(|row| row.pid == killed.pid)).count();
    let explains_any = matches!(
        kind,
        Kind::Point | Kind::Crash | Kind::Memory | Kind::Descriptors | Kind::Checkpoint | Kind::Shm | Kind::Rogue
    );
    let unexplained = deaths.iter().filter(|row| {
        let consequence = row.cause == "exit code 5" || row.cause.starts_with("taken down");
        let stopped = row.cause == "hang" && matches!(kind, Kind::Hang | Kind::Stop | Kind::Clock | Kind::Hog);
        !consequence && !stopped && !explains_any && !killed.iter().any(|killed| killed.pid == row.pid)
    });
    (unlogged + unexplained.count()) as u64
}

/// The value that the fraction `p` does not exceed.
pub fn order_statistic(values: &[f64], p: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = ((p * sorted.len() as f64).ceil() as usize).saturating_sub(1);
    sorted.get(at).copied()
}

fn of_order(values: &[f64]) -> Value {
    json!({ "p50": order_statistic(values, 0.5), "p99": order_statistic(values, 0.99), "max": order_statistic(values, 1.0), "count": values.len() })
}

/// Sums by fault, in the order in which they first came.
pub type ByFault = BTreeMap<Kind, Tally>;

#[cfg(test)]
mod tests {
    use super::*;

    fn death(pid: u32, cause: &str) -> DeathRow {
        DeathRow {
            partition: "slosh-id".into(),
            epoch: 0,
            pid,
            cause: cause.into(),
            t_s: 0.0,
            noticed_ns: 0,
            detect_ms: None,
            recover_ms: None,
        }
    }

    #[test]
    fn a_kill_that_is_not_logged_and_a_death_that_nobody_inflicted_are_disagreements() {
        let killed = [Killed { pid: 7, at_ns: 0 }];
        assert_eq!(disagreements(Kind::Kill, &[death(7, "signal 9")], &killed), 0);
        assert_eq!(disagreements(Kind::Kill, &[death(7, "signal 9"), death(8, "exit code 5")], &killed), 0);
        assert_eq!(disagreements(Kind::Kill, &[death(8, "signal 9")], &killed), 2);
        assert_eq!(disagreements(Kind::Hang, &[death(7, "signal 9"), death(8, "hang")], &killed), 0);
    }

    #[test]
    fn the_median_of_a_hundred_is_one_of_them() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!([0.5, 0.99, 1.0].map(|p| order_statistic(&values, p)), [Some(50.0), Some(99.0), Some(100.0)]);
        assert_eq!(order_statistic(&[], 0.5), None);
    }
}
