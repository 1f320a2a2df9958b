//! From the effects of a plant to values and parts.

use super::{Catalogue, Effect, Law};
use crate::description::{EffectUse, Plant, Site, Space};

/// Most parameters an effect can have.
pub const PARAMETERS_MAX: usize = 8;

/// Why an effect of a plant cannot act.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EffectError {
    #[error("there is no effect '{kind}'{}", hint(.nearest))]
    UnknownKind { kind: String, nearest: Option<String> },
    #[error("{kind} cannot sit at {site}{}", hint(.nearest))]
    UnknownSite { kind: String, site: String, nearest: Option<String> },
    #[error("{kind} has no parameter '{parameter}'{}", hint(.nearest))]
    UnknownParameter { kind: String, parameter: String, nearest: Option<String> },
    /// The part cannot be built with these values.
    #[error("{kind} at {site}: {reason}")]
    Impossible { kind: String, site: String, reason: String },
}

fn hint(nearest: &Option<String>) -> String {
    nearest.as_ref().map_or_else(String::new, |nearest| format!("; did you mean '{nearest}'?"))
}

/// The candidate most like `word`, if any is like it.
fn nearest(word: &str, candidates: impl Iterator<Item = String>) -> Option<String> {
    let scored = candidates.map(|candidate| (strsim::jaro_winkler(word, &candidate), candidate));
    let best = scored.fold(None, |best: Option<(f64, String)>, next| match best {
        Some(best) if best.0 >= next.0 => Some(best),
        _ => Some(next),
    });
    best.filter(|(score, _)| *score > 0.75).map(|(_, candidate)| candidate)
}

/// The catalogue entry of `used`, which sits where it can.
///
/// # Errors
/// The kind is not in the catalogue, or the site is not one of its sites in `plant`.
fn entry(used: &EffectUse, plant: &Plant) -> Result<&'static Effect, EffectError> {
    let found = plant.catalogue.effect(&used.kind).ok_or_else(|| unknown_kind(used, plant.catalogue))?;
    if sites(found, plant).contains(&used.site) { Ok(found) } else { Err(unknown_site(found, used, plant)) }
}

fn unknown_kind(used: &EffectUse, catalogue: Catalogue) -> EffectError {
    let kind = used.kind.clone();
    let nearest = nearest(&kind, catalogue.entries().iter().map(|effect| effect.kind.to_owned()));
    EffectError::UnknownKind { kind, nearest }
}

fn unknown_site(effect: &Effect, used: &EffectUse, plant: &Plant) -> EffectError {
    let (kind, site) = (used.kind.clone(), used.site.to_string());
    let nearest = nearest(&site, sites(effect, plant).iter().map(ToString::to_string));
    EffectError::UnknownSite { kind, site, nearest }
}

/// The values of `used` in the order of the catalogue entry, absent ones at their defaults, zero
/// behind the last.
///
/// # Errors
/// [`EffectError::UnknownParameter`]: a name that the entry does not have.
pub fn values(effect: &Effect, used: &EffectUse) -> Result<[f64; PARAMETERS_MAX], EffectError> {
    let mut values = [0.0; PARAMETERS_MAX];
    for (value, parameter) in values.iter_mut().zip(effect.parameters) {
        *value = parameter.default;
    }
    for (name, quantity) in &used.values {
        let Some(place) = effect.parameters.iter().position(|parameter| parameter.name == name) else {
            let nearest = nearest(name, effect.parameters.iter().map(|parameter| parameter.name.to_owned()));
            return Err(EffectError::UnknownParameter { kind: used.kind.clone(), parameter: name.clone(), nearest });
        };
        values[place] = quantity.value;
    }
    Ok(values)
}

/// Sets to zero the values of components that leave the plane of a planar plant.
pub fn felt(effect: &Effect, values: &mut [f64; PARAMETERS_MAX], space: Space) {
    for (value, parameter) in values.iter_mut().zip(effect.parameters) {
        if space == Space::Planar && parameter.out_of_plane {
            *value = 0.0;
        }
    }
}

/// Every site of `plant` at which `effect` can sit.
pub fn sites(effect: &Effect, plant: &Plant) -> Vec<Site> {
    let of_kind = effect.sites.iter().flat_map(|kind| plant.sites(*kind));
    of_kind.filter(|site| (effect.applies)(plant, site)).collect()
}

/// Builds the parts of the plant's structural effects and removes those effects; all others stay.
/// Every effect is checked for its name, its site and its parameters.
///
/// Structures at sites of the plant itself are built in the order of the catalogue, then of their
/// sites; those at parts that others have made follow in the same manner: the order in the plant
/// does not matter.
///
/// # Errors
/// The first effect that cannot act; the plant is then as it was.
pub fn apply_structures(plant: &mut Plant) -> Result<(), EffectError> {
    let mut built = Plant { effects: Vec::new(), ..plant.clone() };
    let mut waiting = Vec::new();
    for used in &plant.effects {
        let effect = plant.catalogue.effect(&used.kind).ok_or_else(|| unknown_kind(used, plant.catalogue))?;
        let mut numbers = values(effect, used)?;
        felt(effect, &mut numbers, plant.space);
        match effect.law {
            Law::Structure(build) => waiting.push((effect, build, used, numbers)),
            _ => built.effects.push(used.clone()),
        }
    }
    waiting.sort_by_cached_key(|(_, _, used, _)| plant.order_of_action(used));
    while let Some((effect, _, used, _)) = waiting.first() {
        let there: Vec<bool> = waiting.iter().map(|(e, _, used, _)| sites(e, &built).contains(&used.site)).collect();
        if !there.contains(&true) {
            return Err(unknown_site(effect, used, &built));
        }
        let mut later = Vec::new();
        for (next, there) in waiting.into_iter().zip(there) {
            let (_, build, used, numbers) = next;
            if !there {
                later.push(next);
                continue;
            }
            let impossible =
                |reason| EffectError::Impossible { kind: used.kind.clone(), site: used.site.to_string(), reason };
            build(&mut built, &used.site, &numbers).map_err(impossible)?;
        }
        waiting = later;
    }
    for used in &built.effects {
        entry(used, &built)?;
    }
    *plant = built;
    Ok(())
}
