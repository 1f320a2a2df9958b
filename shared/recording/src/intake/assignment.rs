//! `own = theirs [unit]`: a channel of the file under the user's own name, with its unit.

use super::names;
use crate::error::{MapPlace, RecordingError};
use crate::units::{Unit, unit_named};
use miette::NamedSource;
use std::sync::Arc;

/// Where an assignment stands, for the error that names it.
#[derive(Clone, Debug)]
pub enum Origin {
    /// `--channel` of the command line.
    CommandLine,
    /// A line of a map file.
    Map {
        /// File, line and column.
        place: Box<MapPlace>,
        /// The whole text of the file.
        text: Arc<NamedSource<String>>,
        /// Bytes of the right side.
        span: core::ops::Range<usize>,
        /// Place and bytes of the own name.
        own: (Box<MapPlace>, core::ops::Range<usize>),
    },
}

impl PartialEq for Origin {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Origin::CommandLine, Origin::CommandLine) => true,
            (Origin::Map { place, .. }, Origin::Map { place: other, .. }) => place == other,
            _ => false,
        }
    }
}

/// Own name, unit and scale of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// Name in the plant and in every answer.
    pub own: String,
    /// Name in the file, or the number of the column from 1.
    pub theirs: String,
    /// In which the file's numbers are, whatever its header says.
    pub unit: Option<Unit>,
    /// Text of that unit.
    pub unit_text: String,
    /// Multiplies what is then in SI; −1 turns the sign.
    pub scale: f64,
    /// Where it was said.
    pub origin: Origin,
}

impl Assignment {
    /// `own = theirs [unit]`, `own = theirs` or `theirs [unit]`.
    ///
    /// # Errors
    /// An empty name, a unit that is not known.
    pub fn parse(text: &str) -> Result<Self, RecordingError> {
        let (own, right) = match text.split_once('=') {
            Some((own, right)) => (Some(own.trim()), right.trim()),
            None => (None, text.trim()),
        };
        let (theirs, unit_text) = names::bracketed(right);
        let own = own.unwrap_or(theirs);
        if own.is_empty() || theirs.is_empty() || own == "time" {
            return Err(bad(text, "a channel needs a name on both sides, and `time` is the clock's".into()));
        }
        let unit = match unit_text {
            Some(unit) => Some(unit_named(unit).ok_or_else(|| bad(text, unknown(unit)))?),
            None => None,
        };
        Ok(Assignment {
            own: own.into(),
            theirs: theirs.into(),
            unit,
            unit_text: unit_text.unwrap_or_default().into(),
            scale: 1.0,
            origin: Origin::CommandLine,
        })
    }

    /// The error of an own name that nobody knows.
    #[must_use]
    pub fn unknown_own(&self, found: String, cure: String) -> RecordingError {
        match &self.origin {
            Origin::CommandLine => {
                RecordingError::BadOption { said: format!("--channel '{} = {}'", self.own, self.theirs), found, cure }
            }
            Origin::Map { text, own: (place, span), .. } => RecordingError::MapName {
                found,
                cure,
                place: place.clone(),
                source_code: text.clone(),
                span: span.clone().into(),
            },
        }
    }

    /// The error of a name that the file `file` has not.
    pub(crate) fn absent(&self, file: &str, columns: &[String]) -> RecordingError {
        let near = crate::error::nearest(&self.theirs, columns.iter().map(String::as_str));
        let meant = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let cure = format!("{meant}right stands the name in the recording: {}", names::listed(columns));
        match &self.origin {
            Origin::CommandLine => RecordingError::NoSuchChannel {
                said: format!("--channel '{} = {}'", self.own, self.theirs),
                file: file.into(),
                found: self.theirs.clone(),
                cure,
            },
            Origin::Map { place, text, span, .. } => RecordingError::NoSuchColumn {
                table: file.into(),
                found: self.theirs.clone(),
                cure,
                place: place.clone(),
                source_code: text.clone(),
                span: span.clone().into(),
            },
        }
    }
}

fn bad(text: &str, found: String) -> RecordingError {
    RecordingError::BadOption {
        said: format!("--channel '{text}'"),
        found,
        cure: "write 'own name = name in the file [unit]', as in --channel 'torque = cmd.tau_z [mN*m]'".into(),
    }
}

/// What is said of a unit that is not known.
pub(crate) fn unknown(unit: &str) -> String {
    if let Some(spellings) = crate::units::two_meanings(unit) {
        return format!("unit `{unit}` may be two things; write {spellings}");
    }
    let near = crate::units::nearest_spelling(unit);
    let meant = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    format!("unit `{unit}` is not known{meant}")
}
