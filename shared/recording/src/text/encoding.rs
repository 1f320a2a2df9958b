//! Bytes of a text file as UTF-8: UTF-16 with its mark (or told by its zeros) is decoded on the
//! way, ends of lines by carriage returns alone are line feeds; what is no UTF-8 is read as
//! Latin-1, line by line.

use std::io::{self, BufRead, Read};

/// How the bytes are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// UTF-8, or a superset of ASCII.
    Bytes,
    Utf16Little,
    Utf16Big,
}

impl Encoding {
    /// Of a file that begins with `head`; `None` for bytes that are no text.
    pub fn of(head: &[u8]) -> Option<Self> {
        match head {
            [0xff, 0xfe, ..] => return Some(Encoding::Utf16Little),
            [0xfe, 0xff, ..] => return Some(Encoding::Utf16Big),
            _ if !head.contains(&0) || is_filled_up(head) => return Some(Encoding::Bytes),
            _ => {}
        }
        let pairs: Vec<&[u8]> = head.chunks_exact(2).collect();
        let zeros = |k: usize| pairs.iter().filter(|pair| pair[k] == 0).count();
        let (first, second) = (zeros(0), zeros(1));
        let most = pairs.len() * 9 / 10;
        match (first, second) {
            (0, second) if second > most => Some(Encoding::Utf16Little),
            (first, 0) if first > most => Some(Encoding::Utf16Big),
            _ => None,
        }
    }
}

/// Text, and behind it nothing but zeros: a logger that allocates its file before it fills it.
fn is_filled_up(head: &[u8]) -> bool {
    const ZEROS_MIN: usize = 16;
    let text = head.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    text > 0 && head.len() - text >= ZEROS_MIN && !head[..text].contains(&0)
}

/// Lines that end in a carriage return alone, as lines that end in a line feed.
pub(crate) struct Returns<R>(pub R);

impl<R> Returns<R> {
    /// A file that begins with `head` has such lines.
    pub fn are_in(head: &[u8]) -> bool {
        head.contains(&b'\r') && !head.contains(&b'\n')
    }
}

impl<R: Read> Read for Returns<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.0.read(out)?;
        out[..n].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
        Ok(n)
    }
}

/// UTF-16 as UTF-8.
pub(crate) struct Utf16<R> {
    source: R,
    little: bool,
    high: Option<u16>,
    /// Decoded and not yet taken.
    ready: Vec<u8>,
    taken: usize,
}

impl<R: BufRead> Utf16<R> {
    /// Decodes `source`; characters that are none become U+FFFD.
    pub fn new(source: R, little: bool) -> Self {
        Utf16 { source, little, high: None, ready: Vec::new(), taken: 0 }
    }

    fn decode(&mut self) -> io::Result<()> {
        self.ready.clear();
        self.taken = 0;
        let mut pairs = Vec::with_capacity(1 << 14);
        let read = (&mut self.source).take(1 << 14).read_to_end(&mut pairs)?;
        let units = pairs.chunks_exact(2).map(|pair| {
            let pair = [pair[0], pair[1]];
            if self.little { u16::from_le_bytes(pair) } else { u16::from_be_bytes(pair) }
        });
        let mut units: Vec<u16> = self.high.take().into_iter().chain(units).collect();
        let cut = units.last().is_some_and(|unit| (0xd800..0xdc00).contains(unit)) && read == 1 << 14;
        self.high = if cut { units.pop() } else { None };
        let mut utf8 = [0; 4];
        for c in char::decode_utf16(units) {
            self.ready.extend(c.unwrap_or('\u{fffd}').encode_utf8(&mut utf8).bytes());
        }
        Ok(())
    }
}

impl<R: BufRead> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.ready.len() {
            self.decode()?;
        }
        let n = out.len().min(self.ready.len() - self.taken);
        out[..n].copy_from_slice(&self.ready[self.taken..self.taken + n]);
        self.taken += n;
        Ok(n)
    }
}

/// A line as text: UTF-8, else Latin-1.
pub(crate) fn text_of(line: &[u8]) -> String {
    core::str::from_utf8(line).map_or_else(|_| line.iter().map(|byte| char::from(*byte)).collect(), str::to_owned)
}
