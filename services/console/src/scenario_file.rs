//! Scenario files: TOML with spans, so that an error points at its place.

use crate::{Failure, scenario_limits};
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceSpan};
use runtime::Scenario;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The scenario of `obsid run` without arguments.
const DEFAULT: &str = include_str!("../../../deploy/scenarios/default.toml");

/// Something in a scenario file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
struct ScenarioError {
    file: String,
    line: usize,
    column: usize,
    message: String,
    cure: String,
    document: NamedSource<String>,
    span: SourceSpan,
}

impl Diagnostic for ScenarioError {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        (!self.cure.is_empty()).then(|| Box::new(&self.cure) as Box<dyn std::fmt::Display>)
    }
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&self.document)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(LabeledSpan::underline(self.span))))
    }
}

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
    parse(&file, &text)
}

/// The built-in scenario.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn default_scenario() -> Result<Scenario, Failure> {
    parse("deploy/scenarios/default.toml", DEFAULT)
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

/// Parses `text`; all impossible numbers are reported, the first with its place.
///
/// # Errors
/// [`Failure::Input`].
pub fn parse(file: &str, text: &str) -> Result<Scenario, Failure> {
    let scenario: Scenario = toml_file(file, text, "see deploy/scenarios/default.toml for every key")?;
    let mut impossible = scenario.impossible_numbers();
    impossible.extend(scenario_limits::beyond(&scenario));
    let Some(first) = impossible.first() else { return Ok(scenario) };
    let others: Vec<String> =
        impossible.iter().skip(1).map(|i| format!("{} = {}: {}", i.key, i.value, i.why)).collect();
    let example = "see deploy/scenarios/default.toml for numbers that fly";
    let cure = if others.is_empty() { example.into() } else { format!("{example}; also: {}", others.join("; ")) };
    let span = span_of(text, &first.key).unwrap_or(0..0);
    Err(error_at(file, text, span, format!("{} = {}: {}", first.key, first.value, first.why), cure))
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
    let (line, column) = place(text, span.start);
    let document = NamedSource::new(file, text.to_string());
    Failure::input(ScenarioError { file: file.into(), line, column, message, cure, document, span: span.into() })
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

/// Line and column, from 1.
fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let line = before.matches('\n').count() + 1;
    let column = before.len() - before.rfind('\n').map_or(0, |newline| newline + 1) + 1;
    (line, column)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(text: &str) -> String {
        match parse("test.toml", text) {
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
