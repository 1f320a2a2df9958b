//! bzip2, unpacked: Huffman codes, move to front, Burrows-Wheeler, runs; every block has a CRC.
//!
//! Why not a crate? The pure Rust ones are unmaintained or under a licence of their own.

mod bits;
mod codes;

use bits::Bits;
use codes::{Code, GROUP};

const BLOCK: u64 = 0x3141_5926_5359;
const STREAM_END: u64 = 0x1772_4538_5090;
const CODES_MAX: usize = 6;
/// Symbols of the alphabet: runs of zeros take two, the end of a block one.
const RUN_A: u16 = 0;
const RUN_B: u16 = 1;

/// The content of `packed`, at most `limit` bytes.
///
/// # Errors
/// Where the stream is damaged, or larger than `limit`.
pub(super) fn unpack(packed: &[u8], limit: usize) -> Result<Vec<u8>, String> {
    let mut bits = Bits::new(packed);
    let mut out = Vec::new();
    loop {
        let level = match [bits.take(8)?, bits.take(8)?, bits.take(8)?, bits.take(8)?] {
            [0x42, 0x5a, 0x68, level @ 0x31..=0x39] => level as usize - 0x30,
            _ => return Err("a bzip2 stream does not begin with `BZh`".into()),
        };
        loop {
            match u64::from(bits.take(24)?) << 24 | u64::from(bits.take(24)?) {
                BLOCK => block(&mut bits, level * 100_000, limit, &mut out)?,
                STREAM_END => break,
                other => return Err(format!("{other:#014x} begins no bzip2 block")),
            }
        }
        // The CRC of all blocks: each has its own, which was compared.
        bits.take(32)?;
        bits.align();
        if bits.is_at_end() {
            return Ok(out);
        }
    }
}

fn block(bits: &mut Bits<'_>, size: usize, limit: usize, out: &mut Vec<u8>) -> Result<(), String> {
    let stored = bits.take(32)?;
    if bits.take(1)? != 0 {
        return Err("randomised bzip2 blocks are not read".into());
    }
    let origin = bits.take(24)? as usize;
    let used = used(bits)?;
    let (codes, selectors) = tables(bits, used.len() + 2)?;
    let sorted = symbols(bits, &codes, &selectors, used, size)?;
    if origin >= sorted.len() {
        return Err("a bzip2 block begins outside of itself".into());
    }
    let from = out.len();
    unsorted(&sorted, origin, limit, out)?;
    let computed = crc(&out[from..]);
    if computed != stored {
        return Err(format!("CRC of a bzip2 block is {computed:#010x}, stored {stored:#010x}"));
    }
    Ok(())
}

/// The bytes that occur in a block, in their order.
fn used(bits: &mut Bits<'_>) -> Result<Vec<u8>, String> {
    let rows = bits.take(16)?;
    let mut used = Vec::new();
    for row in (0..16_u8).filter(|row| rows & (0x8000 >> row) != 0) {
        let columns = bits.take(16)?;
        used.extend((0..16_u8).filter(|column| columns & (0x8000 >> column) != 0).map(|column| row * 16 + column));
    }
    if used.is_empty() { Err("a bzip2 block without bytes".into()) } else { Ok(used) }
}

/// The Huffman codes of a block, and which of them every 50 symbols use.
fn tables(bits: &mut Bits<'_>, alphabet: usize) -> Result<(Vec<Code>, Vec<u8>), String> {
    let count = bits.take(3)? as usize;
    let selectors = bits.take(15)?;
    if !(2..=CODES_MAX).contains(&count) || selectors == 0 {
        return Err(format!("a bzip2 block with {count} codes and {selectors} selectors"));
    }
    let mut recent: Vec<u8> = (0..count as u8).collect();
    let mut chosen = Vec::new();
    for _ in 0..selectors {
        let mut place = 0;
        while bits.take(1)? == 1 {
            place += 1;
        }
        if place >= count {
            return Err("a selector of a bzip2 block names no code".into());
        }
        recent[..=place].rotate_right(1);
        chosen.push(recent[0]);
    }
    let codes = (0..count).map(|_| Code::read(bits, alphabet)).collect::<Result<_, _>>()?;
    Ok((codes, chosen))
}

/// The sorted block: symbols decoded, runs of the most recent byte written out.
fn symbols(
    bits: &mut Bits<'_>,
    codes: &[Code],
    selectors: &[u8],
    mut recent: Vec<u8>,
    size: usize,
) -> Result<Vec<u8>, String> {
    let end = recent.len() as u16 + 1;
    let mut sorted: Vec<u8> = Vec::new();
    let (mut run, mut weight) = (0_usize, 1_usize);
    for selector in selectors {
        for _ in 0..GROUP {
            let symbol = codes[usize::from(*selector)].symbol(bits)?;
            if symbol == RUN_A || symbol == RUN_B {
                run += weight << symbol;
                weight <<= 1;
                if run > size {
                    return Err("a run longer than a bzip2 block".into());
                }
                continue;
            }
            if sorted.len() + run + 1 > size + usize::from(symbol == end) {
                return Err("more bytes than a bzip2 block holds".into());
            }
            sorted.resize(sorted.len() + run, recent[0]);
            (run, weight) = (0, 1);
            if symbol == end {
                return Ok(sorted);
            }
            let place = usize::from(symbol) - 1;
            recent[..=place].rotate_right(1);
            sorted.push(recent[0]);
        }
    }
    Err("a bzip2 block without an end".into())
}

/// Burrows-Wheeler undone, then runs: four equal bytes are followed by how many more there are.
fn unsorted(sorted: &[u8], origin: usize, limit: usize, out: &mut Vec<u8>) -> Result<(), String> {
    let mut starts = [0_u32; 256];
    for byte in sorted {
        starts[usize::from(*byte)] += 1;
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += core::mem::replace(start, sum);
    }
    let mut next = vec![0_u32; sorted.len()];
    for (from, byte) in (0_u32..).zip(sorted) {
        let start = &mut starts[usize::from(*byte)];
        next[*start as usize] = from;
        *start += 1;
    }
    let mut place = next[origin] as usize;
    let (mut last, mut equal) = (None, 0);
    for _ in 0..sorted.len() {
        let byte = sorted[place];
        place = next[place] as usize;
        let (value, count) = match last {
            Some(value) if equal == 4 => {
                (last, equal) = (None, 0);
                (value, usize::from(byte))
            }
            _ => {
                equal = if last == Some(byte) { equal + 1 } else { 1 };
                last = Some(byte);
                (byte, 1)
            }
        };
        if out.len() + count > limit {
            return Err(format!("a bzip2 stream of more than the stated {limit} bytes"));
        }
        out.resize(out.len() + count, value);
    }
    Ok(())
}

/// CRC-32 with the highest bit first.
fn crc(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0_u32; 256];
        let mut index = 0;
        while index < 256 {
            let mut crc = (index as u32) << 24;
            let mut bit = 0;
            while bit < 8 {
                crc = if crc & 0x8000_0000 != 0 { (crc << 1) ^ 0x04c1_1db7 } else { crc << 1 };
                bit += 1;
            }
            table[index] = crc;
            index += 1;
        }
        table
    };
    !bytes.iter().fold(!0_u32, |crc, byte| (crc << 8) ^ TABLE[((crc >> 24) as u8 ^ byte) as usize])
}
