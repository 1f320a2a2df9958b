//! Map files: what is said of a file, kept for the next one of its kind.

use super::assignment::{Assignment, Origin, unknown};
use super::clock::TimeColumn;
use super::{Intake, names};
use crate::error::{MapPlace, RecordingError};
use crate::units::unit_named;
use miette::NamedSource;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// How a map looks, for help and errors.
#[must_use]
pub const fn example() -> &'static str {
    "as in: [channels] rate = \"rate_z [deg/s]\", or rate = { name = \"rate_z\", scale = -1, unit = \"deg/s\" }; \
     left the name in the plant, right the name in the recording; above [channels] time = \"stamp:us\""
}

pub(super) fn read_text(intake: &mut Intake, file: &str, text: &str) -> Result<(), RecordingError> {
    Map { file: file.into(), text: text.trim_start_matches('\u{feff}').to_owned() }.read_into(intake)
}

/// The error of a map that is to name channels and names none.
pub(crate) fn names_no_channel(file: &str, text: &str) -> RecordingError {
    Map { file: file.into(), text: text.into() }.refuse(0..0, "the map names no channel".into())
}

struct Map {
    file: String,
    text: String,
}

impl Map {
    fn read_into(&self, intake: &mut Intake) -> Result<(), RecordingError> {
        let table = DeTable::parse(&self.text)
            .map_err(|error| self.refuse(error.span().unwrap_or(0..0), error.message().to_owned()))?;
        let before = intake.channels.len();
        for (key, value) in table.get_ref() {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("channels", DeValue::Table(lines)) => self.channels("", lines, intake)?,
                ("time", DeValue::String(text)) => {
                    let said = TimeColumn::parse(text).map_err(|error| self.refuse(value.span(), error.to_string()))?;
                    intake.time_column.get_or_insert(said);
                }
                ("dataset", DeValue::String(text)) => {
                    intake.dataset.get_or_insert(text.to_string());
                }
                ("time" | "dataset", _) => {
                    return Err(self.refuse(value.span(), format!("`{}` must be text", key.get_ref())));
                }
                ("channels", _) => return Err(self.refuse(value.span(), "`channels` must be a table".into())),
                (other, _) => {
                    let what = format!("`{other}` is not known: a map has time, dataset and [channels]");
                    return Err(self.refuse(key.span(), what));
                }
            }
        }
        if intake.channels.len() == before && intake.time_column.is_none() && intake.dataset.is_none() {
            return Err(names_no_channel(&self.file, &self.text));
        }
        Ok(())
    }

    /// Lines of a table; names with points may stand as they are, `imu.rate = …`.
    fn channels(&self, path: &str, lines: &DeTable<'_>, intake: &mut Intake) -> Result<(), RecordingError> {
        for (key, value) in lines {
            let own = if path.is_empty() { key.get_ref().to_string() } else { format!("{path}.{}", key.get_ref()) };
            match value.get_ref() {
                DeValue::Table(inner) if !inner.iter().any(|(name, _)| name.get_ref() == "name") => {
                    self.channels(&own, inner, intake)?;
                }
                _ if intake.channels.iter().any(|of| of.own == own && of.origin != Origin::CommandLine) => {
                    return Err(self.refuse(key.span(), format!("`{own}` is mapped twice")));
                }
                // the command line has said it
                _ if intake.channels.iter().any(|of| of.own == own) => {}
                _ => intake.channels.push(self.assignment((own, key.span()), value)?),
            }
        }
        Ok(())
    }

    fn assignment(
        &self,
        (own, at): (String, core::ops::Range<usize>),
        value: &Spanned<DeValue<'_>>,
    ) -> Result<Assignment, RecordingError> {
        let own_place = (self.place(at.clone()), at);
        let origin =
            Origin::Map { place: self.place(value.span()), text: self.source(), span: value.span(), own: own_place };
        let mut of =
            Assignment { own, theirs: String::new(), unit: None, unit_text: String::new(), scale: 1.0, origin };
        let table = match value.get_ref() {
            DeValue::String(text) => {
                let (theirs, unit) = names::bracketed(text);
                of.theirs = theirs.to_owned();
                if let Some(unit) = unit {
                    self.set_unit(&mut of, unit, value)?;
                }
                return Ok(of);
            }
            DeValue::Table(table) => table,
            _ => {
                let what = format!("`{}` must be the name of a column, in quotes", of.own);
                return Err(self.refuse(value.span(), what));
            }
        };
        for (key, value) in table {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("name", DeValue::String(name)) => names::bracketed(name).0.clone_into(&mut of.theirs),
                ("scale", _) => match number(value.get_ref()).filter(|scale| scale.is_finite() && *scale != 0.0) {
                    Some(scale) => of.scale = scale,
                    None => {
                        let what = "`scale` must be a number, not zero; -1 turns the sign".into();
                        return Err(self.refuse(value.span(), what));
                    }
                },
                ("unit", DeValue::String(unit)) => self.set_unit(&mut of, unit, value)?,
                ("name" | "unit", _) => {
                    return Err(self.refuse(value.span(), format!("`{}` must be text", key.get_ref())));
                }
                (other, _) => {
                    let what = format!("`{other}` is not known: a channel has name, scale and unit");
                    return Err(self.refuse(key.span(), what));
                }
            }
        }
        Ok(of)
    }

    fn set_unit(&self, of: &mut Assignment, text: &str, value: &Spanned<DeValue<'_>>) -> Result<(), RecordingError> {
        let unit = unit_named(text).ok_or_else(|| self.refuse(value.span(), unknown(text)))?;
        (of.unit, of.unit_text) = (Some(unit), text.to_owned());
        Ok(())
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

    fn refuse(&self, span: core::ops::Range<usize>, reason: String) -> RecordingError {
        RecordingError::MapSyntax {
            reason,
            place: self.place(span.clone()),
            source_code: self.source(),
            span: span.into(),
        }
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        _ => None,
    }
}
