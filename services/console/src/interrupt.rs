//! The first interruption asks a command to end with what it has; a second one ends it at once.

use crate::Failure;
use signal_hook::consts::SIGINT;
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Exit code of a command that was interrupted: that of a shell for a signal, 128 and its number.
pub const EXIT_CODE: u8 = 130;

/// A flag that `kill -INT` and Ctrl-C set.
///
/// # Errors
/// [`Failure::Run`] when the handlers cannot be set.
pub fn flag() -> Result<Arc<AtomicBool>, Failure> {
    let asked = Arc::new(AtomicBool::new(false));
    // in this order: the first signal finds the flag clear
    flag::register_conditional_shutdown(SIGINT, i32::from(EXIT_CODE), asked.clone())
        .and_then(|_| flag::register(SIGINT, asked.clone()))
        .map_err(|error| Failure::Run(format!("the signal handlers: {error}")))?;
    Ok(asked)
}
