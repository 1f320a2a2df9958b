//! Scenario files on the command line: the user's, and the one that comes with the program.

use crate::{Failure, hidden, plants};
use plant_file::scenario::{self, Opened, Refusal};
use std::path::Path;

/// The scenario of `obsid run` without arguments.
const DEFAULT: &str = include_str!("../../../deploy/scenarios/default.toml");
/// What `obsid drill`, `latency` and `budget` fly: every mode in 40 s.
const SHORT: &str = include_str!("../../../deploy/scenarios/short.toml");
/// What `obsid bench study-case` flies.
const STUDY_CASE: &str = include_str!("../../../deploy/scenarios/study-case.toml");
/// The scenario of a recording without one: nothing is known, nothing is needed.
const NONE: &str = "format = 1\nname = \"no scenario\"\n";

/// Reads and checks a scenario file.
///
/// # Errors
/// [`Failure::Input`] with file, line, column, value and cure.
pub fn read(path: &Path) -> Result<Opened, Failure> {
    open(&path.display().to_string(), &text_of(path)?, Some(folder_of(path)))
}

/// As [`read`]; its craft carries the effects `hide` beside its own.
///
/// # Errors
/// As [`read`]; a scenario without a craft.
pub fn read_hiding(path: &Path, hide: &[String]) -> Result<Opened, Failure> {
    // faults of the file as it is written have their places in it
    let opened = read(path)?;
    let file = path.display().to_string();
    open(&file, &hidden::with(&file, &opened.text, hide)?, Some(folder_of(path)))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn text_of(path: &Path) -> Result<String, Failure> {
    plants::utf8_text(path).map_err(|(message, cure)| {
        let cure = cure.unwrap_or_else(|| "give the path of a scenario file, see deploy/scenarios".into());
        Failure::Input(miette::miette!(help = cure, "{message}"))
    })
}

/// The built-in scenario.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn default_scenario() -> Result<Opened, Failure> {
    open("deploy/scenarios/default.toml", DEFAULT, None)
}

/// The built-in scenario that reaches every mode soon.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn short_scenario() -> Result<Opened, Failure> {
    open("deploy/scenarios/short.toml", SHORT, None)
}

/// The built-in scenario of one craft.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn study_case() -> Result<Opened, Failure> {
    open("deploy/scenarios/study-case.toml", STUDY_CASE, None)
}

/// The built-in scenario of one craft, which carries the effects `hide`.
///
/// # Errors
/// [`Failure::Input`] where it cannot carry them.
pub fn study_case_hiding(hide: &[String]) -> Result<Opened, Failure> {
    let file = "deploy/scenarios/study-case.toml";
    open(file, &hidden::with(file, STUDY_CASE, hide)?, None)
}

/// What a recording without a scenario is replayed with.
///
/// # Errors
/// Never in a build whose tests pass.
pub fn no_scenario() -> Result<Opened, Failure> {
    open("no scenario", NONE, None)
}

/// Reads `text` and sees whether it can be flown; warnings go to standard error. Plant files are
/// looked for from `folder`; without one there are only those that come with the program.
fn open(file: &str, text: &str, folder: Option<&Path>) -> Result<Opened, Failure> {
    let text_of = |name: &str| {
        let own = folder.is_none().then(|| plants::built_in(name)).flatten();
        own.map_or_else(|| plants::text_of(name, folder.unwrap_or(Path::new(""))), |text| Ok(text.into()))
    };
    let refused = |refusal: Refusal| plants::refusal(&refusal.file, &refusal.text, refusal.errors);
    let opened = scenario::open(file, text, text_of).map_err(refused)?;
    opened.warnings.iter().for_each(|warning| crate::tell(&format!("warning: {warning}")));
    sensor_sim::systems::check(&opened.scenario).map_err(|(experiment, error)| {
        let cure = "see deploy/plants for plants that fly";
        let message = format!("{experiment}.plant: {error}");
        let error = scenario::error_at(file, text, &[experiment, "plant"], message, cure);
        plants::refusal(file, text, vec![error])
    })?;
    Ok(opened)
}

#[cfg(test)]
mod tests {
    use super::{default_scenario, no_scenario};

    #[test]
    fn the_scenarios_that_come_with_the_program_can_be_flown() {
        assert!(default_scenario().is_ok());
        assert!(no_scenario().is_ok_and(|opened| opened.files.is_empty()));
    }
}
