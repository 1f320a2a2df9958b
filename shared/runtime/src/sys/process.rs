//! Process control: dying with the parent, and the drills' signals to oneself.

use rustix::process::{Signal, getpid, getppid, kill_process, set_parent_process_death_signal};

/// The kernel kills this process when its parent dies; ends at once when it already has.
pub fn die_with_parent() {
    let parent = getppid();
    // Refused only for a signal that does not exist.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    if getppid() != parent {
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
