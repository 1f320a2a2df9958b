//! Word to a service manager that started this process (`sd_notify`): ready, alive, ending.

use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

/// The manager's socket; held open, for a hardened process may not open it later.
#[derive(Debug)]
pub struct Notifier(UnixDatagram);

impl Notifier {
    /// The socket that the manager named in `NOTIFY_SOCKET`; `None` without one.
    #[must_use]
    pub fn of_environment() -> Option<Self> {
        let name = std::env::var("NOTIFY_SOCKET").ok()?;
        let socket = UnixDatagram::unbound().ok()?;
        match name.strip_prefix('@') {
            Some(hidden) => socket.connect_addr(&SocketAddr::from_abstract_name(hidden).ok()?).ok()?,
            None => socket.connect(&name).ok()?,
        }
        // A manager that does not read holds nobody up.
        socket.set_nonblocking(true).ok()?;
        Some(Notifier(socket))
    }

    /// `READY=1`, `WATCHDOG=1` or `STOPPING=1`.
    pub fn say(&self, word: &str) {
        let _ = self.0.send(word.as_bytes());
    }
}
