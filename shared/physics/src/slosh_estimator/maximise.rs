//! Levenberg–Marquardt over the arc: from the scan, from a hypothesis, and what is reported of the
//! maximum.

use super::*;
use estimation::levenberg_marquardt::{End, Quadratic, Settings, minimise};
use nalgebra::Const;

/// Of the fit. At the bottom rounding of χ² decides: a step below 1 % of a sigma is as good as
/// taken.
const FIT: Settings = Settings {
    iterations_max: FIT_ITERATIONS_MAX,
    step_sigmas: STEP_SIGMAS,
    gain_share: 0.0,
    rounding: (0.01, 1e-6),
    damping_max: f64::INFINITY,
};

impl<const CAPACITY: usize> SloshEstimator<CAPACITY> {
    pub(super) fn maximise_from_scan(&mut self) -> Result<Solved, SloshError> {
        let scan = self.scan();
        self.scanned_at_samples = self.arc.samples();
        self.searched_hz = scan.band_hz;
        let gain = scan.candidates[0].gain;
        if gain <= scan.threshold {
            return Err(self.fragmented().unwrap_or(SloshError::NoSloshFound { gain, threshold: scan.threshold }));
        }
        // The best grid point nearly always leads to the maximum; the others stand by for broad,
        // damped modes.
        let mut outcome = Err(SloshError::NotConverged { iterations: 0, step_sigmas: f64::INFINITY });
        for candidate in scan.candidates.iter().filter(|candidate| candidate.gain > scan.threshold) {
            let (parameters, bias_m_s2) = (candidate.parameters, candidate.bias_m_s2);
            let start = SloshHypothesis { parameters, bias_m_s2, ..SloshHypothesis::default() };
            outcome = self.maximise(&start, true);
            if !matches!(outcome, Err(SloshError::NotConverged { .. })) {
                break;
            }
        }
        self.or_near_the_prior(outcome)
    }

    /// The maximum next to the prior where that is the more likely one: the strongest line may be
    /// another mode's.
    fn or_near_the_prior(&self, outcome: Result<Solved, SloshError>) -> Result<Solved, SloshError> {
        let near = self.prior.map(|prior| self.maximise(&prior.hypothesis(), true));
        let misfit = |solved: &Solved| self.likelihood(&solved.0.hypothesis).chi_square;
        match (outcome, near) {
            (Ok(found), Some(Ok(near))) => Ok(if misfit(&near) < misfit(&found) { near } else { found }),
            (Err(_), Some(Ok(near))) => Ok(near),
            (outcome, _) => outcome,
        }
    }

    pub(super) fn maximise(&self, start: &SloshHypothesis, scanned: bool) -> Result<Solved, SloshError> {
        let beside = |hypothesis: SloshHypothesis| {
            let here = self.likelihood(&hypothesis);
            let Likelihood { chi_square, information, gradient, .. } = here;
            ((hypothesis, here), Quadratic::<Const<6>> { chi_square, information, gradient })
        };
        let found = minimise(beside(*start), &FIT, |(from, _), step, _| {
            Some(from.moved(step)).filter(SloshHypothesis::is_possible).map(beside)
        });
        let ((hypothesis, here), step_sigmas) = (found.point, found.step_sigmas);
        match found.end {
            End::Converged => self.report(&hypothesis, &here, found.iterations, scanned),
            End::Exhausted | End::Singular => {
                Err(SloshError::NotConverged { iterations: FIT_ITERATIONS_MAX, step_sigmas })
            }
        }
    }

    pub(super) fn report(
        &self,
        hypothesis: &SloshHypothesis,
        at: &Likelihood,
        iterations: u32,
        scanned: bool,
    ) -> Result<Solved, SloshError> {
        if let Some(refusal) = self.unresolved(hypothesis) {
            return Err(refusal);
        }
        let mut whiteness = Whiteness::default();
        let SloshSettings { base_mass_kg, unknowns } = self.settings;
        let held = likelihood(&self.arc, base_mass_kg, hypothesis, unknowns, |residual| whiteness.push(residual));
        let singular = SloshError::NotConverged { iterations, step_sigmas: f64::INFINITY };
        let covariance = FisherInformation::<6> { matrix: at.information }.bound().ok_or(singular)?;
        let fitted = at.eliminated + unknowns.kept();
        let three: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into();
        let estimate = SloshEstimate {
            hypothesis: SloshHypothesis { state: at.start, ..*hypothesis },
            covariance: three,
            state_at_end: at.end,
            chi_square: held.chi_square,
            degrees_of_freedom: at.blocks.saturating_sub(fitted) as u64,
            whiteness,
            iterations,
            scanned,
            searched_hz: self.searched_hz,
            identifiability: self.prior.map(|prior| prior.identifiability(&three.diagonal().map(libm::sqrt))),
            innovation: None,
        };
        Ok((estimate, covariance))
    }
}
