//! The pages of one column of a Parquet file.

use crate::bytes::{Bytes, COPY, expanded};
use crate::error::RecordingError;
use crate::parquet_encodings as encodings;
use crate::parquet_schema::{Leaf, Meaning, Physical};
use crate::parquet_thrift::{self as thrift, Value};
use std::borrow::Cow;

const CURE: &str = "write the file again, with the compression `snappy` and without encryption";

/// Levels of a kind that writers left years ago.
const BIT_PACKED: i64 = 4;

/// One column in one row group.
pub(crate) struct Chunk<'a> {
    file: &'a str,
    part: String,
    /// From the first page on.
    bytes: Bytes<'a>,
    codec: i64,
    /// Values of the column, those that are missing included.
    count: usize,
    /// Bytes that the pages may still expand to.
    limit: usize,
    /// Level of a value that is there.
    level: u32,
    meaning: Meaning,
    /// The numbers that indices stand for.
    dictionary: Option<Vec<u64>>,
    values: Vec<f64>,
    /// What they do not hold of whole numbers; empty: nothing.
    rest: Vec<f64>,
}

impl<'a> Chunk<'a> {
    /// The column that `metadata` describes; `limit` is what its pages may expand to.
    ///
    /// # Errors
    /// Its place is not in the file, or it has no numbers.
    pub fn open(
        file: &'a str,
        content: &'a [u8],
        metadata: &Value,
        leaf: &Leaf,
        limit: usize,
    ) -> Result<Self, RecordingError> {
        let name = &leaf.name;
        let mut bytes = Bytes::new(file, "", content);
        let first = [metadata.size(11).filter(|at| *at > 0), metadata.size(9)].into_iter().flatten().min();
        let (Some(first), Some(size), Some(count), Some(codec), Ok(meaning)) =
            (first, metadata.size(7), metadata.size(5), metadata.whole(4), leaf.meaning.clone())
        else {
            return Err(bytes.error(format!("the place of the column `{name}` is not stated"), COPY));
        };
        bytes.go_to(first);
        let bytes = bytes.split(size, "a column")?;
        let part = format!("column `{name}` at byte {first}, ");
        let level = leaf.level;
        Ok(Self {
            file,
            part,
            bytes,
            codec,
            count,
            limit,
            level,
            meaning,
            dictionary: None,
            values: Vec::new(),
            rest: Vec::new(),
        })
    }

    /// Values of the column, those that are missing included.
    pub fn count(&self) -> usize {
        self.count
    }

    /// All values, NaN for what is missing, and what they do not hold of whole numbers.
    ///
    /// # Errors
    /// A damaged page, a compression or an encoding that is not read.
    pub fn read(mut self) -> Result<(Vec<f64>, Vec<f64>), RecordingError> {
        while self.values.len() < self.count {
            let head = thrift::structure(&mut self.bytes)?;
            let size = head.size(3).ok_or_else(|| self.error("a page without a size"))?;
            let data = self.bytes.take(size, "a page")?;
            match head.whole(1) {
                Some(0) => self.page(&head, data)?,
                Some(2) => self.dictionary = Some(self.dictionary(&head, data)?),
                Some(3) => self.page_2(&head, data)?,
                _ => {}
            }
        }
        if !self.rest.is_empty() {
            self.rest.resize(self.values.len(), 0.0);
        }
        Ok((self.values, self.rest))
    }

    fn error(&self, found: impl Into<String>) -> RecordingError {
        Bytes::new(self.file, &self.part, &[]).error(found, COPY)
    }

    fn dictionary(&mut self, head: &Value, data: &[u8]) -> Result<Vec<u64>, RecordingError> {
        let page = self.unpacked(data, head.size(2))?;
        let count = head.get(7).and_then(|head| head.size(1));
        let count = count.ok_or_else(|| self.error("a dictionary without a count"))?;
        encodings::plain(&mut Bytes::new(self.file, &self.part, &page), self.meaning.physical, count)
    }

    /// A page of the first kind: levels and values, compressed together.
    fn page(&mut self, head: &Value, data: &[u8]) -> Result<(), RecordingError> {
        let page = self.unpacked(data, head.size(2))?;
        let part = self.part.clone();
        let mut bytes = Bytes::new(self.file, &part, &page);
        let head = head.get(5).ok_or_else(|| self.error("a page without a header"))?;
        let count = self.count_of(head)?;
        let there = if self.level > 0 {
            if head.whole(3) == Some(BIT_PACKED) {
                return Err(bytes.error("levels of an old kind are not read", CURE));
            }
            let length = bytes.u32("the levels")? as usize;
            Some(there(bytes.split(length, "the levels")?, self.level, count)?)
        } else {
            None
        };
        self.add(bytes, head.whole(2), count, there)
    }

    /// A page of the second kind: the levels are not compressed.
    fn page_2(&mut self, head: &Value, data: &[u8]) -> Result<(), RecordingError> {
        let size = head.size(2);
        let head = head.get(8).ok_or_else(|| self.error("a page without a header"))?;
        let count = self.count_of(head)?;
        let part = self.part.clone();
        let mut bytes = Bytes::new(self.file, &part, data);
        let (definition, repetition) = (head.size(5).unwrap_or(0), head.size(6).unwrap_or(0));
        bytes.take(repetition, "the levels")?;
        let levels = bytes.split(definition, "the levels")?;
        let there = if self.level > 0 { Some(there(levels, self.level, count)?) } else { None };
        let packed = bytes.take(bytes.left(), "the values")?;
        let page = if head.truth(7) == Some(false) {
            Cow::Borrowed(packed)
        } else {
            self.unpacked(packed, size.and_then(|size| size.checked_sub(definition + repetition)))?
        };
        self.add(Bytes::new(self.file, &part, &page), head.whole(4), count, there)
    }

    /// Values of a page, those that are missing included.
    fn count_of(&self, head: &Value) -> Result<usize, RecordingError> {
        let left = self.count - self.values.len();
        let count = head.size(1).filter(|count| (1..=left).contains(count));
        count.ok_or_else(|| self.error(format!("a page has {:?} values, {left} are due", head.whole(1))))
    }

    /// Adds the values of a page, which are stored where they are `there`.
    fn add(
        &mut self,
        mut bytes: Bytes<'_>,
        encoding: Option<i64>,
        count: usize,
        there: Option<Vec<bool>>,
    ) -> Result<(), RecordingError> {
        let number = there.as_ref().map_or(count, |there| there.iter().filter(|there| **there).count());
        let meaning = self.meaning;
        let stored = decoded(&mut bytes, encoding, number, meaning.physical, self.dictionary.as_deref())?;
        let mut stored = stored.into_iter().map(|bits| (meaning.value(bits), meaning.rest(bits)));
        let absent = (f64::NAN, 0.0);
        for k in 0..count {
            let is_there = there.as_ref().is_none_or(|there| there[k]);
            let (value, rest) = if is_there { stored.next().unwrap_or(absent) } else { absent };
            self.values.push(value);
            // most columns leave none
            if rest != 0.0 {
                self.rest.resize(self.values.len(), 0.0);
                self.rest[self.values.len() - 1] = rest;
            }
        }
        Ok(())
    }

    /// The bytes of a page that states to expand to `size`.
    fn unpacked<'b>(&mut self, packed: &'b [u8], size: Option<usize>) -> Result<Cow<'b, [u8]>, RecordingError> {
        if self.codec == 0 {
            return Ok(Cow::Borrowed(packed));
        }
        let size = size.filter(|size| *size <= self.limit);
        let size = size.ok_or_else(|| self.error("a page states a size that is absurd for this file"))?;
        self.limit -= size;
        if size == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let data = match self.codec {
            1 => snappy(packed, size),
            2 => expanded(flate2::read::MultiGzDecoder::new(packed), size).map_err(|reason| reason.to_string()),
            6 => zstd::stream::read::Decoder::with_buffer(packed)
                .and_then(|stream| expanded(stream, size))
                .map_err(|reason| reason.to_string()),
            7 => lz4(packed, size).ok_or_else(|| "the bytes are no block of LZ4".to_string()),
            other => {
                let found = format!("the compression {} (number {other}) is not read", compression(other));
                return Err(Bytes::new(self.file, &self.part, &[]).error(found, CURE));
            }
        };
        let data = data.map_err(|reason| self.error(format!("a page cannot be expanded: {reason}")))?;
        if data.len() == size {
            Ok(Cow::Owned(data))
        } else {
            Err(self.error("a page has another size than it states"))
        }
    }
}

fn compression(number: i64) -> &'static str {
    match number {
        3 => "LZO",
        4 => "Brotli",
        5 => "LZ4 of Hadoop",
        _ => "of an unknown kind",
    }
}

/// Which values are there.
fn there(mut levels: Bytes<'_>, level: u32, count: usize) -> Result<Vec<bool>, RecordingError> {
    let levels = encodings::runs(&mut levels, level.ilog2() + 1, count)?;
    Ok(levels.into_iter().map(|found| found == u64::from(level)).collect())
}

/// The bits of `count` numbers.
fn decoded(
    bytes: &mut Bytes<'_>,
    encoding: Option<i64>,
    count: usize,
    physical: Physical,
    dictionary: Option<&[u64]>,
) -> Result<Vec<u64>, RecordingError> {
    match encoding {
        _ if count == 0 => Ok(Vec::new()),
        Some(0) => encodings::plain(bytes, physical, count),
        Some(2 | 8) => {
            let width = u32::from(bytes.u8("the width of indices")?);
            let indices = encodings::runs(bytes, width, count)?;
            let entry = |index: u64| dictionary?.get(usize::try_from(index).ok()?).copied();
            let values: Option<Vec<u64>> = indices.into_iter().map(entry).collect();
            values.ok_or_else(|| bytes.error("an index is not in the dictionary", COPY))
        }
        Some(3) if physical == Physical::Truth => {
            bytes.take(4, "the length of the truths")?;
            encodings::runs(bytes, 1, count)
        }
        Some(5) if matches!(physical, Physical::Whole32 | Physical::Whole64) => encodings::differences(bytes, count),
        Some(9) if !matches!(physical, Physical::Truth | Physical::Date96) => {
            encodings::split_bytes(bytes, physical, count)
        }
        other => Err(bytes.error(format!("the encoding {other:?} is not read for these numbers"), CURE)),
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
