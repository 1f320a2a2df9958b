//! Processes of a world, found by the environment they inherited: nobody else's can be touched.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use std::path::Path;
use std::time::Duration;

/// A living process, held by a pidfd: its number cannot come to mean another one.
pub struct Process {
    pub pid: u32,
    /// `console`, `warden` or a partition's name.
    pub name: String,
    pidfd: OwnedFd,
}

impl Process {
    /// A child that was not waited for yet.
    pub fn child(pid: u32, name: &str) -> Self {
        Process { pid, name: name.into(), pidfd: open(pid).expect("its number is taken until it is waited for") }
    }

    /// Process `pid`, when it lives and belongs to the world whose folder of runs is `root`.
    pub fn of_world(pid: u32, root: &Path) -> Option<Self> {
        let pidfd = open(pid)?;
        // Read after the pidfd was opened: what is read is what is held, or the process is gone and
        // nothing is read.
        let environment = std::fs::read(format!("/proc/{pid}/environ")).ok()?;
        let mark = format!("OBSID_ROOT={}", root.display());
        if !environment.split(|&byte| byte == 0).any(|variable| variable == mark.as_bytes()) {
            return None;
        }
        let command_line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        let words: Vec<_> = command_line.split(|&byte| byte == 0).map(String::from_utf8_lossy).collect();
        let name = match &words[..] {
            [_, verb, name, ..] if verb == "partition" => name.to_string(),
            _ => "console".into(),
        };
        Some(Process { pid, name, pidfd })
    }

    /// All living processes of that world.
    pub fn all_of_world(root: &Path) -> Vec<Self> {
        let entries = std::fs::read_dir("/proc").expect("a Linux system");
        let pids = entries.flatten().filter_map(|entry| entry.file_name().to_string_lossy().parse().ok());
        pids.filter_map(|pid| Process::of_world(pid, root)).collect()
    }

    pub fn signal(&self, signal: Signal) {
        // Already dead is as good.
        let _ = pidfd_send_signal(&self.pidfd, signal);
    }

    /// Waits for its end; whether it came within `patience`.
    pub fn ends_within(&self, patience: Duration) -> bool {
        let timeout = Timespec { tv_sec: patience.as_secs() as i64, tv_nsec: i64::from(patience.subsec_nanos()) };
        poll(&mut [PollFd::new(&self.pidfd, PollFlags::IN)], Some(&timeout)).is_ok_and(|ready| ready > 0)
    }

    /// State letter of `/proc/PID/stat`, for the autopsy of a run.
    pub fn state(&self) -> String {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid)).unwrap_or_default();
        stat.rsplit(") ").next().and_then(|rest| rest.split(' ').next()).unwrap_or("gone").into()
    }
}

fn open(pid: u32) -> Option<OwnedFd> {
    pidfd_open(Pid::from_raw(pid.try_into().ok()?)?, PidfdFlags::empty()).ok()
}
