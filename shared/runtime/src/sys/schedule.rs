//! The kernel's scheduling of another process.
#![allow(unsafe_code)]

use std::io;

/// What a child of the process gets: the ordinary scheduling again.
const RESET_ON_FORK: u64 = 0x01;
const SCHED_FIFO: u32 = 1;
const SCHED_DEADLINE: u32 = 6;

/// Gives the first thread of `pid` `runtime_ns` of a processor in every `period_ns`, before all
/// other scheduling, and no more.
///
/// # Errors
/// The kernel's: no right to it (`CAP_SYS_NICE`), or no such share is left.
pub fn set_deadline(pid: u32, runtime_ns: u64, period_ns: u64) -> io::Result<()> {
    set(pid, SCHED_DEADLINE, 0, [runtime_ns, period_ns, period_ns])
}

/// Lets the first thread of `pid` run before all ordinary processes.
///
/// # Errors
/// The kernel's: no right to it (`CAP_SYS_NICE`, `RLIMIT_RTPRIO`).
pub fn set_fifo(pid: u32, priority: u32) -> io::Result<()> {
    set(pid, SCHED_FIFO, priority, [0; 3])
}

fn set(pid: u32, sched_policy: u32, sched_priority: u32, times_ns: [u64; 3]) -> io::Result<()> {
    let [sched_runtime, sched_deadline, sched_period] = times_ns;
    let attributes = libc::sched_attr {
        size: size_of::<libc::sched_attr>() as u32,
        sched_policy,
        sched_flags: RESET_ON_FORK,
        sched_nice: 0,
        sched_priority,
        sched_runtime,
        sched_deadline,
        sched_period,
    };
    // SAFETY: sched_setattr(2) reads `size` bytes of a structure that outlives the call.
    let result = unsafe { libc::syscall(libc::SYS_sched_setattr, pid, &raw const attributes, 0) };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}
