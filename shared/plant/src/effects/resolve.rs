//! From the effects a plant carries to numbers and parts.

use super::{EFFECTS, Effect, Law, effect, sites};
use crate::description::{EffectUse, Plant};

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
    /// The part cannot be built with these numbers.
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
pub fn entry(used: &EffectUse, plant: &Plant) -> Result<&'static Effect, EffectError> {
    let kind = used.kind.clone();
    let Some(found) = effect(&used.kind) else {
        let nearest = nearest(&kind, EFFECTS.iter().map(|effect| effect.kind.to_owned()));
        return Err(EffectError::UnknownKind { kind, nearest });
    };
    let sites = sites(found, plant);
    if !sites.contains(&used.site) {
        let site = used.site.to_string();
        let nearest = nearest(&site, sites.iter().map(ToString::to_string));
        return Err(EffectError::UnknownSite { kind, site, nearest });
    }
    Ok(found)
}

/// The numbers of `used` in the order of the catalogue entry, absent ones at their defaults, zero behind the last.
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

/// Builds the parts that the plant's structural effects stand for, in the order of the effects, and removes those effects; all others
/// stay. Every effect is checked for its name, its site and its parameters.
///
/// # Errors
/// The first effect that cannot act; the plant is then as it was.
pub fn apply_structures(plant: &mut Plant) -> Result<(), EffectError> {
    let mut built = plant.clone();
    built.effects.clear();
    for used in &plant.effects {
        let effect = entry(used, &built)?;
        let values = values(effect, used)?;
        let Law::Structure(build) = effect.law else {
            built.effects.push(used.clone());
            continue;
        };
        build(&mut built, &used.site, &values).map_err(|reason| EffectError::Impossible {
            kind: used.kind.clone(),
            site: used.site.to_string(),
            reason,
        })?;
    }
    *plant = built;
    Ok(())
}
