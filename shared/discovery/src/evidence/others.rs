//! Hypotheses about a model that are no laws: noise that remembers, the time of inputs, numbers in
//! conflict with their file.
//!
//! A conflict has a closed form, as the pole of a channel has from the slope along it.

use super::decide::{CONFLICT_FACTOR, POLE_PRIOR, SHIFT_SIGMA};
use super::hypothesis::{Hypothesis, Part, name_of};
use super::linear_evidence::linear_evidence;
use super::noise::Linearly;
use super::propose::{Look, Proposal, columns_of};
use super::screen::Rated;
use super::timing::{ROOM, nearest};
use crate::score::Candidate;
use identification::filter::NoiseModel;

/// Sets of laws that are evaluated with a shift of the inputs. A budget.
const TIMED_MAX: usize = 3;

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

    /// Inputs shifted by the share of a sample that the linear problem asks for.
    pub(super) fn timing(&self, shift: &[f64], bare: f64) -> Option<Proposal> {
        self.shifted_with(&[], &[], (&self.model.noise, shift, bare))
    }

    /// Of the laws that are proposed, the set that a shift of the inputs joins for more than the
    /// price of a member: about a motion that lacks the laws the shift may be nothing, and a law
    /// that is none may be fitted in its place.
    pub(super) fn with_timing(&self, list: &[Proposal], (shift, bare, log_m): (&[f64], f64, f64)) -> Option<Proposal> {
        let mut best: Vec<&Proposal> = list.iter().filter(|own| !own.instead).collect();
        best.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        let of = |own: &&Proposal| {
            let of = |part: &Part| Some(Rated { part: part.clone(), ..self.rated(&part.column.candidate)?.clone() });
            let parts = own.set.iter().flat_map(Hypothesis::parts).map(of).collect::<Option<Vec<Rated>>>()?;
            let found = self.shifted_with(&own.set, &parts.iter().collect::<Vec<_>>(), (&own.noise, shift, bare))?;
            (found.log_bayes > own.log_bayes + log_m).then_some(found)
        };
        let all = best.iter().take(TIMED_MAX).filter_map(of);
        all.max_by(|a, b| a.log_bayes.total_cmp(&b.log_bayes))
    }

    /// A set of laws and a shift of the inputs on the linear problem.
    fn shifted_with(
        &self,
        laws: &[Hypothesis],
        parts: &[&Rated],
        (start, column, bare): (&NoiseModel, &[f64], f64),
    ) -> Option<Proposal> {
        let (linearised, theta) = (&self.model.fit.linearised, &self.model.fit.theta[..]);
        let (mut extra, mut room) = columns_of(parts);
        extra.push(column.to_vec());
        room.push(ROOM);
        let linear = Linearly { session: self.session, linearised, theta, extra: &extra, room: &room };
        let found = linear_evidence(&linear, (start, &self.model.prior(self.ground.session)))?;
        let shift = nearest(SHIFT_SIGMA * found.amplitudes.last()?);
        let points: f64 = parts.iter().map(|own| own.part.log_points).sum();
        let set = [laws, &[Hypothesis::Timing(shift)]].concat();
        Some(Proposal { instead: false, set, log_bayes: found.value - points - bare, noise: found.noise })
    }

    /// As the screening rated a law.
    fn rated(&self, candidate: &Candidate) -> Option<&Rated> {
        self.screened.rated.iter().find(|own| name_of(&own.column.candidate) == name_of(candidate))
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
