//! Model comparison: sets of effects against each other and against the noise, by joint likelihoods
//! in which each side has its own noise.
//!
//! The sets that [`subsets`] ranks first are tested by a likelihood ratio. Sizes and poles of the
//! noise are maximised with the effects and without them: noise fitted to the nominal plant alone
//! has absorbed part of the unmodelled physics, noise taken as stated invents some. The best sets
//! are fitted as physics, starting at the amplitudes of the linear problem, with the shape
//! parameters of their laws free.
//!
//! Criterion: `BIC = −2 ln p + k ln n`; weights `exp(−ΔBIC/2)`. A set is accepted when three
//! conditions hold: its likelihood ratio is significant at `alpha` after the correction for
//! multiplicity ([`Multiplicity`]), it beats the best smaller set by the same test, and the robust
//! score of its joint direction does not veto it.

mod multiplicity;
mod multistart;
mod onset;
mod refit;
pub mod subsets;

pub use multiplicity::Multiplicity;
pub use multistart::multistart;
pub use onset::{onset_estimates, refine_onsets};
pub(crate) use refit::augmented;
pub use refit::{FittedModel, free_parameters, refit_all, settled};
pub use subsets::{Ranking, Subset, rank};

use crate::outline::{COMPLETION_SETS, SET_ROUNDS};
use crate::score::{Column, Score, scores};
use identification::dot::dot;
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, Normal, parallel};
use identification::statistics::{chi_squared_quantile, chi_squared_tail};
use identification::work::Work;
use nalgebra::{Cholesky, DMatrix, DVector};

/// A set of effects with its likelihood, noise and fit.
#[derive(Clone, Debug)]
pub struct ModelHypothesis {
    pub subset: Subset,
    /// Least `−2 ln p`: as physics, else on the linear model.
    pub objective: f64,
    /// Likelihood ratio `2 Δ ln p`, noise maximised on both sides, and its p value after the
    /// correction for multiplicity.
    pub ratio: f64,
    pub p: f64,
    pub noise: NoiseModel,
    pub veto: Veto,
    pub refit: Option<FittedModel>,
    /// The fit has converged in parameters and noise, and the nominal plant was fitted from there.
    pub is_settled: bool,
    pub is_compared: bool,
    /// `−2 ln p + k ln n`, relative to the nominal plant's.
    pub bic: f64,
    pub free: usize,
}

/// Result of the robust score, which does not depend on the noise model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Veto {
    Passed,
    Vetoed,
    /// No power: the largest value that it can reach is below its threshold.
    NoPower,
}

/// The sets tested so far, best first, and the least objective of the nominal plant found on the
/// way.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub hypotheses: Vec<ModelHypothesis>,
    pub null: f64,
    /// Logarithm of the number of samples.
    samples: f64,
    /// Work of the most expensive set so far.
    work_each: f64,
}

/// The nominal plant that the sets are compared with.
pub struct Nominal<'a> {
    pub fit: &'a Fit,
    pub noise: &'a NoiseModel,
    pub objective: f64,
}

/// ΔBIC from which one law replaces another, or a law with more shape parameters the simpler one
/// [−2 ln p]. Posterior odds of 20 : 1, as exp(−6/2) = 1/20; Kass & Raftery's "strong" evidence.
pub const BIC_PREFERENCE: f64 = 6.0;
/// Largest set.
pub const SET_MAX: usize = 3;
/// Family-wise level of the robust veto over the sets tested. Chosen, no derivation: a lower level
/// vetoes more effects where the noise model is right.
const VETO_LEVEL: f64 = 0.01;
/// Ratio of noise standard deviations without and with an effect from which that noise has absorbed
/// part of the effect, so that a veto whitened by it is not counted. Chosen on seeded cases, no
/// derivation.
const ABSORBED_NOISE_RATIO: f64 = 1.5;
/// Sets tested before the cost of one is known.
const FIRST_BATCH: usize = 2;
/// Ratio of the robust score's ceiling to its threshold below which the score has no power: the
/// effect acts in too few independent instants. Chosen, no derivation.
const CEILING_RATIO_MIN: f64 = 1.15;

/// Likelihoods and fits of the first sets of `ranking`, at the level `alpha`.
///
/// Cost: for each set of the shortlist up to three maximisations of the noise and one fit as
/// physics; bounded by `session.work`.
pub fn compete(
    session: &EstimationSession<'_>,
    nominal: &Nominal<'_>,
    columns: &[Column],
    ranking: &Ranking,
    alpha: f64,
) -> Outcome {
    let samples = libm::log(session.samples.max(2) as f64);
    let mut outcome = Outcome { hypotheses: Vec::new(), null: nominal.objective, samples, work_each: 0.0 };
    let list = ranking.shortlist(columns, samples, alpha);
    let sets = if list.is_empty() { 0.0 } else { list.len() as f64 + COMPLETION_SETS };
    session.work.plan_now(sets * SET_ROUNDS * session.round_work());
    outcome.enter(session, nominal, columns, ranking, &list);
    outcome
}

/// Likelihood and fit of one set, and the least objective without it under the noise that suits it.
fn one(
    session: &EstimationSession<'_>,
    nominal: &Nominal<'_>,
    columns: &[Column],
    subset: &Subset,
    p_veto: f64,
) -> Option<(ModelHypothesis, f64)> {
    let extra: Vec<&Vec<f64>> = subset.members.iter().flat_map(|c| &columns[*c].raw).collect();
    let search = Search { sweeps: 3, colour: true, scan: false };
    let (linearised, theta) = (&nominal.fit.linearised, &nominal.fit.theta);
    let starts = [&subset.noise, nominal.noise];
    let apart = if subset.noise.is_about(nominal.noise) { 1 } else { 2 };
    let found = starts.iter().filter_map(|start| maximise(session, linearised, theta, &extra, start, search));
    let (noise, objective) = found.take(apart).min_by(|a, b| a.1.total_cmp(&b.1))?;
    // the noise found with the effects may also be the better one without them
    let other = (!noise.is_about(nominal.noise)).then(|| maximise(session, linearised, theta, &[], &noise, search));
    let without = other.flatten().map_or(nominal.objective, |found| found.1);
    let null = without.min(nominal.objective);
    let normal = linearised.normal(session, theta, &noise, &extra)?;
    let (_, amplitude) = normal.minimum()?;
    let amplitudes = signed(columns, subset, &amplitude)?;
    let says = |noise: &NoiseModel| veto(session, nominal.fit, columns, subset, noise, p_veto);
    // the set also relieves the parameters of their tension with the priors under the noise of the
    // plant alone
    let alone = linearised.normal(session, theta, nominal.noise, &extra);
    let relief = |normal: &Normal| normal.relief(session, theta).unwrap_or(0.0);
    let least = relief(&normal).min(alone.as_ref().map_or(0.0, relief));
    // several laws that together only change the plant's parameters are a change of those
    // parameters
    let is_one = subset.members.len() == 1;
    let relieves = is_one && least > chi_squared_quantile(1.0 - p_veto, extra.len() as f64);
    let veto = match (says(&noise), says(nominal.noise)) {
        _ if relieves => Veto::Passed,
        (Veto::Passed, _) | (_, Veto::Passed) => Veto::Passed,
        (Veto::NoPower, Veto::NoPower) => Veto::NoPower,
        // noise that has absorbed the effect cannot veto it
        (Veto::NoPower, _) if nominal.noise.exceeds(&noise, &session.noise, ABSORBED_NOISE_RATIO) => Veto::NoPower,
        _ => Veto::Vetoed,
    };
    let subset = Subset { amplitudes, ..subset.clone() };
    let parts: Vec<(&Column, &[f64])> =
        subset.members.iter().zip(&subset.amplitudes).map(|(c, a)| (&columns[*c], a.as_slice())).collect();
    let ratio = null - objective;
    let refit = (veto != Veto::Vetoed).then(|| refit_all(session, nominal.fit, &parts, &noise, null - 0.5 * ratio));
    // a fit that lost most of the gain of the linear problem has not converged
    let refit = refit.flatten().filter(|refit| null - refit.objective > 0.5 * ratio);
    let free = refit.as_ref().map_or(subset.free, |refit| refit.free);
    let objective = refit.as_ref().map_or(objective, |refit| refit.objective);
    let (ratio, p, bic, is_settled, is_compared) = (0.0, 1.0, 0.0, false, false);
    Some((
        ModelHypothesis { subset, objective, ratio, p, noise, veto, refit, is_settled, is_compared, bic, free },
        without,
    ))
}

impl ModelHypothesis {
    /// Significant at `alpha` after multiplicity, fitted as physics, preferred to the nominal plant
    /// by BIC, and not vetoed.
    pub fn is_accepted(&self, alpha: f64) -> bool {
        self.p < alpha && self.veto != Veto::Vetoed && self.refit.is_some() && self.bic < 0.0
    }

    /// Iterates the fit to its local optimum and runs the multistart about it, once.
    pub fn settle(&mut self, session: &EstimationSession<'_>, columns: &[Column]) {
        if !core::mem::replace(&mut self.is_settled, true)
            && let Some(refit) = self.refit.take()
        {
            let members: Vec<&Column> = self.subset.members.iter().map(|member| &columns[*member]).collect();
            let refit = multistart(session, refine_onsets(session, settled(session, refit), &members), &members);
            self.objective = refit.objective;
            self.refit = Some(refit);
        }
    }

    /// No member has all its amplitudes within two standard errors of zero. A single effect is
    /// tested only where it adds a mode or a tank: a gain by their free initial state alone is an
    /// oscillation that nothing drives. Any other single effect is decided by the likelihood ratio
    /// (a lag's jump shows the lag, not its length).
    pub fn all_amplitudes_significant(&self, session: &EstimationSession<'_>, columns: &[Column]) -> bool {
        let members = &self.subset.members;
        let amplitude_insignificant =
            |refit: &FittedModel| members.iter().any(|member| refit.amplitude_insignificant(&columns[*member]));
        let is_tested = |refit: &FittedModel| members.len() > 1 || refit.adds_masses(&session.problem.plant);
        self.refit.as_ref().is_some_and(|refit| !is_tested(refit) || !amplitude_insignificant(refit))
    }

    fn evaluate(&mut self, null: f64, multiplicity: &Multiplicity, samples: f64) {
        self.ratio = null - self.objective;
        self.p = multiplicity.p(self.ratio, self.free, &self.subset.members);
        self.bic = self.free as f64 * samples - self.ratio;
    }
}

impl Outcome {
    /// Tests the sets of `list` in order, as many as the work allows and `FIRST_BATCH` in any
    /// case. Returns how many.
    pub fn enter(
        &mut self,
        session: &EstimationSession<'_>,
        nominal: &Nominal<'_>,
        columns: &[Column],
        ranking: &Ranking,
        list: &[Subset],
    ) -> usize {
        let p_veto = VETO_LEVEL / (self.hypotheses.len() + list.len()).max(1) as f64;
        let single = EstimationSession { threads: 1, ..session.clone() };
        let mut null = self.null;
        let mut rest = list;
        while !rest.is_empty() {
            if !session.work.goes_on("sets of lower score") {
                break;
            }
            let is_first = self.work_each == 0.0;
            let many =
                if is_first { FIRST_BATCH } else { session.work.pays_for(self.work_each, "sets of lower score") };
            if many == 0 {
                break;
            }
            if !is_first {
                let is_complete = self.hypotheses.iter().any(|own| own.is_compared);
                self.plan(session, rest.len() as f64 + if is_complete { 0.0 } else { COMPLETION_SETS });
            }
            let (own, behind) = rest.split_at(rest.len().min(many));
            rest = behind;
            let before = session.work.spent();
            let share = 1.0 / own.len() as f64;
            let tasks: Vec<EstimationSession<'_>> = (0..own.len())
                .map(|_| EstimationSession { work: Work::part(&session.work, share), ..single.clone() })
                .collect();
            let found = parallel(own.len(), session.threads, |i| one(&tasks[i], nominal, columns, &own[i], p_veto));
            self.work_each = self.work_each.max((session.work.spent() - before) / own.len() as f64);
            for (hypothesis, without) in found.into_iter().flatten() {
                null = null.min(without);
                self.hypotheses.push(hypothesis);
            }
        }
        self.settle(null, &ranking.multiplicity);
        list.len() - rest.len()
    }

    /// Plans the work of `sets` more.
    pub(crate) fn plan(&self, session: &EstimationSession<'_>, sets: f64) {
        session.work.plan_now(sets * self.work_each);
    }

    /// Recomputes ratios, p, BIC and order against a nominal plant of objective `null`.
    pub fn settle(&mut self, null: f64, multiplicity: &Multiplicity) {
        self.null = null.min(self.null);
        self.hypotheses.iter_mut().for_each(|c| c.evaluate(self.null, multiplicity, self.samples));
        self.sort();
    }

    /// Best first; sets of equal BIC in the order of the catalogue.
    fn sort(&mut self) {
        let key = |c: &ModelHypothesis| libm::round(c.bic / subsets::BIC_TIE);
        self.hypotheses.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.subset.members.cmp(&b.subset.members)));
    }

    /// Index of the set to adopt: the best accepted one. A larger set must beat every smaller
    /// accepted one at `alpha` and predict data it was not fitted to better than it (`better`).
    pub fn best(
        &self,
        alpha: f64,
        multiplicity: &Multiplicity,
        better: &dyn Fn(&ModelHypothesis, &ModelHypothesis) -> bool,
    ) -> Option<usize> {
        let mut best: Option<usize> = None;
        for size in 1..=SET_MAX {
            let own =
                |i: &usize| self.hypotheses[*i].subset.members.len() == size && self.hypotheses[*i].is_accepted(alpha);
            let Some(i) = (0..self.hypotheses.len()).find(own) else { continue };
            let challenger = &self.hypotheses[i];
            let holder = best.map(|b| &self.hypotheses[b]);
            let wins = holder.is_none_or(|holder| {
                let more = size - holder.subset.members.len();
                let mut price: Vec<f64> = challenger.subset.members.iter().map(|m| multiplicity.of(*m)).collect();
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

/// Amplitudes by member; `None` where one is impossible for its effect.
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

/// The robust score of the set's joint direction, whitened by `noise`; it is valid whatever the
/// noise is, so any whitening may pass it.
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
        robust if robust.ceiling < CEILING_RATIO_MIN * level => Veto::NoPower,
        robust if robust.z.abs() >= level => Veto::Passed,
        _ => Veto::Vetoed,
    }
}

/// `exp(−ΔBIC/2)`, normalised over those within `span` of the best; zero beyond.
pub fn weights(bic: &[f64], span: f64) -> Vec<f64> {
    let best = bic.iter().copied().fold(f64::INFINITY, f64::min);
    let raw: Vec<f64> = bic.iter().map(|b| if b - best <= span { libm::exp(-0.5 * (b - best)) } else { 0.0 }).collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|w| if sum > 0.0 { w / sum } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests;
