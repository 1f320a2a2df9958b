//! Every effect at every site as a column along a model's trajectory, rated under two noises.
//!
//! The noise that was fitted has absorbed physics, the stated one overrates all of it: every law
//! is rated under both, the stated one scaled to the innovations, and keeps the better rating:
//!
//! ```text
//! ln B ≈ ½ T m A²/(1 + m A²) − ½ Σ ln(1 + m_i A²) − ln points
//! T, m: score and information of the projected column
//! ```

use super::hypothesis::{Part, part};
use super::model::{Ground, Model};
use super::scale::Drive;
use crate::score::refine::refined;
use crate::score::{
    Candidate, Column, LIMIT_D, Lines, Orders, Score, Scorer, candidates, columns, instants, lines, noise_free, orders,
    thin,
};
use dynamics::effect::Role;
use identification::dot::dot;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, LinearisedProblem};

/// Difference of the logarithms of two frequencies or orders from which on a fit of one may end
/// elsewhere than one of the other. A budget: another start finds no less.
const NEAR: f64 = 0.05;

/// A law with its best column.
#[derive(Clone)]
pub(super) struct Rated {
    pub column: Column,
    /// Prior, grid and start.
    pub part: Part,
    pub log_bayes: f64,
    /// Rated under the stated noise.
    pub is_stated: bool,
}

/// A law that was screened: kind, site, its hypotheses for a table of power, and the amplitude that
/// one standard error is [unit of the amplitude].
#[derive(Clone)]
pub(super) struct Looked {
    pub candidate: Candidate,
    pub chances: f64,
    pub sigma: f64,
}

/// All laws about one model, best first.
pub(super) struct Screened {
    pub rated: Vec<Rated>,
    /// The same laws at other frequencies and orders, best first.
    pub elsewhere: Vec<Rated>,
    pub looked: Vec<Looked>,
    /// The model's noise, and the stated one scaled to its innovations.
    pub noises: [NoiseModel; 2],
}

/// Screens the catalogue about `model`; `without` names entries that are left out.
pub(super) fn screen(ground: Ground<'_>, model: &Model, without: &[String]) -> Option<Screened> {
    let session = model.session(ground)?;
    along_noise_free_loop(&session, model, |along| screen_along(&session, along, model, without))
}

/// Evaluates `look` along the trajectory of `model`; where a loop feeds back sensor noise, along
/// the loop without that noise.
pub(super) fn along_noise_free_loop<T>(
    session: &EstimationSession<'_>,
    model: &Model,
    look: impl FnOnce((&EstimationSession<'_>, &LinearisedProblem)) -> T,
) -> T {
    let (plant, linearised, theta) = (&model.problem.plant, &model.fit.linearised, &model.fit.theta);
    let loops = noise_free(&model.problem, plant, theta, &model.noise.sensor_sigma);
    let loops = loops.as_ref().and_then(|problem| {
        let own = EstimationSession::at_other_values(session, problem).ok()?;
        let linearised = LinearisedProblem::new(&own, plant, theta, &model.fit.noise).ok()?;
        Some((own, linearised))
    });
    look(loops.as_ref().map_or((session, linearised), |(session, linearised)| (session, linearised)))
}

fn screen_along(
    session: &EstimationSession<'_>,
    along: (&EstimationSession<'_>, &LinearisedProblem),
    model: &Model,
    without: &[String],
) -> Option<Screened> {
    let plant = &model.problem.plant;
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta);
    let noises = [model.noise.clone(), scaled_stated(session, model)?];
    let period_s = session.timelines[0].period_s;
    let (found_lines, found_orders) = longest(session, model);
    let jumps = instants((session, linearised), along, plant, theta, &noises[1]);
    let found = (&found_lines, &found_orders[..], &jumps);
    let mut list = candidates(&model.problem, plant, (&linearised.linears, &session.timelines), found, without);
    thin(session, (plant, theta), &mut list);
    let mut all = columns(along, plant, theta, &list);
    let scorers: Vec<Scorer<'_, '_>> =
        noises.iter().filter_map(|noise| Scorer::new(session, linearised, theta, noise)).collect();
    let mut finer = Vec::new();
    for scorer in &scorers {
        let found: Vec<Score> = scorer.scores(&all).into_iter().flatten().collect();
        finer.extend(refined(scorer, along, plant, theta, (&all, &found)));
    }
    all.extend(finer);
    let drive = Drive::new(along.0, along.1, plant);
    let chances = chances(&all);
    let mut laws = Laws { rated: Vec::new(), elsewhere: Vec::new(), looked: Vec::new() };
    for (which, scorer) in scorers.iter().enumerate() {
        let scores = scorer.scores(&all);
        for score in scores.iter().flatten() {
            let column = &all[score.column];
            let Some(scale) = drive.scale(session, plant, column) else { continue };
            let points: Vec<&Candidate> = list.iter().filter(|other| other.same_law(&column.candidate)).collect();
            let setting = (&model.problem, plant, &linearised.linears[..]);
            let part = part(setting, period_s, column, &points, (score.amplitude.clone(), scale));
            let part = Part { kappa: score.kappa, ..part };
            laws.look(column, score, chances[score.column]);
            laws.rate(Rated { column: column.clone(), log_bayes: rating(score, &part), part, is_stated: which == 1 });
        }
    }
    laws.rated.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
    let elsewhere = laws.elsewhere();
    Some(Screened { rated: laws.rated, elsewhere, looked: laws.looked, noises })
}

/// Of every column how many hypotheses a p value of its law counts: laws, times points of its own
/// grid.
fn chances(columns: &[Column]) -> Vec<f64> {
    let same = |a: &Column, b: &Column| a.candidate.same_law(&b.candidate);
    let is_first = |place: &usize| !columns[..*place].iter().any(|other| same(other, &columns[*place]));
    let laws = (0..columns.len()).filter(is_first).count() as f64;
    let points = |own: &Column| -> f64 {
        columns.iter().filter(|other| same(other, own)).map(|other| other.candidate.tries as f64).sum()
    };
    columns.iter().map(|own| laws * points(own)).collect()
}

struct Laws {
    rated: Vec<Rated>,
    elsewhere: Vec<Rated>,
    looked: Vec<Looked>,
}

impl Laws {
    fn rate(&mut self, new: Rated) {
        let same = |own: &&mut Rated| own.column.candidate.same_law(&new.column.candidate);
        match self.rated.iter_mut().find(same) {
            Some(own) if own.log_bayes >= new.log_bayes => self.elsewhere.push(new),
            Some(own) => self.elsewhere.push(core::mem::replace(own, new)),
            None => self.rated.push(new),
        }
    }

    /// Columns of laws that repeat, at frequencies and orders that are neither near the best one
    /// nor near a better one.
    fn elsewhere(&mut self) -> Vec<Rated> {
        let mut all = core::mem::take(&mut self.elsewhere);
        all.retain(|own| own.log_bayes > 0.0 && repeats_at(&own.column.candidate).is_some());
        all.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        let mut kept: Vec<Rated> = Vec::new();
        for new in all {
            let mut known = self.rated.iter().chain(&kept);
            if !known.any(|own| is_near(&own.column.candidate, &new.column.candidate)) {
                kept.push(new);
            }
        }
        kept
    }

    fn look(&mut self, column: &Column, score: &Score, chances: f64) {
        let sigma = score.limit / LIMIT_D;
        match self.looked.iter_mut().find(|own| own.candidate.same_law(&column.candidate)) {
            Some(own) => own.sigma = own.sigma.min(sigma),
            None => self.looked.push(Looked { candidate: column.candidate.clone(), chances, sigma }),
        }
    }
}

/// The frequency or order of a law that repeats.
fn repeats_at(candidate: &Candidate) -> Option<f64> {
    let place = candidate.inner_with(Role::Frequency).or_else(|| candidate.inner_with(Role::Order))?;
    Some(candidate.inner[place].1)
}

/// The same law at a frequency or order that a fit from here reaches.
fn is_near(a: &Candidate, b: &Candidate) -> bool {
    let both = repeats_at(a).zip(repeats_at(b));
    a.same_law(b) && both.is_none_or(|(a, b)| libm::log(a / b).abs() < NEAR)
}

/// `ln B` of a column about its best amplitude.
fn rating(score: &Score, part: &Part) -> f64 {
    let square = part.scale * part.scale;
    let information = score.projected.iter().map(|c| dot(c, c) * square);
    let largest = information.clone().fold(0.0, f64::max);
    let occam: f64 = information.map(|m| 0.5 * libm::log(1.0 + m)).sum();
    0.5 * score.statistic * largest / (1.0 + largest) - occam - part.log_points
}

/// The stated noise, unstated disturbances at their floors, scaled to the innovations.
pub(super) fn scaled_stated(session: &EstimationSession<'_>, model: &Model) -> Option<NoiseModel> {
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta);
    let normal = linearised.normal(session, theta, &session.noise, &[])?;
    Some(session.noise.scaled((normal.chi2 / session.samples.max(1) as f64).sqrt()))
}

/// Lines of the innovations of the longest run, and orders at which they repeat over a joint.
fn longest(session: &EstimationSession<'_>, model: &Model) -> (Lines, Vec<Orders>) {
    let runs = model.fit.linearised.linears.iter().zip(session.timelines.iter());
    let Some((linear, timeline)) = runs.max_by_key(|(linear, _)| linear.nu.len()) else { return Default::default() };
    let sigma = &session.noise.sensor_sigma;
    (lines(linear, timeline, sigma.len()), orders(linear, timeline, &model.problem.plant, sigma))
}
