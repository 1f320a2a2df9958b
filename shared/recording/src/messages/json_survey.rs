//! A first look at a file of JSON: which lists of objects hold rows, and which hold structures.
//!
//! The objects of a list are its rows, unless rows run inside of them: they hold lists that are
//! longer than the list of objects, and no time of their own.

use crate::intake::clock;
use crate::texts::{Cell, cell};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// A list of objects with fewer elements may hold structures whatever their length.
const ROWS_MIN: usize = 8;

/// Of every list of objects, in the order in which they begin, those inside of rows left out:
/// whether it holds structures.
///
/// # Errors
/// The text is no JSON.
pub(super) fn structures(content: &[u8]) -> serde_json::Result<Vec<bool>> {
    let mut lists = Vec::new();
    let mut text = serde_json::Deserializer::from_slice(content);
    Survey(&mut lists).deserialize(&mut text)?;
    text.end()?;
    Ok(lists)
}

/// Whether a key is no name: the objects with such keys are lists that their keys count.
pub(super) fn is_index(key: &str) -> bool {
    !key.is_empty() && matches!(cell(key, &mut None), Cell::Number(_) | Cell::Date(_))
}

struct Survey<'l>(&'l mut Vec<bool>);

/// What a value is.
#[derive(Clone, Copy, Default)]
struct Seen {
    /// Elements of the longest list in it.
    longest: usize,
    is_scalar: bool,
    is_object: bool,
    /// It states a time.
    has_clock: bool,
}

const SCALAR: Seen = Seen { longest: 0, is_scalar: true, is_object: false, has_clock: false };

/// A list while it is read.
#[derive(Default)]
struct List {
    count: usize,
    longest_inside: usize,
    /// Place among the lists of objects.
    place: Option<usize>,
    has_clock: bool,
}

impl List {
    fn add(&mut self, element: Seen) {
        self.count += 1;
        self.longest_inside = self.longest_inside.max(element.longest);
        self.has_clock |= element.has_clock;
    }

    fn end(self, lists: &mut Vec<bool>) -> Seen {
        let holds_structures = !self.has_clock && self.longest_inside > self.count.max(ROWS_MIN);
        if let Some(place) = self.place {
            lists[place] = holds_structures;
            if !holds_structures {
                lists.truncate(place + 1);
            }
        }
        Seen { longest: self.longest_inside.max(self.count), ..Seen::default() }
    }
}

impl<'de> DeserializeSeed<'de> for Survey<'_> {
    type Value = Seen;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Seen, D::Error> {
        deserializer.deserialize_any(self)
    }
}

/// An element of a list; the first object takes the place of its list.
struct Element<'l>(&'l mut Vec<bool>, &'l mut List);

impl<'de> DeserializeSeed<'de> for Element<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        // the place is kept free for an object: what is in it comes behind
        let before = self.0.len();
        if self.1.place.is_none() {
            self.0.push(false);
        }
        let seen = Survey(self.0).deserialize(deserializer)?;
        if !seen.is_object {
            // lists in lists are numbers, or not read
            self.0.truncate(before);
        } else if self.1.place.is_none() {
            self.1.place = Some(before);
        }
        self.1.add(seen);
        Ok(())
    }
}

impl<'de> Visitor<'de> for Survey<'_> {
    type Value = Seen;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Seen, A::Error> {
        let mut seen = Seen { is_object: true, ..Seen::default() };
        let mut list: Option<List> = None;
        let mut is_first = true;
        while let Some(key) = map.next_key::<String>()? {
            if std::mem::take(&mut is_first) && is_index(&key) {
                list = Some(List::default());
            }
            if let Some(list) = &mut list {
                map.next_value_seed(Element(self.0, list))?;
                continue;
            }
            let value = map.next_value_seed(Survey(self.0))?;
            seen.longest = seen.longest.max(value.longest);
            seen.has_clock |= value.has_clock || (value.is_scalar && clock::rank(&key).is_some());
        }
        Ok(match list {
            Some(list) => Seen { is_object: true, ..list.end(self.0) },
            None => seen,
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Seen, A::Error> {
        let mut list = List::default();
        while elements.next_element_seed(Element(self.0, &mut list))?.is_some() {}
        Ok(list.end(self.0))
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<Seen, E> {
        Ok(SCALAR)
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<Seen, E> {
        Ok(SCALAR)
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<Seen, E> {
        Ok(SCALAR)
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<Seen, E> {
        Ok(SCALAR)
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<Seen, E> {
        Ok(SCALAR)
    }

    fn visit_unit<E: Error>(self) -> Result<Seen, E> {
        Ok(SCALAR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_of_a_list_are_rows_unless_rows_run_inside_of_them() {
        let nine = "[1,2,3,4,5,6,7,8,9]";
        let cases = [
            ("[{\"t\":1},{\"t\":2}]".to_owned(), vec![false]),
            (format!("[{{\"x\":{nine}}},{{\"x\":{nine}}}]"), vec![true]),
            (format!("[{{\"t\":1,\"x\":{nine}}}]"), vec![false]),
            (format!("{{\"a\":[{{\"b\":[{{\"x\":{nine}}}]}}],\"c\":[{{\"d\":1}}]}}"), vec![true, true, false]),
            (format!("[{{\"t\":1,\"b\":[{{\"x\":{nine}}}]}}]"), vec![false]),
            ("{\"0\":{\"x\":1},\"1\":{\"x\":2}}".to_owned(), vec![false]),
            ("[[1,2],[3,4]]".to_owned(), vec![]),
        ];
        for (text, expected) in cases {
            assert_eq!(structures(text.as_bytes()).unwrap(), expected, "{text}");
        }
    }
}
