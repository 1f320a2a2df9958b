//! `obsid effects`: the catalogue of physics that a model can leave out.

use crate::{Failure, plants};
use catalogue::CATALOGUE;
use dynamics::description::{Plant, SiteKind, Space};
use dynamics::effect::{Catalogue, Effect, EffectParameter, Limit, Role, sites};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// List the physics that a model can leave out, and where it can sit
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid effects                                       the whole catalogue
  obsid effects joint_coulomb                         one entry: equation, signature, confounders, experiment
  obsid effects --plant deploy/plants/drive_rig.toml  what this plant can carry, and at which sites

In a unit `*` stands for that of the site: rad or m at a joint, the input's at an actuator, the channel's at a sensor; with --plant it is
filled in.")]
pub struct Arguments {
    /// One entry in full
    kind: Option<String>,
    /// Only what this plant can carry, with its sites
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// # Errors
/// [`Failure::Input`] for an unknown entry or a plant that cannot be read.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let plant = arguments.plant.as_deref().map(plants::read).transpose()?;
    let entries = entries(arguments.kind.as_deref(), plant.as_ref())?;
    crate::print(&match (&arguments.kind, arguments.json) {
        (_, true) => format!("{}\n", json!({ "effects": entries.iter().map(as_json).collect::<Vec<_>>() })),
        (Some(_), false) => entries.iter().map(page).collect(),
        (None, false) => table(&entries),
    });
    Ok(())
}

/// An effect, the sites it can have, and the unit of each parameter there.
struct Entry {
    effect: &'static Effect,
    sites: Vec<String>,
    units: Vec<String>,
    space: Space,
}

impl Entry {
    /// The parameters that the plant feels, each with its unit.
    fn parameters(&self) -> impl Iterator<Item = (&'static EffectParameter, &String)> {
        let felt = |parameter: &EffectParameter| self.space == Space::Spatial || !parameter.out_of_plane;
        self.effect.parameters.iter().zip(&self.units).filter(move |(parameter, _)| felt(parameter))
    }
}

fn entries(kind: Option<&str>, plant: Option<&Plant>) -> Result<Vec<Entry>, Failure> {
    let catalogue = plant.map_or(CATALOGUE, |plant| plant.catalogue);
    let chosen: Vec<&'static Effect> = match kind {
        None => catalogue.entries().to_vec(),
        Some(kind) => vec![catalogue.effect(kind).ok_or_else(|| unknown(catalogue, kind))?],
    };
    let entry = |effect: &'static Effect| {
        let sites = match plant {
            Some(plant) => sites(effect, plant).iter().map(ToString::to_string).collect(),
            None => effect.sites.iter().map(|kind: &SiteKind| format!("{}:NAME", kind.name())).collect(),
        };
        Entry { effect, sites, units: units(effect, plant), space: plant.map_or(Space::Spatial, |plant| plant.space) }
    };
    Ok(chosen.into_iter().map(entry).filter(|entry| !entry.sites.is_empty()).collect())
}

/// Units at the sites of a plant, `N or N*m` where they differ; of the catalogue, where `*` is the
/// site's, without one.
fn units(effect: &Effect, plant: Option<&Plant>) -> Vec<String> {
    let mut units: Vec<Vec<String>> = vec![Vec::new(); effect.parameters.len()];
    for (plant, site) in
        plant.into_iter().flat_map(|plant| sites(effect, plant).into_iter().map(move |site| (plant, site)))
    {
        let mut carrying = plant.without_effects();
        let values: Vec<(&str, f64)> = effect.parameters.iter().map(|p| (p.name, p.default)).collect();
        if carrying.add_effect(effect.kind, &site, &values).is_err() {
            continue;
        }
        let numbers = carrying.parameters();
        for (parameter, known) in effect.parameters.iter().zip(&mut units) {
            let name = format!("effect.{}@{site}.{}", effect.kind, parameter.name);
            if let Some(number) = numbers.iter().find(|number| number.name == name)
                && !known.contains(&number.unit)
            {
                known.push(number.unit.clone());
            }
        }
    }
    let of_catalogue = effect.parameters.iter().map(|parameter| parameter.unit);
    units
        .iter()
        .zip(of_catalogue)
        .map(|(known, unit)| if known.is_empty() { unit.into() } else { known.join(" or ") })
        .collect()
}

fn unknown(catalogue: Catalogue, kind: &str) -> Failure {
    let near = catalogue
        .entries()
        .iter()
        .map(|effect| effect.kind)
        .max_by(|a, b| strsim::jaro_winkler(a, kind).total_cmp(&strsim::jaro_winkler(b, kind)));
    let help = format!("did you mean '{}'? `obsid effects` lists all", near.unwrap_or_default());
    Failure::Input(miette::miette!(help = help, "'{kind}' is not in the catalogue"))
}

fn as_json(entry: &Entry) -> Value {
    let parameters: Vec<Value> = entry
        .parameters()
        .map(|(p, unit)| {
            json!({ "name": p.name, "unit": unit, "low": p.low, "high": p.high, "default": p.default,
            "what": p.what, "role": role(p.role) })
        })
        .collect();
    let Effect { kind, title, what, signature, confounders, experiment, .. } = entry.effect;
    json!({ "kind": kind, "title": title, "family": entry.effect.family.name(), "sites": entry.sites, "parameters": parameters, "what": what,
        "signature": signature, "confounders": confounders, "experiment": experiment,
        "limits": entry.effect.limits.iter().map(|limit| json!({ "kind": limit.kind, "at": at(limit) })).collect::<Vec<_>>() })
}

/// What a parameter is to its law, in one word.
const fn role(role: Role) -> &'static str {
    match role {
        Role::Amplitude => "amplitude",
        Role::Direction { .. } => "direction",
        Role::Frequency => "frequency",
        Role::DampingRatio => "damping ratio",
        Role::Order => "order",
        Role::Onset => "onset",
        Role::Duration => "duration",
        Role::Width => "width",
        Role::Smoothing => "smoothing",
        Role::Shape => "shape",
    }
}

/// `presliding = 1e-6, bristle_damping = 0`.
fn at(limit: &Limit) -> String {
    limit.at.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
}

fn table(entries: &[Entry]) -> String {
    let mut text = format!("{:<28} {:<34} parameters [unit]\n", "kind", "sites");
    for entry in entries {
        let parameters: Vec<String> = entry.parameters().map(|(p, unit)| format!("{} [{unit}]", p.name)).collect();
        let _ = writeln!(text, "{:<28} {:<34} {}", entry.effect.kind, entry.sites.join(" "), parameters.join(", "));
    }
    let _ = writeln!(text, "\n{} effects; `obsid effects KIND` shows one in full", entries.len());
    text
}

fn page(entry: &Entry) -> String {
    let Effect { kind, title, what, signature, confounders, experiment, .. } = entry.effect;
    let family = entry.effect.family.name();
    let mut text = format!("{kind}: {title}\n\n  family       {family}\n  sites        {}\n", entry.sites.join(" "));
    for (label, words) in
        [("what", what), ("signature", signature), ("confounders", confounders), ("experiment", experiment)]
    {
        let _ = writeln!(text, "  {label:<12} {words}");
    }
    for limit in entry.effect.limits {
        let _ = writeln!(text, "  {:<12} {} at {}", "contains", limit.kind, at(limit));
    }
    let _ = writeln!(
        text,
        "\n  {:<20} {:<14} {:>12} {:>12} {:>12}  {:<13} meaning",
        "parameter", "unit", "low", "high", "default", "role"
    );
    for (p, unit) in entry.parameters() {
        let row = format!("  {:<20} {unit:<14} {:>12} {:>12} {:>12}", p.name, p.low, p.high, p.default);
        let _ = writeln!(text, "{row}  {:<13} {}", role(p.role), p.what);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An effect that exists in this test alone.
    static OWN: Effect = Effect {
        kind: "mass_of_a_test",
        title: "Mass of a test",
        sites: &[SiteKind::Body],
        parameters: &[EffectParameter::new("added", "kg", [0.0, 1.0], 0.1, "mass that the test adds").amplitude()],
        what: "m = m_0 + added",
        ..Effect::PLAIN
    };

    #[test]
    fn an_effect_of_the_plants_own_catalogue_is_listed_and_described() {
        let mut plant = plant_file::parse("pendulum", plants::built_in("pendulum").unwrap()).unwrap().plant;
        static ENTRIES: [&Effect; 1] = [&OWN];
        plant.catalogue = Catalogue::new(&ENTRIES);
        let listed = entries(None, Some(&plant)).unwrap_or_default();
        assert_eq!(listed.len(), 1);
        assert!(table(&listed).contains("mass_of_a_test") && table(&listed).contains("added [kg]"));
        let described = page(&listed[0]);
        for text in ["Mass of a test", "m = m_0 + added", "mass that the test adds", "amplitude", "body:"] {
            assert!(described.contains(text), "{text} in {described}");
        }
        assert_eq!(as_json(&listed[0])["parameters"][0]["role"], "amplitude");
        assert!(entries(Some("joint_coulomb"), Some(&plant)).is_err());
    }
}
