//! A plant with an effect at the amplitude that its score found.

use crate::score::{Candidate, Column};
use dynamics::description::{EffectUse, Plant, Quantity};
use dynamics::effect::{AMPLITUDE_PRIOR_RATIO, Amplitude, DIRECTION_PRIOR_RAD, EffectParameter, Role};

/// Largest share of a body's mass that a mode carries [1]. It keeps the rest of the body from a
/// zero mass; chosen, no derivation.
const MODE_MASS_SHARE_MAX: f64 = 0.9;

/// The plant with the effect at `share` of its estimated amplitude; its parameters have wide
/// priors.
pub(super) fn augmented(nominal: &Plant, column: &Column, amplitude: &[f64], share: f64) -> Option<Plant> {
    let candidate = &column.candidate;
    let parameters = candidate.effect.parameters;
    let components = candidate.effect.amplitudes();
    let (size, angles) = if components > 1 { (0.0, Vec::new()) } else { polar(candidate, amplitude) };
    // of a vector, by name
    let component = |name: &str| -> Option<f64> {
        let felt = candidate.directions.iter().zip(amplitude);
        let shares =
            felt.map(|(direction, a)| direction.iter().find(|(n, s)| *n == name && *s != 0.0).map(|(_, s)| s * a));
        shares.flatten().next()
    };
    let largest = amplitude.iter().fold(column.step.abs(), |most, a| most.max(a.abs()));
    let floor = if candidate.one_sided { 1e-3 * column.step.abs() } else { f64::NEG_INFINITY };
    let start = (share * candidate.at.unwrap_or(size)).clamp(parameters[0].low.max(floor), parameters[0].high);
    let mut values = Vec::new();
    for (place, parameter) in parameters.iter().enumerate() {
        let name = parameter.name;
        let given = if components > 1 && place < components {
            Some(component(name).map_or((0.0, None), |a| {
                ((share * a).clamp(parameter.low, parameter.high), Some(AMPLITUDE_PRIOR_RATIO * largest))
            }))
        } else if name == candidate.amplitude() {
            Some((start, Some(AMPLITUDE_PRIOR_RATIO * start.abs().max(column.step.abs()))))
        } else if let Some((_, angle)) = angles.iter().find(|(n, _)| *n == name) {
            Some((*angle, varies(candidate, name).then_some(DIRECTION_PRIOR_RAD)))
        } else {
            candidate.inner.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value, parameter.prior.sigma(*value)))
        };
        let given = given.map(|(value, sigma)| (value * locked(parameter, candidate, amplitude, share), sigma));
        let Some((value, sigma)) = given else { continue };
        let quantity = sigma.map_or(Quantity::known(value), |sigma| Quantity::with_prior(value, sigma));
        values.push((name.to_owned(), quantity));
    }
    let mut plant = nominal.clone();
    let effect = EffectUse { kind: candidate.effect.kind.to_owned(), site: candidate.site.clone(), values };
    plant.effects.push(effect);
    dynamics::system::System::new(&plant).ok()?;
    Some(plant)
}

/// Factor on the frequency of an appendage: a spectral line lies at the frequency of the free body,
/// the mode's own frequency (body locked) is lower by the root of the share of the body that the
/// mode does not carry.
fn locked(parameter: &EffectParameter, candidate: &Candidate, amplitude: &[f64], share: f64) -> f64 {
    if parameter.role != Role::Frequency || candidate.effect.amplitude != Amplitude::ShareOfBody {
        return 1.0;
    }
    let carried: f64 = amplitude.iter().map(|a| (share * a).abs()).sum();
    (1.0 - carried.min(MODE_MASS_SHARE_MAX)).sqrt()
}

/// Size and angles from amplitudes along the directions.
fn polar(candidate: &Candidate, amplitude: &[f64]) -> (f64, Vec<(&'static str, f64)>) {
    let directions = &candidate.directions;
    if directions.len() < 2 {
        return (amplitude.first().copied().unwrap_or(0.0), directions.first().cloned().unwrap_or_default());
    }
    let plane = (amplitude[0] * amplitude[0] + amplitude[1] * amplitude[1]).sqrt();
    let turn = candidate.pitch() * libm::atan2(amplitude[1], amplitude[0]);
    let mut angles = vec![(directions[0][0].0, turn)];
    if let Some(third) = amplitude.get(2) {
        angles.push((directions[0][1].0, libm::atan2(*third, plane)));
        return ((plane * plane + third * third).sqrt(), angles);
    }
    angles.extend(directions[0].iter().skip(1).copied());
    (plane, angles)
}

/// The directions differ in this angle.
fn varies(candidate: &Candidate, name: &str) -> bool {
    let of = |direction: &Vec<(&'static str, f64)>| direction.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
    candidate.directions.windows(2).any(|pair| of(&pair[0]) != of(&pair[1]))
}
