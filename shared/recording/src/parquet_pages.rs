//! The pages of one column of a Parquet file.

use crate::bytes::{Bytes, COPY};
use crate::error::RecordingError;
use crate::parquet_encodings as encodings;
use crate::parquet_schema::{Leaf, Meaning, Physical};
use crate::parquet_thrift::{self as thrift, Value};
use crate::parquet_unpack::{compression, unpacked};
use crate::text::stamps::Form;
use crate::texts::{Cell, cell, seconds_of};
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
    /// Rows are lists.
    is_list: bool,
    /// The numbers that indices stand for.
    dictionary: Option<Vec<u64>>,
    /// Form of the dates before.
    form: Option<Form>,
    pages: Pages,
}

/// What pages hold.
#[derive(Debug, Default)]
pub(crate) struct Pages {
    /// NaN for what is missing.
    pub values: Vec<f64>,
    /// What they do not hold of whole numbers; empty: nothing.
    pub rest: Vec<f64>,
    /// Whether a value is the first of its row; empty where each is.
    pub starts: Vec<bool>,
    /// What texts are.
    kinds: u8,
}

const NUMBER: u8 = 1;
const DATE: u8 = 2;
/// Bits of a text that says that there is no value.
const MISSING: u64 = u64::MAX;

impl Pages {
    /// Adds what follows.
    pub fn extend(&mut self, other: Pages) {
        if !other.rest.is_empty() {
            self.rest.resize(self.values.len(), 0.0);
            self.rest.extend(other.rest);
        }
        self.values.extend(other.values);
        self.starts.extend(other.starts);
        self.kinds |= other.kinds;
    }

    /// Whether texts are numbers or dates, all of them.
    pub fn is_number(&self) -> bool {
        self.kinds.count_ones() == 1
    }

    /// Whether texts are dates.
    pub fn is_date(&self) -> bool {
        self.kinds == DATE
    }
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
            is_list: leaf.is_list,
            dictionary: None,
            form: None,
            pages: Pages::default(),
        })
    }

    /// Values of the column, those that are missing included.
    pub fn count(&self) -> usize {
        self.count
    }

    /// All values.
    ///
    /// # Errors
    /// A damaged page, a compression or an encoding that is not read, a text that is no number.
    pub fn read(mut self) -> Result<Pages, RecordingError> {
        while self.pages.values.len() < self.count {
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
        if !self.pages.rest.is_empty() {
            self.pages.rest.resize(self.pages.values.len(), 0.0);
        }
        Ok(self.pages)
    }

    fn error(&self, found: impl Into<String>) -> RecordingError {
        Bytes::new(self.file, &self.part, &[]).error(found, COPY)
    }

    fn dictionary(&mut self, head: &Value, data: &[u8]) -> Result<Vec<u64>, RecordingError> {
        let page = self.unpacked(data, head.size(2))?;
        let count = head.get(7).and_then(|head| head.size(1));
        let count = count.ok_or_else(|| self.error("a dictionary without a count"))?;
        if self.meaning.physical == Physical::Text {
            let part = self.part.clone();
            return self.texts(&mut Bytes::new(self.file, &part, &page), count);
        }
        encodings::plain(&mut Bytes::new(self.file, &self.part, &page), self.meaning.physical, count)
    }

    /// Texts as bits: of nanoseconds since 1970, or of a number.
    fn texts(&mut self, bytes: &mut Bytes<'_>, count: usize) -> Result<Vec<u64>, RecordingError> {
        let mut all = Vec::new();
        for text in encodings::texts(bytes, count)? {
            let found = core::str::from_utf8(text).map_or(Cell::Text, |text| cell(text, &mut self.form));
            all.push(match found {
                Cell::Number(value) => {
                    self.pages.kinds |= NUMBER;
                    value.to_bits()
                }
                Cell::Date(ns) => {
                    self.pages.kinds |= DATE;
                    ns as u64
                }
                Cell::Missing => MISSING,
                Cell::Text => return Err(self.error("a text is no number")),
            });
        }
        Ok(all)
    }

    /// The number that bits stand for, and what its `f64` does not hold.
    fn value(&self, bits: u64) -> (f64, f64) {
        match self.meaning.physical {
            Physical::Text if bits == MISSING => (f64::NAN, 0.0),
            Physical::Text if self.pages.kinds == DATE => seconds_of(i128::from(bits as i64)),
            _ => (self.meaning.value(bits), self.meaning.rest(bits)),
        }
    }

    /// Adds where rows begin, by the levels of repetition.
    fn add_starts(&mut self, mut levels: Bytes<'_>, count: usize) -> Result<(), RecordingError> {
        let levels = encodings::runs(&mut levels, 1, count)?;
        self.pages.starts.extend(levels.into_iter().map(|level| level == 0));
        Ok(())
    }

    /// A page of the first kind: levels and values, compressed together.
    fn page(&mut self, head: &Value, data: &[u8]) -> Result<(), RecordingError> {
        let page = self.unpacked(data, head.size(2))?;
        let part = self.part.clone();
        let mut bytes = Bytes::new(self.file, &part, &page);
        let head = head.get(5).ok_or_else(|| self.error("a page without a header"))?;
        let count = self.count_of(head)?;
        if self.is_list {
            let length = bytes.u32("the levels")? as usize;
            self.add_starts(bytes.split(length, "the levels")?, count)?;
        }
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
        let repeated = bytes.split(repetition, "the levels")?;
        if self.is_list {
            self.add_starts(repeated, count)?;
        }
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
        let left = self.count - self.pages.values.len();
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
        let physical = self.meaning.physical;
        let stored = if physical == Physical::Text && encoding == Some(0) {
            self.texts(&mut bytes, number)?
        } else {
            decoded(&mut bytes, encoding, number, physical, self.dictionary.as_deref())?
        };
        let mut stored = stored.into_iter();
        for k in 0..count {
            let is_there = there.as_ref().is_none_or(|there| there[k]);
            let bits = if is_there { stored.next() } else { None };
            let (value, rest) = bits.map_or((f64::NAN, 0.0), |bits| self.value(bits));
            let pages = &mut self.pages;
            pages.values.push(value);
            // most columns leave none
            if rest != 0.0 {
                pages.rest.resize(pages.values.len(), 0.0);
                pages.rest[pages.values.len() - 1] = rest;
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
        let data = unpacked(self.codec, packed, size).ok_or_else(|| {
            let found = format!("the compression {} (number {}) is not read", compression(self.codec), self.codec);
            Bytes::new(self.file, &self.part, &[]).error(found, CURE)
        })?;
        let data = data.map_err(|reason| self.error(format!("a page cannot be expanded: {reason}")))?;
        if data.len() == size {
            Ok(Cow::Owned(data))
        } else {
            Err(self.error("a page has another size than it states"))
        }
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
        Some(0) if physical != Physical::Text => encodings::plain(bytes, physical, count),
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
        Some(9) if matches!(physical, Physical::Whole32 | Physical::Whole64 | Physical::Float | Physical::Double) => {
            encodings::split_bytes(bytes, physical, count)
        }
        other => Err(bytes.error(format!("the encoding {other:?} is not read for these numbers"), CURE)),
    }
}
