//! `--map FILE`: which channel of a recording is which of the plant, with its unit, scale and sign.
//!
//! `[channels]` with lines `rate = "rate_z"` or
//! `rate = { name = "rate_z", scale = -1, unit = "deg/s" }`: left the name in the plant, right the
//! name in the recording. A unit says in what the file's numbers are, whatever its header says; a
//! scale multiplies what is then in SI.

use crate::Failure;
use crate::located::Located;
use crate::plants::utf8_text;
use crate::recordings::nearest;
use channels::{Channel, Recording};
use dynamics::description::Plant;
use recording::SeriesSet;
use recording::units::{UNITS, Unit, unit_named};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// One line of the map.
struct Entry {
    ours: String,
    theirs: String,
    theirs_at: Range<usize>,
    unit: Option<Unit>,
    scale: f64,
}

/// The map; without a file it changes nothing.
#[derive(Default)]
pub struct ChannelMap {
    file: String,
    text: String,
    entries: Vec<Entry>,
}

const EXAMPLE: &str = "as in: [channels] rate = \"rate_z\", or rate = { name = \"rate_z\", scale = -1, unit = \"deg/s\" }; \
                       left the name in the plant, right the name in the recording";

impl ChannelMap {
    /// # Errors
    /// [`Failure::Input`] with line and suggestion: TOML that does not parse, a name that the plant
    /// has not, an unknown unit.
    pub fn read(path: &Path, plant: &Plant) -> Result<Self, Failure> {
        let file = path.display().to_string();
        let text = utf8_text(path).map_err(|(message, cure)| {
            let cure = cure.unwrap_or_else(|| format!("--map takes the path of a TOML file, {EXAMPLE}"));
            Failure::Input(miette::miette!(help = cure, "{message}"))
        })?;
        Self::parse(file, text, plant)
    }

    fn parse(file: String, text: String, plant: &Plant) -> Result<Self, Failure> {
        let mut map = ChannelMap { file, entries: Vec::new(), text: text.clone() };
        let table =
            DeTable::parse(&text).map_err(|e| map.refuse(e.span().unwrap_or(0..0), e.message().to_owned(), EXAMPLE))?;
        for (key, value) in table.get_ref() {
            if key.get_ref() != "channels" {
                let what = format!("`{}` is not known: a map has [channels]", key.get_ref());
                return Err(map.refuse(key.span(), what, EXAMPLE));
            }
            let DeValue::Table(lines) = value.get_ref() else {
                return Err(map.refuse(value.span(), "`channels` must be a table".into(), EXAMPLE));
            };
            map.collect("", lines, plant)?;
        }
        if map.entries.is_empty() {
            return Err(map.refuse(0..0, "the map names no channel".into(), EXAMPLE));
        }
        Ok(map)
    }

    /// Lines of a table; names with points may stand as they are, `imu.rate = …`.
    fn collect(&mut self, path: &str, lines: &DeTable<'_>, plant: &Plant) -> Result<(), Failure> {
        for (key, value) in lines {
            let ours = if path.is_empty() { key.get_ref().to_string() } else { format!("{path}.{}", key.get_ref()) };
            match value.get_ref() {
                DeValue::Table(inner) if !inner.iter().any(|(name, _)| name.get_ref() == "name") => {
                    self.collect(&ours, inner, plant)?;
                }
                _ => {
                    self.check_name(&ours, key.span(), plant)?;
                    let entry = self.entry(ours, value)?;
                    self.entries.push(entry);
                }
            }
        }
        Ok(())
    }

    fn check_name(&self, ours: &str, at: Range<usize>, plant: &Plant) -> Result<(), Failure> {
        let known: Vec<&str> = plant
            .sensors
            .iter()
            .map(|s| s.name.as_str())
            .chain(plant.actuators.iter().map(|a| a.name.as_str()))
            .collect();
        if known.contains(&ours) {
            return Ok(());
        }
        let meant =
            nearest(ours, known.iter().copied()).map_or(String::new(), |near| format!("did you mean '{near}'? "));
        let cure = format!("{meant}left stands the name in the plant: {}", known.join(", "));
        Err(self.refuse(at, format!("'{ours}' is no sensor or actuator of plant '{}'", plant.name), &cure))
    }

    fn entry(&self, ours: String, value: &Spanned<DeValue<'_>>) -> Result<Entry, Failure> {
        let bad = |at: Range<usize>, what: String| Err(self.refuse(at, what, EXAMPLE));
        let mut entry = Entry { ours, theirs: String::new(), theirs_at: value.span(), unit: None, scale: 1.0 };
        let table = match value.get_ref() {
            DeValue::String(name) => {
                entry.theirs = without_unit(name).to_owned();
                return Ok(entry);
            }
            DeValue::Table(table) => table,
            _ => return bad(value.span(), format!("'{}' must be the name of a channel, in quotes", entry.ours)),
        };
        for (key, value) in table {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("name", DeValue::String(name)) => {
                    (entry.theirs, entry.theirs_at) = (without_unit(name).to_owned(), value.span());
                }
                ("scale", _) => match number(value.get_ref()).filter(|scale| scale.is_finite() && *scale != 0.0) {
                    Some(scale) => entry.scale = scale,
                    None => return bad(value.span(), "`scale` must be a number, not zero; -1 turns the sign".into()),
                },
                ("unit", DeValue::String(unit)) => entry.unit = Some(self.unit(unit, value.span())?),
                ("name" | "unit", _) => return bad(value.span(), format!("`{}` must be text", key.get_ref())),
                (other, _) => {
                    return bad(key.span(), format!("`{other}` is not known: a channel has name, scale and unit"));
                }
            }
        }
        Ok(entry)
    }

    fn unit(&self, text: &str, at: Range<usize>) -> Result<Unit, Failure> {
        unit_named(text).ok_or_else(|| {
            let meant = nearest(text, UNITS.iter().map(|unit| unit.symbol));
            let cure = meant.map_or(String::new(), |near| format!("did you mean '{near}'? "));
            self.refuse(
                at,
                format!("unit '{text}' is not known"),
                &format!("{cure}units are written as rad/s, N*m, m/s^2"),
            )
        })
    }

    /// Gives the channels of a recording the plant's names, in SI.
    ///
    /// # Errors
    /// [`Failure::Input`] at the line of the map that names a channel which the recording has not.
    pub fn apply(&self, set: &mut SeriesSet) -> Result<(), Failure> {
        let mut renamed = SeriesSet::new(&set.recording.name);
        renamed.notes.append(&mut set.notes);
        for entry in &self.entries {
            let source =
                set.recording.channel_named(&entry.theirs).ok_or_else(|| self.absent(entry, &set.recording))?;
            let (channel, unit_in_file) = converted(source, set.unit_in_file(source), entry).map_err(|what| {
                self.refuse(entry.theirs_at.clone(), what, "give the unit in which the file's numbers are")
            })?;
            renamed.push(channel, &unit_in_file);
        }
        let taken = |c: &Channel| self.entries.iter().any(|e| e.theirs == c.name || e.ours == c.name);
        for channel in set.recording.channels.iter().filter(|channel| !taken(channel)) {
            renamed.push(channel.clone(), set.unit_in_file(channel));
        }
        *set = renamed;
        Ok(())
    }

    fn absent(&self, entry: &Entry, recording: &Recording) -> Failure {
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        let near = nearest(&entry.theirs, names.iter().copied());
        let meant = near.map_or(String::new(), |near| format!("did you mean '{near}'? "));
        let cure = format!("{meant}right stands the name in the recording: {}", names.join(", "));
        self.refuse(entry.theirs_at.clone(), format!("'{}' is no channel of {}", entry.theirs, recording.name), &cure)
    }

    fn refuse(&self, at: Range<usize>, message: String, cure: &str) -> Failure {
        Failure::input(Located::new(&self.file, &self.text, at, message, cure.to_owned()))
    }
}

/// `rate_z [deg/s]`, as headers have it, means `rate_z`.
fn without_unit(name: &str) -> &str {
    name.split_once(" [").filter(|(_, unit)| unit.ends_with(']')).map_or(name, |(name, _)| name).trim()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        _ => None,
    }
}

/// The channel under the plant's name, its numbers read in the map's unit and scaled, and the unit
/// in which the file gave them.
fn converted(source: &Channel, unit_in_file: &str, entry: &Entry) -> Result<(Channel, String), String> {
    let mut channel = Channel { name: entry.ours.clone(), ..source.clone() };
    let mut given_in = unit_in_file.to_owned();
    if let Some(unit) = entry.unit {
        let of_file = unit_named(unit_in_file)
            .ok_or_else(|| format!("'{}' has the unknown unit '{unit_in_file}'", source.name))?;
        // back to the numbers of the file: units are straight lines
        let (offset, slope) = (of_file.to_si(0.0), of_file.to_si(1.0) - of_file.to_si(0.0));
        channel.value.iter_mut().for_each(|value| *value = unit.to_si((*value - offset) / slope));
        (channel.unit, given_in) = (unit.si.to_owned(), unit.symbol.to_owned());
    }
    channel.value.iter_mut().for_each(|value| *value *= entry.scale);
    Ok((channel, given_in))
}

#[cfg(test)]
mod tests;
