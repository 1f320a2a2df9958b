//! System facilities, one file each. Through safe wrappers (`rustix`, `signal-hook`), but for the
//! allocator.

mod allocations;
mod clock;
mod lines;
mod process;

pub use allocations::{CountingAllocator, allocations, allocations_of_system};
pub use clock::{cpu_ns, monotonic_ns};
pub use lines::{LineWriter, tell};
pub use process::{crash_self, die_with_parent, kill_self, stop_self};
