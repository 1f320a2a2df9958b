//! Disturbances that the plant file does not state, on a model's linear problem.

use super::hypothesis::Hypothesis;
use super::marginal::log_marginal;
use super::model::{Ground, Model};
use super::noise::{Linearly, NoisePrior, unstated};
use super::propose::{Proposal, WORTH};
use identification::filter::{DISTURBANCE, NoiseModel};
use identification::fit::EstimationSession;

/// Disturbances of unspecified size about `model`: all that explain something at once, and the best
/// of them.
pub(super) fn of_disturbances(ground: Ground<'_>, model: &Model) -> Vec<Proposal> {
    let Some(session) = model.session(ground) else { return Vec::new() };
    let at = Disturbed { ground, session: &session, model };
    at.evidence(&[], &model.noise).map_or(Vec::new(), |(bare, _)| at.proposals(bare))
}

/// A model on its linear problem with disturbances of unspecified size.
pub(super) struct Disturbed<'a> {
    pub ground: Ground<'a>,
    pub session: &'a EstimationSession<'a>,
    pub model: &'a Model,
}

impl Disturbed<'_> {
    fn linear(&self) -> Linearly<'_> {
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        Linearly { session: self.session, linearised, theta, extra: &[], room: &[] }
    }

    fn set(&self, inputs: &[usize]) -> Vec<Hypothesis> {
        let names = &self.ground.session.noise_names;
        inputs
            .iter()
            .map(|k| Hypothesis::Disturbance(*k, names[*k].trim_start_matches(DISTURBANCE).to_owned()))
            .collect()
    }

    fn prior(&self, inputs: &[usize]) -> NoisePrior {
        NoisePrior::new(self.ground.session, &[&self.model.set[..], &self.set(inputs)].concat())
    }

    fn evidence(&self, inputs: &[usize], start: &NoiseModel) -> Option<(f64, NoiseModel)> {
        let (linear, prior) = (self.linear(), self.prior(inputs));
        let noise = linear.settled(start, &prior)?.noise;
        let value = log_marginal(&linear.normal(&noise)?, &[])? + linear.log_width_expected(&noise, &prior)?;
        Some((value, noise))
    }

    /// Beside a model of evidence `bare` on its linear problem.
    pub(super) fn proposals(&self, bare: f64) -> Vec<Proposal> {
        let (stated, known) = (self.ground.session, self.prior(&[]));
        let open: Vec<usize> = unstated(stated).filter(|k| known.holds(*k)).collect();
        // sensors that a fit without them made noisier hide them
        let start = NoiseModel { sensor_sigma: stated.noise.sensor_sigma.clone(), ..self.model.noise.clone() };
        let Some(scanned) = self.linear().scanned(&start, &self.prior(&open)) else { return Vec::new() };
        let off: Vec<usize> = open.into_iter().filter(|k| scanned.input_sigma[*k] > start.input_sigma[*k]).collect();
        let of = |inputs: &[usize]| {
            let (value, noise) = self.evidence(inputs, &scanned)?;
            Some(Proposal { set: self.set(inputs), instead: false, log_bayes: value - bare, noise })
        };
        let single = off.iter().filter_map(|k| of(&[*k])).max_by(|a, b| a.log_bayes.total_cmp(&b.log_bayes));
        let all = if off.len() > 1 { of(&off) } else { None };
        all.into_iter().chain(single).filter(|own| own.log_bayes > WORTH).collect()
    }
}
