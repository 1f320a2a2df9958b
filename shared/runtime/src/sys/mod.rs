//! System facilities, one file each. Through safe wrappers (`rustix`, `signal-hook`, `landlock`,
//! `seccompiler`), but for the allocator, one system call of scheduling and the probes of a test.

mod allocations;
mod clock;
mod confinement;
mod lines;
mod notify;
mod probes;
mod process;
mod schedule;
mod system_calls;

pub use allocations::{CountingAllocator, allocations, allocations_of_system};
pub use clock::{cpu_ns, monotonic_ns, unix_ns};
pub use confinement::{Place, drop_capabilities, freeze_limits, no_new_privileges, stay_within};
pub use lines::{LineWriter, tell};
pub use notify::Notifier;
pub use probes::{is_refused, try_all as try_forbidden_acts};
pub use process::{Precedence, crash_self, die_with_parent, keep_own_rights, kill_self, stop_self};
pub use schedule::{run_as_others, set_deadline, set_fifo};
pub use system_calls::restrict as restrict_system_calls;
