//! The end of an archive that would never end.

use std::io::{Error, ErrorKind, Read};

/// A packed table may hold so many times its bytes: of a cell of 20 characters one digit at least
/// is new, which takes 3.3 of its 160 bits.
const UNPACKED_RATIO: u64 = 50;
/// What every packed table may hold \[bytes\]: cells of constants are packed better than that.
const UNPACKED_FREE: u64 = 64 << 20;

/// Most bytes that an archive of `packed` bytes may hold.
pub(crate) fn unpacked_max(packed: u64) -> u64 {
    packed.saturating_mul(UNPACKED_RATIO).max(UNPACKED_FREE)
}

/// A source that fails where it gives more than it may, with [`ErrorKind::FileTooLarge`].
pub(crate) struct AtMost<R> {
    source: R,
    left: u64,
}

impl<R: Read> AtMost<R> {
    /// At most `most` bytes of `source`.
    pub fn new(source: R, most: u64) -> Self {
        AtMost { source, left: most }
    }
}

impl<R: Read> Read for AtMost<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let read = self.source.read(out)?;
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| {
            Error::new(ErrorKind::FileTooLarge, format!("it holds more than {UNPACKED_RATIO} times its own bytes"))
        })?;
        Ok(read)
    }
}
