//! Recordings on the command line as channels with roles: what `doctor`, `compare` and `diagnose`
//! work on.

use crate::Failure;
use crate::plant::plain;
use channels::{Channel, Recording, Role};
use dynamics::description::Plant;
use recording::units::NOT_STATED;
use recording::{Imported, Intake, SeriesSet, Spectrum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// One recording of a file.
pub struct Loaded {
    /// The path as it was given.
    pub file: String,
    pub recording: Recording,
    /// Repairs of the import, and what a plant has to say about the names.
    pub notes: Vec<String>,
    /// What its times count from \[s since 1970\]; 0: from where the file says.
    pub origin_s: i64,
    /// BLAKE3 of the file.
    pub digest: String,
}

/// What a file holds.
pub enum Evidence {
    /// Time records, one for most files.
    Time(Vec<Loaded>),
    /// Columns over frequency.
    Spectrum { spectrum: Spectrum, digest: String },
}

/// The recordings of a file: one for most, several where time starts again, each then named with
/// its place.
///
/// # Errors
/// [`Failure::Input`] for what cannot be read, and for a plant that shares no name with the
/// recording.
pub fn read(path: &Path, intake: &Intake, plant: Option<&Plant>) -> Result<Vec<Loaded>, Failure> {
    loaded(path, recording::read_with(path, &as_channels(intake)).map_err(Failure::input)?, plant)
}

/// As [`read`]; spectra are taken, too.
///
/// # Errors
/// As [`read`], and for a channel of the plant whose unit nobody states.
pub fn read_evidence(path: &Path, intake: &Intake, plant: &Plant) -> Result<Evidence, Failure> {
    match recording::read_with(path, &as_channels(intake)).map_err(Failure::input)? {
        Imported::Spectrum(spectrum) => Ok(Evidence::Spectrum { spectrum, digest: digest_of(path) }),
        imported => {
            let loaded = loaded(path, imported, Some(plant))?;
            loaded.iter().try_for_each(|one| units_are_stated(&one.recording, plant))?;
            Ok(Evidence::Time(loaded))
        }
    }
}

/// Channels with clocks of their own are taken here.
fn as_channels(intake: &Intake) -> Intake {
    Intake { clocks_of_their_own: true, ..intake.clone() }
}

/// Every channel of the plant has a unit: numbers without one are no evidence.
fn units_are_stated(recording: &Recording, plant: &Plant) -> Result<(), Failure> {
    let unit_of = |name: &str| match (plant.actuator(name), plant.sensor(name)) {
        (Some(actuator), _) => Some(plant.actuator_unit(actuator).to_owned()),
        (_, Some(sensor)) => Some(plant.sensor_unit(sensor).to_owned()),
        _ => None,
    };
    let silent = recording.channels.iter().filter(|channel| channel.unit == NOT_STATED);
    let silent: Vec<(&str, String)> =
        silent.filter_map(|channel| Some((channel.name.as_str(), unit_of(&channel.name)?))).collect();
    if silent.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = silent.iter().map(|(name, _)| *name).collect();
    let cure: Vec<String> = silent.iter().map(|(name, unit)| format!("--channel '{name} = {name} [{unit}]'")).collect();
    Err(Failure::Input(miette::miette!(
        help = format!("say the unit of the file's numbers, if the plant's: {}", cure.join(" ")),
        "{}: the unit of {} is not stated",
        recording.name,
        names.join(", ")
    )))
}

/// BLAKE3 of a file, which is not held in memory; empty for what is no regular file.
pub fn digest_of(path: &Path) -> String {
    let hashed = || {
        let mut hasher = blake3::Hasher::new();
        std::io::copy(&mut std::fs::File::open(path)?, &mut hasher).map(|_| hasher.finalize().to_hex().to_string())
    };
    if path.is_file() { hashed().unwrap_or_default() } else { String::new() }
}

fn loaded(path: &Path, imported: Imported, plant: Option<&Plant>) -> Result<Vec<Loaded>, Failure> {
    let sets = recording::segments(imported).map_err(Failure::input)?;
    let file = path.display().to_string();
    let digest = digest_of(path);
    let several = sets.len() > 1;
    let mut loaded = Vec::with_capacity(sets.len());
    for (k, set) in sets.into_iter().enumerate() {
        let name = if several { format!("{file}, part {}", k + 1) } else { file.clone() };
        let SeriesSet { mut recording, mut notes, origin_s, .. } = set;
        recording.name = name;
        if let Some(plant) = plant {
            notes.extend(called_as_in_the_plant(&mut recording, plant));
            notes.extend(names_of_the_plant(&recording, plant)?);
            recording.channels.iter_mut().for_each(|channel| channel.role = role(&channel.name, plant));
        }
        loaded.push(Loaded { file: file.clone(), recording, notes, origin_s, digest: digest.clone() });
    }
    Ok(loaded)
}

/// A plant file holds letters, digits and underscores: `Soll-Moment` of a file is `Soll_Moment`
/// there, where neither has another of that name.
fn called_as_in_the_plant(recording: &mut Recording, plant: &Plant) -> Vec<String> {
    let recorded: Vec<String> = recording.channels.iter().map(|channel| channel.name.clone()).collect();
    let is_known = |name: &str| plant.actuator(name).is_some() || plant.sensor(name).is_some();
    let only = |name: &str| recorded.iter().filter(|other| plain(other) == name).count() == 1;
    let mut notes = Vec::new();
    for channel in recording.channels.iter_mut().filter(|channel| !is_known(&channel.name)) {
        let written = plain(&channel.name);
        if is_known(&written) && only(&written) {
            notes.push(format!("channel '{}' is '{written}' of the plant", channel.name));
            channel.name = written;
        }
    }
    notes
}

/// What a plant says of a channel of this name.
fn role(name: &str, plant: &Plant) -> Role {
    if plant.actuator(name).is_some() {
        Role::Input
    } else if plant.sensor(name).is_some() {
        Role::Output
    } else {
        Role::Unknown
    }
}

/// Where names or units of plant and recording do not meet.
fn names_of_the_plant(recording: &Recording, plant: &Plant) -> Result<Vec<String>, Failure> {
    let inputs = plant.actuators.iter().filter(|a| a.recorded).map(|a| (a.name.as_str(), plant.actuator_unit(a)));
    let outputs = plant.sensors.iter().map(|s| (s.name.as_str(), plant.sensor_unit(s)));
    let known: Vec<(&str, &str)> = inputs.chain(outputs).collect();
    let recorded: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    if !known.iter().any(|(known, _)| recorded.contains(known)) {
        return Err(Failure::Input(miette::miette!(
            help = "say which is which, as in --channel 'NAME IN THE PLANT = NAME IN THE FILE [UNIT]', or in a file with --map",
            "{}: none of its channels ({}) is an actuator or a sensor of plant '{}' ({})",
            recording.name,
            recorded.join(", "),
            plant.name,
            known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
        )));
    }
    let mut notes = Vec::new();
    for channel in &recording.channels {
        match known.iter().find(|(known, _)| *known == channel.name) {
            None => {
                let near =
                    nearest(&channel.name, known.iter().map(|(name, _)| *name).filter(|n| !recorded.contains(n)));
                let near = near.map_or(String::new(), |near| format!(" (is it '{near}'?)"));
                notes.push(format!(
                    "channel '{}' is no actuator or sensor of the plant{near}: its role is guessed",
                    channel.name
                ));
            }
            Some((_, unit)) if recording::units::unit_named(unit).is_some_and(|u| u.si != channel.unit) => {
                notes.push(format!("channel '{}' is in {}, the plant has it in {unit}", channel.name, channel.unit))
            }
            Some(_) => {}
        }
    }
    let absent: Vec<&str> = known.iter().map(|(name, _)| *name).filter(|name| !recorded.contains(name)).collect();
    if !absent.is_empty() {
        notes.push(format!("of the plant, not in the recording: {}", absent.join(", ")));
    }
    Ok(notes)
}

/// The name most like `name`, if any is like it: of short names, whose likeness is low, the only
/// one that a single slip of the hand turns into it.
pub fn nearest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let names: Vec<&str> = names.collect();
    let lower = name.to_lowercase();
    let likeness = names.iter().map(|known| (strsim::jaro_winkler(&known.to_lowercase(), &lower), *known));
    let like = likeness.filter(|(likeness, _)| *likeness > 0.8).max_by(|a, b| a.0.total_cmp(&b.0));
    like.map(|(_, known)| known).or_else(|| {
        let slip = |known: &&&str| strsim::damerau_levenshtein(&known.to_lowercase(), &lower) == 1;
        let mut slips = names.iter().filter(slip);
        slips.next().filter(|_| lower.chars().count() > 1 && slips.next().is_none()).copied()
    })
}

impl Loaded {
    /// First and last time of all channels \[s\].
    pub fn span_s(&self) -> (f64, f64) {
        let times =
            |f: fn(&[f64]) -> Option<&f64>| self.recording.channels.iter().filter_map(move |c| f(&c.time_s).copied());
        (times(<[f64]>::first).fold(f64::INFINITY, f64::min), times(<[f64]>::last).fold(f64::NEG_INFINITY, f64::max))
    }

    /// Channels, samples, span and rate in a few words.
    pub fn in_words(&self) -> String {
        let (start, end) = self.span_s();
        let most = self.recording.channels.iter().max_by_key(|c| c.value.len());
        let samples = most.map_or(0, |c| c.value.len());
        let rate = most
            .and_then(Channel::interval_s)
            .map_or(String::new(), |dt| format!(" at {} Hz", report::text::short(1.0 / dt)));
        let channels = self.recording.channels.len();
        format!(
            "{channels} channel{}, {samples} samples over {} s{rate}",
            if channels == 1 { "" } else { "s" },
            report::text::short((end - start).max(0.0))
        )
    }

    /// Different times at which a channel has a sample.
    pub fn rows(&self) -> usize {
        let channels = &self.recording.channels;
        let first = channels.iter().max_by_key(|c| c.value.len());
        if first.is_none_or(|first| channels.iter().all(|c| c.same_clock(first))) {
            return first.map_or(0, |c| c.time_s.len());
        }
        let mut times: Vec<f64> = channels.iter().flat_map(|c| c.time_s.iter().copied()).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times.len()
    }

    /// File, digest, time span \[s\], channels and notes.
    pub fn as_json(&self) -> Value {
        let (start_s, end_s) = self.span_s();
        let rows = self.rows();
        let channel = |c: &Channel| {
            json!({ "name": c.name, "unit": c.unit, "unit_stated": c.unit != NOT_STATED, "role": c.role,
                "samples": c.value.len(), "missing": missing(c, rows), "rate_hz": c.rate_hz() })
        };
        let most = self.recording.channels.iter().max_by_key(|c| c.value.len());
        let rate_hz = most.and_then(Channel::rate_hz);
        json!({ "file": self.file, "name": self.recording.name, "digest": self.digest, "origin_s": self.origin_s, "start_s": start_s, "end_s": end_s,
            "rate_hz": rate_hz, "rows": rows, "channels": self.recording.channels.iter().map(channel).collect::<Vec<_>>(), "notes": self.notes })
    }
}

/// Samples that a channel lacks: of the rows it shares with others, else of its own even clock.
fn missing(channel: &Channel, rows: usize) -> usize {
    let samples = channel.value.len();
    // most rows are its own: it is a column of the table
    if 2 * samples > rows {
        return rows - samples;
    }
    let span_s = channel.time_s.last().zip(channel.time_s.first()).map_or(0.0, |(last, first)| last - first);
    let due = channel.rate_hz().map_or(0.0, |rate_hz| span_s * rate_hz);
    (due.round() as usize + 1).saturating_sub(samples)
}

/// Where a report goes.
pub struct ReportFile(PathBuf);

impl ReportFile {
    /// Makes the folder, so that a place that cannot be written is found out before the work.
    ///
    /// # Errors
    /// [`Failure::Input`] when it cannot be made.
    pub fn new(folder: &Path, name: &str) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| {
            Failure::Input(miette::miette!(
                help = "--out takes the path of a folder, which is made where it does not exist",
                "--out {}: cannot be used: {error}",
                folder.display()
            ))
        })?;
        Ok(ReportFile(folder.join(name)))
    }

    /// The path as text for messages; bytes that are no UTF-8 are replaced.
    pub fn path(&self) -> String {
        self.0.display().to_string()
    }

    /// # Errors
    /// [`Failure::Run`] when the file system denies it.
    pub fn write(&self, page: &report::Page) -> Result<(), Failure> {
        std::fs::write(&self.0, page.html()).map_err(|error| Failure::Run(format!("{}: {error}", self.path())))
    }
}

/// A command line as it can be typed again.
pub fn command_line(words: &[String]) -> String {
    let plain = |w: &str| !w.is_empty() && w.chars().all(|c| c.is_alphanumeric() || "-_./=:,+%@".contains(c));
    let quoted = words.iter().map(|w| if plain(w) { w.clone() } else { format!("'{}'", w.replace('\'', "'\\''")) });
    quoted.collect::<Vec<_>>().join(" ")
}

/// Name and version of the program, for the foot of a page.
pub fn tool() -> String {
    format!("obsid {}", env!("CARGO_PKG_VERSION"))
}

/// Whole words in lines of at most 110 characters, each behind `indent`.
pub fn wrapped(text: &str, indent: &str) -> String {
    const WIDTH: usize = 110;
    let mut out = String::new();
    let mut used = WIDTH;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if used + 1 + length > WIDTH {
            out.push_str(if out.is_empty() { "" } else { "\n" });
            out.push_str(indent);
            used = indent.chars().count();
        } else {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += length;
    }
    out.push('\n');
    out
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_in_a_short_name_finds_it_unless_two_names_are_as_near() {
        assert_eq!(nearest("ay", ["ax", "bz", "q"].into_iter()), Some("ax"));
        assert_eq!(nearest("a9", ["a1", "a2"].into_iter()), None);
        assert_eq!(nearest("torqe", ["torque", "angle"].into_iter()), Some("torque"));
        assert_eq!(nearest("q", ["u", "y"].into_iter()), None);
    }
}
