//! Records of a file that were left out, counted, with the first reason.

use super::unpack::Budget;

/// What is left of a walk over the records of a file.
pub(super) struct Damaged {
    /// Bytes that chunks may still expand to.
    pub budget: Budget,
    count: u64,
    first: String,
}

impl Damaged {
    /// Nothing is damaged yet of a file of `size` bytes.
    pub fn new(size: u64) -> Self {
        Damaged { budget: Budget::new(size), count: 0, first: String::new() }
    }

    /// A record at `offset` is left out.
    pub fn add(&mut self, offset: u64, reason: &str) {
        if self.count == 0 {
            self.first = format!("byte {offset}: {reason}");
        }
        self.count += 1;
    }

    /// Says how many, if any.
    pub fn note(&self) -> Option<String> {
        let Damaged { count, first, .. } = self;
        (*count > 0).then(|| format!("{count} records are damaged and left out; the first: {first}"))
    }
}
