//! Fit of the augmented plant: an effect as physics, started at the score's amplitude, the shape
//! parameters of its law free.

use super::BIC_PREFERENCE;
use crate::score::{Candidate, Column};
use dynamics::description::{EffectUse, Plant, Quantity};
use dynamics::effect::{AMPLITUDE_PRIOR_RATIO, Amplitude, DIRECTION_PRIOR_RAD, EffectParameter, Role};
use dynamics::system::System;
use identification::filter::{NoiseModel, equip};
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit, is_mass};
use identification::problem::Problem;

/// A fitted augmented plant.
#[derive(Clone, Debug)]
pub struct FittedModel {
    pub plant: Plant,
    pub problem: Problem,
    pub fit: Fit,
    pub noise: NoiseModel,
    /// Least `−2 ln p` with its own noise.
    pub objective: f64,
    /// Free parameters of the effects.
    pub free: usize,
    /// Other local optima that are nearly as good.
    pub optima: Vec<LocalOptimum>,
}

/// A further local optimum of a fit.
#[derive(Clone, Debug)]
pub struct LocalOptimum {
    pub objective: f64,
    pub theta: Vec<f64>,
    pub sigma: Vec<f64>,
}

impl FittedModel {
    /// The plant of `fit` without effects to be counted, at its only optimum.
    pub fn new(problem: Problem, fit: Fit, noise: NoiseModel, objective: f64) -> Self {
        Self { plant: fit.plant.clone(), problem, fit, noise, objective, free: 0, optima: Vec::new() }
    }

    /// One optimum instead of several: the best, its standard deviations over all of them.
    pub fn merged(&self) -> Self {
        Self {
            plant: self.plant.clone(),
            problem: self.problem.clone(),
            fit: Fit { sigma: self.sigma(), ..self.fit.clone() },
            noise: self.noise.clone(),
            objective: self.objective,
            free: self.free,
            optima: Vec::new(),
        }
    }

    /// Posterior standard deviations over all local optima, one for each unknown, in its unit.
    pub fn sigma(&self) -> Vec<f64> {
        let weight = |optimum: &LocalOptimum| libm::exp(-0.5 * (optimum.objective - self.objective));
        let whole = 1.0 + self.optima.iter().map(weight).sum::<f64>();
        let over = |i: usize| {
            let off = |optimum: &LocalOptimum| {
                weight(optimum) * (optimum.sigma[i].powi(2) + (optimum.theta[i] - self.fit.theta[i]).powi(2))
            };
            (self.fit.sigma[i].powi(2) + self.optima.iter().map(off).sum::<f64>()) / whole
        };
        (0..self.fit.sigma.len()).map(|i| over(i).sqrt()).collect()
    }

    /// Fitted again without the effect of `column`; `None` where that fit fails.
    pub fn without(&self, session: &EstimationSession<'_>, column: &Column) -> Option<Self> {
        let candidate = &column.candidate;
        let mut plant = self.plant.clone();
        plant.effects.retain(|used| used.kind != candidate.effect.kind || used.site != candidate.site);
        let problem = session.problem.with_plant(&plant);
        let own = EstimationSession::like(session, &problem).ok()?;
        let theta = own.start_from(&self.problem.unknowns, &self.fit.theta);
        let fitted = fit(&own, &plant, &theta, &self.noise, REFIT_ROUNDS).ok()?;
        drop(own);
        let start = Self { plant, problem, fit: fitted, objective: f64::INFINITY, optima: Vec::new(), ..self.clone() };
        Some(settled(session, start))
    }

    /// The effects add modes or tanks that `plant` lacks, whose initial state is free.
    pub fn adds_masses(&self, plant: &Plant) -> bool {
        let masses = |plant: &Plant| {
            let system = System::new(&equip(plant)).ok()?;
            let names = system.states().iter().map(|state| state.name.clone());
            Some(names.filter(|name| is_mass(name)).collect::<Vec<_>>())
        };
        masses(plant).zip(masses(&self.plant)).is_some_and(|(known, own)| own.iter().any(|name| !known.contains(name)))
    }

    /// Every amplitude of the effect is within two standard errors of zero.
    pub fn amplitude_insignificant(&self, column: &Column) -> bool {
        self.evidence(column) <= 2.0
    }

    /// Largest amplitude of the effect in its standard errors; infinite for an effect without
    /// amplitude.
    pub fn evidence(&self, column: &Column) -> f64 {
        let effect = column.candidate.effect;
        let prefix = format!("effect.{}@{}.", effect.kind, column.candidate.site);
        let amplitudes = effect.parameters.iter().take(effect.amplitudes());
        let place = |p: &EffectParameter| {
            self.problem.unknowns.iter().position(|unknown| unknown.parameter == format!("{prefix}{}", p.name))
        };
        let size = |at: usize| self.fit.theta[at].abs() / self.fit.sigma[at].max(f64::MIN_POSITIVE);
        amplitudes.filter_map(place).map(size).reduce(f64::max).unwrap_or(f64::INFINITY)
    }
}

/// Duration from which an effect has no end in any recording \[s\].
pub(super) const ENDLESS_S: f64 = 1e8;
/// Largest share of a body's mass that a mode carries [1]. It keeps the rest of the body from a
/// zero mass; chosen, no derivation.
const MODE_MASS_SHARE_MAX: f64 = 0.9;
/// Relinearisations of a refit.
pub(super) const REFIT_ROUNDS: usize = 3;
/// Alternations between parameters and noise in the final fit, relinearisations of each, and the
/// gain in `−2 ln p` that ends them: small against the 0.5 and more of every decision on such
/// gains.
const SETTLING_TURNS: usize = 6;
const SETTLING_ROUNDS: usize = 6;
const SETTLING_GAIN: f64 = 0.1;

/// Fits `nominal` plus all `parts` (column, amplitudes along its directions) with `noise`. A start
/// whose objective is below `good` ends the search over starts; `None` where no start can be
/// fitted.
///
/// Cost: at most one fit a start, each of a few relinearisations.
pub fn refit_all(
    session: &EstimationSession<'_>,
    nominal: &Fit,
    parts: &[(&Column, &[f64])],
    noise: &NoiseModel,
    good: f64,
) -> Option<FittedModel> {
    let mut best: Option<FittedModel> = None;
    for share in [1.0, 0.3] {
        let mut plant = nominal.plant.clone();
        let mut free = 0;
        let mut possible = true;
        for (column, amplitude) in parts {
            match augmented(&plant, column, amplitude, share) {
                Some((with, more)) => (plant, free) = (with, free + more),
                None => possible = false,
            }
        }
        if !possible {
            continue;
        }
        let problem = session.problem.with_plant(&plant);
        let Ok(own) = EstimationSession::like(session, &problem) else { continue };
        let theta = own.start_from(&session.problem.unknowns, &nominal.theta);
        let Ok(fitted) = fit(&own, &plant, &theta, noise, REFIT_ROUNDS) else { continue };
        let search = Search { sweeps: 2, colour: true, scan: false };
        let Some((adapted, objective)) = maximise(&own, &fitted.linearised, &fitted.theta, &[], noise, search) else {
            continue;
        };
        let better = best.as_ref().is_none_or(|best| objective < best.objective);
        if better {
            drop(own);
            best =
                Some(FittedModel { plant, problem, fit: fitted, noise: adapted, objective, free, optima: Vec::new() });
        }
        if objective < good {
            break;
        }
    }
    let shaped = best.as_ref().and_then(|best| shaped(session, best, parts));
    shaped.or(best)
}

/// `refit` with the shape parameters of its laws free, where BIC prefers that.
fn shaped(session: &EstimationSession<'_>, refit: &FittedModel, parts: &[(&Column, &[f64])]) -> Option<FittedModel> {
    let mut plant = refit.plant.clone();
    let mut more = 0;
    for candidate in parts.iter().map(|(column, _)| &column.candidate) {
        let own = plant.effects.iter_mut().find(|e| e.kind == candidate.effect.kind && e.site == candidate.site)?;
        for (name, quantity) in &mut own.values {
            let shape = candidate.effect.parameter(name).and_then(|p| p.prior.sigma_if_preferred(quantity.value));
            let Some(sigma) = shape else { continue };
            *quantity = Quantity::with_prior(quantity.value, sigma);
            more += 1;
        }
    }
    (more > 0).then_some(())?;
    let problem = session.problem.with_plant(&plant);
    let own = EstimationSession::like(session, &problem).ok()?;
    let theta = own.start_from(&refit.problem.unknowns, &refit.fit.theta);
    let fitted = fit(&own, &plant, &theta, &refit.noise, SETTLING_ROUNDS).ok()?;
    let search = Search { sweeps: 2, colour: true, scan: false };
    let (noise, objective) = maximise(&own, &fitted.linearised, &fitted.theta, &[], &refit.noise, search)?;
    drop(own);
    let price = more as f64 * libm::log(session.samples.max(2) as f64);
    let free = refit.free + more;
    (objective + price + BIC_PREFERENCE < refit.objective).then(|| FittedModel {
        plant,
        problem,
        fit: fitted,
        noise,
        objective,
        free,
        optima: Vec::new(),
    })
}

/// `refit` at its local optimum: parameters and noise in turn until neither gains; unchanged where
/// it cannot be improved.
pub fn settled(session: &EstimationSession<'_>, refit: FittedModel) -> FittedModel {
    let search = Search { sweeps: 3, colour: true, scan: false };
    let mut best = refit;
    for _ in 0..SETTLING_TURNS {
        let Ok(own) = EstimationSession::like(session, &best.problem) else { break };
        let Ok(fitted) = fit(&own, &best.plant, &best.fit.theta, &best.noise, SETTLING_ROUNDS) else { break };
        let found = maximise(&own, &fitted.linearised, &fitted.theta, &[], &best.noise, search);
        let Some((noise, objective)) = found.filter(|found| found.1 < best.objective) else { break };
        let gained = best.objective - objective;
        best = FittedModel { fit: fitted, noise, objective, ..best };
        if gained < SETTLING_GAIN {
            break;
        }
    }
    best
}

/// The plant with the effect at `share` of its estimated amplitude; its parameters have wide
/// priors.
pub(crate) fn augmented(nominal: &Plant, column: &Column, amplitude: &[f64], share: f64) -> Option<(Plant, usize)> {
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
    let mut free = 0;
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
        free += usize::from(sigma.is_some() || is_searched(parameter, value));
        let quantity = sigma.map_or(Quantity::known(value), |sigma| Quantity::with_prior(value, sigma));
        values.push((name.to_owned(), quantity));
    }
    let mut plant = nominal.clone();
    let effect = EffectUse { kind: candidate.effect.kind.to_owned(), site: candidate.site.clone(), values };
    plant.effects.push(effect);
    dynamics::system::System::new(&plant).ok()?;
    Some((plant, free))
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

/// Number of parameters that a fit of `candidate` along `directions` leaves free.
pub fn free_parameters(candidate: &Candidate, directions: usize) -> usize {
    let is_free = |p: &EffectParameter, value: f64| p.prior.sigma(value).is_some() || is_searched(p, value);
    let free = |(name, value): &&(&str, f64)| candidate.effect.parameter(name).is_some_and(|p| is_free(p, *value));
    let inner = candidate.inner.iter().filter(free);
    directions + inner.count()
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

/// A time that the score's refinement has searched: the fit keeps its value, and it counts as a
/// free parameter.
fn is_searched(parameter: &EffectParameter, value: f64) -> bool {
    parameter.role == Role::Onset || parameter.role == Role::Duration && value < ENDLESS_S
}
