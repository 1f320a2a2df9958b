//! System facilities, one file each. All through safe wrappers (`rustix`, `signal-hook`).

mod clock;
mod process;

pub use clock::{cpu_ns, monotonic_ns};
pub use process::{die_with_parent, kill_self, stop_self};
