//! Hypotheses about a model that are no laws: noise that remembers, the time of inputs, numbers in
//! conflict with their file.
//!
//! A conflict has a closed form, as the pole of a channel has from the slope along it.

use super::decide::{CONFLICT_FACTOR, POLE_PRIOR, SHIFT_SIGMA};
use super::hypothesis::Hypothesis;
use super::marginal::log_marginal;
use super::noise::Linearly;
use super::propose::{Look, Proposal};
use super::timing::{SHIFTS, is_possible, shift_of, shifted};
use identification::fit::EstimationSession;

impl Look<'_> {
    /// Channels whose innovations remember, by the slope along their poles; all of those together
    /// that pay for themselves.
    pub(super) fn coloured(&self, log_m: f64) -> Vec<Proposal> {
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        let noise = &self.model.noise;
        let Some((found, _)) = linearised.gradient(self.session, (&linearised.nu, theta), noise) else {
            return Vec::new();
        };
        let white = found.pole.iter().enumerate().filter(|(channel, _)| noise.pole[*channel] == 0.0);
        let of = |(channel, slope): (usize, &identification::filter::Slope)| {
            let gain = slope.first * slope.first / (4.0 * slope.second.max(f64::MIN_POSITIVE));
            let occam = 0.5 * libm::log(1.0 + 0.5 * slope.second * POLE_PRIOR[1] * POLE_PRIOR[1]);
            let set = vec![Hypothesis::Coloured(channel)];
            Proposal { set, instead: false, log_bayes: gain - occam, noise: noise.clone() }
        };
        let mut list: Vec<Proposal> = white.map(of).collect();
        let worthy: Vec<&Proposal> = list.iter().filter(|own| own.log_bayes > log_m).collect();
        if worthy.len() > 1 {
            let set = worthy.iter().flat_map(|own| own.set.iter().cloned()).collect();
            let log_bayes = worthy.iter().map(|own| own.log_bayes).sum();
            list.push(Proposal { set, instead: false, log_bayes, noise: noise.clone() });
        }
        list
    }

    /// Inputs shifted by the share of a sample that the linear problem asks for, where it asks for
    /// one.
    pub(super) fn timing(&self, bare: f64) -> Option<Proposal> {
        if shift_of(&self.model.set).is_some() || !is_possible(&self.model.problem) {
            return None;
        }
        let (plant, theta) = (&self.model.problem.plant, &self.model.fit.theta[..]);
        let linearised = &self.model.fit.linearised;
        let problem = shifted(&self.model.problem, SHIFT_SIGMA);
        let session = EstimationSession { problem: &problem, ..self.session.clone() };
        let session = session.in_parts(session.parts).ok()?;
        let nu = session.innovations(plant, theta, &linearised.linears, &|_| true)?;
        let change = linearised.nu.iter().zip(&nu).map(|(own, moved)| own - moved).collect();
        let (extra, room) = ([change], [[-2.0, 2.0]]);
        let linear = Linearly { session: self.session, linearised, theta, extra: &extra, room: &room };
        let prior = self.model.prior(self.ground.session);
        let noise = linear.settled(&self.model.noise, &prior)?.noise;
        let normal = linear.normal(&noise)?;
        let (_, x) = normal.least()?;
        let value = log_marginal(&normal, &[])? + linear.log_width_expected(&noise, &prior)?;
        let wanted = SHIFT_SIGMA * x[normal.unknowns];
        let nearest = SHIFTS.iter().min_by(|a, b| (**a - wanted).abs().total_cmp(&(**b - wanted).abs()))?;
        Some(Proposal { instead: false, set: vec![Hypothesis::Timing(*nearest)], log_bayes: value - bare, noise })
    }

    /// Parameters of the plant that a wider prior would move: with the likelihood of one number z
    /// normal about z₀ with variance s, `B = N(z₀; 0, c² + s) / N(z₀; 0, 1 + s)`.
    pub(super) fn conflicts(&self) -> Vec<Proposal> {
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        let (extra, room) = (&[][..], &[][..]);
        let linear = Linearly { session: self.session, linearised, theta, extra, room };
        let found = linear.normal(&self.model.noise);
        let Some((normal, factor)) = found.and_then(|normal| normal.factor().map(|factor| (normal, factor))) else {
            return Vec::new();
        };
        let (inverse, step) = (factor.inverse(), factor.solve(&normal.right));
        let unknowns = self.model.problem.unknowns.iter().enumerate();
        let own = unknowns.filter(|(_, unknown)| !unknown.parameter.starts_with("effect."));
        let of = |(i, unknown): (usize, &identification::problem::Unknown)| {
            let at = (theta[i] - unknown.prior) / unknown.sigma + step[i];
            let precision = 1.0 / inverse[(i, i)] - 1.0;
            let known = self.model.set.iter().any(|own| matches!(own, Hypothesis::Conflict(n) if *n == unknown.name));
            if known || precision < 1e-6 {
                return None;
            }
            let (centre, s) = (at / (inverse[(i, i)] * precision), 1.0 / precision);
            let log_normal = |variance: f64| -0.5 * centre * centre / variance - 0.5 * libm::log(variance);
            let log_bayes = log_normal(CONFLICT_FACTOR * CONFLICT_FACTOR + s) - log_normal(1.0 + s);
            let set = vec![Hypothesis::Conflict(unknown.name.clone())];
            Some(Proposal { set, instead: false, log_bayes, noise: self.model.noise.clone() })
        };
        own.filter_map(of).collect()
    }
}
