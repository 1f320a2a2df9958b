//! Candidates against each other and against the noise: joint likelihoods, both sides with their own noise.
//!
//! What a score screens in goes to a likelihood ratio in which sizes and poles of the noise are maximised with the candidate and
//! without it: noise fitted to the nominal plant alone has swallowed part of the effect, noise taken on trust invents effects. The
//! linear ratio ranks; the best are fitted as physics, from the score's amplitude on, with the numbers inside their laws free.
//!
//! Criterion: `BIC = −2 ln p + k ln n`; weights `exp(−ΔBIC/2)`. A likelihood counts when its ratio passes χ² at `alpha / m`, m all columns
//! that were tried, and the robust score does not veto it.

mod pairs;
mod refit;

pub use pairs::{Pair, pair};
pub use refit::{Refit, refit, refit_all};

use crate::filter::NoiseModel;
use crate::fit::noise::{Search, maximise};
use crate::fit::{Engine, Fit};
use crate::score::{Column, Score, cosine};
use crate::statistics::{chi_squared_tail, normal_two_sided};

/// Bounds on the work.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Contenders whose linear ratio is taken, and those that are fitted.
    pub linear_max: usize,
    pub refit_max: usize,
}

/// One candidate that came this far.
#[derive(Clone, Debug)]
pub struct Contender {
    pub column: usize,
    pub score: Score,
    /// Ratio on the linear model, noise maximised on both sides, and its p times the number of columns tried.
    pub ratio: f64,
    pub p: f64,
    /// Amplitudes of its directions at that maximum.
    pub amplitude: Vec<f64>,
    pub noise: NoiseModel,
    /// The robust score neither vetoes it nor lies beyond its own reach.
    pub veto: Veto,
    pub refit: Option<Refit>,
    /// `−2 ln p + k ln n`, relative to the nominal plant's.
    pub bic: f64,
    /// Cosine with the best.
    pub cosine: f64,
}

/// What the robust score says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Veto {
    Passed,
    Vetoed,
    /// Its ceiling is below its threshold: it cannot speak.
    Silent,
}

/// Family-wise level of the veto among the contenders that are looked at.
const VETO_LEVEL: f64 = 0.01;
/// Energy of an effect in less than this many independent instants counts as brief.
const CEILING_SPARE: f64 = 1.15;

/// Contenders for what is left out, best first. `null` is the nominal plant's least objective with its noise.
pub fn contenders(
    engine: &Engine<'_>,
    fit: &Fit,
    columns: &[Column],
    screened: &[(Score, Score)],
    (null_noise, null): (&NoiseModel, f64),
    alpha: f64,
    limits: Limits,
) -> Vec<Contender> {
    let tried = columns.len().max(1) as f64;
    let chosen = choose(columns, screened, alpha / tried, limits.linear_max);
    let z_veto = normal_two_sided(VETO_LEVEL / chosen.len().max(1) as f64);
    let mut list: Vec<Contender> = Vec::new();
    for (assumed, adapted) in chosen {
        let column = &columns[adapted.column];
        let extra: Vec<&Vec<f64>> = column.raw.iter().collect();
        let search = Search { sweeps: 2, colour: true, scan: false };
        let from_null = maximise(engine, &fit.board, &fit.theta, &extra, null_noise, search);
        let from_stated = (adapted.statistic < 0.7 * assumed.statistic)
            .then(|| maximise(engine, &fit.board, &fit.theta, &extra, &engine.noise, search))
            .flatten();
        let best = [from_null, from_stated].into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((noise, objective)) = best else { continue };
        let amplitude = fit.board.normal(engine, &fit.theta, &noise, &extra).and_then(|n| n.minimum());
        let Some((_, amplitude)) = amplitude else { continue };
        let wrong_sign = column.candidate.one_sided && amplitude[0] < 0.0;
        let ratio = if wrong_sign { 0.0 } else { (null - objective).max(0.0) };
        let freedom = column.raw.len() as f64;
        let veto = match adapted.robust {
            robust if robust.ceiling < CEILING_SPARE * z_veto => Veto::Silent,
            robust if robust.z.abs() >= z_veto => Veto::Passed,
            _ => Veto::Vetoed,
        };
        list.push(Contender {
            column: adapted.column,
            ratio,
            p: (chi_squared_tail(ratio, freedom) * tried).min(1.0),
            amplitude: amplitude.iter().copied().collect(),
            noise,
            veto,
            refit: None,
            bic: freedom * libm::log(engine.samples as f64) - ratio,
            cosine: 0.0,
            score: adapted,
        });
    }
    list.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let first = list.first().map(|first| first.score.clone());
    for contender in &mut list {
        contender.cosine = first.as_ref().map_or(0.0, |first| cosine(first, &contender.score));
    }
    list
}

/// The best of each effect and site that either score finds, most significant first.
fn choose(columns: &[Column], screened: &[(Score, Score)], level: f64, most: usize) -> Vec<(Score, Score)> {
    let passing = screened.iter().filter(|(assumed, adapted)| assumed.p.min(adapted.p) < 10.0 * level);
    let mut list: Vec<&(Score, Score)> = passing.collect();
    // by what survives adapted noise, then by what the stated noise says
    let excess = |pair: &(Score, Score)| {
        (pair.1.statistic - 2.0 * pair.1.freedom as f64) + 1e-3 * (pair.0.statistic - 2.0 * pair.0.freedom as f64)
    };
    list.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let mut chosen: Vec<&(Score, Score)> = Vec::new();
    for pair in list {
        let law = &columns[pair.0.column].candidate;
        // two points of one grid may both be worth a start
        let known = chosen.iter().filter(|c| columns[c.0.column].candidate.same_law(law)).count();
        if known < 1 && chosen.len() < most {
            chosen.push(pair);
        }
    }
    chosen.into_iter().cloned().collect()
}

/// `exp(−ΔBIC/2)` normalised over contenders within `span` of the best; zero beyond.
pub fn weights(bic: &[f64], span: f64) -> Vec<f64> {
    let best = bic.iter().copied().fold(f64::INFINITY, f64::min);
    let raw: Vec<f64> = bic.iter().map(|b| if b - best <= span { libm::exp(-0.5 * (b - best)) } else { 0.0 }).collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|w| if sum > 0.0 { w / sum } else { 0.0 }).collect()
}
