//! An effect on one line: `joint_coulomb@joint:shoulder force=0.2 smooth_rate="0.1 deg/s"`.

use super::numbers::{self, Expected};
use super::run;
use dynamics::description::{
    EffectUse, Plant, Quantity, check_site, implausible, in_catalogue_order, known_parameter, unit_at,
};

/// Reads `KIND@SITE name=value …` for `plant`; a value without unit is in SI, one with spaces
/// stands in quotes.
///
/// # Errors
/// What is unknown or impossible, with the nearest known word.
pub fn parse_effect(plant: &Plant, text: &str) -> Result<EffectUse, String> {
    let mut words = words(text)?.into_iter();
    let head = words.next().ok_or("an effect is KIND@SITE name=value …")?;
    let (kind, site) =
        head.split_once('@').ok_or_else(|| format!("'{head}' is not KIND@SITE, as in joint_coulomb@joint:NAME"))?;
    let entry = plant.catalogue.known(kind)?;
    let site = site.parse()?;
    check_site(plant, entry, &site)?;
    let mut values = Vec::new();
    for word in words {
        let (name, value) = word.split_once('=').ok_or_else(|| format!("'{word}' is not name=value"))?;
        let parameter = known_parameter(entry, name)?;
        let unit = run::readable(unit_at(plant, &site, parameter.unit));
        let expected = Expected { what: format!("{name} of {kind}"), unit: &unit };
        let value = value_in_si(value, &expected)
            .map_err(|(message, cure)| if cure.is_empty() { message } else { format!("{message}; {cure}") })?;
        values.push((name.to_owned(), Quantity::known(value)));
    }
    in_catalogue_order(EffectUse { kind: kind.to_owned(), site, values }, entry)
}

/// Warnings that a file with this effect would get: what is possible, but not plausible.
pub fn effect_warnings(plant: &Plant, effect: &EffectUse) -> Vec<String> {
    let Ok(entry) = plant.catalogue.known(&effect.kind) else { return Vec::new() };
    let said = |(_, message, what): (&str, String, &str)| format!("{message} ({what})");
    implausible(plant, entry, effect).into_iter().map(said).collect()
}

pub(super) fn value_in_si(text: &str, expected: &Expected<'_>) -> Result<f64, (String, String)> {
    let not_a_number = || {
        let cure = super::units::likely_cure(text).unwrap_or_else(|| format!("in {}", expected.unit));
        (format!("{}: '{text}' is not a number", expected.what), cure)
    };
    let (number, unit) = super::units::split(text).ok_or_else(not_a_number)?;
    let unit = if unit.is_empty() { expected.unit } else { unit };
    numbers::in_si(number, unit, expected)
}

/// Divides at spaces outside quotes.
fn words(text: &str) -> Result<Vec<String>, String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in text.chars() {
        match quote {
            Some(open) if c == open => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c.is_whitespace() => words.push(core::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    words.push(word);
    words.retain(|word| !word.is_empty());
    if quote.is_some() { Err(format!("a quote in '{text}' is not closed")) } else { Ok(words) }
}
