//! Bits of a byte stream, the highest of every byte first.

/// Bits that are read from front to back.
pub(super) struct Bits<'a> {
    rest: &'a [u8],
    /// The low `count` bits are the next ones.
    buffer: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Bits { rest: bytes, buffer: 0, count: 0 }
    }

    /// The next `count` bits, at most 32.
    ///
    /// # Errors
    /// When there are fewer.
    pub fn take(&mut self, count: u32) -> Result<u32, String> {
        while self.count < count {
            let (first, rest) = self.rest.split_first().ok_or("a bzip2 stream ends early")?;
            self.rest = rest;
            self.buffer = (self.buffer << 8) | u64::from(*first);
            self.count += 8;
        }
        self.count -= count;
        Ok(((self.buffer >> self.count) & ((1 << count) - 1)) as u32)
    }

    /// Goes to the next whole byte.
    pub fn align(&mut self) {
        self.count -= self.count % 8;
    }

    pub fn is_at_end(&self) -> bool {
        self.rest.is_empty() && self.count == 0
    }
}
