//! Screening: every effect at every site with its score, on grids first, then refined where it is
//! promising.

use super::Options;
use crate::compete::FittedModel;
use crate::compete::subsets::noise_hypotheses;
use crate::score::refine::refined;
use crate::score::{
    Column, Lines, Orders, Score, Scorer, candidates, columns, instants, lines, noise_free, orders, thin,
};
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, LinearisedProblem};

/// Ratio of adapted to stated noise from which the noise may have absorbed an effect, so that
/// scores are also taken under the stated noise. Chosen, no derivation.
const GROWN_NOISE_RATIO: f64 = 3.0;

/// Columns and their scores under the adapted noise.
#[derive(Default)]
pub(super) struct Screening {
    pub columns: Vec<Column>,
    pub scores: Vec<Score>,
}

impl Screening {
    /// Score of a column.
    pub fn score(&self, column: usize) -> Option<&Score> {
        self.scores.iter().find(|score| score.column == column)
    }
}

/// Evaluates `look` along the trajectory of `best`; where a loop feeds back sensor noise, along the
/// loop without that noise.
pub(super) fn along_noise_free_loop<T>(
    session: &EstimationSession<'_>,
    best: &FittedModel,
    look: impl FnOnce((&EstimationSession<'_>, &LinearisedProblem)) -> T,
) -> T {
    let (linearised, theta) = (&best.fit.linearised, &best.fit.theta);
    let loops = noise_free(session.problem, &best.plant, theta, &best.noise.sensor_sigma);
    let loops = loops.as_ref().and_then(|problem| {
        let own = EstimationSession::at_other_values(session, problem).ok()?;
        let linearised = LinearisedProblem::new(&own, &best.plant, theta, &best.fit.noise).ok()?;
        Some((own, linearised))
    });
    look(loops.as_ref().map_or((session, linearised), |(session, linearised)| (session, linearised)))
}

pub(super) fn screen(session: &EstimationSession<'_>, best: &FittedModel, options: &Options) -> Screening {
    along_noise_free_loop(session, best, |along| screen_along(session, along, best, options))
}

fn screen_along(
    session: &EstimationSession<'_>,
    along: (&EstimationSession<'_>, &LinearisedProblem),
    best: &FittedModel,
    options: &Options,
) -> Screening {
    let (linearised, theta) = (&best.fit.linearised, &best.fit.theta);
    let period_s = session.timelines[0].period_s;
    let stated = scaled_stated_noise(session, best);
    let (lines, orders) = longest(session, best);
    let noise = stated.as_ref().unwrap_or(&best.noise);
    let jumps = instants((session, linearised), along, &best.plant, theta, noise);
    let found = (&lines, &orders[..], &jumps);
    let mut list = candidates(session.problem, &best.plant, &linearised.linears, period_s, found, &options.without);
    thin(session, (&best.plant, theta), &mut list);
    let mut all = columns(along, &best.plant, theta, &list);
    let Some(scorer) = Scorer::new(session, linearised, theta, &best.noise) else {
        return Screening { columns: all, scores: Vec::new() };
    };
    let mut found = scored(&scorer, &all);
    let mut finer = refined(&scorer, along, &best.plant, theta, (&all, &found));
    if let Some(scorer) = stated.and_then(|stated| Scorer::new(session, linearised, theta, &stated)) {
        // noise that has absorbed an effect also hides its shape parameters: of a fault that begins
        // and ends it leaves two instants
        let found = scored(&scorer, &all);
        finer.extend(refined(&scorer, along, &best.plant, theta, (&all, &found)));
    }
    found.extend(scored(&scorer, &finer).into_iter().map(|own| Score { column: own.column + all.len(), ..own }));
    all.extend(finer);
    Screening { columns: all, scores: found }
}

fn scored(scorer: &Scorer<'_, '_>, columns: &[Column]) -> Vec<Score> {
    scorer.scores(columns).into_iter().flatten().collect()
}

/// The last noise hypothesis (all noise as stated) scaled to the innovations; `None` where it is
/// the adapted noise.
fn scaled_stated_noise(session: &EstimationSession<'_>, best: &FittedModel) -> Option<NoiseModel> {
    let (found, stated) = (&best.noise, &session.noise);
    let sizes = |noise: &NoiseModel| [noise.input_sigma.clone(), noise.sensor_sigma.clone()].concat();
    let is_larger = sizes(found).iter().zip(&sizes(stated)).any(|(sigma, stated)| *sigma > GROWN_NOISE_RATIO * stated);
    let grown = is_larger || found.jitter_s.iter().any(|jitter| *jitter > 0.0);
    let noise = noise_hypotheses(session, &best.noise).pop().filter(|_| grown)?;
    let normal = best.fit.linearised.normal(session, &best.fit.theta, &noise, &[])?;
    let scale = (normal.chi2 / session.samples.max(1) as f64).sqrt();
    Some(noise.scaled(scale))
}

/// Lines of the innovations of the longest run, and orders at which they repeat over a joint.
fn longest(session: &EstimationSession<'_>, best: &FittedModel) -> (Lines, Vec<Orders>) {
    let runs = best.fit.linearised.linears.iter().zip(session.timelines.iter());
    let Some((linear, timeline)) = runs.max_by_key(|(linear, _)| linear.nu.len()) else { return Default::default() };
    let sigma = &session.noise.sensor_sigma;
    (lines(linear, timeline, sigma.len()), orders(linear, timeline, &best.plant, sigma))
}
