//! Two effects at once: terms that only together beat what is there.
//!
//! The nominal plant often holds the best single term already (viscous friction); its rival is a pair (Coulomb and quadratic), none of
//! which alone gains anything. Pairs are ranked by their joint score under adapted and stated noise; the best go to the two-sided
//! likelihood and are fitted as physics.

use super::{Limits, Refit, refit_all};
use crate::filter::NoiseModel;
use crate::fit::board::dot;
use crate::fit::noise::{Search, maximise};
use crate::fit::{Engine, Fit};
use crate::score::{Column, Score};
use crate::statistics::chi_squared_tail;
use nalgebra::{Cholesky, DMatrix, DVector};

/// A pair that was fitted.
#[derive(Clone, Debug)]
pub struct Pair {
    pub columns: [usize; 2],
    pub scores: [Score; 2],
    pub refit: Refit,
    pub ratio: f64,
    /// Times the number of pairs of columns.
    pub p: f64,
    pub bic: f64,
}

/// Laws that are paired, and pairs whose likelihood is taken.
const LAWS_MAX: usize = 14;
const PAIRS_MAX: usize = 4;

/// The best pair by BIC, if its two-sided likelihood passes `alpha`.
pub fn pair(
    engine: &Engine<'_>,
    fit: &Fit,
    columns: &[Column],
    screened: &[(Score, Score)],
    (null_noise, null): (&NoiseModel, f64),
    alpha: f64,
    limits: Limits,
) -> Option<Pair> {
    let tried = (columns.len() * columns.len().saturating_sub(1) / 2).max(1) as f64;
    let mut best: Option<Pair> = None;
    let ranked = ranked(engine, fit, columns, screened, null_noise);
    for [a, b] in ranked.into_iter().take(PAIRS_MAX.min(limits.refit_max)) {
        let (first, second) = (&screened[a].1, &screened[b].1);
        let (left, right) = (&columns[first.column], &columns[second.column]);
        let extra: Vec<&Vec<f64>> = left.raw.iter().chain(&right.raw).collect();
        let search = Search { sweeps: 2, colour: true, scan: false };
        let starts = [null_noise, &engine.noise];
        let found = starts.iter().filter_map(|start| maximise(engine, &fit.board, &fit.theta, &extra, start, search));
        let Some((noise, objective)) = found.min_by(|x, y| x.1.total_cmp(&y.1)) else { continue };
        let ratio = null - objective;
        if chi_squared_tail(ratio.max(0.0), extra.len() as f64) * tried > 10.0 * alpha {
            continue;
        }
        let Some((_, amplitude)) = fit.board.normal(engine, &fit.theta, &noise, &extra).and_then(|n| n.minimum())
        else {
            continue;
        };
        let amplitude: Vec<f64> = amplitude.iter().copied().collect();
        let (one, two) = amplitude.split_at(left.raw.len());
        let parts = [(left, one), (right, two)];
        if vetoed(engine, fit, [first, second], null_noise) {
            continue;
        }
        let Some(refit) = refit_all(engine, fit, &parts, &noise, null - 0.5 * ratio) else { continue };
        let ratio = null - refit.objective;
        let p = (chi_squared_tail(ratio.max(0.0), refit.free as f64) * tried).min(1.0);
        let bic = refit.free as f64 * libm::log(engine.samples as f64) - ratio;
        if p < alpha && bic < 0.0 && best.as_ref().is_none_or(|best| bic < best.bic) {
            let scores = [first.clone(), second.clone()];
            best = Some(Pair { columns: [first.column, second.column], scores, refit, ratio, p, bic });
        }
    }
    best
}

/// Pairs of laws, largest joint likelihood ratio on the linear model first; places in `screened`.
fn ranked(
    engine: &Engine<'_>,
    fit: &Fit,
    columns: &[Column],
    screened: &[(Score, Score)],
    noise: &NoiseModel,
) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..screened.len()).collect();
    let size = |i: usize| screened[i].1.statistic.max(0.02 * screened[i].0.statistic);
    order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
    let mut laws: Vec<usize> = Vec::new();
    for i in order {
        let candidate = &columns[screened[i].1.column].candidate;
        if laws.len() < LAWS_MAX && !laws.iter().any(|l| columns[screened[*l].1.column].candidate.same_law(candidate)) {
            laws.push(i);
        }
    }
    let mut residual = [fit.board.nu.clone()];
    if fit.board.whiten(engine, noise, &mut residual).is_none() {
        return Vec::new();
    }
    let mut list: Vec<(f64, [usize; 2])> = Vec::new();
    for (k, a) in laws.iter().enumerate() {
        for b in &laws[k + 1..] {
            let both = [&screened[*a].1, &screened[*b].1];
            let joint = joint(both, &residual[0]);
            let gain = joint - screened[*a].1.statistic.max(screened[*b].1.statistic);
            list.push((gain.min(joint), [*a, *b]));
        }
    }
    list.sort_by(|x, y| y.0.total_cmp(&x.0));
    list.into_iter().map(|(_, pair)| pair).collect()
}

/// Level of the veto, as for single effects among a few contenders.
const VETO_Z: f64 = 3.2;

/// The robust score of the pair's joint direction could pass and does not.
fn vetoed(engine: &Engine<'_>, fit: &Fit, scores: [&Score; 2], noise: &NoiseModel) -> bool {
    let mut residual = [fit.board.nu.clone()];
    if fit.board.whiten(engine, noise, &mut residual).is_none() {
        return true;
    }
    let all: Vec<&Vec<f64>> = scores.iter().flat_map(|score| &score.projected).collect();
    let n = all.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| dot(all[i], all[j]) * if i == j { 1.0 + 1e-9 } else { 1.0 });
    let right = DVector::from_fn(n, |i, _| dot(all[i], &residual[0]));
    let Some(factor) = Cholesky::new(matrix) else { return true };
    let size = factor.solve(&right);
    let along: Vec<f64> =
        (0..residual[0].len()).map(|s| all.iter().zip(size.iter()).map(|(c, a)| a * c[s]).sum()).collect();
    let found = crate::score::robust::robust(&along, &residual[0], &crate::score::event_of_sample(engine));
    found.ceiling >= 1.15 * VETO_Z && found.z.abs() < VETO_Z
}

/// Joint statistic of two scores.
fn joint(scores: [&Score; 2], residual: &[f64]) -> f64 {
    let all: Vec<&Vec<f64>> = scores.iter().flat_map(|score| &score.projected).collect();
    let n = all.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| dot(all[i], all[j]) * if i == j { 1.0 + 1e-9 } else { 1.0 });
    let right = DVector::from_fn(n, |i, _| dot(all[i], residual));
    Cholesky::new(matrix).map_or(0.0, |factor| factor.solve(&right).dot(&right))
}
