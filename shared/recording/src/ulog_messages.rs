//! The messages of a PX4 log one after another, also those of a log that is damaged or cut.

use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;

/// First bytes of a log; the version follows.
pub(crate) const ULOG_MAGIC: &[u8] = b"ULog\x01\x12\x35";
/// Magic, version, time of the start.
const ULOG_HEADER_BYTES: usize = 16;
/// Size and type.
const HEAD_BYTES: usize = 3;
/// A whole message that is written now and then, to be found again after damage.
const SYNC: &[u8] = b"\x08\x00S\x2f\x73\x13\x20\x25\x0c\xbb\x12";
/// Types of messages.
const KINDS: &[u8] = b"BFIMPQALCDRSO";
/// In the first incompatible flags: data were appended to the log after it was closed.
const APPENDED: u8 = 1;

/// One message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Message<'a> {
    pub kind: u8,
    pub data: &'a [u8],
}

/// The messages from front to back.
#[derive(Clone, Debug)]
pub(crate) struct Messages<'a> {
    log: &'a [u8],
    at: usize,
    /// Where appended data begin, in rising order.
    appended: Vec<usize>,
    /// Where bytes were passed over, up to where.
    pub passed_over: Vec<(usize, usize)>,
}

impl<'a> Messages<'a> {
    /// Reads the header and the flags.
    ///
    /// # Errors
    /// No log, or one with flags that change what follows and are not known.
    pub fn open(file: &str, log: &'a [u8]) -> Result<Self, RecordingError> {
        let mut bytes = Bytes::new(file, "", log);
        if bytes.take(ULOG_HEADER_BYTES, "the header")?.get(..ULOG_MAGIC.len()) != Some(ULOG_MAGIC) {
            bytes.go_to(0);
            return Err(bytes.error("this is no PX4 log", COPY));
        }
        let mut messages = Self { log, at: ULOG_HEADER_BYTES, appended: Vec::new(), passed_over: Vec::new() };
        let flags = messages.clone().next().filter(|message| message.kind == b'B');
        if let Some(flags) = flags.map(|message| message.data).filter(|flags| flags.len() >= 40) {
            let incompatible = &flags[8..16];
            if incompatible[0] & !APPENDED != 0 || incompatible[1..].iter().any(|flag| *flag != 0) {
                let cure = "convert it with a newer pyulog: `ulog2csv FILE`";
                return Err(bytes.error(format!("the flags {incompatible:02x?} are not known"), cure));
            }
            if incompatible[0] & APPENDED != 0 {
                messages.appended = appended(flags, log.len());
            }
        }
        Ok(messages)
    }

    /// The place after `from` where messages can be read again.
    fn next_sync(&self, from: usize, bound: usize) -> Option<usize> {
        let rest = self.log.get(from..bound)?;
        rest.windows(SYNC.len()).position(|window| window == SYNC).map(|place| from + place)
    }
}

/// Places of appended data that lie in the log.
fn appended(flags: &[u8], length: usize) -> Vec<usize> {
    let offset = |bytes: &[u8]| bytes.iter().rev().fold(0u64, |value, byte| value << 8 | u64::from(*byte));
    let places = flags[16..40].chunks_exact(8).filter_map(|bytes| usize::try_from(offset(bytes)).ok());
    let mut places: Vec<usize> = places.filter(|place| (ULOG_HEADER_BYTES..length).contains(place)).collect();
    places.sort_unstable();
    places
}

impl<'a> Iterator for Messages<'a> {
    type Item = Message<'a>;

    fn next(&mut self) -> Option<Message<'a>> {
        loop {
            let bound = self.appended.iter().copied().find(|place| *place > self.at).unwrap_or(self.log.len());
            if self.at >= self.log.len() {
                return None;
            }
            if let Some(head) = self.log.get(self.at..bound.min(self.at + HEAD_BYTES)).filter(|head| head.len() == 3) {
                let from = self.at + HEAD_BYTES;
                let end = from + usize::from(u16::from_le_bytes([head[0], head[1]]));
                if end <= bound && KINDS.contains(&head[2]) {
                    self.at = end;
                    return Some(Message { kind: head[2], data: &self.log[from..end] });
                }
            }
            let again = self.next_sync(self.at + 1, bound).unwrap_or(bound);
            self.passed_over.push((self.at, again));
            self.at = again;
        }
    }
}
