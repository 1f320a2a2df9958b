//! What an answer says of the structure beyond its list of modes.

use super::geometry::{self, Geometry};
use super::merge::Merge;
use super::reference::{self, Compared};
use super::{Arguments, Outcome, singular, uff_export};
use crate::Failure;
use modal::record::Record;
use modal::singular_values::SingularValues;

/// Comparison, geometry, singular values, setups.
#[derive(Default)]
pub(super) struct Structure {
    /// Only where a page or a table is written.
    pub singular_values: Option<SingularValues>,
    pub compared: Option<Compared>,
    pub geometry: Option<Geometry>,
    pub merge: Option<Merge>,
}

impl Structure {
    /// Of a record between gaps: its singular values, where somebody looks at them.
    pub(super) fn of_record(arguments: &Arguments, record: &Record, gaps: &[usize]) -> Self {
        let singular_values = wants_singular_values(arguments).then(|| singular::of_record(record, gaps)).flatten();
        Structure { singular_values, ..Structure::default() }
    }
}

/// Whether somebody looks at the singular values.
pub(super) fn wants_singular_values(arguments: &Arguments) -> bool {
    arguments.out.is_some() || arguments.structural.singular_values.is_some()
}

/// Holds the modes against the reference, places the channels, and writes the files asked for.
///
/// # Errors
/// [`Failure::Input`] for files that cannot be read or do not belong to this record,
/// [`Failure::Run`] for files that cannot be written.
pub(super) fn complete(arguments: &Arguments, outcome: &mut Outcome) -> Result<(), Failure> {
    let asked = &arguments.structural;
    if asked.geometry.is_some() || asked.uff.is_some() || arguments.out.is_some() {
        let found = geometry::read(asked.geometry.as_deref(), &arguments.files, &outcome.channels)?;
        outcome.notes.extend(found.iter().flat_map(|geometry| geometry.notes.clone()));
        outcome.structure.geometry = found;
    }
    if let Some(file) = &asked.reference {
        outcome.structure.compared = Some(reference::compared(file, outcome)?);
    }
    if let Some(file) = &asked.singular_values {
        singular::write(outcome.structure.singular_values.as_ref(), file)?;
    }
    if let Some(file) = &asked.uff {
        let notes = uff_export::write(outcome, file)?;
        outcome.notes.extend(notes);
    }
    Ok(())
}
