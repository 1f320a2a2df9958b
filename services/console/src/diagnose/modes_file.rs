//! Modes as evidence: the object that `obsid modal --json` prints, with shapes and the modes of the
//! record's parts where it has them.

use super::sensor_names::named_as_sensors;
use crate::{Failure, plants};
use discovery::diagnose::Diagnosis;
use discovery::features::{self, FeatureOptions, MeasuredMode, ModeInPart, ModeTrack, ShapeComponent};
use dynamics::description::Plant;
use nalgebra::Complex;
use serde::Deserialize;
use std::path::Path;

/// A list of modes and where it was read.
pub struct ModesFile {
    pub file: String,
    pub digest: String,
    pub modes: Vec<MeasuredMode>,
    pub tracks: Vec<ModeTrack>,
    /// Rows that were skipped, and why.
    pub notes: Vec<String>,
}

#[derive(Deserialize)]
struct Object {
    modes: Vec<Mode>,
    #[serde(default)]
    tracks: Vec<Track>,
}

#[derive(Deserialize)]
struct Mode {
    frequency_hz: f64,
    frequency_sd: Option<f64>,
    damping: Option<f64>,
    damping_sd: Option<f64>,
    #[serde(default)]
    shape: Vec<Component>,
}

/// What one channel says of a mode; `sd` of real and imaginary part, where somebody knows it.
#[derive(Deserialize)]
struct Component {
    channel: String,
    re: f64,
    im: f64,
    sd: Option<f64>,
}

#[derive(Deserialize)]
struct Track {
    frequency_hz: f64,
    damping: f64,
    parts: Vec<Part>,
}

#[derive(Deserialize)]
struct Part {
    begin_s: f64,
    end_s: f64,
    amplitude: Option<f64>,
    frequency_hz: f64,
    frequency_sd: Option<f64>,
    damping: Option<f64>,
    damping_sd: Option<f64>,
}

/// Whether a file is taken for a list of modes: by its ending.
pub fn is_one(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
}

const WRITTEN_BY: &str = "write it with `obsid modal RECORDING --json > modes.json`";

/// # Errors
/// [`Failure::Input`] for a file that is no such object, or in which no mode has a standard
/// deviation.
pub fn read(path: &Path) -> Result<ModesFile, Failure> {
    let file = path.display().to_string();
    let refuse = |why: String| Failure::Input(miette::miette!(help = WRITTEN_BY, "{file}: {why}"));
    let text = plants::utf8_text(path).map_err(|(message, cure)| {
        let cure = cure.unwrap_or_else(|| WRITTEN_BY.into());
        Failure::Input(miette::miette!(help = cure, "{message}"))
    })?;
    let (modes, tracks, notes) = parse(&text).map_err(refuse)?;
    let digest = blake3::hash(text.as_bytes()).to_hex().to_string();
    Ok(ModesFile { digest, file, modes, tracks, notes })
}

type Parsed = (Vec<MeasuredMode>, Vec<ModeTrack>, Vec<String>);

fn parse(text: &str) -> Result<Parsed, String> {
    let object: Object = serde_json::from_str(text).map_err(|error| format!("no list of modes: {error}"))?;
    let measured = |mode: &Mode| {
        let sigma_hz = mode.frequency_sd.filter(|sigma| *sigma > 0.0 && mode.frequency_hz > 0.0)?;
        Some(MeasuredMode {
            frequency_hz: mode.frequency_hz,
            sigma_hz,
            damping_ratio: mode.damping.unwrap_or(f64::NAN),
            damping_sigma: mode.damping_sd.unwrap_or(f64::NAN),
            // a list says of none that it is fainter than another
            prominence: 1.0,
            shape: mode.shape.iter().map(component).collect(),
        })
    };
    let mut modes: Vec<MeasuredMode> = object.modes.iter().filter_map(measured).collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    if modes.is_empty() {
        return Err("no mode with a frequency and its standard deviation".into());
    }
    let tracks: Vec<ModeTrack> = object.tracks.iter().map(track).collect();
    let modes_left_out = object.modes.len() - modes.len();
    let given: usize = object.tracks.iter().map(|track| track.parts.len()).sum();
    let parts_left_out = given - tracks.iter().map(|track| track.parts.len()).sum::<usize>();
    let notes = [
        (modes_left_out, "modes without a standard deviation are left out"),
        (parts_left_out, "parts of modes without amplitude, damping or a standard deviation are left out"),
    ];
    let notes = notes.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    Ok((modes, tracks, notes))
}

fn component(of: &Component) -> ShapeComponent {
    ShapeComponent {
        channel: of.channel.clone(),
        value: Complex::new(of.re, of.im),
        sigma: of.sd.filter(|sigma| *sigma > 0.0).unwrap_or(0.0),
    }
}

/// With the parts of which everything is known.
fn track(track: &Track) -> ModeTrack {
    let part = |part: &Part| {
        Some(ModeInPart {
            begin_s: part.begin_s,
            end_s: part.end_s,
            amplitude: part.amplitude?,
            frequency_hz: (part.frequency_hz, part.frequency_sd?),
            damping_ratio: (part.damping?, part.damping_sd?),
        })
    };
    ModeTrack {
        frequency_hz: track.frequency_hz,
        damping_ratio: track.damping,
        parts: track.parts.iter().filter_map(part).collect(),
    }
}

/// What is missing from `plant` according to the modes.
pub fn diagnose(plant: &Plant, from: &ModesFile) -> Diagnosis {
    let options = FeatureOptions::default();
    let (modes, unknown) = named_as_sensors(&from.modes, plant);
    let mut diagnosis = features::diagnose_tracked_modes(plant, &from.file, &modes, &from.tracks, &options);
    if !unknown.is_empty() {
        diagnosis.notes.push(format!(
            "{}: shapes at {} are no evidence: the plant has no sensor of the name",
            from.file,
            unknown.join(", ")
        ));
    }
    diagnosis.notes.extend(from.notes.iter().map(|note| format!("{}: {note}", from.file)));
    diagnosis
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn shapes_come_with_the_modes_and_a_deviation_that_nobody_knows_is_zero() {
        let text = r#"{"modes":[{"frequency_hz":1.5,"frequency_sd":0.01,"shape":[{"channel":"tip","re":1.0,"im":0.0},
            {"channel":"root","re":0.5,"im":-0.1,"sd":0.02}]},{"frequency_hz":2.5,"frequency_sd":0.01}]}"#;
        let (modes, ..) = parse(text).unwrap();
        let at: Vec<_> =
            modes[0].shape.iter().map(|at| (at.channel.as_str(), at.value.re, at.value.im, at.sigma)).collect();
        assert_eq!(at, [("tip", 1.0, 0.0, 0.0), ("root", 0.5, -0.1, 0.02)]);
        assert!(modes[1].shape.is_empty());
    }

    #[test]
    fn modes_without_a_deviation_are_left_out_and_said_and_a_list_of_none_is_refused() {
        let text = r#"{"modes":[{"frequency_hz":1.5,"frequency_sd":0.01,"damping":null,"damping_sd":null},
            {"frequency_hz":3.0,"frequency_sd":null,"damping":0.01,"damping_sd":null}]}"#;
        let (modes, tracks, notes) = parse(text).unwrap();
        assert!(modes.len() == 1 && modes[0].sigma_hz == 0.01 && tracks.is_empty());
        assert!(notes[0].starts_with("1 modes without"), "{notes:?}");
        assert!(parse(r#"{"modes":[]}"#).unwrap_err().contains("no mode"));
        assert!(parse(r#"{"peaks":[]}"#).unwrap_err().contains("no list of modes"));
    }

    #[test]
    fn a_part_without_a_number_is_left_out_and_said_and_the_others_are_kept() {
        let part = |begin: u32, sd: &str, damping_sd: &str, amplitude: &str| {
            format!(
                r#"{{"begin_s":{begin},"end_s":{},"amplitude":{amplitude},"frequency_hz":1.5,"frequency_sd":{sd},"damping":0.01,"damping_sd":{damping_sd}}}"#,
                begin + 5
            )
        };
        let all = [
            part(0, "0.01", "0.001", "1.0"),
            part(5, "null", "0.001", "1.0"),
            part(10, "0.01", "null", "1.0"),
            part(15, "0.01", "0.001", "null"),
            part(20, "0.02", "0.002", "0.5"),
        ];
        let text = format!(
            r#"{{"modes":[{{"frequency_hz":1.5,"frequency_sd":0.01}}],"tracks":[{{"frequency_hz":1.5,"damping":0.01,"parts":[{}]}}]}}"#,
            all.join(",")
        );
        let (_, tracks, notes) = parse(&text).unwrap();
        let begins: Vec<f64> = tracks[0].parts.iter().map(|part| part.begin_s).collect();
        assert_eq!(begins, [0.0, 20.0]);
        assert!(notes.len() == 1 && notes[0].starts_with("3 parts of modes without"), "{notes:?}");
    }
}
