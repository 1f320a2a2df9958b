//! Which physics an arc misses, as the sample that travels, and as part of a plant.
//!
//! Effects travel as numbers: their places in the catalogue, which both sides have, and the places
//! of their sites in the plant file.

use crate::parameters::Parameters;
use dynamics::description::{EffectUse, Plant, Quantity, Site};
use dynamics::effect::{AMPLITUDE_PRIOR_RATIO, DIRECTION_PRIOR_RAD, Role, sites};
use telemetry::{DIAGNOSED_MAX, DIAGNOSED_PARAMETERS_MAX, Diagnosis, DiagnosisVerdict, Sample, layout_hash};

/// Prior standard deviation of the rate over which a sign turns, in the rate that the search kept:
/// it divides the rate by five until that explains no more, and so knows it within a factor of
/// five. Where a joint is held and creeps, the rate is the slope of its friction, which other arcs
/// tell. Where five times the rate is beyond the plausible, the arc tells no rate at all: it is
/// kept.
const SMOOTHING_PRIOR_RATIO: f64 = 4.0;

/// An effect that is missing, or that could replace one.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    pub kind: String,
    pub site: Site,
    /// The effect of this place in the answer, which it could replace.
    pub stands_in_for: Option<usize>,
    pub probability: f64,
    /// Root of the gain in `−2 ln p`.
    pub significance: f64,
    /// Name, value and standard deviation of each parameter of the law that was fitted, in the unit
    /// of the effect's site; of one that was kept at its value the deviation is NaN.
    pub values: Vec<(String, f64, f64)>,
}

/// What one arc answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    pub arc: usize,
    pub generation: u16,
    pub verdict: DiagnosisVerdict,
    /// The shared parameters beside what is missing.
    pub theta: Vec<f64>,
    /// Those that are missing before those that could replace them.
    pub effects: Vec<Missing>,
}

/// Why an answer cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unusable {
    #[error("its CRC is wrong")]
    Damaged,
    #[error("it speaks of another list of parameters or of effects: another build or plant file")]
    OtherBuild,
    #[error("an effect or a site of it does not exist here, or a parameter is not finite")]
    Unknown,
}

/// CRC-32 over the names of all effects in the order of the plant's catalogue.
#[must_use]
pub fn catalogue_hash(plant: &Plant) -> u32 {
    plant.catalogue.entries().iter().fold(0, |hash, effect| layout_hash(hash, effect.kind.as_bytes()))
}

/// The sample of `answer` about `plant`; effects beyond those that a sample holds are left out,
/// those that could replace others first.
#[must_use]
pub fn sample(answer: &Answer, plant: &Plant, parameters: &Parameters) -> Diagnosis {
    let mut sample = Diagnosis::zeroed_at(0);
    (sample.arc, sample.generation, sample.verdict) = (answer.arc as u16, answer.generation, answer.verdict.code());
    (sample.parameter_hash, sample.catalogue_hash) = (parameters.hash, catalogue_hash(plant));
    sample.theta.iter_mut().zip(&answer.theta).for_each(|(to, value)| *to = *value);
    (sample.value, sample.sigma) = ([[f64::NAN; _]; _], [[f64::NAN; _]; _]);
    for (k, missing) in answer.effects.iter().take(DIAGNOSED_MAX).enumerate() {
        let placed = plant
            .catalogue
            .effect(&missing.kind)
            .and_then(|effect| Some((effect, sites(effect, plant).iter().position(|site| *site == missing.site)?)));
        let Some((effect, site)) = placed else {
            // An effect at a part that another effect has made has no place in the plant file. What
            // could replace others may be left out, with all behind it; a model without one of the
            // effects found is not the model that was found.
            if missing.stands_in_for.is_none() {
                sample.count = 0;
            }
            break;
        };
        sample.count = k as u16 + 1;
        (sample.effect[k], sample.site[k]) = (plant.catalogue.place(&missing.kind) as u16, site as u16);
        sample.stands_in_for[k] = missing.stands_in_for.map_or(0, |of| of as u16 + 1);
        (sample.probability[k], sample.significance[k]) = (missing.probability, missing.significance);
        for (i, parameter) in effect.parameters.iter().take(DIAGNOSED_PARAMETERS_MAX).enumerate() {
            if let Some((_, value, sigma)) = missing.values.iter().find(|(name, ..)| name == parameter.name) {
                (sample.value[k][i], sample.sigma[k][i]) = (*value, *sigma);
            }
        }
    }
    sample.sealed()
}

/// What `sample` says about `plant`.
///
/// # Errors
/// See [`Unusable`].
pub fn answer(sample: &Diagnosis, plant: &Plant, parameters: &Parameters) -> Result<Answer, Unusable> {
    if !sample.is_intact() {
        return Err(Unusable::Damaged);
    }
    if (sample.parameter_hash, sample.catalogue_hash) != (parameters.hash, catalogue_hash(plant)) {
        return Err(Unusable::OtherBuild);
    }
    let verdict = DiagnosisVerdict::from_code(sample.verdict).ok_or(Unusable::OtherBuild)?;
    let count = usize::from(sample.count).min(DIAGNOSED_MAX);
    let effects = (0..count).map(|k| missing(sample, k, plant).ok_or(Unusable::Unknown)).collect::<Result<_, _>>()?;
    let theta = sample.theta[..parameters.len()].to_vec();
    if theta.iter().any(|value| !value.is_finite()) {
        return Err(Unusable::Unknown);
    }
    Ok(Answer { arc: sample.arc.into(), generation: sample.generation, verdict, theta, effects })
}

fn missing(sample: &Diagnosis, k: usize, plant: &Plant) -> Option<Missing> {
    let effect = plant.catalogue.entries().get(usize::from(sample.effect[k]))?;
    let site = sites(effect, plant).get(usize::from(sample.site[k]))?.clone();
    let numbers = sample.value[k].iter().zip(&sample.sigma[k]);
    let named = effect.parameters.iter().zip(numbers).filter(|(_, (value, _))| value.is_finite());
    Some(Missing {
        kind: effect.kind.to_owned(),
        site,
        stands_in_for: usize::from(sample.stands_in_for[k]).checked_sub(1),
        probability: sample.probability[k],
        significance: sample.significance[k],
        values: named.map(|(parameter, (value, sigma))| (parameter.name.to_owned(), *value, *sigma)).collect(),
    })
}

impl Missing {
    /// The law that was fitted as part of a plant: what was estimated is unknown, amplitudes within
    /// [`AMPLITUDE_PRIOR_RATIO`] of the largest of them or of their deviations, angles within
    /// [`DIRECTION_PRIOR_RAD`], others as the catalogue has it; what was kept is known, but the
    /// rate over which a sign turns.
    ///
    /// `None` for what begins or ends: its instants are those of one arc, and other arcs have
    /// others.
    #[must_use]
    pub fn as_effect(&self, plant: &Plant) -> Option<EffectUse> {
        let effect = plant.catalogue.effect(&self.kind)?;
        let is_amplitude = |name: &str| effect.parameter(name).is_some_and(|p| p.role == Role::Amplitude);
        let estimated = self.values.iter().filter(|(name, _, sigma)| is_amplitude(name) && sigma.is_finite());
        let size = estimated.fold(0.0, |size: f64, (_, value, sigma)| size.max(value.abs()).max(*sigma));
        let quantity = |(name, value, sigma): &(String, f64, f64)| {
            let parameter = effect.parameter(name)?;
            let of_catalogue = || parameter.prior.sigma(*value).or_else(|| parameter.prior.sigma_if_preferred(*value));
            let sigma = match parameter.role {
                Role::Onset | Role::Duration => return None,
                Role::Smoothing => Some(SMOOTHING_PRIOR_RATIO * value).filter(|sigma| value + sigma < parameter.high),
                _ if !sigma.is_finite() => None,
                Role::Amplitude => Some(AMPLITUDE_PRIOR_RATIO * size).filter(|sigma| *sigma > 0.0),
                Role::Direction { .. } => Some(DIRECTION_PRIOR_RAD),
                _ => of_catalogue(),
            };
            let quantity = sigma.map_or(Quantity::known(*value), |sigma| Quantity::with_prior(*value, sigma));
            Some((name.clone(), quantity))
        };
        let values = self.values.iter().map(quantity).collect::<Option<Vec<_>>>()?;
        Some(EffectUse { kind: self.kind.clone(), site: self.site.clone(), values })
    }
}

impl Answer {
    /// The effects that are missing, without those that could replace them.
    pub fn found(&self) -> impl Iterator<Item = &Missing> {
        self.effects.iter().filter(|missing| missing.stands_in_for.is_none())
    }

    /// `plant` with every effect that is missing; `None` where there is none, or where they cannot
    /// act together.
    #[must_use]
    pub fn augmented(&self, plant: &Plant) -> Option<Plant> {
        let mut augmented = plant.clone();
        for missing in self.found() {
            augmented.effects.push(missing.as_effect(plant)?);
        }
        augmented.effects.sort_by_key(|used| plant.order_of_action(used));
        let acts = augmented.effects.len() > plant.effects.len() && dynamics::system::System::new(&augmented).is_ok();
        acts.then_some(augmented)
    }
}
