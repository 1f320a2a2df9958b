//! Plant files on the command line: the user's, and those that come with the program.

use crate::Failure;
use crate::located::Located;
pub use bench::plants::{BUILT_IN, built_in};
use dynamics::description::Plant;
use plant_file::{self, FileError, Parsed};
use std::path::Path;

/// Bytes of a text file that are read at most.
const TEXT_MAX: u64 = 16 << 20;
/// Errors of a file that are told; the others are counted.
pub const ERRORS_MAX: usize = 20;

/// Text of a plant file, else of the built-in plant of that name; `folder` is where relative paths
/// begin.
///
/// A file that exists wins, and so does a name that can only be a path; where both could be meant,
/// it is said which was taken.
///
/// # Errors
/// What is wrong, and the cure.
pub fn text_of(name: &str, folder: &Path) -> Result<String, (String, String)> {
    let path = folder.join(name);
    let is_path = name.contains('/') || name.ends_with(".toml");
    match built_in(name).filter(|_| !is_path) {
        Some(text) if !path.is_file() => return Ok(text.to_owned()),
        Some(_) => {
            let shown = path.display();
            crate::tell(&format!(
                "note: '{name}' is the file {shown}, not the plant of that name that comes with the program"
            ));
        }
        None => {}
    }
    utf8_text(&path).map_err(|(message, cure)| {
        let message = message.replacen(&path.display().to_string(), name, 1);
        (message, cure.unwrap_or_else(|| where_plants_are(name)))
    })
}

fn where_plants_are(name: &str) -> String {
    let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
    let near = BUILT_IN.iter().map(|(known, _)| (strsim::jaro_winkler(known, name), *known));
    let near = near.filter(|(likeness, _)| *likeness > 0.85).max_by(|a, b| a.0.total_cmp(&b.0));
    let meant = near.map_or(String::new(), |(_, known)| format!("did you mean '{known}'? "));
    format!("{meant}give the path of a plant file (see deploy/plants), or one of {}", names.join(", "))
}

/// Text of a file.
///
/// # Errors
/// What is wrong, and the cure where the bytes themselves say it.
pub fn utf8_text(path: &Path) -> Result<String, (String, Option<String>)> {
    let file = path.display();
    let bytes = bounded(path)?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let byte = error.as_bytes().get(at).copied().unwrap_or(0);
        let line = error.as_bytes()[..at].iter().filter(|b| **b == b'\n').count() + 1;
        let cure = "save it as UTF-8; where it is a recording or a binary file, another file was meant";
        (format!("{file}:{line}: not UTF-8 text: byte {at} is {byte:#04x}"), Some(cure.into()))
    })
}

/// Bytes of a regular file of at most [`TEXT_MAX`]: what never ends is not opened, what is long is
/// not read.
fn bounded(path: &Path) -> Result<Vec<u8>, (String, Option<String>)> {
    use std::io::Read;
    let file = path.display();
    let failed = |error: std::io::Error| (format!("{file}: cannot be read: {error}"), None);
    let said = std::fs::metadata(path).map_err(failed)?;
    if !said.is_file() {
        let what = if said.is_dir() { "this is a folder" } else { "this is no regular file (a pipe or a device)" };
        return Err((format!("{file}: cannot be read: {what}"), None));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(path).and_then(|opened| opened.take(TEXT_MAX + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > TEXT_MAX {
        let cure = "no text file of the program is so long; where it is a recording, another file was meant";
        return Err((format!("{file}: longer than {} MiB", TEXT_MAX >> 20), Some(cure.into())));
    }
    Ok(bytes)
}

/// Reads a plant file; warnings go to standard error.
///
/// # Errors
/// [`Failure::Input`] with every error of the file.
pub fn read(path: &Path) -> Result<Plant, Failure> {
    read_with_digest(path).map(|(plant, _)| plant)
}

/// As [`read`], with the BLAKE3 of the text.
///
/// # Errors
/// [`Failure::Input`] with every error of the file.
pub fn read_with_digest(path: &Path) -> Result<(Plant, String), Failure> {
    let name = path.display().to_string();
    let text = text_of(&name, Path::new(""))
        .map_err(|(message, cure)| Failure::Input(miette::miette!(help = cure, "{message}")))?;
    let parsed = parse(&name, &text)?;
    warn(&parsed);
    Ok((parsed.plant, blake3::hash(text.as_bytes()).to_hex().to_string()))
}

/// What is possible in a plant file, but not plausible, on standard error.
pub fn warn(parsed: &Parsed) {
    parsed.warnings.iter().for_each(|warning| crate::tell(&format!("warning: {warning}")));
}

/// # Errors
/// [`Failure::Input`] with every error of `text`.
pub fn parse(name: &str, text: &str) -> Result<Parsed, Failure> {
    plant_file::parse(name, text).map_err(|errors| refusal(name, text, errors))
}

/// Every error of `text` in one report.
pub fn refusal(name: &str, text: &str, errors: Vec<FileError>) -> Failure {
    let example = "deploy/plants has examples, `obsid plant format` prints the format";
    let cure = |cure: String| if cure.is_empty() { example.to_string() } else { cure };
    let more = errors.len().saturating_sub(ERRORS_MAX);
    if more > 0 {
        crate::tell(&format!("{name}: the first {ERRORS_MAX} errors, and {more} more"));
    }
    let errors = errors.into_iter().take(ERRORS_MAX);
    let located = errors.map(|e| Located::new(name, text, e.span, e.message, cure(e.cure))).collect();
    Located::first_of(located).map_or_else(|| Failure::Run(format!("{name}: refused without a reason")), Failure::input)
}
