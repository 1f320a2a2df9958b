//! Plant files on the command line: the user's, and those that come with the program.

use crate::Failure;
use crate::located::Located;
use plant::description::Plant;
use plant::file::{self, FileError, Parsed};
use std::path::Path;

/// A plant of `deploy/plants` by its name.
macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../deploy/plants/", $name, ".toml")))),*]
    };
}

/// Plants that need no file: name and text.
pub const BUILT_IN: &[(&str, &str)] = built_in![
    "damper_rig",
    "double_pendulum",
    "drive_rig",
    "free_floating_arm",
    "free_flying_arm",
    "hub_appendage",
    "hub_appendage_closed_loop",
    "mated",
    "oscillator",
    "pendulum",
    "rigid_body_imu",
    "study_case",
    "study_case_spatial",
    "tank_1d",
    "tank_pendulum",
    "tank_planar",
];

/// Text of a plant file, or of the built-in plant of that name; `folder` is where relative paths begin.
///
/// # Errors
/// What is wrong, and the cure.
pub fn text_of(name: &str, folder: &Path) -> Result<String, (String, String)> {
    if let Some((_, text)) = BUILT_IN.iter().find(|(built_in, _)| *built_in == name) {
        return Ok((*text).to_string());
    }
    std::fs::read_to_string(folder.join(name)).map_err(|error| {
        let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
        let near = BUILT_IN.iter().map(|(known, _)| (strsim::jaro_winkler(known, name), *known));
        let near = near.filter(|(likeness, _)| *likeness > 0.85).max_by(|a, b| a.0.total_cmp(&b.0));
        let meant = near.map_or(String::new(), |(_, known)| format!("did you mean '{known}'? "));
        let cure = format!("{meant}give the path of a plant file (see deploy/plants), or one of {}", names.join(", "));
        (format!("{name}: cannot be read: {error}"), cure)
    })
}

/// Reads a plant file; warnings go to standard error.
///
/// # Errors
/// [`Failure::Input`] with every error of the file.
pub fn read(path: &Path) -> Result<Plant, Failure> {
    let name = path.display().to_string();
    let text = text_of(&name, Path::new(""))
        .map_err(|(message, cure)| Failure::Input(miette::miette!(help = cure, "{message}")))?;
    let parsed = parse(&name, &text)?;
    parsed.warnings.iter().for_each(|warning| crate::tell(&format!("warning: {warning}")));
    Ok(parsed.plant)
}

/// # Errors
/// [`Failure::Input`] with every error of `text`.
pub fn parse(name: &str, text: &str) -> Result<Parsed, Failure> {
    file::parse(name, text).map_err(|errors| refusal(name, text, errors))
}

/// Every error of `text` in one report.
pub fn refusal(name: &str, text: &str, errors: Vec<FileError>) -> Failure {
    let example = "deploy/plants has examples, the head of shared/plant/src/file.rs describes the format";
    let cure = |cure: String| if cure.is_empty() { example.to_string() } else { cure };
    let located = errors.into_iter().map(|e| Located::new(name, text, e.span, e.message, cure(e.cure))).collect();
    Located::first_of(located).map_or_else(|| Failure::Run(format!("{name}: refused without a reason")), Failure::input)
}

#[cfg(test)]
mod tests {
    use super::BUILT_IN;

    #[test]
    fn every_plant_of_the_deployment_needs_no_path() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut files: Vec<String> = files.filter_map(|name| name.strip_suffix(".toml").map(str::to_owned)).collect();
        files.sort();
        assert_eq!(BUILT_IN.iter().map(|(name, _)| *name).collect::<Vec<_>>(), files);
    }
}
