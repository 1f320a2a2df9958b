//! Multistart over the multimodal parameters of an effect.
//!
//! Some shape parameters have a likelihood with many maxima: the order of a ripple has one for each
//! period more over the range travelled, a frequency one for each period more over the recording, a
//! width inside friction one on each side of the rates visited. A fit climbs the maximum it starts
//! in; the accepted model is therefore fitted once more from both neighbours of every such
//! parameter. A local optimum that is nearly as good enlarges the standard deviations:
//! `σ² = Σ w (σ_k² + (θ_k − θ)²)`, `w ∝ exp(−½ Δ)` of `−2 ln p` (all optima taken as equally wide).
//!
//! The rate over which a sign is smoothed is not physics where it is only numerical: a smaller one
//! is taken where it fits better.

use super::refit::{FittedModel, LocalOptimum, REFIT_ROUNDS, settled};
use crate::score::Column;
use crate::score::candidates::motion;
use dynamics::description::Plant;
use dynamics::effect::{EffectParameter, Role};
use identification::fit::{EstimationSession, fit};

/// Gain in `−2 ln p` from which a neighbour is a better optimum. Below it, the same optimum was
/// reached from another side (convergence tolerance).
const OPTIMUM_GAIN_MIN: f64 = 0.5;
/// Loss in `−2 ln p` up to which a local optimum is kept for the uncertainties: weight exp(−6) =
/// 0.25 % beyond. The second is the distance in standard errors from which two optima are distinct;
/// chosen, no derivation.
const OPTIMUM_LOSS_MAX: f64 = 12.0;
const OPTIMUM_SEPARATION_SIGMA: f64 = 3.0;
/// Factor to the neighbours of a width, a rate or a time; divisor of the smoothing rate of a sign,
/// and how often it is divided. They trade coverage against fits; chosen, no derivation.
const NEIGHBOUR_FACTOR: f64 = 3.0;
const SIGN_RATE_DIVISOR: f64 = 5.0;
const SIGN_RATE_DIVISIONS: usize = 2;

/// The best of `refit` and the fits of a multistart about it: one start below and one above for
/// every multimodal parameter of `members` while the work allows, and for every smoothing rate in
/// any case.
///
/// Cost: two fits for each such parameter and smoothing rate, and one more for each smaller rate.
pub fn multistart(session: &EstimationSession<'_>, refit: FittedModel, members: &[&Column]) -> FittedModel {
    let mut best = refit;
    let mut dearest = 0.0f64;
    for column in members {
        // with a sharper sign the best parameters may lie elsewhere
        let mut plant = Some(best.plant.clone());
        for sharpness in 0..=SIGN_RATE_DIVISIONS {
            let Some(own) = plant else { break };
            plant = sharper(&own, column);
            let straight = (sharpness > 0).then_some(None);
            let starts = parameters_of(&best, column).into_iter().flat_map(|(place, parameter)| {
                let moved = neighbours(session, &best, column, (parameter, best.fit.theta[place]));
                moved.into_iter().flatten().map(move |moved| Some((place, moved)))
            });
            for moved in straight.into_iter().chain(starts).collect::<Vec<_>>() {
                if moved.is_some() && !session.work.allows(dearest, "other local optima of a likelihood") {
                    continue;
                }
                let before = session.work.spent();
                let found = from(session, &best, own.clone(), moved);
                dearest = dearest.max(session.work.spent() - before);
                if let Some(found) = found {
                    take(&mut best, found);
                }
            }
        }
    }
    best
}

/// Index among the unknowns of each parameter of the effect of `column`.
fn parameters_of(refit: &FittedModel, column: &Column) -> Vec<(usize, &'static EffectParameter)> {
    let candidate = &column.candidate;
    let place = |p: &'static EffectParameter| {
        let name = format!("effect.{}@{}.{}", candidate.effect.kind, candidate.site, p.name);
        let at = refit.problem.unknowns.iter().position(|unknown| unknown.parameter == name);
        at.map(|at| (at, p))
    };
    candidate.effect.parameters.iter().filter_map(place).collect()
}

/// Keeps the better of both, and every other distinct optimum that is nearly as good.
fn take(best: &mut FittedModel, found: FittedModel) {
    let other =
        if found.objective < best.objective - OPTIMUM_GAIN_MIN { core::mem::replace(best, found) } else { found };
    let mut list = core::mem::take(&mut best.optima);
    list.extend(other.optima);
    list.push(LocalOptimum { objective: other.objective, theta: other.fit.theta, sigma: other.fit.sigma });
    list.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    for optimum in list {
        let is_same = |theta: &[f64]| {
            let numbers = theta.iter().zip(&optimum.theta).zip(&optimum.sigma);
            theta.len() == optimum.theta.len()
                && numbers.clone().all(|((a, b), s)| (a - b).abs() <= OPTIMUM_SEPARATION_SIGMA * s)
        };
        let is_near =
            optimum.objective < best.objective + OPTIMUM_LOSS_MAX && optimum.theta.len() == best.fit.theta.len();
        if is_near && !is_same(&best.fit.theta) && !best.optima.iter().any(|known| is_same(&known.theta)) {
            best.optima.push(optimum);
        }
    }
}

/// `plant` with the sign of the effect of `column` smoothed over a smaller rate.
fn sharper(plant: &Plant, column: &Column) -> Option<Plant> {
    let (candidate, mut plant) = (&column.candidate, plant.clone());
    let smoothing = candidate.effect.with_role(Role::Smoothing)?;
    let own = plant.effects.iter_mut().find(|e| e.kind == candidate.effect.kind && e.site == candidate.site)?;
    let (_, rate) = own.values.iter_mut().find(|(name, _)| name == smoothing.name)?;
    let sharp = rate.value / SIGN_RATE_DIVISOR;
    (sharp >= smoothing.low).then(|| rate.value = sharp)?;
    Some(plant)
}

/// Starting values at which the next optima of a parameter may lie; `None` where its likelihood is
/// unimodal.
fn neighbours(
    session: &EstimationSession<'_>,
    refit: &FittedModel,
    column: &Column,
    (parameter, value): (&EffectParameter, f64),
) -> Option<[f64; 2]> {
    match parameter.role {
        Role::Frequency => {
            let longest = session.problem.runs.iter().map(|run| run.end_s - run.begin_s).fold(0.0, f64::max);
            (longest > 0.0).then(|| [value - 1.0 / longest, value + 1.0 / longest])
        }
        Role::Order => {
            let visited = motion(&refit.plant, &refit.fit.linearised.linears, &column.candidate.site)?;
            let lobe = core::f64::consts::TAU / (visited.high - visited.low);
            lobe.is_finite().then_some([value - lobe, value + lobe])
        }
        _ if parameter.multimodal => Some([value / NEIGHBOUR_FACTOR, value * NEIGHBOUR_FACTOR]),
        _ => None,
    }
}

/// Fit of `plant` that starts at the parameters of `best`, one of them `moved` together with its
/// prior.
fn from(
    session: &EstimationSession<'_>,
    best: &FittedModel,
    mut plant: Plant,
    moved: Option<(usize, f64)>,
) -> Option<FittedModel> {
    let mut theta = best.fit.theta.clone();
    if let Some((place, value)) = moved {
        let unknown = &best.problem.unknowns[place];
        let value = value.clamp(unknown.low, unknown.high);
        (value != theta[place]).then_some(())?;
        theta[place] = value;
        plant.set_parameter(&unknown.parameter, value).ok()?;
    }
    let problem = session.problem.with_plant(&plant);
    let own = EstimationSession::like(session, &problem).ok()?;
    let present = best.fit.linearised.normal(&own, &best.fit.theta, &best.noise, &[])?.objective;
    let fitted = fit(&own, &plant, &theta, &best.noise, REFIT_ROUNDS).ok()?;
    (fitted.objective < present + OPTIMUM_LOSS_MAX).then_some(())?;
    drop(own);
    let start =
        FittedModel { plant, problem, fit: fitted, objective: f64::INFINITY, optima: Vec::new(), ..best.clone() };
    Some(settled(session, start))
}

#[cfg(test)]
mod tests {
    use super::super::refit::refit_all;
    use super::*;
    use crate::score::{Candidate, columns};
    use crate::synthetic::{plant, problem, recording, with_effect};
    use identification::fit::{Fit, LinearisedProblem};
    use identification::work::Work;

    /// The hidden law fitted from `inner` on: before its multistart and after it.
    fn fitted(
        (name, duration_s): (&str, f64),
        (kind, site): (&str, &str),
        hidden: &[(&str, f64)],
        inner: &dyn Fn(&LinearisedProblem) -> Vec<(&'static str, f64)>,
    ) -> [FittedModel; 2] {
        fitted_within(Work::default(), (name, duration_s), (kind, site), hidden, inner)
    }

    fn fitted_within(
        work: Work,
        (name, duration_s): (&str, f64),
        (kind, site): (&str, &str),
        hidden: &[(&str, f64)],
        inner: &dyn Fn(&LinearisedProblem) -> Vec<(&'static str, f64)>,
    ) -> [FittedModel; 2] {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&with_effect(&nominal, kind, site, hidden), 5, duration_s));
        let session = EstimationSession::counted(&problem, 1, std::sync::Arc::new(work)).unwrap();
        let fit: Fit = fit(&session, &nominal, &session.prior(), &session.noise, 6).unwrap();
        let effect = nominal.catalogue.effect(kind).unwrap();
        let along = |k: usize| (0..effect.amplitudes()).map(move |i| (effect.parameters[i].name, f64::from(i == k)));
        let directions = if effect.amplitudes() > 1 {
            (0..effect.amplitudes())
                .map(|k| along(k).map(|(n, s)| (n, f64::from(u8::from(s != 0.0)))).collect())
                .collect()
        } else {
            vec![Vec::new()]
        };
        let candidate = Candidate {
            effect,
            site: site.parse().unwrap(),
            inner: inner(&fit.linearised),
            directions,
            one_sided: effect.amplitudes() == 1,
            high: effect.parameters[0].high,
            at: None,
            felt: None,
            tries: 1,
        };
        let list = columns((&session, &fit.linearised), &nominal, &fit.theta, &[candidate]);
        let extra: Vec<&Vec<f64>> = list[0].raw.iter().collect();
        let normal = fit.linearised.normal(&session, &fit.theta, &session.noise, &extra).unwrap();
        let (_, amplitude) = normal.minimum().unwrap();
        let refit = refit_all(&session, &fit, &[(&list[0], &amplitude)], &session.noise, f64::NEG_INFINITY).unwrap();
        let start = settled(&session, refit);
        [start.clone(), multistart(&session, start, &[&list[0]])]
    }

    fn number(refit: &FittedModel, name: &str) -> [f64; 2] {
        let at = refit.problem.unknowns.iter().position(|unknown| unknown.parameter.ends_with(name)).unwrap();
        [refit.fit.theta[at], refit.sigma()[at]]
    }

    #[test]
    fn a_ripple_that_was_taken_for_one_of_a_period_more_or_less_finds_its_order() {
        let hidden = [("sine", 0.03), ("order", 14.0)];
        let site = "joint:pivot".parse().unwrap();
        let off_by_a_period = |linearised: &LinearisedProblem| {
            let visited = motion(&plant("pendulum"), &linearised.linears, &site).unwrap();
            vec![("order", 14.0 + core::f64::consts::TAU / (visited.high - visited.low))]
        };
        let [start, end] = fitted(("pendulum", 12.0), ("joint_gear_ripple", "joint:pivot"), &hidden, &off_by_a_period);
        assert!(number(&start, ".order")[0] > 16.0, "{:?}", number(&start, ".order"));
        let ([order, sigma], [sine, sigma_sine]) = (number(&end, ".order"), number(&end, ".sine"));
        assert!((order - 14.0).abs() < 3.0 * sigma && sigma < 0.3, "{order} {sigma}");
        assert!(
            (sine - 0.03).abs() < 3.0 * sigma_sine && end.objective < start.objective - 20.0,
            "{sine} {sigma_sine}"
        );
    }

    #[test]
    fn friction_that_turns_sharply_is_not_blamed_on_another_rate() {
        let hidden = [("force", 0.3), ("stribeck_rate", 0.15), ("smooth_rate", 1e-3)];
        let blunt = |_: &LinearisedProblem| vec![("stribeck_rate", 0.4), ("smooth_rate", 0.1)];
        let [start, end] = fitted(("drive_rig", 4.0), ("joint_stribeck", "joint:drive"), &hidden, &blunt);
        let off = |refit: &FittedModel| {
            let [rate, sigma] = number(refit, ".stribeck_rate");
            (rate - 0.15).abs() / sigma
        };
        assert!(off(&start) > 4.0 && off(&end) < 3.0, "{} {}", off(&start), off(&end));
        assert!(end.objective < start.objective - 20.0, "{} {}", start.objective, end.objective);
    }

    #[test]
    fn friction_turns_as_sharply_where_there_is_no_room_for_more() {
        let hidden = [("force", 0.3), ("smooth_rate", 1e-3)];
        let blunt = |_: &LinearisedProblem| vec![("smooth_rate", 0.1)];
        let law = ("joint_coulomb", "joint:drive");
        let [start, end] = fitted_within(Work::of(0.0), ("drive_rig", 4.0), law, &hidden, &blunt);
        let turn = |refit: &FittedModel| {
            refit.plant.effects[0].values.iter().find(|(name, _)| name == "smooth_rate").unwrap().1.value
        };
        let [force, sigma] = number(&end, ".force");
        assert!(
            turn(&start) == 0.1 && turn(&end) < 0.01 && (force - 0.3).abs() < 3.0 * sigma,
            "{} {force}",
            turn(&end)
        );
        assert!(end.objective < start.objective - 20.0, "{} {}", start.objective, end.objective);
    }

    #[test]
    fn an_equally_good_optimum_enlarges_the_standard_deviation_to_the_distance_between_both() {
        let hidden = [("sine", 0.03), ("order", 14.0)];
        let [start, _] =
            fitted(("pendulum", 6.0), ("joint_gear_ripple", "joint:pivot"), &hidden, &|_| vec![("order", 14.0)]);
        let mut two = FittedModel { optima: Vec::new(), ..start };
        let alone = two.sigma();
        assert!(alone.iter().zip(&two.fit.sigma).all(|(a, b)| (a / b - 1.0).abs() < 1e-12));
        let theta = two.fit.theta.iter().zip(&two.fit.sigma).map(|(t, s)| t + 6.0 * s).collect();
        two.optima.push(LocalOptimum { objective: two.objective, theta, sigma: two.fit.sigma.clone() });
        // (σ² + σ² + 36 σ²) / 2
        assert!(two.sigma().iter().zip(&alone).all(|(both, one)| (both / one - 19f64.sqrt()).abs() < 1e-9));
    }
}
