//! From text to scenario. Every fault has its place in the text and a cure.

use super::{PlantUseError, Scenario, limits};
use crate::FileError;
use crate::origin::locate;
use crate::section::Finding;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::de::{DeArray, DeTable, DeValue};

/// What the text that a run carries is called in messages.
const CARRIED: &str = "the run's scenario";
const KEYS: &str = "see deploy/scenarios/default.toml for every key";
const SIGNALS: &str = "commands and references are written as in a plant file, see deploy/scenarios/study-case.toml";
const NUMBERS: &str = "see deploy/scenarios/default.toml for numbers that fly";
const NAMES: &str = "see deploy/plants for plants that fly, `obsid plant parameters` for names, \
                     `obsid effects` for what can be hidden";

/// A scenario with the texts of the files that it names: what a run carries to its partitions.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    pub scenario: Scenario,
    pub text: String,
    /// Plant files, by the names that the scenario has for them.
    pub files: BTreeMap<String, String>,
    /// Possible, but not plausible.
    pub warnings: Vec<String>,
}

/// Everything that is wrong with one file, the scenario's or a plant's; never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    pub file: String,
    pub text: String,
    pub errors: Vec<FileError>,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let errors: Vec<String> = self.errors.iter().map(ToString::to_string).collect();
        f.write_str(&errors.join("; "))
    }
}

impl std::error::Error for Refusal {}

impl Scenario {
    /// Reads the scenario that a run carries, with its `files`; the same texts give every
    /// partition the same numbers, to the last bit.
    ///
    /// # Errors
    /// As `parse`, and where the text of a plant is missing.
    pub fn read(text: &str, files: &BTreeMap<String, String>, is_replay: bool) -> Result<Self, Refusal> {
        let refused = |errors| Refusal { file: CARRIED.into(), text: text.into(), errors };
        let mut scenario = parse(CARRIED, text).map_err(refused)?;
        for (experiment, used) in scenario.plants_mut() {
            let found = files.get(&used.file).ok_or_else(|| {
                let message = format!("{experiment}.plant: the run does not carry '{}'", used.file);
                refused(vec![error_at(CARRIED, text, &[experiment, "plant", "file"], message, KEYS)])
            })?;
            used.text.clone_from(found);
        }
        scenario.assume_rest(is_replay);
        Ok(scenario)
    }
}

/// Reads a scenario and every plant that it names, and checks them; `file` is only for messages.
/// `text_of` gives the text of a plant file, or what is wrong with its name and the cure.
///
/// # Errors
/// Everything that is wrong with the scenario, else with the first plant at fault.
pub fn open(
    file: &str,
    text: &str,
    mut text_of: impl FnMut(&str) -> Result<String, (String, String)>,
) -> Result<Opened, Refusal> {
    let refused = |errors| Refusal { file: file.into(), text: text.into(), errors };
    let mut scenario = parse(file, text).map_err(refused)?;
    let (mut files, mut warnings) = (BTreeMap::new(), Vec::new());
    for (experiment, used) in scenario.plants_mut() {
        let at = |keys: &[&str], message: String, cure: &str| {
            let keys = [&[experiment, "plant"], keys].concat();
            refused(vec![error_at(file, text, &keys, message, cure)])
        };
        used.text = text_of(&used.file).map_err(|(message, cure)| at(&["file"], message, &cure))?;
        let configured = used.configure().map_err(|error| match error {
            PlantUseError::File(errors) => Refusal { file: used.file.clone(), text: used.text.clone(), errors },
            PlantUseError::Change { ref keys, .. } => {
                let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
                at(&keys, format!("{experiment}.plant: {}: {error}", used.file), NAMES)
            }
        })?;
        warnings.extend(configured.warnings);
        files.insert(used.file.clone(), used.text.clone());
    }
    if let Some(craft) = &scenario.craft {
        for (k, arc) in craft.arcs.iter().enumerate() {
            let place = ["craft", "arc", &k.to_string()];
            craft
                .known(arc)
                .map_err(|error| refused(vec![error_at(file, text, &place, error.to_string(), SIGNALS)]))?;
        }
    }
    Ok(Opened { scenario, text: text.into(), files, warnings })
}

/// Reads a scenario and checks its numbers; `file` is only for messages. Of a plant it has the
/// name, not yet the text.
///
/// # Errors
/// A key or a type that is not of a scenario; else every number beyond a limit, in the order of the
/// text; never empty.
pub fn parse(file: &str, text: &str) -> Result<Scenario, Vec<FileError>> {
    let scenario: Scenario = toml::from_str(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        let offending = text.get(span.clone()).unwrap_or("").lines().next().unwrap_or("");
        let message = format!("{} (at '{offending}')", error.message());
        locate(file, text, vec![Finding { span, message, cure: KEYS.into() }])
    })?;
    let mut impossible = scenario.impossible_numbers();
    for beyond in limits::beyond(&scenario) {
        // A number that no system can have is beyond its limit, too.
        if impossible.iter().all(|known| known.key != beyond.key) {
            impossible.push(beyond);
        }
    }
    if impossible.is_empty() {
        return Ok(scenario);
    }
    let findings = impossible.into_iter().map(|number| {
        let keys: Vec<&str> = number.key.split('.').collect();
        let message = format!("{} = {}: {}", number.key, number.value, number.why);
        Finding { span: place_of(text, &keys), message, cure: NUMBERS.into() }
    });
    Err(locate(file, text, findings.collect()))
}

/// A fault of the value under nested keys.
#[must_use]
pub fn error_at(file: &str, text: &str, keys: &[&str], message: String, cure: &str) -> FileError {
    locate(file, text, vec![Finding { span: place_of(text, keys), message, cure: cure.into() }]).remove(0)
}

/// Where the value under nested keys stands, or what would hold it.
fn place_of(text: &str, keys: &[&str]) -> Range<usize> {
    let outer = (1..=keys.len()).rev();
    outer.filter_map(|count| value_at(text, &keys[..count])).next().unwrap_or(0..0)
}

/// Where the value under nested keys stands; an element of an array has its number for a key.
fn value_at(text: &str, keys: &[&str]) -> Option<Range<usize>> {
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
