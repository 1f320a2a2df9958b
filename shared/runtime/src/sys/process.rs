//! Process control: dying with the parent, and the drills' signals to oneself.

use rustix::process::{Signal, getpid, getppid, kill_process, set_parent_process_death_signal};

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
