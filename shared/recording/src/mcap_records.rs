//! Layout of records in an MCAP file (mcap.dev/spec): opcode, length, then fields in little-endian
//! order, texts and maps behind their length in bytes.

use std::collections::BTreeMap;

/// Opcode and length.
pub(crate) const RECORD_HEADER: usize = 9;

/// Records as bytes.
#[derive(Default)]
pub(crate) struct Records(Vec<u8>);

impl Records {
    pub fn with_capacity(bytes: usize) -> Self {
        Records(Vec::with_capacity(bytes))
    }

    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// A record with the fields that `write` appends.
    pub fn record(&mut self, opcode: u8, write: impl FnOnce(&mut Self)) {
        self.0.push(opcode);
        self.counted_u64(write);
    }

    /// What `write` appends, behind its length.
    pub fn counted_u64(&mut self, write: impl FnOnce(&mut Self)) {
        let at = self.len();
        self.u64(0);
        write(self);
        let length = (self.len() - at - size_of::<u64>()) as u64;
        self.0[at..at + size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    pub fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    pub fn u16(&mut self, value: u16) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn u64(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.bytes(text.as_bytes());
    }

    pub fn texts(&mut self, map: &BTreeMap<String, String>) {
        let bytes = map.iter().map(|(key, value)| 2 * size_of::<u32>() + key.len() + value.len()).sum::<usize>();
        self.u32(bytes as u32);
        for (key, value) in map {
            self.text(key);
            self.text(value);
        }
    }

    /// A map of a channel's number to `values`.
    pub fn by_channel(&mut self, values: impl Iterator<Item = (u16, u64)> + Clone) {
        self.u32((values.clone().count() * (size_of::<u16>() + size_of::<u64>())) as u32);
        for (channel, value) in values {
            self.u16(channel);
            self.u64(value);
        }
    }

    /// Appends what `fill` writes into `room` bytes, of which it returns how many it used.
    pub fn fill<E>(&mut self, room: usize, fill: impl FnOnce(&mut [u8]) -> Result<usize, E>) -> Result<(), E> {
        let start = self.len();
        self.0.resize(start + room, 0);
        let used = fill(&mut self.0[start..])?;
        self.0.truncate(start + used);
        Ok(())
    }
}
