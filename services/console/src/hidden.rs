//! Physics that is hidden in a craft from the command line.

use crate::Failure;

/// The text of a scenario whose craft carries `hide`, too.
///
/// # Errors
/// [`Failure::Input`] where the scenario has no craft.
pub fn with(file: &str, text: &str, hide: &[String]) -> Result<String, Failure> {
    let unreadable = |error: &dyn std::fmt::Display| Failure::Input(miette::miette!("{file}: {error}"));
    let mut document: toml::Table = toml::from_str(text).map_err(|error| unreadable(&error))?;
    let plant = document.get_mut("craft").and_then(|craft| craft.get_mut("plant")).and_then(toml::Value::as_table_mut);
    let plant = plant.ok_or_else(|| without_craft(file))?;
    let own = plant.entry("hide").or_insert_with(|| toml::Value::Array(Vec::new()));
    if let Some(own) = own.as_array_mut() {
        own.extend(hide.iter().map(|effect| toml::Value::from(effect.clone())));
    }
    toml::to_string(&document).map_err(|error| unreadable(&error))
}

/// There is nothing to hide anything in.
pub fn without_craft(file: &str) -> Failure {
    Failure::Input(miette::miette!(
        help = "give a scenario with a [craft], as deploy/scenarios/study-case.toml; experiments on plants of their own \
                have `hide` in their `plant`",
        "--hide: {file} has no [craft]"
    ))
}
