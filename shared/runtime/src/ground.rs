//! The ground port: a datagram socket in the supervisor's folder that takes commands.
//!
//! The run's folder is its user's alone, and so is the port. A datagram is copied before it is
//! looked at; what it says is checked in [`crate::orders`].

use std::fs;
use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use telemetry::Telecommand;

/// Datagrams taken in one turn: a flood of commands keeps the supervisor from no frame.
const AT_ONCE: usize = 4;
/// One byte more than a command: a longer datagram shows.
const ROOM: usize = size_of::<Telecommand>() + 1;

/// The port of one life of the supervisor.
pub struct GroundPort {
    socket: UnixDatagram,
    buffer: [u8; ROOM],
}

impl GroundPort {
    /// Binds `path`, in the place of what an earlier life has left.
    ///
    /// # Errors
    /// When the socket cannot be made.
    pub fn open(path: &Path) -> io::Result<Self> {
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let socket = UnixDatagram::bind(path)?;
        socket.set_nonblocking(true)?;
        Ok(GroundPort { socket, buffer: [0; ROOM] })
    }

    /// Hands what has come to `sink`, a few datagrams at a time.
    ///
    /// # Errors
    /// Those of `sink`.
    pub fn receive<E>(&mut self, mut sink: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        for _ in 0..AT_ONCE {
            let Ok(length) = self.socket.recv(&mut self.buffer) else { return Ok(()) };
            sink(&self.buffer[..length])?;
        }
        Ok(())
    }
}

/// Sends a command to the port at `path`.
///
/// # Errors
/// When nobody has the port.
pub fn send(path: &Path, command: &[u8]) -> io::Result<()> {
    let socket = UnixDatagram::unbound()?;
    socket.send_to(command, path).map(drop)
}
