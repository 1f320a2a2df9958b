//! Messages in JSON: numbers and truth values of nested objects and arrays, without a tree in
//! memory.

use super::left_out::Reason;
use super::rows::{ELEMENTS_MAX, Rows};
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Puts the numbers of a message into the open row.
///
/// # Errors
/// Where the text stops being JSON.
pub(crate) fn decode(message: &[u8], rows: &mut Rows) -> Result<(), String> {
    let mut text = serde_json::Deserializer::from_slice(message);
    Node(rows).deserialize(&mut text).and_then(|()| text.end()).map_err(|error| error.to_string())
}

struct Node<'r>(&'r mut Rows);

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = ();

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.0.number(f64::from(u8::from(value)), None);
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.0.number(value as f64, None);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.0.number(value as f64, None);
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.0.number(value, None);
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        self.0.leave_out(Reason::Text);
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(mark) = map.next_key_seed(Key(self.0))? {
            map.next_value_seed(Node(self.0))?;
            self.0.leave(mark);
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        let open = self.0.open_array();
        let mut length = 0;
        loop {
            let more = if open && length < ELEMENTS_MAX {
                let mark = self.0.enter_element(length);
                let element = elements.next_element_seed(Node(self.0))?;
                self.0.leave(mark);
                element.is_some()
            } else {
                elements.next_element::<IgnoredAny>()?.is_some()
            };
            if !more {
                break;
            }
            length += 1;
        }
        if open {
            self.0.close_array(length);
        }
        Ok(())
    }
}

/// Goes into the field that a key names.
struct Key<'r>(&'r mut Rows);

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = usize;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E>(self, key: &str) -> Result<usize, E> {
        Ok(self.0.enter(key))
    }
}
