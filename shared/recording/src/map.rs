//! Channel map: a TOML file that says which column is which channel.
//!
//! `[channels]` with lines `imu.accel_x = "acceleration_x [m/s^2]"`; quoted keys
//! (`"imu.accel_x" = …`) and tables (`[channels.imu]`) mean the same. With a map, only the channels
//! it names exist.

use crate::canonical::CHANNELS;
use crate::error::{MapPlace, RecordingError, nearest};
use crate::file_name;
use crate::intake::Intake;
use crate::table::Table;
use crate::units::unit_named;
use miette::NamedSource;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Which column is which channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelMap {
    file: String,
    text: String,
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    /// Index in [`CHANNELS`].
    channel: usize,
    column: String,
    span: core::ops::Range<usize>,
}

impl ChannelMap {
    /// Reads a map file.
    ///
    /// # Errors
    /// As [`ChannelMap::parse`].
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let text = std::fs::read_to_string(path).map_err(|source| RecordingError::Io {
            file: file_name(path),
            action: "read",
            reason: source,
        })?;
        Self::parse(&file_name(path), &text)
    }

    /// Reads a map from text; `file` is its name in messages.
    ///
    /// # Errors
    /// TOML that does not parse, a name that is no channel (with the nearest one), a value that is
    /// no text.
    pub fn parse(file: &str, text: &str) -> Result<Self, RecordingError> {
        let mut map = ChannelMap { file: file.into(), text: text.into(), entries: Vec::new() };
        let table = DeTable::parse(text).map_err(|error| map.syntax(error.message(), error.span().unwrap_or(0..0)))?;
        for (key, value) in table.get_ref() {
            // what else a map says is the intake's
            if matches!(key.get_ref().as_ref(), "time" | "dataset") {
                continue;
            }
            if key.get_ref() != "channels" {
                return Err(map.syntax(&format!("`{}` is not known, a map has [channels]", key.get_ref()), key.span()));
            }
            map.collect("", key.span(), value)?;
        }
        if map.entries.is_empty() {
            return Err(map.syntax("the map names no channel", 0..0));
        }
        Ok(map)
    }

    /// What the text of a map says of a recording that is replayed: of the reading, and which
    /// channels there are, if it names any.
    ///
    /// # Errors
    /// As [`ChannelMap::parse`].
    pub fn of_replay(file: &str, text: &str) -> Result<(Intake, Option<Self>), RecordingError> {
        let mut intake = Intake::default();
        intake.read_map(file, text)?;
        let map = if intake.channels.is_empty() { None } else { Some(Self::parse(file, text)?) };
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

    fn collect(
        &mut self,
        path: &str,
        key: core::ops::Range<usize>,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<(), RecordingError> {
        match value.get_ref() {
            DeValue::Table(table) if table.get("name").is_some() && !path.is_empty() => {
                match table.get("name").map(|name| (name.get_ref(), name.span())) {
                    Some((DeValue::String(column), at)) => self.add(path, key, column, at),
                    _ => Err(self.syntax(&format!("`name` of `{path}` must be text"), value.span())),
                }
            }
            DeValue::Table(table) => {
                for (name, inner) in table {
                    let path =
                        if path.is_empty() { name.get_ref().to_string() } else { format!("{path}.{}", name.get_ref()) };
                    self.collect(&path, name.span(), inner)?;
                }
                Ok(())
            }
            DeValue::String(column) => self.add(path, key, column, value.span()),
            _ => Err(self.syntax(&format!("`{path}` must be the name of a column, in quotes"), value.span())),
        }
    }

    fn add(
        &mut self,
        name: &str,
        key: core::ops::Range<usize>,
        column: &str,
        span: core::ops::Range<usize>,
    ) -> Result<(), RecordingError> {
        let Some(channel) = CHANNELS.iter().position(|channel| channel.name == name) else {
            let cure = match nearest(name, CHANNELS.iter().map(|channel| channel.name)) {
                Some(near) => format!("did you mean `{near}`? channels: {}", channel_list()),
                None => format!("channels: {}", channel_list()),
            };
            return Err(RecordingError::UnknownChannel {
                found: name.into(),
                cure,
                place: self.place(key.clone()),
                source_code: self.source(),
                span: key.into(),
            });
        };
        if self.entries.iter().any(|entry| entry.channel == channel) {
            return Err(self.syntax(&format!("`{name}` is mapped twice"), key));
        }
        self.entries.push(Entry { channel, column: column.trim().into(), span });
        Ok(())
    }

    /// Per channel, the column of `table`.
    pub(crate) fn columns(&self, table: &Table) -> Result<Vec<Option<usize>>, RecordingError> {
        let mut columns = vec![None; CHANNELS.len()];
        for entry in &self.entries {
            columns[entry.channel] = Some(self.column(table, entry)?);
        }
        Ok(columns)
    }

    fn column(&self, table: &Table, entry: &Entry) -> Result<usize, RecordingError> {
        let (name, unit) = crate::intake::names::bracketed(&entry.column);
        let found = table.column_named(name);
        if let Some(index) = found {
            let column = &table.columns[index];
            let same = |unit: &str| unit_named(unit).is_some_and(|unit| Some(unit) == unit_named(&column.unit_in_file));
            if unit.is_none_or(same) {
                return Ok(index);
            }
        }
        let near = found.map(|index| &table.columns[index]).or_else(|| {
            let near = nearest(name, table.columns.iter().map(|column| column.name.as_str()))?;
            table.columns.iter().find(|column| column.name == near)
        });
        let all = table.columns.iter().map(|column| format!("`{}`", column.header())).collect::<Vec<_>>().join(", ");
        let cure = match near {
            Some(near) => format!("did you mean `{}`? columns: {all}", near.header()),
            None => format!("columns: {all}"),
        };
        Err(RecordingError::NoSuchColumn {
            table: table.file.clone(),
            found: entry.column.clone(),
            cure,
            place: self.place(entry.span.clone()),
            source_code: self.source(),
            span: entry.span.clone().into(),
        })
    }

    fn source(&self) -> Arc<NamedSource<String>> {
        Arc::new(NamedSource::new(&self.file, self.text.clone()))
    }

    fn place(&self, span: core::ops::Range<usize>) -> Box<MapPlace> {
        let before = self.text.get(..span.start).unwrap_or("");
        Box::new(MapPlace {
            file: self.file.clone(),
            line: before.matches('\n').count() + 1,
            column: before.chars().rev().take_while(|c| *c != '\n').count() + 1,
        })
    }

    fn syntax(&self, reason: &str, span: core::ops::Range<usize>) -> RecordingError {
        RecordingError::MapSyntax {
            reason: reason.into(),
            place: self.place(span.clone()),
            source_code: self.source(),
            span: span.into(),
        }
    }
}

fn channel_list() -> String {
    CHANNELS.iter().map(|channel| channel.name).collect::<Vec<_>>().join(", ")
}
