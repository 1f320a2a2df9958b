//! Plant files: TOML in, a checked [`Plant`] out, and back. Scenarios: [`scenario`].
//!
//! What it is: [`parse`] reads a plant and reports all faults of a file at once, each with line,
//! column and a cure. Every number has a unit. [`write()`] puts a plant back into a file that is
//! read as the same plant.
//!
//! May import: `dynamics`, `catalogue`, `telemetry` (names and limits of a scenario), TOML.
//!
//! Must never know: recordings, estimators, processes; it opens no file, its callers pass the text.
//!
//! ```
//! let text = r#"
//!     format = 1
//!     name = "cart"
//!     space = "planar"
//!     [[body]]
//!     name = "cart"
//!     mass = { value = "2 kg", sigma = "1 %" }
//!     inertia = "0.1 kg m^2"
//!     joint = { kind = "prismatic", name = "rail", axis = "x", friction = "0.3 N*s/m" }
//! "#;
//! let plant = plant_file::parse("cart.toml", text).expect("a complete plant").plant;
//! assert_eq!(plant.bodies[0].name, "cart");
//! let faults = plant_file::parse("cart.toml", &text.replace("2 kg", "2 m")).unwrap_err();
//! assert_eq!(faults.len(), 1); // a mass in metres: line, column and cure
//! ```
//!
//! [`FORMAT`] is the definition of the format; `obsid plant format` prints it.
//!
#![doc = include_str!("format.md")]
#![forbid(unsafe_code)]

mod bodies;
mod effect_text;
mod inputs;
mod numbers;
mod origin;
mod outputs;
mod run;
pub mod scenario;
mod section;
mod set_text;
pub mod units;
pub mod validate;
mod write;

pub use effect_text::{effect_warnings, parse_effect};
pub use set_text::{set, set_all};
pub use write::write;

use crate::validate::{Fault, Place, faults_of_parts, with_faults_of_equations};
use catalogue::CATALOGUE;
use core::ops::Range;
use dynamics::description::{Plant, Space};
use dynamics::effect::Catalogue;
use origin::{Origin, locate};
use section::{Finding, Reader, Section};
use toml::de::DeTable;

/// The definition of plant files, in Markdown; its blocks, put together, are a complete plant.
pub const FORMAT: &str = include_str!("format.md");

/// Something in a plant file that cannot be used, or (as a warning) is not plausible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1, in characters.
    pub column: usize,
    pub message: String,
    /// What to do; empty where nothing is known.
    pub cure: String,
    /// Bytes of the text.
    pub span: Range<usize>,
}

impl core::fmt::Display for FileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        if self.cure.is_empty() { Ok(()) } else { write!(f, " ({})", self.cure) }
    }
}

impl core::error::Error for FileError {}

/// A plant file that can be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Parsed {
    pub plant: Plant,
    /// Possible, but not plausible.
    pub warnings: Vec<FileError>,
}

/// Reads and checks a plant file; `file_name` is only for messages.
///
/// # Errors
/// Everything that is wrong, in the order of the text; never empty.
pub fn parse(file_name: &str, text: &str) -> Result<Parsed, Vec<FileError>> {
    parse_with(CATALOGUE, file_name, text)
}

/// [`parse`] with the effects of another catalogue.
///
/// # Errors
/// As [`parse`].
pub fn parse_with(catalogue: Catalogue, file_name: &str, text: &str) -> Result<Parsed, Vec<FileError>> {
    let (document, syntax) = DeTable::parse_recoverable(text);
    let located = |findings: Vec<Finding>| locate(file_name, text, findings);
    if !syntax.is_empty() {
        let finding = |error: &toml::de::Error| {
            let message = error.message().lines().collect::<Vec<_>>().join(", ");
            let span = error.span().unwrap_or(0..0);
            let cure = syntax_cure(&message, text.get(span.clone()).unwrap_or(""));
            Finding { span, message, cure }
        };
        return Err(located(syntax.iter().map(finding).collect()));
    }
    let reader = Reader::default();
    let (plant, origin) = read(&reader, catalogue, document.get_ref(), text.len());
    let readable = reader.findings.borrow().is_empty();
    let (warnings, faults): (Vec<Fault>, Vec<Fault>) =
        faults_of(&plant, reader.space.get(), readable).into_iter().partition(|fault| fault.warning);
    let mut errors = origin.findings(&reader, &plant, faults);
    errors.extend(reader.findings.take());
    if errors.is_empty() {
        let warnings = located(origin.findings(&reader, &plant, warnings));
        Ok(Parsed { plant, warnings })
    } else {
        Err(located(errors))
    }
}

/// Faults of the plant; of its equations only where everything is `readable`. Where the space is
/// not known, those that hold in both.
fn faults_of(plant: &Plant, space: Option<Space>, readable: bool) -> Vec<Fault> {
    if space.is_none() {
        let other = faults_of_parts(&Plant { space: Space::Spatial, ..plant.clone() });
        return faults_of_parts(plant).into_iter().filter(|fault| other.contains(fault)).collect();
    }
    let parts = faults_of_parts(plant);
    if readable { with_faults_of_equations(plant, parts) } else { parts }
}

/// What to do about a text that is no TOML.
fn syntax_cure(message: &str, at: &str) -> String {
    if message.contains("duplicate key") || message.contains("cannot extend") || message.contains("redefine") {
        let word = at.trim_matches(['[', ']', '"', ' ']);
        return format!(
            "'{word}' is defined once more here: a key stands once in a table, [[{word}]] begins a further table, [{word}] never repeats"
        );
    }
    "correct this place: a plant file is written in TOML (https://toml.io), and `obsid plant format` has an example of each table".into()
}

/// The plant as far as it can be read, with stand-ins for the rest.
fn read(reader: &Reader, catalogue: Catalogue, document: &DeTable<'_>, length: usize) -> (Plant, Origin) {
    let place = Place { section: "plant", index: 0, key: String::new() };
    let root = Section::new(reader, document, 0..length.min(1), place, "the plant file".into());
    let mut origin = Origin::default();
    let mut plant = Plant { catalogue, ..Plant::default() };
    head(&root, &mut plant);
    plant.environment = run::environment(&root);
    plant.bodies = root.tables("body").iter_mut().map(bodies::body).collect();
    origin.put_parents_first(&mut plant);
    plant.tanks = root.tables("tank").iter_mut().map(bodies::tank).collect();
    plant.appendages = root.tables("appendage").iter_mut().map(bodies::appendage).collect();
    plant.actuators = root.tables("actuator").iter_mut().map(|section| inputs::actuator(section, &plant)).collect();
    plant.sources = root.tables("source").iter_mut().map(outputs::source).collect();
    for (i, section) in root.tables("sensor").iter_mut().enumerate() {
        let channels = outputs::sensors(section, &plant);
        origin.put_channels(i, &channels);
        plant.sensors.extend(channels);
    }
    plant.controllers =
        root.tables("controller").iter_mut().map(|section| inputs::controller(section, &plant)).collect();
    plant.initial = root.table("initial").map(|section| run::initial(&section, &plant)).unwrap_or_default();
    plant.segments = root.tables("segment").iter_mut().map(|section| run::segment(section, &plant)).collect();
    plant.simulation = root.table("simulation").map(|section| run::simulation(&section)).unwrap_or_default();
    plant.effects = root.tables("effect").iter_mut().map(|section| run::effect(section, &plant)).collect();
    root.finish();
    (plant, origin)
}

/// Format, name, text and space.
fn head(root: &Section<'_, '_>, plant: &mut Plant) {
    if !root.has("format") {
        root.get("format");
        root.missing("format", "a plant file begins with format = 1");
    } else if root.count("format") != 1 {
        root.error("format", "this format of plant files is unknown", "this version reads format = 1");
    }
    plant.name = root.required_text("name", "what the plant is called");
    plant.about = root.text("about").unwrap_or_default();
    let spaces = [("planar", Space::Planar), ("spatial", Space::Spatial)];
    let space = root.word("space", &spaces, None);
    root.reader.space.set(space);
    plant.space = space.unwrap_or_default();
}

#[cfg(test)]
mod tests;
