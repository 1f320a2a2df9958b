//! Sets of effects against each other and against the noise: joint likelihoods, both sides with their own noise.
//!
//! What [`subsets`] ranks first goes to a likelihood ratio in which sizes and poles of the noise are maximised with the effects and
//! without them: noise fitted to the nominal plant alone has swallowed part of the physics, noise taken on trust invents some. The best
//! are fitted as physics, from the amplitudes of the linear problem on, with the numbers inside their laws free.
//!
//! Criterion: `BIC = −2 ln p + k ln n`; weights `exp(−ΔBIC/2)`. A set counts when its ratio passes at `alpha` over all that was
//! tried ([`Trials`]), when it beats the best smaller set by as much, and when the robust score of its joint direction does not veto it.

mod hops;
mod refit;
pub mod subsets;
mod times;
mod trials;

pub use hops::hopped;
pub use refit::{Refit, free_numbers, refit_all, settled};
pub use subsets::{Ranking, Subset, rank};
pub use times::{found_times, timed};
pub use trials::Trials;

use crate::score::{Column, Score, scores};
use identification::dot::dot;
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, Normal, parallel};
use identification::statistics::{chi_squared_quantile, chi_squared_tail};
use nalgebra::{Cholesky, DMatrix, DVector};

/// One set of effects that came this far.
#[derive(Clone, Debug)]
pub struct Contender {
    pub subset: Subset,
    /// Least `−2 ln p`: as physics, else on the linear model.
    pub objective: f64,
    /// Ratio of likelihoods, noise maximised on both sides, and its p times the price of the search.
    pub ratio: f64,
    pub p: f64,
    pub noise: NoiseModel,
    pub veto: Veto,
    pub refit: Option<Refit>,
    /// The refit was taken to the end of its valley, and the nominal plant was fitted from there.
    pub is_settled: bool,
    pub is_met: bool,
    /// `−2 ln p + k ln n`, relative to the nominal plant's.
    pub bic: f64,
    pub free: usize,
}

/// What the robust score says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Veto {
    Passed,
    Vetoed,
    /// Its ceiling is below its threshold: it cannot speak.
    Silent,
}

/// Who competed, best first, and the least objective of the nominal plant that was met on the way.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub contenders: Vec<Contender>,
    pub null: f64,
    /// Logarithm of the number of samples.
    samples: f64,
    /// Work of the dearest sets so far, each.
    work_each: f64,
}

/// The nominal plant as the sets meet it.
pub struct Nominal<'a> {
    pub fit: &'a Fit,
    pub noise: &'a NoiseModel,
    pub objective: f64,
}

/// BIC from which a law takes the place of another, or another shape than usual: twenty to one.
pub const PREFERRED: f64 = 6.0;
/// Largest set.
pub const SET_MAX: usize = 3;
/// Family-wise level of the veto among the sets that are looked at.
const VETO_LEVEL: f64 = 0.01;
/// Noise this many times as loud without an effect as with it has swallowed some of it.
const SWALLOWED: f64 = 1.5;
/// Sets that meet each other before it is known what one costs.
const FEW: usize = 2;
/// Energy of an effect in less than this many independent instants counts as brief.
const CEILING_SPARE: f64 = 1.15;

/// Likelihoods and refits of the most promising sets of `ranking`.
pub fn compete(
    session: &EstimationSession<'_>,
    nominal: &Nominal<'_>,
    columns: &[Column],
    ranking: &Ranking,
    alpha: f64,
) -> Outcome {
    let samples = libm::log(session.samples.max(2) as f64);
    let mut outcome = Outcome { contenders: Vec::new(), null: nominal.objective, samples, work_each: 0.0 };
    outcome.enter(session, nominal, columns, ranking, &ranking.shortlist(columns, samples, alpha));
    outcome
}

/// Likelihood and refit of one set, and the least objective without it under the noise that suits it.
fn one(
    session: &EstimationSession<'_>,
    nominal: &Nominal<'_>,
    columns: &[Column],
    subset: &Subset,
    p_veto: f64,
) -> Option<(Contender, f64)> {
    let extra: Vec<&Vec<f64>> = subset.members.iter().flat_map(|c| &columns[*c].raw).collect();
    let search = Search { sweeps: 3, colour: true, scan: false };
    let (linearised, theta) = (&nominal.fit.linearised, &nominal.fit.theta);
    let starts = [&subset.noise, nominal.noise];
    let apart = if subset.noise.is_about(nominal.noise) { 1 } else { 2 };
    let found = starts.iter().filter_map(|start| maximise(session, linearised, theta, &extra, start, search));
    let (noise, objective) = found.take(apart).min_by(|a, b| a.1.total_cmp(&b.1))?;
    // the noise found with the effects may be the better one without them, too
    let other = (!noise.is_about(nominal.noise)).then(|| maximise(session, linearised, theta, &[], &noise, search));
    let without = other.flatten().map_or(nominal.objective, |found| found.1);
    let null = without.min(nominal.objective);
    let normal = linearised.normal(session, theta, &noise, &extra)?;
    let (_, amplitude) = normal.minimum()?;
    let amplitudes = signed(columns, subset, &amplitude)?;
    let says = |noise: &NoiseModel| veto(session, nominal.fit, columns, subset, noise, p_veto);
    // under the noise that suits the plant alone, too, its numbers are driven from their priors
    let alone = linearised.normal(session, theta, nominal.noise, &extra);
    let relief = |normal: &Normal| normal.relief(session, theta).unwrap_or(0.0);
    let least = relief(&normal).min(alone.as_ref().map_or(0.0, relief));
    // several laws that only share a change of the plant's numbers among them are a change of those numbers
    let is_one = subset.members.len() == 1;
    let relieves = is_one && least > chi_squared_quantile(1.0 - p_veto, extra.len() as f64);
    let veto = match (says(&noise), says(nominal.noise)) {
        _ if relieves => Veto::Passed,
        (Veto::Passed, _) | (_, Veto::Passed) => Veto::Passed,
        (Veto::Silent, Veto::Silent) => Veto::Silent,
        // noise that has swallowed the effect has no say in it
        (Veto::Silent, _) if nominal.noise.exceeds(&noise, &session.noise, SWALLOWED) => Veto::Silent,
        _ => Veto::Vetoed,
    };
    let subset = Subset { amplitudes, ..subset.clone() };
    let parts: Vec<(&Column, &[f64])> =
        subset.members.iter().zip(&subset.amplitudes).map(|(c, a)| (&columns[*c], a.as_slice())).collect();
    let ratio = null - objective;
    let refit = (veto != Veto::Vetoed).then(|| refit_all(session, nominal.fit, &parts, &noise, null - 0.5 * ratio));
    // a refit that lost most of what the line promised has not converged
    let refit = refit.flatten().filter(|refit| null - refit.objective > 0.5 * ratio);
    let free = refit.as_ref().map_or(subset.free, |refit| refit.free);
    let objective = refit.as_ref().map_or(objective, |refit| refit.objective);
    let (ratio, p, bic, is_settled, is_met) = (0.0, 1.0, 0.0, false, false);
    Some((Contender { subset, objective, ratio, p, noise, veto, refit, is_settled, is_met, bic, free }, without))
}

impl Contender {
    /// Significant, fitted as physics, better than nothing by BIC, and not vetoed.
    pub fn stands(&self, alpha: f64) -> bool {
        self.p < alpha && self.veto != Veto::Vetoed && self.refit.is_some() && self.bic < 0.0
    }

    /// Fits its plant to the end of its valley and looks into those beside it, once.
    pub fn settle(&mut self, session: &EstimationSession<'_>, columns: &[Column]) {
        if !core::mem::replace(&mut self.is_settled, true)
            && let Some(refit) = self.refit.take()
        {
            let members: Vec<&Column> = self.subset.members.iter().map(|member| &columns[*member]).collect();
            let refit = hopped(session, timed(session, settled(session, refit), &members), &members);
            self.objective = refit.objective;
            self.refit = Some(refit);
        }
    }

    /// No member has all its amplitudes within two of their standard errors of nothing. A single one is asked only where it adds a mode or a
    /// tank: what gained by their free start alone is a swing that nothing drives. Whether any other is there the ratio of likelihoods has said (a
    /// lag's jump shows the lag, and not how long it is).
    pub fn is_there(&self, session: &EstimationSession<'_>, columns: &[Column]) -> bool {
        let members = &self.subset.members;
        let vanishes = |refit: &Refit| members.iter().any(|member| refit.vanishes(&columns[*member]));
        let is_asked = |refit: &Refit| members.len() > 1 || refit.adds_masses(&session.problem.plant);
        self.refit.as_ref().is_some_and(|refit| !is_asked(refit) || !vanishes(refit))
    }

    fn judge(&mut self, null: f64, trials: &Trials, samples: f64) {
        self.ratio = null - self.objective;
        self.p = trials.p(self.ratio, self.free, &self.subset.members);
        self.bic = self.free as f64 * samples - self.ratio;
    }
}

impl Outcome {
    /// The sets of `list` meet the others, as many of them as there is room for, at first [`FEW`] in any case. Returns how many.
    pub fn enter(
        &mut self,
        session: &EstimationSession<'_>,
        nominal: &Nominal<'_>,
        columns: &[Column],
        ranking: &Ranking,
        list: &[Subset],
    ) -> usize {
        let p_veto = VETO_LEVEL / (self.contenders.len() + list.len()).max(1) as f64;
        let single = EstimationSession { threads: 1, ..session.clone() };
        let mut null = self.null;
        let mut rest = list;
        while !rest.is_empty() {
            let is_first = self.work_each == 0.0;
            let many = if is_first { FEW } else { session.work.pays_for(self.work_each, "sets that scored less") };
            if many == 0 {
                break;
            }
            let (own, behind) = rest.split_at(rest.len().min(many));
            rest = behind;
            let before = session.work.spent();
            let found = parallel(own.len(), session.threads, |i| one(&single, nominal, columns, &own[i], p_veto));
            self.work_each = self.work_each.max((session.work.spent() - before) / own.len() as f64);
            for (contender, without) in found.into_iter().flatten() {
                null = null.min(without);
                self.contenders.push(contender);
            }
        }
        self.settle(null, &ranking.trials);
        list.len() - rest.len()
    }

    /// Ratios, p, BIC and order against a nominal plant that does as well as `null`.
    pub fn settle(&mut self, null: f64, trials: &Trials) {
        self.null = null.min(self.null);
        self.contenders.iter_mut().for_each(|c| c.judge(self.null, trials, self.samples));
        self.sort();
    }

    /// Best first; twins in the order of the catalogue.
    fn sort(&mut self) {
        let key = |c: &Contender| libm::round(c.bic / subsets::TIE);
        self.contenders.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.subset.members.cmp(&b.subset.members)));
    }

    /// The set to adopt: the best that stands; a larger one must beat every smaller one that stands at `alpha`, and predict what it was
    /// not fitted to better than it (`better`).
    pub fn best(&self, alpha: f64, trials: &Trials, better: &dyn Fn(&Contender, &Contender) -> bool) -> Option<usize> {
        let mut best: Option<usize> = None;
        for size in 1..=SET_MAX {
            let own = |i: &usize| self.contenders[*i].subset.members.len() == size && self.contenders[*i].stands(alpha);
            let Some(i) = (0..self.contenders.len()).find(own) else { continue };
            let challenger = &self.contenders[i];
            let holder = best.map(|b| &self.contenders[b]);
            let wins = holder.is_none_or(|holder| {
                let more = size - holder.subset.members.len();
                let mut price: Vec<f64> = challenger.subset.members.iter().map(|m| trials.of(*m)).collect();
                price.sort_by(|a, b| b.total_cmp(a));
                let free = challenger.free.saturating_sub(holder.free).max(1);
                let gained = (challenger.ratio - holder.ratio).max(0.0);
                let p = chi_squared_tail(gained, free as f64) * price[..more].iter().product::<f64>();
                challenger.bic < holder.bic && p < alpha
            });
            if wins && holder.is_none_or(|holder| better(holder, challenger)) {
                best = Some(i);
            }
        }
        best
    }
}

/// Amplitudes by member; `None` where one is none that its effect can have.
fn signed(columns: &[Column], subset: &Subset, flat: &[f64]) -> Option<Vec<Vec<f64>>> {
    let mut at = 0;
    let mut amplitudes = Vec::with_capacity(subset.members.len());
    for c in &subset.members {
        let own = &flat[at..at + columns[*c].raw.len()];
        if !columns[*c].candidate.is_possible(own) {
            return None;
        }
        amplitudes.push(own.to_vec());
        at += own.len();
    }
    Some(amplitudes)
}

/// The robust score of the set's joint direction, whitened by `noise`; it holds whatever the noise is, so any whitening may pass it.
fn veto(
    session: &EstimationSession<'_>,
    fit: &Fit,
    columns: &[Column],
    subset: &Subset,
    noise: &NoiseModel,
    p: f64,
) -> Veto {
    let own: Vec<Column> = subset.members.iter().map(|c| columns[*c].clone()).collect();
    let scores: Option<Vec<Score>> = scores(session, &fit.linearised, &fit.theta, noise, &own).into_iter().collect();
    let mut residual = [fit.linearised.nu.clone()];
    let (Some(own), Some(_)) = (scores, fit.linearised.whiten(session, noise, &mut residual)) else {
        return Veto::Vetoed;
    };
    let all: Vec<&Vec<f64>> = own.iter().flat_map(|score| &score.projected).collect();
    let k = all.len();
    // the joint direction is the best of k
    let level = chi_squared_quantile(1.0 - p, k as f64).sqrt();
    let matrix = DMatrix::from_fn(k, k, |i, j| dot(all[i], all[j]) * if i == j { 1.0 + 1e-9 } else { 1.0 });
    let right = DVector::from_fn(k, |i, _| dot(all[i], &residual[0]));
    let Some(factor) = Cholesky::new(matrix) else { return Veto::Vetoed };
    let amplitude = factor.solve(&right);
    let joint: Vec<f64> =
        (0..residual[0].len()).map(|s| all.iter().zip(amplitude.iter()).map(|(c, a)| a * c[s]).sum()).collect();
    match crate::score::robust::robust(&joint, &residual[0], &crate::score::event_of_sample(session)) {
        robust if robust.ceiling < CEILING_SPARE * level => Veto::Silent,
        robust if robust.z.abs() >= level => Veto::Passed,
        _ => Veto::Vetoed,
    }
}

/// `exp(−ΔBIC/2)` normalised over contenders within `span` of the best; zero beyond.
pub fn weights(bic: &[f64], span: f64) -> Vec<f64> {
    let best = bic.iter().copied().fold(f64::INFINITY, f64::min);
    let raw: Vec<f64> = bic.iter().map(|b| if b - best <= span { libm::exp(-0.5 * (b - best)) } else { 0.0 }).collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|w| if sum > 0.0 { w / sum } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests;
