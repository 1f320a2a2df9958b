//! The kernel's scheduling of another process.
#![allow(unsafe_code)]

use std::io;

/// What a child of the process gets: the ordinary scheduling again.
const RESET_ON_FORK: u64 = 0x01;
const SCHED_OTHER: u32 = 0;
const SCHED_FIFO: u32 = 1;
const SCHED_DEADLINE: u32 = 6;

/// Gives the first thread of `pid` `runtime_ns` of a processor in every `period_ns`, before all
/// other scheduling, and no more.
///
/// # Errors
/// The kernel's: no right to it (`CAP_SYS_NICE`), or no such share is left.
pub fn set_deadline(pid: u32, runtime_ns: u64, period_ns: u64) -> io::Result<()> {
    let times = libc::sched_attr {
        sched_runtime: runtime_ns,
        sched_deadline: period_ns,
        sched_period: period_ns,
        ..of(SCHED_DEADLINE)
    };
    set(pid, &times)
}

/// Lets the first thread of `pid` run before all ordinary processes.
///
/// # Errors
/// The kernel's: no right to it (`CAP_SYS_NICE`, `RLIMIT_RTPRIO`).
pub fn set_fifo(pid: u32, priority: u32) -> io::Result<()> {
    set(pid, &libc::sched_attr { sched_priority: priority, ..of(SCHED_FIFO) })
}

/// Lets the first thread of `pid` run as ordinary processes do.
///
/// # Errors
/// The kernel's: there is no such process.
pub fn run_as_others(pid: u32, nice: i32) -> io::Result<()> {
    set(pid, &libc::sched_attr { sched_nice: nice, sched_flags: 0, ..of(SCHED_OTHER) })
}

fn of(sched_policy: u32) -> libc::sched_attr {
    libc::sched_attr {
        size: size_of::<libc::sched_attr>() as u32,
        sched_policy,
        sched_flags: RESET_ON_FORK,
        sched_nice: 0,
        sched_priority: 0,
        sched_runtime: 0,
        sched_deadline: 0,
        sched_period: 0,
    }
}

fn set(pid: u32, attributes: &libc::sched_attr) -> io::Result<()> {
    // SAFETY: sched_setattr(2) reads `size` bytes of a structure that outlives the call.
    let result = unsafe { libc::syscall(libc::SYS_sched_setattr, pid, core::ptr::from_ref(attributes), 0) };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}
