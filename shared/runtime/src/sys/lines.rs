//! Lines to a reader that may be gone or may have stopped reading: no writer blocks on it or ends
//! with it.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::collections::VecDeque;
use std::io::Write;

/// Lines kept for a reader that does not read; older ones go first.
const WAITING_MAX: usize = 1024;
/// A pipe that polls as writable takes this many bytes without blocking (POSIX `PIPE_BUF`).
const PIPE_BUF: usize = 4096;

/// Writes to standard error; a reader that is gone changes nothing.
pub fn tell(text: &str) {
    // One write: several processes share the console's standard error.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Standard output as a queue of lines that never blocks the writer.
#[derive(Debug, Default)]
pub struct LineWriter {
    waiting: VecDeque<String>,
}

impl LineWriter {
    /// Queues `line`; one that only reports progress may be dropped instead of waiting.
    pub fn say(&mut self, line: &str, droppable: bool) {
        self.flush();
        if self.waiting.is_empty() && write_if_ready(line) || droppable {
            return;
        }
        if self.waiting.len() == WAITING_MAX {
            self.waiting.pop_front();
        }
        self.waiting.push_back(line.to_string());
    }

    /// Writes what waits, as far as the reader reads.
    pub fn flush(&mut self) {
        while self.waiting.front().is_some_and(|line| write_if_ready(line)) {
            self.waiting.pop_front();
        }
    }
}

/// True when the line was written, or never will be (the reader is gone). Takes no memory.
fn write_if_ready(line: &str) -> bool {
    let out = std::io::stdout();
    let mut lock = out.lock();
    // A line longer than the pipe's guarantee is finished once it was begun: half a line would be
    // read as one.
    let ready = {
        let mut fds = [PollFd::new(&out, PollFlags::OUT)];
        poll(&mut fds, Some(&Timespec { tv_sec: 0, tv_nsec: 0 })).is_ok_and(|count| count > 0)
    };
    if !ready {
        return false;
    }
    let parts = line.as_bytes().chunks(PIPE_BUF).chain([&b"\n"[..]]);
    for part in parts {
        if lock.write_all(part).is_err() {
            return true;
        }
    }
    let _ = lock.flush();
    true
}
