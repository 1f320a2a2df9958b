//! CPU windows: how much of a processor a partition has in each of its periods, set by the warden
//! on the partition's process.
//!
//! `SCHED_DEADLINE` with runtime and period of the table of limits: the kernel gives no more, and
//! promises as much. Where it does not, `SCHED_FIFO` with a limit of uninterrupted computing,
//! behind which the process is ended; where neither is allowed, a better nice value. What holds is
//! said.

use crate::config::PartitionLimits;
use crate::sys;
use rustix::process::{Pid, Resource, Rlimit, getpriority_process, prlimit, setpriority_process};
use std::time::Duration;

/// A life opens its services and finds its memory before it has a window.
pub(super) const AFTER: Duration = Duration::from_secs(2);
/// Below every watchdog of a kernel, above every ordinary process.
const FIFO_PRIORITY: u32 = 10;
/// A partition that computes so long without a wait has no processor's worth of work: it spins
/// \[µs\].
const FIFO_TIME_MAX_US: u64 = 1_000_000;
const NICER_BY: i32 = 5;

/// What a process has got.
#[derive(Clone, Debug, Default)]
pub(super) struct Window {
    /// Which window, and why not a better one.
    pub text: String,
    /// Share of a processor above which the kernel lets it wait.
    pub share: Option<f64>,
}

/// Gives process `pid` the window of `row`.
pub(super) fn give(pid: u32, row: &PartitionLimits) -> Window {
    let (Some(runtime_us), Some(period_ms)) = (row.runtime_us, row.period_ms) else {
        let text = "none: the table of limits states no period_ms and runtime_us".into();
        return Window { text, share: None };
    };
    let (runtime_ns, period_ns) = ((runtime_us * 1e3) as u64, (period_ms * 1e6) as u64);
    match sys::set_deadline(pid, runtime_ns, period_ns) {
        Ok(()) => {
            let text = format!("deadline: {runtime_us} us of {period_ms} ms");
            Window { text, share: Some(runtime_us / (period_ms * 1e3)) }
        }
        Err(refusal) => Window { text: without_deadline(pid, &refusal), share: None },
    }
}

fn without_deadline(pid: u32, refusal: &std::io::Error) -> String {
    let Some(process) = Pid::from_raw(pid as i32) else { return "none: no process".into() };
    let limit = Rlimit { current: Some(FIFO_TIME_MAX_US), maximum: Some(FIFO_TIME_MAX_US) };
    // The limit first: without it a loop without end would keep the processor for itself.
    let fifo = prlimit(Some(process), Resource::Rttime, limit).map_err(Into::into);
    let refusal = match fifo.and_then(|_| sys::set_fifo(pid, FIFO_PRIORITY)) {
        Ok(()) => return format!("fifo: priority {FIFO_PRIORITY}; no deadline: {refusal}"),
        Err(error) => format!("no deadline: {refusal}; no fifo: {error}"),
    };
    let nice = getpriority_process(Some(process)).unwrap_or(0) - NICER_BY;
    match setpriority_process(Some(process), nice) {
        Ok(()) => format!("nice: {nice}; {refusal}"),
        Err(error) => format!("none: {refusal}; no better nice value: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::give;
    use crate::config::Limits;
    use telemetry::PartitionId;

    #[test]
    fn what_a_process_is_given_is_said_and_the_kernel_says_the_same() {
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let mut limits = Limits::alike(150);
        let row = limits.partitions.iter_mut().find(|row| row.name == PartitionId::SloshId).unwrap();
        assert!(give(child.id(), row).text.starts_with("none: the table"));
        (row.runtime_us, row.period_ms) = (Some(300.0), Some(10.0));
        let said = give(child.id(), row).text;
        // proc(5): field 41 of stat is the policy, 2 fields behind the name in parentheses being 3.
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
        let policy = stat.rsplit(')').next().unwrap().split_whitespace().nth(41 - 3).unwrap().to_string();
        child.kill().unwrap();
        child.wait().unwrap();
        let policies =
            [("deadline: 300 us of 10 ms", "6"), ("fifo: priority 10", "1"), ("nice: ", "0"), ("none: ", "0")];
        assert!(
            policies.iter().any(|(word, code)| said.starts_with(word) && policy == *code),
            "{said}: policy {policy}"
        );
    }
}
