//! What is left out of a dataset: counted and named in one note.

use std::collections::BTreeSet;

/// Why a field gives no column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Reason {
    Text,
    Bytes,
    Map,
    LongArray,
    VaryingArray,
    /// There are too many columns, or its name is too long.
    Excess,
    /// It has a value in few of the rows.
    Sparse,
}

impl Reason {
    fn text(self) -> &'static str {
        match self {
            Reason::Text => "text",
            Reason::Bytes => "bytes",
            Reason::Map => "maps",
            Reason::LongArray => "arrays longer than 64",
            Reason::VaryingArray => "arrays of varying length",
            Reason::Excess => "fields beyond the first 1024",
            Reason::Sparse => "fields with few values",
        }
    }
}

/// Fields that are left out, each once.
#[derive(Default)]
pub(crate) struct LeftOut {
    fields: BTreeSet<(Reason, String)>,
    /// Some fields had no place in `fields`.
    more: bool,
}

/// Fields that are remembered.
const FIELDS_MAX: usize = 256;
/// Fields of one reason that are named.
const NAMED_MAX: usize = 6;
/// Bytes of a name that is remembered.
const NAME_MAX: usize = 128;

impl LeftOut {
    /// Remembers that `field` is left out.
    pub fn add(&mut self, reason: Reason, field: &str) {
        let end = (0..=NAME_MAX.min(field.len())).rev().find(|end| field.is_char_boundary(*end)).unwrap_or(0);
        let key = (reason, field[..end].to_string());
        if self.fields.len() < FIELDS_MAX {
            self.fields.insert(key);
        } else if !self.fields.contains(&key) {
            self.more = true;
        }
    }

    /// The note, when anything is left out.
    pub fn note(&self) -> Option<String> {
        let mut parts = Vec::new();
        let reasons: BTreeSet<Reason> = self.fields.iter().map(|(reason, _)| *reason).collect();
        for reason in reasons {
            let names: Vec<String> =
                self.fields.iter().filter(|(of, _)| *of == reason).map(|(_, name)| format!("`{name}`")).collect();
            let shown = names[..names.len().min(NAMED_MAX)].join(", ");
            let dots = if names.len() > NAMED_MAX { ", ..." } else { "" };
            parts.push(format!("{} {} ({shown}{dots})", names.len(), reason.text()));
        }
        let more = if self.more { ", and more" } else { "" };
        (!parts.is_empty()).then(|| format!("left out: {}{more}", parts.join("; ")))
    }
}
