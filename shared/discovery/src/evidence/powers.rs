//! Laws of one number that the catalogue lacks, as evidence about a model.
//!
//! Two effects of several parameters each may come near a law that is neither. A law of one number
//! that explains as much is ahead of them by what their parameters cost. Each is rated under the
//! model's noise and under the stated one, as the catalogue is (`screen`); the best are evaluated
//! with the noise free again.

use super::linear_evidence::linear_evidence;
use super::model::{Ground, Model};
use super::noise::{Linearly, NoisePrior};
use super::scale::Drive;
use super::screen::{along_noise_free_loop, scaled_stated};
use crate::score::{Instants, Lines, candidates, columns};
use crate::unknown_law::{self, Acts, NoiseHypothesis, Power, UnknownLaw};
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, White};
use nalgebra::Cholesky;

/// Laws whose evidence is evaluated with the noise free, and of how many that are rated best.
/// Budgets.
const EVALUATED_MAX: usize = 3;
const RATED_MAX: usize = 12;
/// Share of the nats that are needed from which a rating is worth an evaluation: noise that is free
/// may leave a law more than either of two does. A budget.
const RATED_SHARE: f64 = 0.5;
/// Cosine from which two columns, whitened and without what the unknowns take up, are one law: what
/// of `d²` they differ by, 1 − c² = 4 %, is no more than noise and a linear problem leave open.
const SAME_LAW_COSINE: f64 = 0.98;
/// Columns of the catalogue that are whitened at a time. A budget of memory.
const WHITENED: usize = 32;
/// Columns that rating all laws of a plant costs, for the limit of the work: some thirty for an
/// input.
const COLUMNS: usize = 40;

/// A law with the standard deviation of its prior and its rating under one of two noises.
struct Rated {
    power: Power,
    scale: f64,
    log_bayes: f64,
    noise: usize,
}

/// The one-parameter law of most evidence about `model` that the catalogue, taken without some,
/// does not have, where it may reach `needed` nats: `evidence` is twice its logarithm, as of any
/// [`UnknownLaw`].
///
/// Cost: a column for each, whitened under two noises; where some are promising a part of a
/// screening, and three maximisations of the noise.
pub(super) fn best(ground: Ground<'_>, model: &Model, (without, needed): (&[String], f64)) -> Option<UnknownLaw> {
    let session = model.session(ground)?;
    let inputs = model.fit.linearised.linears.first()?.input_names.len();
    let work =
        model.fit.linearised.normal_work(&session, COLUMNS) * (inputs + model.problem.plant.sensors.len()) as f64;
    if !session.work.allows(work, "laws of one number without a name") {
        return None;
    }
    let noises = [model.noise.clone(), scaled_stated(&session, model)?];
    let look = Look { session: &session, model, noises, prior: model.prior(ground.session) };
    let (mut few, tried) = look.rated()?;
    few.retain(|own| own.log_bayes > RATED_SHARE * needed);
    if few.is_empty() {
        return None;
    }
    let names = names(&session, model, (without, &few))?;
    let mut has_name = names.iter();
    few.retain(|_| !has_name.next().is_some_and(|named| *named));
    few.truncate(EVALUATED_MAX);
    look.evaluated(few, tried)
}

struct Look<'a> {
    session: &'a EstimationSession<'a>,
    model: &'a Model,
    /// The model's, and the stated one scaled to its innovations.
    noises: [NoiseModel; 2],
    prior: NoisePrior,
}

impl Look<'_> {
    /// The laws that are rated best, best first, and how many were.
    fn rated(&self) -> Option<(Vec<Rated>, usize)> {
        let Self { session, model, .. } = *self;
        let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
        let whites: Option<Vec<White<'_>>> =
            self.noises.iter().map(|noise| White::new(session, linearised, noise)).collect();
        let (whites, plant) = (whites?, &model.problem.plant);
        let (mut few, mut tried) = (Vec::new(), 0);
        along_noise_free_loop(session, model, |along| {
            let drive = Drive::new(along.0, along.1, plant);
            unknown_law::powers(along.0, (along.1, theta), plant, &mut |laws| {
                tried += laws.len();
                few.extend(self.rate(laws, &drive, &whites));
                few.sort_by(|a: &Rated, b| b.log_bayes.total_cmp(&a.log_bayes));
                few.truncate(RATED_MAX);
            })
        })?;
        Some((few, tried))
    }

    /// The laws of one place, each under the noise that rates it better.
    fn rate(&self, laws: Vec<Power>, drive: &Drive, whites: &[White<'_>]) -> Vec<Rated> {
        let scale = |power: &Power| {
            let channel = if let Acts::Reading(channel) = power.place.acts { Some(channel) } else { None };
            drive.amplitude(self.session, channel, &power.column, power.push)
        };
        let laws: Vec<(f64, Power)> = laws.into_iter().filter_map(|power| Some((scale(&power)?, power))).collect();
        let extra: Vec<Vec<f64>> = laws.iter().map(|(scale, power)| times(&power.column, *scale)).collect();
        let extra: Vec<&Vec<f64>> = extra.iter().collect();
        let theta = &self.model.fit.theta;
        let rate = |white: &White<'_>| {
            let normal = white.normal(self.session, theta, &extra)?;
            Some(NoiseHypothesis::of(self.session, theta, normal, &white.noise)?.ratings())
        };
        let ratings: Vec<Option<Vec<f64>>> = whites.iter().map(rate).collect();
        let of = |place: usize| {
            let all = ratings.iter().enumerate().filter_map(|(noise, own)| Some((own.as_ref()?[place], noise)));
            all.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let all = laws.into_iter().enumerate();
        all.filter_map(|(place, (scale, power))| {
            let (log_bayes, noise) = of(place)?;
            Some(Rated { power, scale, log_bayes, noise })
        })
        .collect()
    }

    /// The one of most evidence with the noise free.
    fn evaluated(&self, few: Vec<Rated>, tried: usize) -> Option<UnknownLaw> {
        let Self { session, model, noises, prior } = self;
        let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
        let bare = Linearly { session, linearised, theta, extra: &[], room: &[] };
        let alone = linear_evidence(&bare, (&model.noise, prior))?.value;
        let of = |Rated { power, scale, noise, .. }: Rated| {
            let (extra, room) = ([times(&power.column, scale)], [[f64::NEG_INFINITY, f64::INFINITY]]);
            let linear = Linearly { extra: &extra, room: &room, ..bare };
            let found = linear_evidence(&linear, (&noises[noise], prior))?;
            let variance = Cholesky::new(linear.normal(&found.noise)?.matrix)?.inverse()[(theta.len(), theta.len())];
            let amplitude = [found.amplitudes[0] * scale, variance.max(0.0).sqrt() * scale];
            Some((found.value - alone, power, (amplitude, scale), found.noise))
        };
        let (log_bayes, power, amplitude, noise) = few.into_iter().filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0))?;
        power.into_unknown_law(session, (linearised, theta, &noise), amplitude, (2.0 * log_bayes, tried))
    }
}

/// Whether the catalogue, taken without some, has each law: one of its laws of one number changes
/// the innovations as it does, whitened and without what the unknowns take up.
fn names(session: &EstimationSession<'_>, model: &Model, (without, laws): (&[String], &[Rated])) -> Option<Vec<bool>> {
    let theta = &model.fit.theta;
    let white = White::new(session, &model.fit.linearised, &model.noise)?;
    let mut found = vec![false; laws.len()];
    for some in columns_of_catalogue(session, model, without).chunks(WHITENED) {
        let extra: Vec<&Vec<f64>> = laws.iter().map(|own| &own.power.column).chain(some).collect();
        let normal = white.normal(session, theta, &extra)?;
        let products = NoiseHypothesis::of(session, theta, normal, &white.noise)?.reduced;
        let is_one = |a: usize, b: usize| {
            let across = products[(a, b)];
            across * across > SAME_LAW_COSINE * SAME_LAW_COSINE * products[(a, a)] * products[(b, b)]
        };
        found.iter_mut().enumerate().for_each(|(law, own)| *own |= (laws.len()..extra.len()).any(|b| is_one(law, b)));
    }
    Some(found)
}

/// Of the catalogue's laws of one number.
fn columns_of_catalogue(session: &EstimationSession<'_>, model: &Model, without: &[String]) -> Vec<Vec<f64>> {
    let (plant, linears) = (&model.problem.plant, &model.fit.linearised.linears);
    let none = (&Lines::default(), &[][..], &Instants::default());
    let mut list = candidates(&model.problem, plant, (linears, &session.timelines), none, without);
    list.retain(|own| own.numbers() == 1);
    let all = along_noise_free_loop(session, model, |along| columns(along, plant, &model.fit.theta, &list));
    all.into_iter().flat_map(|column| column.raw).collect()
}

fn times(column: &[f64], factor: f64) -> Vec<f64> {
    column.iter().map(|c| c * factor).collect()
}
