//! Canonical Huffman codes, as bzip2 states them: by the length of every symbol's code.

use super::bits::Bits;

/// Symbols that are read with one code before the next is chosen.
pub(super) const GROUP: usize = 50;
const LENGTH_MAX: usize = 20;

/// A code: the symbols by length, and how many there are of each length.
pub(super) struct Code {
    counts: [u32; LENGTH_MAX + 1],
    symbols: Vec<u16>,
}

impl Code {
    /// Reads the lengths of all codes of an `alphabet`, each as its difference to the one before.
    ///
    /// # Errors
    /// A length that no code has; the end of the stream.
    pub fn read(bits: &mut Bits<'_>, alphabet: usize) -> Result<Self, String> {
        let mut length = bits.take(5)? as usize;
        let mut lengths = Vec::with_capacity(alphabet);
        for _ in 0..alphabet {
            loop {
                if !(1..=LENGTH_MAX).contains(&length) {
                    return Err(format!("a bzip2 code of {length} bits"));
                }
                match bits.take(1)? {
                    0 => break,
                    _ if bits.take(1)? == 0 => length += 1,
                    _ => length -= 1,
                }
            }
            lengths.push(length);
        }
        let mut counts = [0; LENGTH_MAX + 1];
        lengths.iter().for_each(|length| counts[*length] += 1);
        let mut symbols: Vec<u16> = (0..alphabet as u16).collect();
        symbols.sort_by_key(|symbol| lengths[usize::from(*symbol)]);
        Ok(Code { counts, symbols })
    }

    /// The next symbol.
    ///
    /// # Errors
    /// Bits that are no code; the end of the stream.
    pub fn symbol(&self, bits: &mut Bits<'_>) -> Result<u16, String> {
        // Codes of one length follow each other; behind the last, the first of the next length.
        let (mut code, mut first, mut before) = (0_u32, 0_u32, 0_u32);
        for count in &self.counts[1..] {
            code = (code << 1) | bits.take(1)?;
            if code >= first && code - first < *count {
                return self.symbols.get((before + code - first) as usize).copied().ok_or("no symbol".into());
            }
            before += count;
            first = first.wrapping_add(*count) << 1;
        }
        Err("bits of a bzip2 block are no code".into())
    }
}
