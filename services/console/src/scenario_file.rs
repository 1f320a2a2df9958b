//! Scenario files: TOML with spans, so that an error points at its place.

use crate::located::Located;
use crate::{Failure, plants};
use dynamics::description::Plant;
use plant_file::scenario::{CapturePlan, PlantUse, Scenario, limits};
use std::ops::Range;
use std::path::Path;
use toml::de::{DeArray, DeTable, DeValue};

/// The scenario of `obsid run` without arguments.
const DEFAULT: &str = include_str!("../../../deploy/scenarios/default.toml");

/// Reads and checks a scenario file.
///
/// # Errors
/// [`Failure::Input`] with file, line, column, value and cure.
pub fn read(path: &Path) -> Result<Scenario, Failure> {
    let file = path.display().to_string();
    let text = plants::utf8_text(path).map_err(|(message, cure)| {
        let cure = cure.unwrap_or_else(|| "give the path of a scenario file, see deploy/scenarios".into());
        Failure::Input(miette::miette!(help = cure, "{message}"))
    })?;
    parse(&file, &text, Some(path.parent().unwrap_or(Path::new(""))))
}

/// The built-in scenario.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn default_scenario() -> Result<Scenario, Failure> {
    parse("deploy/scenarios/default.toml", DEFAULT, None)
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
        capture: CapturePlan::default(),
        mated: None,
    }
}

/// Parses `text`; all impossible numbers are reported, the first with its place. Plant files are looked for from `folder`; without one
/// there are only those that come with the program.
///
/// # Errors
/// [`Failure::Input`].
pub fn parse(file: &str, text: &str, folder: Option<&Path>) -> Result<Scenario, Failure> {
    let mut scenario: Scenario = toml_file(file, text, "see deploy/scenarios/default.toml for every key")?;
    let mut impossible = scenario.impossible_numbers();
    impossible.extend(limits::beyond(&scenario));
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
fn read_plants(file: &str, text: &str, scenario: &mut Scenario, folder: Option<&Path>) -> Result<(), Failure> {
    for (experiment, used) in scenario.plants_mut() {
        let at = |keys: &[&str]| place_of(text, &[&[experiment, "plant"], keys].concat());
        if let Some(span) = at(&["text"]) {
            let cure = "a plant's text stands in its own file: name that as `file`";
            return Err(error_at(file, text, span, format!("unknown field `text` in {experiment}.plant"), cure.into()));
        }
        let own = folder.is_none().then(|| plants::built_in(&used.file)).flatten();
        let found = own.map_or_else(|| plants::text_of(&used.file, folder.unwrap_or(Path::new(""))), |t| Ok(t.into()));
        used.text =
            found.map_err(|(message, cure)| error_at(file, text, at(&["file"]).unwrap_or(0..0), message, cure))?;
        let parsed = plants::parse(&used.file, &used.text)?;
        plants::warn(&parsed);
        change(parsed.plant, used).map_err(|(keys, reason)| {
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            let span = at(&keys).or_else(|| at(&keys[..1])).unwrap_or(0..0);
            error_at(file, text, span, format!("{experiment}.plant: {}: {reason}", used.file), NAMES.into())
        })?;
    }
    sensor_sim::systems::check(scenario).map_err(|(experiment, error)| {
        let span = span_of(text, &format!("{experiment}.plant")).unwrap_or(0..0);
        error_at(file, text, span, format!("{experiment}.plant: {error}"), NAMES.into())
    })
}

const NAMES: &str =
    "see deploy/plants for plants that fly, `obsid plant parameters` for names, `obsid effects` for what can be hidden";

/// Sets and hides as a scenario asks for it: the keys under which the first fault stands, and the fault.
fn change(mut plant: Plant, used: &PlantUse) -> Result<(), (Vec<String>, String)> {
    let numbers: Vec<String> = used.set.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    plant_file::set_all(&mut plant, &numbers).map_err(|reason| {
        let guilty = used.set.keys().zip(&numbers).find(|(_, number)| reason.contains(&format!("'{number}'")));
        let keys = ["set".to_owned()].into_iter().chain(guilty.map(|(name, _)| name.clone()));
        (keys.collect::<Vec<_>>(), reason)
    })?;
    for (k, text) in used.hide.iter().enumerate() {
        let effect = plant_file::parse_effect(&plant, text)
            .map_err(|reason| (vec!["hide".to_owned(), k.to_string()], reason))?;
        for doubt in plant_file::effect_warnings(&plant, &effect) {
            crate::tell(&format!("warning: hide '{text}': {doubt}"));
        }
        plant.effects.push(effect);
    }
    Ok(())
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

fn error_at(file: &str, text: &str, span: Range<usize>, message: String, cure: String) -> Failure {
    Failure::input(Located::new(file, text, span, message, cure))
}

/// Where the value of a dotted key stands.
fn span_of(text: &str, key: &str) -> Option<Range<usize>> {
    let keys: Vec<&str> = key.split('.').collect();
    place_of(text, &keys)
}

/// Where the value under nested keys stands; an element of an array has its number for a key.
fn place_of(text: &str, keys: &[&str]) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut array: Option<&DeArray<'_>> = None;
    let mut found = None;
    for key in keys {
        let value = match array {
            Some(elements) => elements.get(key.parse::<usize>().ok()?)?,
            None => table.iter().find(|(name, _)| name.get_ref() == *key)?.1,
        };
        found = Some(value.span());
        array = None;
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            DeValue::Array(inner) => array = Some(inner),
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(text: &str) -> String {
        match parse("test.toml", text, None) {
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
