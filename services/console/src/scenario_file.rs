//! Scenario files: TOML with spans, so that an error points at its place.

use crate::located::Located;
use crate::{Failure, plant_file, scenario_limits};
use runtime::Scenario;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The scenario of `obsid run` without arguments.
const DEFAULT: &str = include_str!("../../../deploy/scenarios/default.toml");

/// Reads and checks a scenario file.
///
/// # Errors
/// [`Failure::Input`] with file, line, column, value and cure.
pub fn read(path: &Path) -> Result<Scenario, Failure> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::Input(miette::miette!(
            help = "give the path of a scenario file, see deploy/scenarios",
            "{file}: cannot be read: {error}"
        ))
    })?;
    parse(&file, &text, path.parent().unwrap_or(Path::new("")))
}

/// The built-in scenario.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn default_scenario() -> Result<Scenario, Failure> {
    parse("deploy/scenarios/default.toml", DEFAULT, Path::new(""))
}

/// A recording without a scenario: nothing is known, nothing is needed.
#[must_use]
pub fn no_scenario() -> Scenario {
    Scenario {
        format: 1,
        name: "no scenario".into(),
        frame_period_ms: 10,
        seed: 1,
        window_frames: 100,
        modal: None,
        slosh: None,
        inertial: None,
        capture: runtime::scenario::CapturePlan::default(),
        mated: None,
    }
}

/// Parses `text`; all impossible numbers are reported, the first with its place. Plant files are looked for from `folder`.
///
/// # Errors
/// [`Failure::Input`].
pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Scenario, Failure> {
    let mut scenario: Scenario = toml_file(file, text, "see deploy/scenarios/default.toml for every key")?;
    let mut impossible = scenario.impossible_numbers();
    impossible.extend(scenario_limits::beyond(&scenario));
    let Some(first) = impossible.first() else {
        read_plants(file, text, &mut scenario, folder)?;
        return Ok(scenario);
    };
    let others: Vec<String> =
        impossible.iter().skip(1).map(|i| format!("{} = {}: {}", i.key, i.value, i.why)).collect();
    let example = "see deploy/scenarios/default.toml for numbers that fly";
    let cure = if others.is_empty() { example.into() } else { format!("{example}; also: {}", others.join("; ")) };
    let span = span_of(text, &first.key).unwrap_or(0..0);
    Err(error_at(file, text, span, format!("{} = {}: {}", first.key, first.value, first.why), cure))
}

/// Puts the texts of the plant files into the scenario, and sees whether they can be flown.
fn read_plants(file: &str, text: &str, scenario: &mut Scenario, folder: &Path) -> Result<(), Failure> {
    for (experiment, plant) in scenario.plants_mut() {
        let found = plant_file::text_of(&plant.file, folder);
        plant.text = found.map_err(|(message, cure)| {
            let span = span_of(text, &format!("{experiment}.plant.file")).unwrap_or(0..0);
            error_at(file, text, span, message, cure)
        })?;
        plant_file::parse(&plant.file, &plant.text)?;
    }
    sensor_sim::systems::check(scenario).map_err(|(experiment, error)| {
        let span = span_of(text, &format!("{experiment}.plant")).unwrap_or(0..0);
        let cure = "see deploy/plants for plants that fly, `obsid plant parameters` for names, `obsid effects` for what can be hidden";
        error_at(file, text, span, format!("{experiment}.plant: {error}"), cure.into())
    })
}

/// Parses a TOML file of ours: an unknown key or a wrong type is an error with its place.
///
/// # Errors
/// [`Failure::Input`].
pub fn toml_file<T: serde::de::DeserializeOwned>(file: &str, text: &str, cure: &str) -> Result<T, Failure> {
    toml::from_str(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        let offending = text.get(span.clone()).unwrap_or("").lines().next().unwrap_or("").to_string();
        error_at(file, text, span, format!("{} (at '{offending}')", error.message()), cure.into())
    })
}

fn error_at(file: &str, text: &str, span: std::ops::Range<usize>, message: String, cure: String) -> Failure {
    Failure::input(Located::new(file, text, span, message, cure))
}

/// Where the value of a dotted key stands.
fn span_of(text: &str, key: &str) -> Option<std::ops::Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut found = None;
    for part in key.split('.') {
        let value = table.iter().find(|(name, _)| name.get_ref() == part)?.1;
        found = Some(value.span());
        if let DeValue::Table(inner) = value.get_ref() {
            table = inner;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(text: &str) -> String {
        match parse("test.toml", text, Path::new("")) {
            Err(Failure::Input(report)) => format!("{report:?}\n{report}"),
            other => panic!("accepted: {other:?}"),
        }
    }

    #[test]
    fn the_default_scenario_is_valid() {
        assert!(default_scenario().is_ok());
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_column() {
        let message = error_of("format = 1\nname = \"x\"\nwindow_framse = 3\n");
        assert!(message.contains("test.toml:3:1"), "{message}");
        assert!(message.contains("window_framse"), "{message}");
        assert!(message.contains("window_frames"), "the known keys are listed: {message}");
    }

    #[test]
    fn an_impossible_number_is_named_with_its_place_and_all_others_with_it() {
        let text = "format = 1\nname = \"x\"\n[slosh]\nduration_s = -5.0\n[slosh.known]\nm_0_kg = nan\n";
        let message = error_of(text);
        assert!(message.contains("test.toml:4:14"), "{message}");
        assert!(message.contains("-5") && message.contains("above 0"), "{message}");
        assert!(message.contains("m_0_kg"), "the second fault is named too: {message}");
    }

    #[test]
    fn a_number_of_another_type_is_named_with_its_place() {
        let message = error_of("format = 1\nname = \"x\"\nseed = \"one\"\n");
        assert!(message.contains("test.toml:3:8"), "{message}");
    }
}
