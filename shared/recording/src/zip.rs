//! The entries of a zip archive, stored or deflated.

use crate::bytes::{Bytes, COPY, bad, expanded};
use crate::error::RecordingError;
use flate2::read::DeflateDecoder;
use std::borrow::Cow;

const DIRECTORY_END: &[u8] = b"PK\x05\x06";
/// Bytes of the end record, and the longest comment behind it.
const DIRECTORY_END_BYTES: usize = 22;
const COMMENT_MAX: usize = 0xffff;
/// Where a number of 32 bits says that the number of 64 bits stands elsewhere.
const ELSEWHERE: u64 = 0xffff_ffff;
const CURE: &str = "write the archive again, stored or deflated, in parts below 4 GB";

/// One file of an archive.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub name: String,
    method: u16,
    is_encrypted: bool,
    crc: u32,
    packed: usize,
    size: usize,
    /// Of the local header.
    at: usize,
}

/// The entries in the order of the directory at the end of the archive.
///
/// # Errors
/// No directory, or one that is damaged.
pub(crate) fn entries(file: &str, content: &[u8]) -> Result<Vec<Entry>, RecordingError> {
    let from = content.len().saturating_sub(DIRECTORY_END_BYTES + COMMENT_MAX);
    let tail = &content[from..];
    let end = tail.windows(DIRECTORY_END.len()).rposition(|window| window == DIRECTORY_END);
    let end =
        end.ok_or_else(|| bad(file, "the end of the file", "the directory of the zip archive is not there", COPY))?;
    let mut bytes = Bytes::new(file, "", content);
    bytes.go_to(from + end + 10);
    let count = bytes.u16("the directory")?;
    bytes.u32("the directory")?;
    let start = bytes.u32("the directory")?;
    if count == u16::MAX || u64::from(start) == ELSEWHERE {
        return Err(bytes.error("the archive has a directory for more than 4 GB", CURE));
    }
    bytes.go_to(start as usize);
    (0..count).map(|_| entry(&mut bytes)).collect()
}

fn entry(bytes: &mut Bytes<'_>) -> Result<Entry, RecordingError> {
    const WHAT: &str = "an entry of the directory";
    if bytes.take(4, WHAT)? != b"PK\x01\x02" {
        return Err(bytes.error("an entry of the zip directory does not begin here", COPY));
    }
    bytes.take(4, WHAT)?;
    let is_encrypted = bytes.u16(WHAT)? & 1 == 1;
    let method = bytes.u16(WHAT)?;
    bytes.take(4, WHAT)?;
    let crc = bytes.u32(WHAT)?;
    let (packed, size) = (u64::from(bytes.u32(WHAT)?), u64::from(bytes.u32(WHAT)?));
    let lengths = [bytes.u16(WHAT)?, bytes.u16(WHAT)?, bytes.u16(WHAT)?].map(usize::from);
    bytes.take(8, WHAT)?;
    let at = u64::from(bytes.u32(WHAT)?);
    let name = String::from_utf8_lossy(bytes.take(lengths[0], WHAT)?).into_owned();
    let extra = bytes.split(lengths[1], WHAT)?;
    bytes.take(lengths[2], WHAT)?;
    let [size, packed, at] = wide(extra, [size, packed, at])?;
    Ok(Entry { name, method, is_encrypted, crc, packed, size, at })
}

/// Replaces the numbers that stand in the extra field with 64 bits.
fn wide(mut extra: Bytes<'_>, numbers: [u64; 3]) -> Result<[usize; 3], RecordingError> {
    const WHAT: &str = "an extra field of the directory";
    let mut numbers = numbers;
    while extra.left() >= 4 {
        let (kind, length) = (extra.u16(WHAT)?, extra.u16(WHAT)?);
        let mut field = extra.split(usize::from(length), WHAT)?;
        if kind == 1 {
            for number in numbers.iter_mut().filter(|number| **number == ELSEWHERE) {
                *number = field.u64(WHAT)?;
            }
        }
    }
    Ok(numbers.map(|number| usize::try_from(number).unwrap_or(usize::MAX)))
}

impl Entry {
    /// The content; `budget` is what all entries together may still expand to.
    ///
    /// # Errors
    /// A damaged entry, a compression that is not read, more bytes than stated or allowed.
    pub fn read<'a>(&self, file: &str, content: &'a [u8], budget: &mut usize) -> Result<Cow<'a, [u8]>, RecordingError> {
        let part = format!("`{}`, ", self.name);
        let mut bytes = Bytes::new(file, &part, content);
        bytes.go_to(self.at);
        if self.is_encrypted {
            return Err(bytes.error("the entry is encrypted", "write the archive again without a password"));
        }
        if self.size > *budget {
            let found = format!("the entry states {} bytes, absurd for a file of {}", self.size, content.len());
            return Err(bytes.error(found, COPY));
        }
        *budget -= self.size;
        if bytes.take(4, "the entry")? != b"PK\x03\x04" {
            return Err(bytes.error("an entry of the zip archive does not begin here", COPY));
        }
        bytes.take(22, "the entry")?;
        let lengths = [bytes.u16("the entry")?, bytes.u16("the entry")?].map(usize::from);
        bytes.take(lengths[0] + lengths[1], "the entry")?;
        let from = bytes.at();
        bytes.take(self.packed, "the entry")?;
        let packed = &content[from..bytes.at()];
        let data = match self.method {
            0 => Cow::Borrowed(packed),
            8 => Cow::Owned(
                expanded(DeflateDecoder::new(packed), self.size)
                    .map_err(|reason| bytes.error(format!("the entry cannot be expanded: {reason}"), COPY))?,
            ),
            other => return Err(bytes.error(format!("compression method {other} is not read"), CURE)),
        };
        if data.len() != self.size || crc32fast::hash(&data) != self.crc {
            let found = format!("the entry has {} bytes of {} or another checksum than stated", data.len(), self.size);
            return Err(bytes.error(found, COPY));
        }
        Ok(data)
    }
}
