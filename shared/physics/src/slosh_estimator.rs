//! Maximum likelihood of the slosh parameters over a fixed-memory arc.
//!
//! Scan for a global start, Levenberg–Marquardt with exact sensitivities from there, and from the
//! last estimate when there is one; the scan is repeated whenever the record has doubled, so that
//! an early wrong minimum cannot stay.
//!
//! A full arc is merged into blocks of twice the length unless it shows a mode these would not
//! tell; then the oldest quarter leaves instead, and the state at the start of the rest is unknown;
//! what it said of the parameters is remembered as a quadratic about the estimate of that time, for
//! the start of a record often says the most. Every answer names the frequencies that were
//! searched, and a mode that the blocks do not resolve is rejected.
//!
//! *Why not a Kalman filter?* A bank of unscented filters (`bench::slosh_filter`) attains the bound
//! in one pass too, at seven filters' cost a sample; this searches the frequencies from the data
//! alone, needs no prior, and tells its misfit in χ² and block means. *Why not the literature's
//! total least squares?* It integrates a noisy accelerometer twice; its damping error grows with
//! the length of the record.

use estimation::consistency::Whiteness;
use estimation::cramer_rao::FisherInformation;
use nalgebra::{Matrix3, Matrix6, Vector3};
use serde::{Deserialize, Serialize};

use crate::slosh::SloshState;
use crate::slosh_arc::{FLIGHT_CAPACITY, SampleRejected, SloshArc, SloshBlock, SloshSample};
use crate::slosh_likelihood::{
    Likelihood, SEGMENT_BLOCKS_MIN, SloshHypothesis, SloshUnknowns, likelihood, likelihood_until,
};
use crate::slosh_prior::{Remembered, TankPrior};
use crate::slosh_scan::{SloshCandidate, SloshScan, prefers_a_fast_mode, scan};
use estimation::identifiability::Identifiability;

/// Bound of the Levenberg–Marquardt iterations.
pub const FIT_ITERATIONS_MAX: u32 = 60;

/// Converged when a full Gauss–Newton step is shorter than this many standard deviations of the
/// estimate.
const STEP_SIGMAS: f64 = 1e-4;

/// Why an arc gives no tank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SloshError {
    /// Fewer blocks than twice the unknowns: `need > got`.
    ArcTooShort { got: usize, need: usize },
    /// No frequency explains the data better than a rigid spacecraft beyond what noise alone would:
    /// excite more, wait, or there is no slosh.
    NoSloshFound { gain: f64, threshold: f64 },
    /// Iterations ended without a minimum; the last Gauss–Newton step was `step_sigmas` standard
    /// deviations long.
    NotConverged { iterations: u32, step_sigmas: f64 },
    /// Gaps leave too little of the record in pieces long enough to be used: `need > usable`
    /// blocks.
    Fragmented { usable: usize, need: usize },
    /// ω × block length of the mode found exceeds what the blocks tell: sample faster, or excite
    /// for a shorter time.
    ModeNotResolved { omega_times_block: f64, limit: f64 },
}

/// What is known beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshSettings {
    pub base_mass_kg: f64,
    pub unknowns: SloshUnknowns,
}

/// The maximum of the likelihood, its worth, and whether the model explains the arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshEstimate {
    pub hypothesis: SloshHypothesis,
    /// Of `[ms, ks, cs]`: inverse Fisher information, not scaled by χ².
    pub covariance: Matrix3<f64>,
    /// Slosh state at the end of the arc: start of a held-out prediction.
    pub state_at_end: SloshState,
    pub chi_square: f64,
    pub degrees_of_freedom: u64,
    /// Of the residuals over blocks of the arc: scales of 1, 10, 100 blocks.
    pub whiteness: Whiteness,
    pub iterations: u32,
    /// True when this solve began with a scan rather than the last estimate.
    pub scanned: bool,
    /// Frequencies of the last scan: slosh outside is neither found nor excluded.
    pub searched_hz: [f64; 2],
    /// What the record did to each of the three, where there was a prior.
    pub identifiability: Option<[Identifiability; 3]>,
    /// The newest block against what the estimate before said of it; `None` for the first estimate.
    pub innovation: Option<SloshInnovation>,
}

/// A block as it was predicted before it was used, in its own standard deviations. Where fewer
/// samples came since the last estimate than the block holds (a close right behind an estimate)
/// that estimate had used part of it: the innovation is then smaller than its variance says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshInnovation {
    pub innovation: f64,
    /// One, and what parameters and state were uncertain by.
    pub variance: f64,
}

impl SloshEstimate {
    /// Standard deviations of slosh mass \[kg\], stiffness [N/m] and damping [N s/m].
    pub fn sigmas(&self) -> Vector3<f64> {
        self.covariance.diagonal().map(libm::sqrt)
    }

    /// One when the model and the sensor sigma hold; its own spread is `√(2/dof)`. Zero without a
    /// degree of freedom.
    pub fn chi_square_per_degree(&self) -> f64 {
        if self.degrees_of_freedom == 0 { 0.0 } else { self.chi_square / self.degrees_of_freedom as f64 }
    }
}

/// And the covariance of all six unknowns.
type Solved = (SloshEstimate, Matrix6<f64>);

/// The estimator that flies. Fixed memory: the arc, one hypothesis and one quadratic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshEstimator<const CAPACITY: usize = FLIGHT_CAPACITY> {
    settings: SloshSettings,
    arc: SloshArc<CAPACITY>,
    prior: Option<TankPrior>,
    last: Option<SloshHypothesis>,
    /// Covariance of the last estimate's six unknowns.
    last_covariance: Matrix6<f64>,
    scanned_at_samples: u64,
    searched_hz: [f64; 2],
    /// Samples when merging was last found to lose a mode; zero while it does not.
    fast_mode_at_samples: u64,
    remembered: Option<Remembered>,
}

impl<const CAPACITY: usize> SloshEstimator<CAPACITY> {
    /// An estimator without samples and without prior; panics unless the mass of the craft is
    /// positive.
    pub fn new(settings: SloshSettings) -> Self {
        assert!(settings.base_mass_kg > 0.0);
        Self {
            settings,
            arc: SloshArc::default(),
            prior: None,
            last: None,
            last_covariance: Matrix6::zeros(),
            scanned_at_samples: 0,
            searched_hz: [0.0; 2],
            fast_mode_at_samples: 0,
            remembered: None,
        }
    }

    /// With what is believed of the tank: where the record shows no slosh the prior is the answer,
    /// and each number of it says what the record did to the prior. Operational use, where nothing
    /// was designed to show slosh.
    pub fn with_prior(mut self, prior: TankPrior) -> Self {
        assert!(prior.sigma.min() > 0.0);
        assert!(prior.parameters.slosh_mass_kg > 0.0);
        assert!(prior.parameters.stiffness_n_m > 0.0);
        self.prior = Some(prior);
        self
    }

    /// A sample that begins where the last one ended. Cost a few nanoseconds; a search for fast
    /// modes when the arc is full.
    ///
    /// # Errors
    /// [`SampleRejected`] for a sample that is not finite.
    pub fn push(&mut self, sample: &SloshSample) -> Result<(), SampleRejected> {
        self.make_room();
        self.arc.push(sample)
    }

    /// A sample that begins at `begin_s`. Behind a gap the slosh state is unknown again: what the
    /// thrust did meanwhile is not known. A missing acceleration is not a gap: push
    /// [`SloshSample::thrust_alone`].
    ///
    /// # Errors
    /// [`SampleRejected`] for a sample that is not finite or begins before the last one ended.
    pub fn push_at(&mut self, begin_s: f64, sample: &SloshSample) -> Result<(), SampleRejected> {
        self.make_room();
        self.arc.push_at(begin_s, sample)
    }

    /// Merges a full arc, or lets its oldest quarter go when merging would lose a mode it shows.
    /// The verdict is looked up again whenever the record has doubled.
    fn make_room(&mut self) {
        if !self.arc.is_full() {
            return;
        }
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let is_settled = self.fast_mode_at_samples > 0 && self.arc.samples() < 2 * self.fast_mode_at_samples;
        if is_settled || prefers_a_fast_mode(&self.arc, base_mass_kg, unknowns) {
            if !is_settled {
                self.fast_mode_at_samples = self.arc.samples();
            }
            self.remember(CAPACITY / 4);
            self.arc.forget_oldest(CAPACITY / 4);
        } else {
            self.fast_mode_at_samples = 0;
            self.arc.merge();
        }
    }

    /// Keeps what the oldest `blocks` say of the parameters, about the estimate of now; nothing
    /// when there is none.
    fn remember(&mut self, blocks: usize) {
        let Ok(estimate) = self.estimate() else { return };
        // A prior that was kept is no place to expand about: blocks that showed nothing leave
        // nothing.
        if self.last.is_none() {
            return;
        }
        let (at, SloshSettings { base_mass_kg, unknowns }) = (estimate.hypothesis, self.settings);
        let said = likelihood_until(&self.arc, blocks, base_mass_kg, &at, unknowns, |_| {});
        let mut now = Remembered { at, information: said.information, gradient: said.gradient };
        if let Some(before) = &self.remembered {
            now.information += before.information;
            now.gradient += before.gradient_at(&at);
        }
        self.remembered = Some(now);
    }

    /// The record so far, in blocks.
    pub fn arc(&self) -> &SloshArc<CAPACITY> {
        &self.arc
    }

    /// Solves for the whole arc: from the last estimate, or from a scan when there is none or the
    /// arc has doubled.
    ///
    /// # Errors
    /// Each variant of [`SloshError`] is a property of the data; the arc is kept and later samples
    /// may resolve it.
    pub fn estimate(&mut self) -> Result<SloshEstimate, SloshError> {
        let need = 2 * self.settings.unknowns.count();
        let got = self.arc.blocks().filter(SloshBlock::is_measured).count();
        if got < need {
            return Err(SloshError::ArcTooShort { got, need });
        }
        let innovation = self.innovation();
        let doubled = self.arc.samples() >= 2 * self.scanned_at_samples;
        // What is remembered holds near the estimate of its time: the search begins there, whatever
        // the arc alone says.
        let start = self.remembered.map(|remembered| self.last.unwrap_or(remembered.at));
        let warm = start.or(self.last.filter(|_| !doubled)).and_then(|start| self.maximise(&start, false).ok());
        let outcome = match warm {
            Some(estimate) => Ok(estimate),
            None => self.maximise_from_scan(),
        };
        self.last = outcome.as_ref().ok().map(|(estimate, _)| estimate.hypothesis);
        match (outcome, self.prior) {
            (Ok((estimate, covariance)), _) => {
                self.last_covariance = covariance;
                Ok(SloshEstimate { innovation, ..estimate })
            }
            (Err(error), Some(prior)) => self.keep(&prior).ok_or(error),
            (Err(error), None) => Err(error),
        }
    }

    /// The newest block, were it not yet used, against the last estimate.
    fn innovation(&self) -> Option<SloshInnovation> {
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let newest = likelihood(&self.arc, base_mass_kg, &self.last?, unknowns, |_| {}).newest;
        // A residual that the state has been fitted to is the predicted one times what of it was
        // not.
        let left = 1.0 - newest.leverage;
        let uncertain = newest.by.dot(&(self.last_covariance * newest.by)) / (left * left);
        Some(SloshInnovation { innovation: newest.residual / left, variance: 1.0 / left + uncertain })
            .filter(|one| one.variance.is_finite() && one.variance > 0.0)
    }

    /// The prior as the answer of a record that shows no slosh; its misfit is that of the prior.
    fn keep(&self, prior: &TankPrior) -> Option<SloshEstimate> {
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let mut hypothesis = prior.hypothesis();
        let at = |hypothesis: &SloshHypothesis| likelihood(&self.arc, base_mass_kg, hypothesis, unknowns, |_| {});
        let unbiased = at(&hypothesis);
        // Zero where the bias is known, and where no segment is long enough to tell it.
        let information = unbiased.information[(3, 3)];
        hypothesis.bias_m_s2 = if information > 0.0 { unbiased.gradient[3] / information } else { 0.0 };
        let here = Likelihood { information: Matrix6::identity(), ..at(&hypothesis) };
        let kept = self.report(&hypothesis, &here, 0, true).ok()?.0;
        let covariance = Matrix3::from_diagonal(&prior.sigma.component_mul(&prior.sigma));
        let identifiability = Some(prior.identifiability_unseen(&self.arc, base_mass_kg));
        Some(SloshEstimate { covariance, identifiability, ..kept })
    }

    /// Best tank of the grid: where the maximum likelihood, and any other local method, begins.
    ///
    /// # Errors
    /// [`SloshError::NoSloshFound`], [`SloshError::Fragmented`].
    pub fn start(&self) -> Result<SloshCandidate, SloshError> {
        let scan = self.scan();
        let (best, threshold) = (scan.candidates[0], scan.threshold);
        if best.gain > threshold {
            return Ok(best);
        }
        Err(self.fragmented().unwrap_or(SloshError::NoSloshFound { gain: best.gain, threshold }))
    }

    fn scan(&self) -> SloshScan {
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let ratio = self.prior.as_ref().map(|prior| prior.mass_ratio(base_mass_kg));
        scan(&self.arc, base_mass_kg, unknowns, ratio)
    }

    /// The reason why nothing was found, when it lies in the gaps.
    fn fragmented(&self) -> Option<SloshError> {
        let need = 2 * self.settings.unknowns.count();
        let segments = (0..self.arc.segments()).map(|i| self.arc.segment(i));
        let usable = segments
            .map(|segment| self.arc.blocks_of(segment).filter(SloshBlock::is_measured).count())
            .filter(|blocks| *blocks >= SEGMENT_BLOCKS_MIN)
            .sum();
        (self.arc.segments() > 1 && usable < need).then_some(SloshError::Fragmented { usable, need })
    }

    /// Limit of ω × block length and its value at a hypothesis beyond it.
    fn unresolved(&self, hypothesis: &SloshHypothesis) -> Option<SloshError> {
        let omega =
            2.0 * core::f64::consts::PI * hypothesis.parameters.natural_frequency_hz(self.settings.base_mass_kg);
        let (omega_times_block, limit) = (omega * self.arc.resolution_s(), self.arc.resolved_product());
        (omega_times_block > limit).then_some(SloshError::ModeNotResolved { omega_times_block, limit })
    }

    fn likelihood(&self, hypothesis: &SloshHypothesis) -> Likelihood {
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let mut here = likelihood(&self.arc, base_mass_kg, hypothesis, unknowns, |_| {});
        let prior = self.prior.as_ref().map(TankPrior::quadratic);
        for known in self.remembered.iter().chain(&prior) {
            known.add_to(&mut here, hypothesis);
        }
        here
    }
}

mod maximise;
#[cfg(test)]
mod tests;
