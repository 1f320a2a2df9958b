//! How well a plant predicts a recording, labelled in one way or another, and what asking that has cost.

use core::cell::Cell;
use std::sync::Arc;

use plant::description::Plant;

use crate::fit::board::dot;
use crate::fit::{Board, Engine, Fit, FitError, Rounds, fit, fit_from_afar};
use crate::problem::Problem;
use crate::series::Recording;
use crate::work::Work;

/// Mean square of the whitened innovations from which on a recording is missed by far.
pub(super) const FAR_OFF: f64 = 25.0;
/// Standard deviations within which the plant's numbers must stay.
const ASTRAY: f64 = 5.0;
/// Relinearisations of a fit.
const ROUNDS: Rounds = Rounds::at_most(4);
/// A fit from afar is several.
const SEVERAL: f64 = 4.0;

pub(super) struct Prediction {
    /// Of the whitened innovations.
    pub mean_square: f64,
    /// Largest distance of a number from its prior [standard deviations].
    pub astray: f64,
    pub theta: Vec<f64>,
}

impl Prediction {
    pub fn is_near(&self) -> bool {
        self.mean_square < FAR_OFF && self.astray < ASTRAY
    }

    /// The least that may be missed of a recording so many times as long that begins like this one: no numbers miss more of a part than of the
    /// whole.
    pub fn of_more(&self, times: f64) -> Self {
        Self { mean_square: self.mean_square / times, astray: 0.0, theta: self.theta.clone() }
    }
}

/// Numbers of the plant that a recording is predicted with, never further off than [`Prediction::is_near`] lets them.
#[derive(Clone, Copy)]
pub(super) enum Numbers<'a> {
    Priors,
    /// One round of a fit from the priors on.
    Step,
    /// A fit from the priors on.
    Fitted,
    /// The same by way of larger disturbances, where that is better.
    FromAfar,
    /// A fit that starts here.
    From(&'a [f64]),
}

impl Numbers<'_> {
    /// What costs about the same.
    fn kind(self) -> usize {
        match self {
            Self::Priors => 0,
            Self::Step => 1,
            Self::Fitted => 2,
            Self::FromAfar => 3,
            Self::From(_) => 4,
        }
    }
}

/// Asks a plant, and counts what that costs.
pub(super) struct Asking<'a> {
    pub plant: &'a Plant,
    pub work: &'a Arc<Work>,
    /// Work of the dearest so far of each kind, each sample.
    dearest: [Cell<f64>; 5],
}

impl<'a> Asking<'a> {
    pub fn new(plant: &'a Plant, work: &'a Arc<Work>) -> Self {
        Self { plant, work, dearest: Default::default() }
    }

    /// There is room for another as dear as the dearest of its kind; else `what` is left out.
    pub fn affords(&self, recording: &Recording, numbers: Numbers<'_>, what: &'static str) -> bool {
        self.work.allows(self.cost(recording, numbers), what)
    }

    /// The same as long as no more than `until` is spent.
    pub fn affords_until(&self, until: f64, recording: &Recording, numbers: Numbers<'_>) -> bool {
        self.work.spent() + self.cost(recording, numbers) <= until
    }

    fn cost(&self, recording: &Recording, numbers: Numbers<'_>) -> f64 {
        let each = |numbers: Numbers<'_>| self.dearest[numbers.kind()].get();
        let each = match numbers {
            Numbers::FromAfar => each(numbers).max(SEVERAL * each(Numbers::Fitted)),
            _ => each(numbers),
        };
        each * samples(recording) as f64
    }

    /// By a fit from afar, and where there is no room for that by one from the priors.
    pub fn fitted(&self, recording: &Recording) -> Option<Prediction> {
        let far = self.work.spent() + self.cost(recording, Numbers::FromAfar) <= self.work.until(1.0);
        self.predicted(recording, if far { Numbers::FromAfar } else { Numbers::Fitted })
    }

    /// `None` where the filter fails.
    pub fn predicted(&self, recording: &Recording, numbers: Numbers<'_>) -> Option<Prediction> {
        let mut problem = Problem::new(self.plant, core::slice::from_ref(recording), &[]).ok()?;
        confine(&mut problem);
        let before = self.work.spent();
        let engine = Engine::counted(&problem, 1, self.work.clone()).ok()?;
        let found = predicted(&engine, numbers);
        let each = (self.work.spent() - before) / samples(recording).max(1) as f64;
        let dearest = &self.dearest[numbers.kind()];
        dearest.set(dearest.get().max(each));
        found
    }
}

/// Numbers stay where they count as the plant's.
fn confine(problem: &mut Problem) {
    for unknown in &mut problem.unknowns {
        unknown.low = unknown.low.max(unknown.prior - ASTRAY * unknown.sigma);
        unknown.high = unknown.high.min(unknown.prior + ASTRAY * unknown.sigma);
    }
}

fn predicted(engine: &Engine<'_>, numbers: Numbers<'_>) -> Option<Prediction> {
    let (plant, prior) = (&engine.problem.plant, engine.prior());
    let fitted = |fit: Result<Fit, FitError>| Some((fit.as_ref().ok()?.chi2_per_sample, fit.ok()?.theta));
    let (mean_square, theta) = match numbers {
        Numbers::Priors => {
            let board = Board::new(engine, plant, &prior, &engine.noise).ok()?;
            let (r, _) = board.whitened(engine, &engine.noise, &[])?;
            Some((dot(&r, &r) / r.len().max(1) as f64, prior))
        }
        Numbers::Step => fitted(fit(engine, plant, &prior, &engine.noise, Rounds::at_most(1))),
        Numbers::Fitted => fitted(fit(engine, plant, &prior, &engine.noise, ROUNDS)),
        Numbers::FromAfar => fitted(fit_from_afar(engine, ROUNDS)),
        Numbers::From(theta) => fitted(fit(engine, plant, theta, &engine.noise, ROUNDS)),
    }?;
    let off = theta
        .iter()
        .zip(&engine.problem.unknowns)
        .map(|(theta, unknown)| ((theta - unknown.prior) / unknown.sigma).abs());
    let astray = off.fold(0.0, f64::max);
    mean_square.is_finite().then_some(Prediction { mean_square, astray, theta })
}

pub(super) fn samples(recording: &Recording) -> usize {
    recording.channels.iter().map(|channel| channel.value.len()).sum()
}
