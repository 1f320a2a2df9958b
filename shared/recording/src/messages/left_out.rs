//! What is left out of a dataset: counted and named in one note.

use std::collections::{BTreeMap, BTreeSet};

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
            Reason::Text => "text field(s)",
            Reason::Bytes => "field(s) of bytes",
            Reason::Map => "map(s)",
            Reason::LongArray => "array(s) longer than 64",
            Reason::VaryingArray => "array(s) of varying length",
            Reason::Excess => "field(s) beyond 1024 columns",
            Reason::Sparse => "field(s) with few values",
        }
    }
}

/// Fields that are left out, each once.
#[derive(Default)]
pub(crate) struct LeftOut {
    fields: BTreeMap<Reason, BTreeSet<String>>,
    /// Some fields had no place in `fields`.
    more: bool,
}

/// Fields of one reason that are remembered.
const REMEMBERED_MAX: usize = 128;
/// Fields of one reason that are named.
const SHOWN_MAX: usize = 6;
/// Bytes of a name that are remembered.
const SHOWN_BYTES_MAX: usize = 128;

impl LeftOut {
    /// Remembers that `field` is left out.
    pub fn add(&mut self, reason: Reason, field: &str) {
        let field = &field[..field.floor_char_boundary(SHOWN_BYTES_MAX)];
        let fields = self.fields.entry(reason).or_default();
        if fields.contains(field) {
            return;
        }
        if fields.len() == REMEMBERED_MAX {
            self.more = true;
            return;
        }
        fields.insert(field.into());
    }

    /// Whether `field` is left out for this reason.
    pub fn has(&self, reason: Reason, field: &str) -> bool {
        let field = &field[..field.floor_char_boundary(SHOWN_BYTES_MAX)];
        self.fields.get(&reason).is_some_and(|fields| fields.contains(field))
    }

    /// The note, when anything is left out.
    pub fn note(&self) -> Option<String> {
        let part = |(reason, fields): (&Reason, &BTreeSet<String>)| {
            let shown: Vec<String> = fields.iter().take(SHOWN_MAX).map(|name| format!("`{name}`")).collect();
            let dots = if fields.len() > SHOWN_MAX { ", ..." } else { "" };
            format!("{} {} ({}{dots})", fields.len(), reason.text(), shown.join(", "))
        };
        let parts: Vec<String> = self.fields.iter().filter(|(_, fields)| !fields.is_empty()).map(part).collect();
        let more = if self.more { "; and more" } else { "" };
        (!parts.is_empty()).then(|| format!("left out: {}{more}", parts.join("; ")))
    }
}
