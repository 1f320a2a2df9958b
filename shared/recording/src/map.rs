//! Channel map of a replay: which column is which channel of the partitions.
//!
//! `[channels]` with lines `imu.accel_x = "acceleration_x [m/s^2]"`; quoted keys
//! (`"imu.accel_x" = …`) and tables (`[channels.imu]`) mean the same: the text is read as every map
//! is ([`Intake::read_map`]). With a map, only the channels it names exist.

use crate::canonical::CHANNELS;
use crate::error::{RecordingError, nearest};
use crate::intake::{Assignment, Intake, Origin, names_no_channel};
use crate::table::Table;
use crate::units::unit_named;

/// Which column is which channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMap {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    /// Index in [`CHANNELS`].
    channel: usize,
    of: Assignment,
}

impl ChannelMap {
    /// Reads a map from text; `file` is its name in messages.
    ///
    /// # Errors
    /// TOML that does not parse, a name that is no channel (with the nearest one), a value that is
    /// no text.
    pub fn parse(file: &str, text: &str) -> Result<Self, RecordingError> {
        let (_, map) = Self::of_replay(file, text)?;
        map.ok_or_else(|| names_no_channel(file, text))
    }

    /// What the text of a map says of a recording that is replayed: of the reading, and which
    /// channels there are, if it names any.
    ///
    /// # Errors
    /// As [`ChannelMap::parse`].
    pub fn of_replay(file: &str, text: &str) -> Result<(Intake, Option<Self>), RecordingError> {
        let mut intake = Intake::default();
        intake.read_map(file, text)?;
        let entries = intake.channels.iter().map(Entry::of).collect::<Result<Vec<_>, _>>()?;
        let map = (!entries.is_empty()).then_some(ChannelMap { entries });
        Ok((intake.with_names_of_the_file(), map))
    }

    /// Number of channels mapped.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// A map names one channel at least.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Per channel, the column of `table`.
    pub(crate) fn columns(&self, table: &Table) -> Result<Vec<Option<usize>>, RecordingError> {
        let mut columns = vec![None; CHANNELS.len()];
        for entry in &self.entries {
            columns[entry.channel] = Some(entry.column(table)?);
        }
        Ok(columns)
    }
}

impl Entry {
    fn of(of: &Assignment) -> Result<Self, RecordingError> {
        let names = || CHANNELS.iter().map(|channel| channel.name);
        if let Some(channel) = names().position(|name| name == of.own) {
            return Ok(Entry { channel, of: of.clone() });
        }
        let near = nearest(&of.own, names()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let cure = format!("{near}channels: {}", names().collect::<Vec<_>>().join(", "));
        Err(match &of.origin {
            Origin::Map { text, own: (place, span), .. } => RecordingError::UnknownChannel {
                found: of.own.clone(),
                cure,
                place: place.clone(),
                source_code: text.clone(),
                span: span.clone().into(),
            },
            Origin::CommandLine => of.unknown_own(format!("`{}` is no channel", of.own), cure),
        })
    }

    fn column(&self, table: &Table) -> Result<usize, RecordingError> {
        let Assignment { theirs, unit, unit_text, .. } = &self.of;
        let found = table.column_named(theirs);
        if let Some(index) = found {
            let of_file = unit_named(&table.columns[index].unit_in_file);
            if unit.is_none() || of_file == *unit {
                return Ok(index);
            }
        }
        let near = found.map(|index| &table.columns[index]).or_else(|| {
            let near = nearest(theirs, table.columns.iter().map(|column| column.name.as_str()))?;
            table.columns.iter().find(|column| column.name == near)
        });
        let all = table.columns.iter().map(|column| format!("`{}`", column.header())).collect::<Vec<_>>().join(", ");
        let cure = match near {
            Some(near) => format!("did you mean `{}`? columns: {all}", near.header()),
            None => format!("columns: {all}"),
        };
        let found = if unit_text.is_empty() { theirs.clone() } else { format!("{theirs} [{unit_text}]") };
        let said = format!("--channel '{} = {found}'", self.of.own);
        Err(match &self.of.origin {
            Origin::CommandLine => RecordingError::NoSuchChannel { said, file: table.file.clone(), found, cure },
            Origin::Map { place, text, span, .. } => RecordingError::NoSuchColumn {
                table: table.file.clone(),
                found,
                cure,
                place: place.clone(),
                source_code: text.clone(),
                span: span.clone().into(),
            },
        })
    }
}
