//! The compressions of the pages of a Parquet file.

use crate::bytes::expanded;

/// The bytes that expand to `size`, or why they do not; `None` of a compression that is not read.
pub(crate) fn unpacked(codec: i64, packed: &[u8], size: usize) -> Option<Result<Vec<u8>, String>> {
    let data = match codec {
        1 => snappy(packed, size),
        2 => expanded(flate2::read::MultiGzDecoder::new(packed), size).map_err(|reason| reason.to_string()),
        6 => zstd::stream::read::Decoder::with_buffer(packed)
            .and_then(|stream| expanded(stream, size))
            .map_err(|reason| reason.to_string()),
        7 => lz4(packed, size).ok_or_else(|| "the bytes are no block of LZ4".to_string()),
        _ => return None,
    };
    Some(data)
}

/// Name of a compression that is not read.
pub(crate) fn compression(number: i64) -> &'static str {
    match number {
        3 => "LZO",
        4 => "Brotli",
        5 => "LZ4 of Hadoop",
        _ => "of an unknown kind",
    }
}

fn snappy(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let stated = snap::raw::decompress_len(packed).map_err(|reason| reason.to_string())?;
    if stated != size {
        return Err(format!("{stated} bytes are stated inside, {size} outside"));
    }
    snap::raw::Decoder::new().decompress_vec(packed).map_err(|reason| reason.to_string())
}

/// A block of LZ4: literal bytes, then bytes that stood before, in turn.
fn lz4(packed: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut rest = packed.iter().copied();
    let mut out: Vec<u8> = Vec::new();
    let length = |short: u8, rest: &mut dyn Iterator<Item = u8>| {
        let mut length = usize::from(short);
        if short == 15 {
            loop {
                let more = rest.next()?;
                length += usize::from(more);
                if more != 255 {
                    break;
                }
            }
        }
        Some(length)
    };
    loop {
        let token = rest.next()?;
        let literal = length(token >> 4, &mut rest)?;
        if out.len() + literal > size {
            return None;
        }
        let before = out.len();
        out.extend(rest.by_ref().take(literal));
        if out.len() - before < literal {
            return None;
        }
        let Some(low) = rest.next() else { return Some(out) };
        let distance = usize::from(u16::from_le_bytes([low, rest.next()?]));
        let copied = length(token & 15, &mut rest)? + 4;
        let from = out.len().checked_sub(distance).filter(|_| distance > 0 && out.len() + copied <= size)?;
        for place in from..from + copied {
            out.push(out[place]);
        }
    }
}
