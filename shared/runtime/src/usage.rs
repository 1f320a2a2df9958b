//! What the kernel counts of a process: processor, memory, descriptors, faults, context switches.

use serde::{Deserialize, Serialize};
use std::fs;

/// Of one process, or summed over the lives of a partition: counts are summed, sizes are the
/// largest seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Usage {
    /// On a processor \[s\].
    pub run_s: f64,
    /// Ready to run, waiting for a processor \[s\].
    pub wait_s: f64,
    /// Resident memory \[kB\].
    pub rss_kb: u64,
    /// Largest resident memory \[kB\].
    pub rss_max_kb: u64,
    /// Stack of the first thread \[kB\].
    pub stack_kb: u64,
    /// Open descriptors.
    pub descriptors: u64,
    /// Page faults without and with a disk.
    pub minor_faults: u64,
    pub major_faults: u64,
    /// Context switches: it waited, or it was interrupted.
    pub voluntary_switches: u64,
    pub involuntary_switches: u64,
}

impl Usage {
    /// Of the living process `pid`, or of one that is dead and not waited for yet (no sizes then).
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let mut usage = Usage::default();
        for task in fs::read_dir(format!("/proc/{pid}/task")).ok()?.flatten() {
            let (run_ns, wait_ns) = schedstat(&task.path().join("schedstat").to_string_lossy()).unwrap_or_default();
            usage.run_s += run_ns as f64 * 1e-9;
            usage.wait_s += wait_ns as f64 * 1e-9;
        }
        let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
        let of = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key));
            line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
        };
        usage.rss_kb = of("VmRSS:");
        usage.rss_max_kb = of("VmHWM:");
        usage.stack_kb = of("VmStk:");
        usage.voluntary_switches = of("voluntary_ctxt_switches:");
        usage.involuntary_switches = of("nonvoluntary_ctxt_switches:");
        usage.descriptors = fs::read_dir(format!("/proc/{pid}/fd")).map_or(0, |entries| entries.count() as u64);
        let fields = stat(pid)?;
        // proc(5): fields 10 and 12, counted behind pid and name.
        let field = |at: usize| fields.get(at - 3).and_then(|text| text.parse().ok()).unwrap_or(0);
        (usage.minor_faults, usage.major_faults) = (field(10), field(12));
        Some(usage)
    }

    /// Adds a later life.
    pub fn add(&mut self, later: &Self) {
        self.run_s += later.run_s;
        self.wait_s += later.wait_s;
        self.minor_faults += later.minor_faults;
        self.major_faults += later.major_faults;
        self.voluntary_switches += later.voluntary_switches;
        self.involuntary_switches += later.involuntary_switches;
        self.keep_sizes(later);
    }

    /// Takes the sizes of `other` where they are larger.
    pub fn keep_sizes(&mut self, other: &Self) {
        self.rss_kb = self.rss_kb.max(other.rss_kb);
        self.rss_max_kb = self.rss_max_kb.max(other.rss_max_kb);
        self.stack_kb = self.stack_kb.max(other.stack_kb);
        self.descriptors = self.descriptors.max(other.descriptors);
    }
}

/// Time on a processor and time waiting for one \[ns\], of `/proc/…/schedstat`.
#[must_use]
pub fn schedstat(path: &str) -> Option<(u64, u64)> {
    let text = fs::read_to_string(path).ok()?;
    let mut numbers = text.split_whitespace().map(|number| number.parse().ok());
    Some((numbers.next()??, numbers.next()??))
}

/// What the threads of a process have done, and whether one of them could do more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Activity {
    /// Time on a processor of all threads \[ns\], and how often they came to one.
    pub run_ns: u64,
    pub slices: u64,
    /// A thread runs, is ready to, or waits for a disk.
    pub busy: bool,
}

impl Activity {
    /// Of the living process `pid`.
    #[must_use]
    pub fn of(pid: u32) -> Option<Self> {
        let mut activity = Activity::default();
        for task in fs::read_dir(format!("/proc/{pid}/task")).ok()?.flatten() {
            let counts = fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
            let mut numbers = counts.split_whitespace().map(|number| number.parse().unwrap_or(0));
            activity.run_ns += numbers.next().unwrap_or(0);
            activity.slices += numbers.nth(1).unwrap_or(0);
            let state = fields(&task.path().join("stat")).and_then(|fields| fields.first()?.chars().next());
            activity.busy |= matches!(state, Some('R' | 'D'));
        }
        Some(activity)
    }
}

/// Fields of `/proc/PID/stat` behind the name, the state first.
#[must_use]
fn stat(pid: u32) -> Option<Vec<String>> {
    fields(std::path::Path::new(&format!("/proc/{pid}/stat")))
}

fn fields(path: &std::path::Path) -> Option<Vec<String>> {
    let text = fs::read_to_string(path).ok()?;
    // The name stands in parentheses and may contain blanks.
    Some(text.rsplit_once(") ")?.1.split_whitespace().map(String::from).collect())
}

/// State letter of a process: `R` running or ready, `S` asleep, `T` stopped ...
#[must_use]
pub fn state(pid: u32) -> Option<char> {
    stat(pid)?.first()?.chars().next()
}

#[cfg(test)]
mod tests {
    use super::{Usage, state};

    #[test]
    fn a_process_sees_its_own_processor_time_memory_and_descriptors() {
        let own = Usage::of(std::process::id()).unwrap();
        assert!(own.rss_kb > 100 && own.rss_max_kb >= own.rss_kb && own.stack_kb > 0, "{own:?}");
        assert!(own.descriptors >= 3 && own.minor_faults > 0, "{own:?}");
        assert!(matches!(state(std::process::id()), Some('R' | 'S')));
        assert_eq!(Usage::of(u32::MAX), None);
    }

    #[test]
    fn counts_of_two_lives_are_summed_and_of_sizes_the_larger_is_kept() {
        let mut first = Usage { run_s: 1.0, rss_kb: 5, descriptors: 9, major_faults: 1, ..Usage::default() };
        first.add(&Usage { run_s: 2.0, rss_kb: 4, descriptors: 11, major_faults: 2, ..Usage::default() });
        assert_eq!((first.run_s, first.rss_kb, first.descriptors, first.major_faults), (3.0, 5, 11, 3));
    }
}
