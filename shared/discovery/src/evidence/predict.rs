//! Held-out data in the same nats: a model with its numbers as the fitted recordings leave them,
//! noise of greatest posterior for each record of its own.
//!
//! The poorer model's disturbance on the fitted record is large and would follow anything; carried
//! over it would make every law look worse than none. Numbers of one recording are fitted on it, as
//! are numbers that the fitted recordings did not tell.

use super::decide::{Class, HELD_OUT_SIGMA};
use super::horizon::{Compared, Horizons};
use super::hypothesis::Hypothesis;
use super::learned::{self, At, learned};
use super::model::{Ground, Model};
use super::noise::{Linearly, NoisePrior};
use super::temper::Instants;
use super::timing::{as_seen, shift_of};
use dynamics::description::{Plant, Quantity, Scope};
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, LinearisedProblem, NOT_FOUND_RATIO, fit};
use identification::held_out::{ChannelFit, Gain, Predictor, block_s, blocks, free_run};
use identification::problem::{Problem, Unknown};

/// Relinearisations of the numbers of one recording.
const OWN_ROUNDS: usize = 3;

/// What a model says of recordings that it was not fitted to.
#[derive(Clone)]
pub(super) struct HeldOut {
    /// Log-likelihood of every instant, numbers held where the fitted recordings leave them.
    pub terms: Instants,
    /// The same with the numbers where both have them.
    pub found: Instants,
    block_s: f64,
    /// `ln` of the noise's share of the evidence there.
    pub log_width: f64,
    /// Nats of the numbers' widths, as the fitted recordings leave them.
    learned: f64,
    pub free: Vec<ChannelFit>,
    horizons: Option<Horizons>,
    /// Numbers of these recordings alone with their values, and the noise.
    own: (Vec<Unknown>, Vec<f64>),
    noise: NoiseModel,
}

impl HeldOut {
    /// `ln p` of these data given the fitted ones, up to a constant of the data.
    pub(super) fn log_evidence(&self) -> f64 {
        self.terms.sum() + self.log_width + self.learned
    }

    /// Nats ahead of `other`, in blocks of time, numbers held where the fitted recordings leave
    /// them.
    pub(super) fn gain(&self, other: &Self) -> Gain {
        let own = self.terms.times_s.iter().zip(&self.terms.log_likelihood).zip(&other.terms.log_likelihood);
        let gain = blocks(&own.map(|((t, a), b)| (*t, a - b)).collect::<Vec<_>>(), self.block_s);
        gain.beside_free_runs(&other.free, &self.free)
    }

    /// The same with what the parameters give a distance, as well as the fitted recordings tell
    /// them: their error is no misfit. The model is the one that predicts `other`.
    pub(super) fn with_parameters(&self, ground: Ground<'_>, other: &Problem, model: &Model) -> Option<Self> {
        let blank = blank(ground, other)?;
        let own = (&self.own.0[..], &self.own.1[..]);
        let at = At { own, noise: &self.noise, log_likelihood: self.terms.sum() };
        let horizons = learned::with_parameters(self.horizons.clone()?, ground, (other, &blank), model, &at)?;
        Some(Self { horizons: Some(horizons), ..self.clone() })
    }

    /// Free runs over a horizon beside those of `other`.
    pub(super) fn beside(&self, other: &Self) -> Option<Compared> {
        self.horizons.as_ref().zip(other.horizons.as_ref()).and_then(|(own, other)| own.beside(other))
    }

    /// These data reject `set` for `other`, a part of it: its likelihood falls and its free run
    /// comes no nearer, or that goes further away. Noise and a number alone add nothing that
    /// free runs could judge.
    pub(super) fn rejects(&self, set: &[Hypothesis], other: &Self) -> bool {
        let gain = self.gain(other);
        let moves = set.iter().any(|own| matches!(own.class(), Class::Physics | Class::Sensor));
        let compared = if moves { self.beside(other) } else { None };
        let learned = self.learned - other.learned;
        let loses = gain.loglik_gain + learned + HELD_OUT_SIGMA * gain.gain_se < 0.0;
        let comes_nearer = compared.as_ref().is_some_and(Compared::is_better);
        loses && !comes_nearer || compared.is_some_and(|compared| compared.is_worse())
    }
}

/// A session of held-out recordings with the steps of integration of the fitted ones.
fn blank<'p>(ground: Ground<'_>, other: &'p Problem) -> Option<EstimationSession<'p>> {
    let (threads, parts) = (ground.session.threads, ground.session.parts);
    let mut blank = EstimationSession::counted(other, threads, ground.session.work.clone()).ok()?;
    if parts > 1 {
        blank = blank.in_parts(parts).ok()?;
    }
    blank.lower_floors();
    Some(blank)
}

/// Predicts `other` by `model`; `bare` has the parameters of the plant without hypotheses, and
/// which of them the fitted recordings tell. `None`: the plant does not survive the recording.
pub(super) fn predicted(ground: Ground<'_>, other: &Problem, model: &Model, bare: &Model) -> Option<HeldOut> {
    let own = bare.problem.unknowns.iter().zip(&bare.fit.ratio);
    let unseen: Vec<&str> = own.filter(|(_, ratio)| **ratio > NOT_FOUND_RATIO).map(|(u, _)| &*u.name).collect();
    let plant = frozen(&model.problem.plant, (&model.problem.unknowns, &model.fit.theta), &unseen);
    let problem = as_seen(other.with_plant(&plant), &model.set);
    let blank = blank(ground, other)?;
    let session = EstimationSession::like(&blank, &problem).ok()?;
    let session = if shift_of(&model.set).is_some() { session.in_parts(session.parts).ok()? } else { session };
    let prior = NoisePrior::new(&blank, &model.set);
    let start = prior.begun(&model.noise);
    let prior_theta = session.prior();
    let theta = match prior_theta.is_empty() {
        true => prior_theta,
        false => fit(&session, &plant, &prior_theta, &start, OWN_ROUNDS).map_or(prior_theta, |fit| fit.theta),
    };
    let mut linearised = LinearisedProblem::new(&session, &plant, &theta, &start).ok()?;
    linearised.take_jacobian(&session, &plant, &theta);
    let linear = Linearly { session: &session, linearised: &linearised, theta: &theta, extra: &[], room: &[] };
    let noise = linear.settled(&start, &prior)?.noise;
    let log_width = linear.log_width_expected(&noise, &prior)?;
    let terms = Instants::new(&session, &linearised.linears, &noise)?;
    let explaining = explaining(&linear, &noise, prior);
    let horizons = explaining.and_then(|own| Horizons::new(&session, &linearised.linears, &noise, &own));
    let free = free_run(&session, Predictor { plant: &plant, theta: &theta, noise: &noise });
    let at = At { own: (&problem.unknowns, &theta), noise: &noise, log_likelihood: terms.sum() };
    let (learned, found) = learned(ground, (other, &blank), model, &at).unwrap_or_else(|| (0.0, terms.clone()));
    let (block_s, own) = (block_s(&session), (problem.unknowns.clone(), theta));
    Some(HeldOut { terms, found, block_s, log_width, learned, free, horizons, own, noise })
}

/// `noise` with no disturbance above its stated size, since a larger one follows what the plant
/// lacks, and what it follows is misfit; the readings have as much more as they have beside these,
/// up to what is stated.
pub(super) fn explaining(linear: &Linearly<'_>, noise: &NoiseModel, prior: NoisePrior) -> Option<NoiseModel> {
    let stated = &linear.session.noise;
    let above = |k: &usize| noise.input_sigma[*k] > stated.input_sigma[*k];
    let held: Vec<usize> = (0..noise.input_sigma.len()).filter(above).collect();
    if held.is_empty() {
        return Some(noise.clone());
    }
    let mut settled = linear.settled(noise, &prior.holding(&held))?.noise;
    for (k, sigma) in settled.sensor_sigma.iter_mut().enumerate() {
        *sigma = sigma.min(noise.sensor_sigma[k].max(stated.sensor_sigma[k]));
    }
    // what the held ones lose the others would take
    for (own, stated) in settled.input_sigma.iter_mut().zip(&stated.input_sigma) {
        *own = own.min(*stated);
    }
    Some(settled)
}

/// `plant` with its shared numbers known as fitted, except those that the recordings did not tell.
fn frozen(plant: &Plant, (unknowns, theta): (&[Unknown], &[f64]), unseen: &[&str]) -> Plant {
    let mut plant = plant.clone();
    plant.visit_quantities(&mut |name, _, quantity| {
        let at = unknowns.iter().position(|unknown| unknown.name == name && !unseen.contains(&name));
        if let Some(at) = at.filter(|_| quantity.scope == Scope::Shared) {
            *quantity = Quantity::known(theta[at]);
        }
    });
    plant
}
