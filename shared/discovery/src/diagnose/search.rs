//! The search: sets of effects join the plant, and what a later one has taken the place of leaves it.

use super::adoption::{stand, step};
use super::screening::{Screening, screen};
use super::{Adopted, Contested, Options, RIVAL_SPAN, Standing, Unfitted};
use crate::compete::{Refit, free_numbers, hopped, refit_all, settled, weights};
use crate::fit::Engine;
use crate::score::{Candidate, Column, Score, columns, cosine, scores};

/// What the search ends with.
pub(super) struct Found {
    pub best: Standing,
    pub adopted: Vec<Adopted>,
    pub unfitted: Vec<Unfitted>,
    /// The catalogue on the nominal plant.
    pub screening: Screening,
    /// Smaller sets that stood on the way, nearest first.
    pub smaller: Vec<(Vec<Adopted>, Standing)>,
    /// Sets that the recording does not exclude beside the last one adopted, and by how much in BIC they are behind.
    pub rivals: Vec<(Vec<Adopted>, Standing, f64)>,
    /// What noise of another kind gains on the standing plant.
    pub unknown_noise: f64,
}

/// Sets of effects join the plant, round by round, until nothing more stands.
pub(super) fn searched(
    engine: &Engine<'_>,
    nominal: Standing,
    options: &Options,
    notes: &mut Vec<String>,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Found, String> {
    let (adopted, unfitted, smaller, rivals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let screening = Screening::default();
    let mut found = Found { best: nominal, adopted, unfitted, screening, smaller, rivals, unknown_noise: 0.0 };
    let mut last: Option<(Refit, usize)> = None;
    for round in 0..options.terms_max {
        if found.adopted.len() >= options.terms_max || !found.unfitted.is_empty() {
            break;
        }
        let done = round as f64 / options.terms_max as f64;
        progress("score the catalogue", 0.2 + 0.6 * done);
        let own = Engine::like(engine, &found.best.problem).map_err(|error| error.to_string())?;
        let screened = screen(&own, &found.best, options, notes);
        progress("compete", 0.25 + 0.6 * done);
        let step = step(&own, &found.best, &screened, options.terms_max - found.adopted.len(), options);
        found.unfitted = step.unfitted;
        if found.adopted.is_empty() {
            found.screening = screened;
        }
        let Some(refit) = step.refit else {
            found.unknown_noise = (found.best.objective - step.null).max(0.0);
            break;
        };
        // nearest first: without what this round adds, then its own smaller sets before that
        let joined = |set: Vec<Adopted>| found.adopted.iter().cloned().chain(set).collect::<Vec<_>>();
        let mut nearest: Vec<(Vec<Adopted>, Standing)> =
            step.smaller.into_iter().map(|(set, refit)| (joined(set), stand(&refit))).collect();
        found.rivals =
            step.rivals.into_iter().map(|(set, refit, behind)| (joined(set), stand(&refit), behind)).collect();
        let (refit, left) = relieved(engine, refit, &found.adopted);
        let before = core::mem::replace(&mut found.best, stand(&refit));
        let gained = before.objective - found.best.objective;
        if left.contains(&true) {
            // they hold what has left
            found.rivals.clear();
            nearest.clear();
        } else if !found.adopted.is_empty() {
            nearest.push((found.adopted.clone(), before));
        }
        nearest.append(&mut found.smaller);
        found.smaller = nearest;
        let (gone, stay) = found.adopted.into_iter().zip(left).partition::<Vec<_>, _>(|(_, left)| *left);
        found.adopted = stay.into_iter().map(|(adopted, _)| adopted).collect();
        let mut new = step.adopted;
        if let ([new], [(gone, _)]) = (&mut new[..], &gone[..])
            && found.adopted.is_empty()
        {
            new.replace(gone, gained, engine.samples.max(2) as f64);
        }
        last = Some((refit, found.adopted.len()));
        found.adopted.extend(new);
    }
    if let Some((refit, earlier)) = last.filter(|(_, earlier)| *earlier > 0) {
        // valleys and rivals of what came earlier were those of a smaller set
        let columns: Vec<&Column> = found.adopted.iter().map(|adopted| &adopted.column).collect();
        let refit = hopped(engine, refit, &columns);
        found.rivals.extend((0..earlier).flat_map(|place| substitutes(engine, &refit, &found.adopted, place)));
        found.best = stand(&refit);
    }
    Ok(found)
}

/// Rivals in the place of one of `adopted` that are tried beside all others, and their least weight.
const SUBSTITUTES: usize = 2;
const SUBSTITUTE_WEIGHT: f64 = 0.05;

/// `refit` with a rival of the effect at `place` instead, and by how much it is behind in BIC.
///
/// Cost: a fit without the effect, and one a rival.
fn substitutes(
    engine: &Engine<'_>,
    refit: &Refit,
    adopted: &[Adopted],
    place: usize,
) -> Vec<(Vec<Adopted>, Standing, f64)> {
    let own = &adopted[place];
    let mut rivals: Vec<&Contested> = own.rivals.iter().filter(|rival| rival.weight > SUBSTITUTE_WEIGHT).collect();
    rivals.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    rivals.truncate(SUBSTITUTES);
    if rivals.is_empty() {
        return Vec::new();
    }
    let Some(without) = refit.without(engine, &own.column) else { return Vec::new() };
    let instead = |rival: &&Contested| {
        let (column, score, found) = with(engine, &without, &rival.candidate)?;
        let mut set = adopted.to_vec();
        set[place] = Adopted { column, score, rivals: Vec::new(), ..own.clone() };
        let gained = refit.objective - found.objective;
        let behind = set[place].replace(own, gained, engine.samples.max(2) as f64);
        (-behind <= RIVAL_SPAN).then(|| (set, stand(&found), -behind))
    };
    rivals.iter().filter_map(instead).collect()
}

/// `refit` with `candidate` beside what it has.
fn with(engine: &Engine<'_>, refit: &Refit, candidate: &Candidate) -> Option<(Column, Score, Refit)> {
    let own = Engine::like(engine, &refit.problem).ok()?;
    let (board, theta, noise) = (&refit.fit.board, &refit.fit.theta, &refit.noise);
    let column = columns((&own, board), &refit.plant, theta, core::slice::from_ref(candidate)).pop()?;
    let score = scores(&own, board, theta, noise, core::slice::from_ref(&column)).pop()??;
    let extra: Vec<&Vec<f64>> = column.raw.iter().collect();
    let (_, amplitudes) = board.normal(&own, theta, noise, &extra)?.minimum()?;
    let [low, high] = column.candidate.range();
    amplitudes.iter().all(|a| (low..=high).contains(a)).then_some(())?;
    let found = refit_all(&own, &refit.fit, &[(&column, &amplitudes)], noise, f64::NEG_INFINITY)?;
    drop(own);
    Some((column, score, settled(engine, found)))
}

impl Adopted {
    /// Stands where `gone` stood, alone and by so much better in `−2 ln p`: with it as a rival, and no more significant than either was.
    /// How far that is behind in BIC.
    fn replace(&mut self, gone: &Self, gained: f64, samples: f64) -> f64 {
        let numbers = |adopted: &Self| free_numbers(&adopted.column.candidate, adopted.column.raw.len()) as f64;
        let behind = gained + libm::log(samples) * (numbers(gone) - numbers(self));
        self.p = self.p.max(gone.p);
        self.d = (gone.d * gone.d + gained).max(0.0).sqrt();
        if behind <= RIVAL_SPAN {
            self.rivals.push(Contested {
                candidate: gone.column.candidate.clone(),
                kind: gone.column.candidate.effect.kind,
                site: gone.column.candidate.site.to_string(),
                weight: 0.0,
                bic: behind,
                cosine: cosine(&self.score, &gone.score),
            });
        }
        let bic: Vec<f64> = core::iter::once(0.0).chain(self.rivals.iter().map(|rival| rival.bic)).collect();
        let weights = weights(&bic, RIVAL_SPAN);
        self.weight = weights[0];
        self.rivals.iter_mut().zip(&weights[1..]).for_each(|(rival, weight)| rival.weight = *weight);
        behind
    }
}

/// `refit` without the effects of `adopted` that are nothing beside those that joined later, where BIC agrees; which of them left.
fn relieved(engine: &Engine<'_>, refit: Refit, adopted: &[Adopted]) -> (Refit, Vec<bool>) {
    let price = libm::log(engine.samples.max(2) as f64);
    let mut best = refit;
    let leaves = |earlier: &Adopted| {
        let column = &earlier.column;
        let numbers = free_numbers(&column.candidate, column.raw.len()) as f64;
        let found = best.vanishes(column).then(|| best.without(engine, column)).flatten();
        let found = found.filter(|found| found.objective < best.objective + price * numbers);
        found.map(|found| best = found).is_some()
    };
    let left = adopted.iter().map(leaves).collect();
    (best, left)
}
