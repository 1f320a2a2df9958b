//! Ways in which the nominal plant may be wrong, and what their numbers may be.
//!
//! | hypothesis | numbers and priors |
//! |---|---|
//! | effect at a site | amplitude: normal about zero, of one sign where it has one; shape parameters |
//! | the same law at all like sites | one amplitude a site, one prior probability for all |
//! | coloured noise of a channel | its pole |
//! | a disturbance that the file does not state | its level: half-normal (`noise`) |
//! | a number in conflict with its file | the same number, ten times its standard deviation |
//! | a number that its file states as exact | the number (`exact`) |
//! | inputs shifted by a share of a sample | the shift |
//!
//! An amplitude's standard deviation is that whose push has the rms of all that drives the record
//! (`scale`).
//!
//! Shape parameters that a fit moves: frequencies and orders are log-uniform over what the record
//! resolves, widths log-normal about the middle of their screening, angles uniform. The fit itself
//! takes the catalogue's normal prior; where the data tell the number, the ratio of both densities
//! at the estimate is exact, and both are normalised where they do not. Points of a grid share the
//! prior: an onset has one point a sample.

use super::decide::{Class, WIDTH_SPREAD};
use super::exact::Exact;
use super::marginal::log_mass;
use super::timing;
use crate::score::candidates::motion;
use crate::score::{Candidate, Column};
use dynamics::description::{Plant, SiteKind};
use dynamics::effect::{EffectParameter, Role};
use identification::filter::Linear;
use identification::problem::{Problem, Unknown};

/// An effect at a site, as it is put into a plant.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Without the innovations' changes.
    pub column: Column,
    /// Along each direction, to start from.
    pub amplitude: Vec<f64>,
    /// Standard deviation of the amplitude's prior in a fit, and how many times as wide the prior
    /// is.
    pub scale: f64,
    pub clipped: f64,
    /// Logarithm of the number of points that shape parameters were picked from, and of
    /// the amplitude's prior width over `scale`.
    pub log_points: f64,
    /// `(low, high)` over which a searched number is log-uniform, or the middle of a width.
    pub inner: Vec<(&'static str, InnerPrior)>,
    /// Share of its energy that the plant's parameters absorb.
    pub kappa: f64,
}

/// Prior of an shape parameter that a fit moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum InnerPrior {
    LogUniform([f64; 2]),
    LogNormal(f64),
    /// Over so much.
    Uniform(f64),
}

impl InnerPrior {
    /// `ln` of the density at `value`.
    pub(super) fn log_density(self, value: f64) -> f64 {
        match self {
            Self::LogUniform([low, high]) => -libm::log(value) - libm::log(libm::log(high / low).max(1.0)),
            Self::LogNormal(middle) => {
                let z = libm::log(value / middle) / WIDTH_SPREAD;
                -0.5 * z * z - libm::log(value * WIDTH_SPREAD) - 0.5 * libm::log(core::f64::consts::TAU)
            }
            Self::Uniform(width) => -libm::log(width),
        }
    }
}

/// A way in which the nominal plant may be wrong.
#[derive(Clone, Debug)]
pub(super) enum Hypothesis {
    /// One part, or the same law at several sites.
    Effect(Vec<Part>),
    Coloured(usize),
    /// A noise input of unstated size, by its place and name.
    Disturbance(usize, String),
    /// By the name of its unknown.
    Conflict(String),
    /// A number that the file states as exact, free.
    Exact(Exact),
    /// All recorded inputs later by a share of a sample.
    Timing(f64),
}

/// Key of inputs at another time: one hypothesis whatever the shift, as of any number.
pub(super) const SHIFTED_INPUTS: &str = "shifted inputs";

impl Hypothesis {
    pub(super) fn parts(&self) -> &[Part] {
        if let Self::Effect(parts) = self { parts } else { &[] }
    }

    pub(super) fn parts_mut(&mut self) -> &mut [Part] {
        if let Self::Effect(parts) = self { parts } else { &mut [] }
    }

    /// Unique among all hypotheses of a plant.
    pub(super) fn key(&self, plant: &Plant) -> String {
        match self {
            Self::Effect(parts) => {
                let mut names: Vec<String> = parts.iter().map(|part| name_of(&part.column.candidate)).collect();
                names.sort();
                names.join(" + ")
            }
            Self::Coloured(channel) => format!("coloured noise of {}", plant.sensors[*channel].name),
            Self::Disturbance(_, name) => format!("disturbance of {name}"),
            Self::Conflict(name) | Self::Exact(Exact { name, .. }) => format!("conflict of {name}"),
            Self::Timing(_) => SHIFTED_INPUTS.to_owned(),
        }
    }

    pub(super) fn class(&self) -> Class {
        match self {
            Self::Effect(parts) if parts.iter().all(|p| p.column.candidate.site.kind == SiteKind::Sensor) => {
                Class::Sensor
            }
            Self::Effect(_) => Class::Physics,
            Self::Coloured(_) | Self::Disturbance(..) => Class::Noise,
            Self::Conflict(_) | Self::Exact(_) => Class::Conflict,
            Self::Timing(_) => Class::Timing,
        }
    }

    /// Logarithm of the number of grid points that it was picked from.
    pub(super) fn log_points(&self) -> f64 {
        let own = if let Self::Timing(shift) = self { timing::log_points(*shift) } else { 0.0 };
        own + self.parts().iter().map(|part| part.log_points).sum::<f64>()
    }
}

/// `kind@site`.
pub(super) fn name_of(candidate: &Candidate) -> String {
    format!("{}@{}", candidate.effect.kind, candidate.site)
}

/// The unknown of a parameter of an effect.
pub(super) fn unknown_of(candidate: &Candidate, parameter: &str) -> String {
    format!("effect.{}@{}.{parameter}", candidate.effect.kind, candidate.site)
}

/// What the numbers of a law may be on a record: `points` are all candidates of the law.
pub(super) fn part(
    (problem, plant, linears): (&Problem, &Plant, &[Linear]),
    period_s: f64,
    column: &Column,
    points: &[&Candidate],
    (amplitude, scale): (Vec<f64>, f64),
) -> Part {
    let candidate = &column.candidate;
    let [begin_s, end_s] = problem.span_s();
    let duration_s = (end_s - begin_s).max(period_s);
    let moves = motion(plant, linears, &candidate.site);
    let (mut log_points, mut inner) = (0.0, Vec::new());
    for (name, value) in &candidate.inner {
        let Some(parameter) = candidate.effect.parameter(name) else { continue };
        let picked = || {
            let all = points.iter().flat_map(|point| point.inner.iter().filter(|(own, _)| own == name));
            let mut values: Vec<f64> = all.map(|(_, value)| *value).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let is_free = parameter.prior.sigma(*value).is_some();
        match (parameter.role, is_free) {
            (Role::Smoothing, _) => {}
            (Role::Onset, _) => log_points += libm::log(duration_s / period_s),
            (Role::Duration, _) if *value < duration_s => log_points += libm::log(duration_s / period_s),
            (Role::Duration, _) => {}
            (role, true) => match prior_of(role, parameter, (duration_s, period_s), moves, &picked()) {
                Some(prior) => inner.push((*name, prior)),
                None => log_points += libm::log(picked().len().max(1) as f64),
            },
            (_, false) => log_points += libm::log(picked().len().max(1) as f64),
        }
    }
    if candidate.directions.len() > 1 {
        let angle = candidate.effect.parameters.iter().find(|p| matches!(p.role, Role::Direction { .. }));
        inner.extend(angle.map(|p| (p.name, InnerPrior::Uniform(core::f64::consts::TAU))));
    }
    // a fit's steps are shares of its prior: no wider than the plausible range, the rest a factor
    let width = scale.min(candidate.high.abs());
    let clipped = scale / width;
    log_points += candidate.directions.len().max(1) as f64 * libm::log(clipped);
    let column = Column { raw: Vec::new(), ..column.clone() };
    Part { column, amplitude, scale: width, clipped, log_points, inner, kappa: 0.0 }
}

impl Part {
    /// The same with a share of the width of its amplitude's prior.
    pub(super) fn narrowed(mut self, share: f64) -> Self {
        let directions = self.column.candidate.directions.len().max(1) as f64;
        let clipped = (self.clipped * share).max(1.0);
        self.log_points += directions * libm::log(clipped / self.clipped);
        self.scale *= self.clipped * share / clipped;
        self.clipped = clipped;
        self
    }
}

/// Prior of a number that is searched; `None`: that of its catalogue entry.
fn prior_of(
    role: Role,
    parameter: &EffectParameter,
    (duration_s, period_s): (f64, f64),
    moves: Option<crate::score::candidates::Motion>,
    picked: &[f64],
) -> Option<InnerPrior> {
    let cut = |low: f64, high: f64| {
        let low = low.clamp(parameter.low.max(f64::MIN_POSITIVE), parameter.high);
        InnerPrior::LogUniform([low, high.clamp(low, parameter.high)])
    };
    match role {
        // up to Nyquist's: what is above is seen at its alias
        Role::Frequency => Some(cut(3.0 / duration_s, 0.5 / period_s)),
        Role::Order => {
            let turn = core::f64::consts::TAU;
            let (range, rate) = moves.map_or((turn, turn), |m| (m.high - m.low, m.rate_rms));
            Some(cut(turn / range.max(1e-12), 0.3 * turn / period_s / rate.max(1e-12)))
        }
        Role::Width => {
            let logs = picked.iter().filter(|value| **value > 0.0).map(|value| libm::log(*value));
            let count = logs.clone().count().max(1) as f64;
            Some(InnerPrior::LogNormal(libm::exp(logs.sum::<f64>() / count)))
        }
        _ => None,
    }
}

/// `ln` of the true prior's density over that of the fit's normal one, cut at its range, at
/// `theta`, of all searched numbers of a set.
pub(super) fn log_swap(set: &[Hypothesis], unknowns: &[Unknown], theta: &[f64]) -> f64 {
    let mut sum = 0.0;
    for part in set.iter().flat_map(Hypothesis::parts) {
        for (name, prior) in &part.inner {
            let own = unknown_of(&part.column.candidate, name);
            let Some(at) = unknowns.iter().position(|unknown| unknown.parameter == own) else { continue };
            let normal = log_cut_normal(&unknowns[at], theta[at]);
            if theta[at] > 0.0 || matches!(prior, InnerPrior::Uniform(_)) {
                sum += prior.log_density(theta[at]) - normal;
            }
        }
    }
    sum
}

/// `ln` of a normal prior's density at `value`, cut at the range of the unknown.
fn log_cut_normal(unknown: &Unknown, value: f64) -> f64 {
    let [low, z, high] = [unknown.low, value, unknown.high].map(|at| (at - unknown.prior) / unknown.sigma);
    -0.5 * z * z - libm::log(unknown.sigma) - 0.5 * libm::log(core::f64::consts::TAU) - log_mass(low, high)
}

/// `plant` with the numbers that `set` frees.
pub(super) fn freed(plant: &mut Plant, set: &[Hypothesis]) {
    for own in set {
        let Hypothesis::Exact(exact) = own else { continue };
        plant.visit_quantities(&mut |name, _, quantity| {
            if name == exact.name {
                quantity.sigma = Some(exact.sigma);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_prior_of_an_inner_number_has_one_unit_of_mass() {
        let mass = |prior: InnerPrior, low: f64, high: f64| {
            let steps = 40_000;
            let h = libm::log(high / low) / f64::from(steps);
            let at = |i: i32| low * libm::exp((f64::from(i) + 0.5) * h);
            (0..steps).map(|i| libm::exp(prior.log_density(at(i))) * at(i) * h).sum::<f64>()
        };
        assert!((mass(InnerPrior::LogUniform([0.1, 10.0]), 0.1, 10.0) - 1.0).abs() < 1e-9);
        assert!((mass(InnerPrior::LogNormal(0.2), 1e-6, 1e6) - 1.0).abs() < 1e-6);
        assert!((mass(InnerPrior::Uniform(3.0), 1e-9, 3.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_normal_prior_whose_middle_lies_outside_its_range_has_one_unit_of_mass_inside() {
        for (prior, sigma) in [(1.0, 0.3), (3.0, 0.5), (20.0, 3.0)] {
            let name = || "order".to_owned();
            let unknown = Unknown {
                name: name(),
                parameter: name(),
                unit: String::new(),
                prior,
                sigma,
                low: 2.0,
                high: 6.0,
                recording: None,
                segment: None,
            };
            let h = 1e-4;
            let mass: f64 =
                (0..40_000).map(|i| h * libm::exp(log_cut_normal(&unknown, 2.0 + h * (f64::from(i) + 0.5)))).sum();
            assert!((mass - 1.0).abs() < 1e-4, "{prior} {mass}");
        }
    }
}
