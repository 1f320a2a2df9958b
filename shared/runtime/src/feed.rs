//! Samples of real sensors: drivers connect to a Unix stream socket and write samples as the
//! interface control document lays them out, one behind the other.
//!
//! The first word of a sample is its layout hash, which says which record follows and how long it
//! is. A driver that writes anything else is disconnected: behind a wrong word nothing is in its
//! place.

mod journal;
pub use journal::{Journal, newest_counts};

use serde::{Deserialize, Serialize};
use std::io::{ErrorKind, Read};
use std::os::unix::fs::FileTypeExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use telemetry::{Delivery, TICK, TOPICS, TopicId};

/// Drivers at one time; who comes later waits in the socket's queue.
const DRIVERS_MAX: usize = 16;
/// Bytes read of one driver in one look: a second of every source topic at its highest rate would
/// be 900 kB, a look comes every few milliseconds.
const LOOK_BYTES: usize = 1 << 16;

/// Where samples come from instead of a simulation, and how long they are waited for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeedConfig {
    /// Socket that drivers connect to.
    pub socket: PathBuf,
    /// A frame closes when a sample this much behind its end has come \[ns\].
    pub lateness_ns: u64,
    /// Without a sample for so long, frames close by the clock \[ns\].
    pub silence_ns: u64,
    /// Frames as they were formed: what a restarted gateway sends again.
    pub journal: PathBuf,
}

/// What became of the samples that drivers wrote.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FeedCounts {
    /// Whole samples.
    pub received: u64,
    /// Dropped: their frame was closed.
    pub late: u64,
    /// Dropped: their frame had one of that topic and time.
    pub duplicates: u64,
    /// Dropped: their frame had as many of that topic as it may carry.
    pub surplus: u64,
    /// Dropped: a value is not finite, or the time lies too far ahead.
    pub bad: u64,
    /// Frames without a sample.
    pub empty_frames: u64,
    /// Drivers disconnected for a layout that this build does not know.
    pub strangers: u64,
}

/// A topic that a driver may feed, by the layout hash of its samples.
#[must_use]
pub fn topic_of_layout(layout: u32) -> Option<TopicId> {
    let is_fed = |id: &TopicId| TOPICS[*id].delivery == Delivery::Source && *id != TICK.id;
    (0..TOPICS.len()).filter(is_fed).find(|&id| TOPICS[id].layout == layout)
}

struct Driver {
    stream: UnixStream,
    /// The beginning of a sample whose rest has not come.
    rest: Vec<u8>,
}

/// The socket, and the drivers that are connected to it.
pub struct FeedSocket {
    listener: UnixListener,
    drivers: Vec<Driver>,
    buffer: Vec<u8>,
    heard: Instant,
    strangers: u64,
}

impl FeedSocket {
    /// Takes the place of a socket that a dead gateway has left.
    ///
    /// # Errors
    /// When the path is another kind of file, too long for a socket, or may not be written.
    pub fn bind(path: &Path) -> std::io::Result<Self> {
        if std::fs::symlink_metadata(path).is_ok_and(|file| file.file_type().is_socket()) {
            std::fs::remove_file(path)?;
        }
        let listener = UnixListener::bind(path)?;
        listener.set_nonblocking(true)?;
        let (drivers, buffer) = (Vec::with_capacity(DRIVERS_MAX), vec![0; LOOK_BYTES]);
        Ok(FeedSocket { listener, drivers, buffer, heard: Instant::now(), strangers: 0 })
    }

    /// Since a driver last wrote something.
    #[must_use]
    pub fn quiet(&self) -> Duration {
        self.heard.elapsed()
    }

    /// Drivers disconnected so far.
    #[must_use]
    pub fn strangers(&self) -> u64 {
        self.strangers
    }

    /// Hands every whole sample that has come to `sink`, in the order of each driver.
    pub fn drain(&mut self, sink: &mut dyn FnMut(TopicId, &[u8])) {
        while self.drivers.len() < DRIVERS_MAX
            && let Ok((stream, _)) = self.listener.accept()
        {
            if stream.set_nonblocking(true).is_ok() {
                self.drivers.push(Driver { stream, rest: Vec::with_capacity(LOOK_BYTES) });
            }
        }
        let (buffer, heard, strangers) = (&mut self.buffer, &mut self.heard, &mut self.strangers);
        self.drivers.retain_mut(|driver| match driver.stream.read(buffer) {
            Ok(0) => false,
            Ok(count) => {
                *heard = Instant::now();
                driver.rest.extend_from_slice(&buffer[..count]);
                let known = split(&mut driver.rest, sink);
                *strangers += u64::from(!known);
                known
            }
            Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
        });
    }
}

/// Takes whole samples off the front of `bytes`; false where no sample begins.
fn split(bytes: &mut Vec<u8>, sink: &mut dyn FnMut(TopicId, &[u8])) -> bool {
    let mut at = 0;
    while let Some(word) = bytes.get(at..at + 4) {
        let layout = u32::from_le_bytes(word.try_into().expect("four bytes"));
        let Some(topic) = topic_of_layout(layout) else { return false };
        let Some(sample) = bytes.get(at..at + TOPICS[topic].size) else { break };
        sink(topic, sample);
        at += TOPICS[topic].size;
    }
    bytes.drain(..at);
    true
}

#[cfg(test)]
mod tests {
    use super::split;
    use telemetry::{IMU, Imu, JOINTS, Joints, Layout, Sample};
    use zerocopy::IntoBytes;

    fn stream() -> Vec<u8> {
        let mut bytes = Vec::new();
        for k in 0..5 {
            let (mut imu, mut joints) = (Imu::zeroed_at(k), Joints::zeroed_at(k));
            (imu.header.layout, joints.header.layout) = (Imu::HASH, Joints::HASH);
            bytes.extend_from_slice(imu.as_bytes());
            bytes.extend_from_slice(joints.as_bytes());
        }
        bytes
    }

    #[test]
    fn samples_are_found_however_the_stream_is_cut() {
        let bytes = stream();
        for cut in 0..bytes.len() {
            let (mut rest, mut topics) = (bytes[..cut].to_vec(), Vec::new());
            assert!(split(&mut rest, &mut |topic, sample| topics.push((topic, sample.len()))));
            rest.extend_from_slice(&bytes[cut..]);
            assert!(split(&mut rest, &mut |topic, sample| topics.push((topic, sample.len()))));
            let both = [(IMU.id, size_of::<Imu>()), (JOINTS.id, size_of::<Joints>())];
            assert!(topics.iter().eq([both; 5].iter().flatten()) && rest.is_empty(), "cut at byte {cut}");
        }
    }

    #[test]
    fn a_word_that_is_no_layout_of_a_source_ends_the_connection() {
        let mut bytes = stream();
        bytes.extend_from_slice(&telemetry::Tick::HASH.to_le_bytes());
        assert!(!split(&mut bytes, &mut |_, _| ()));
    }
}
