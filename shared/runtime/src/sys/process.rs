//! Process control: dying with the parent, and the drills' signals to oneself.

use rustix::process::{
    Pid, Signal, getpid, getppid, getpriority_process, kill_process, set_parent_process_death_signal,
    setpriority_process,
};
use std::os::unix::fs::FileExt;

/// The kernel kills this process when its parent dies; ends at once when `parent` has died already:
/// whoever adopted this process since is not the warden.
pub fn die_with_parent(parent: Option<u32>) {
    // Refused only for a signal that does not exist.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    let adopted = |parent: u32| getppid().is_none_or(|pid| pid.as_raw_nonzero().get() as u32 != parent);
    if parent.is_some_and(adopted) {
        kill_self();
    }
}

/// Ends this process as a crash would: no destructor runs.
pub fn kill_self() {
    let _ = kill_process(getpid(), Signal::KILL);
}

/// Halts this process as a hang would: it lives, and does nothing.
pub fn stop_self() {
    let _ = kill_process(getpid(), Signal::STOP);
}

/// Ends this process by a real segmentation fault: it writes through a null pointer.
///
/// The kernel lets a process write its own text through its memory file. Elsewhere than on an
/// x86-64, or where that file is closed, the signal alone is sent.
pub fn crash_self() {
    // mov byte ptr [0], al
    const WRITE_TO_NULL: [u8; 7] = [0x88, 0x04, 0x25, 0, 0, 0, 0];
    if cfg!(target_arch = "x86_64")
        && let Ok(memory) = std::fs::OpenOptions::new().write(true).open("/proc/self/mem")
        && memory.write_all_at(&WRITE_TO_NULL, overwritten as fn() as usize as u64).is_ok()
    {
        std::hint::black_box(overwritten as fn())();
    }
    let _ = kill_process(getpid(), Signal::SEGV);
}

/// Long enough for one instruction.
#[inline(never)]
fn overwritten() {
    std::hint::black_box([0_u64; 4]);
}

/// What a watcher gains over those it watches: its share of a busy processor is nine times theirs,
/// and it is the next to run when it wakes. Not `SCHED_FIFO`: whoever waits for a dead child may
/// turn in the kernel until another process has let go of its files in `/proc`, and that one must
/// get the processor (0.8 s were seen).
const PRECEDENCE_NICE: i32 = 10;

/// The precedence of this process over its children.
#[derive(Debug, Default)]
pub struct Precedence {
    /// The nice value of before; `None`: the system allows no other.
    ordinary_nice: Option<i32>,
}

impl Precedence {
    /// Takes it, where the system allows it.
    #[must_use]
    pub fn take() -> Self {
        let take = |nice: i32| setpriority_process(None, nice - PRECEDENCE_NICE).ok().map(|()| nice);
        Self { ordinary_nice: getpriority_process(None).ok().and_then(take) }
    }

    /// Withholds it from a child, which has inherited it.
    pub fn withhold_from(&self, child: Pid) {
        if let Some(nice) = self.ordinary_nice {
            // A child that is dead already needs none.
            let _ = setpriority_process(Some(child), nice);
        }
    }
}

/// From now on the owner may use what this process and its children make, whatever mask they were
/// given: a person may have an odd one, and two threads that make sockets of iceoryx2 at one time
/// can leave that of the other behind.
pub fn keep_own_rights() {
    let mask = rustix::process::umask(rustix::fs::Mode::empty());
    rustix::process::umask(mask & (rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO));
}
