//! Levenberg–Marquardt over the arc: from the scan, from a hypothesis, and what is reported of the
//! maximum.

use super::*;

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
        let (mut hypothesis, mut here) = (*start, self.likelihood(start));
        let (mut damping, mut step_sigmas) = (1e-3, f64::INFINITY);
        for iterations in 0..FIT_ITERATIONS_MAX {
            let Some(full) = damped_step(&here, 0.0) else { break };
            step_sigmas = libm::sqrt(full.dot(&here.gradient));
            if step_sigmas <= STEP_SIGMAS {
                return self.report(&hypothesis, &here, iterations, scanned);
            }
            let Some(step) = damped_step(&here, damping) else { break };
            let trial = hypothesis.moved(&step);
            // A trial that is impossible or worse is not taken; non-finite χ² compares as worse.
            let there = if trial.is_possible() { Some(self.likelihood(&trial)) } else { None };
            match there.filter(|there| there.chi_square < here.chi_square) {
                Some(better) => {
                    (hypothesis, here) = (trial, better);
                    damping *= 0.1;
                }
                // At the bottom rounding of χ² decides: a full step below 1 % of a sigma is as good
                // as taken.
                None if step_sigmas < 0.01 && damping < 1e-6 => {
                    return self.report(&hypothesis, &here, iterations, scanned);
                }
                None => damping *= 10.0,
            }
        }
        Err(SloshError::NotConverged { iterations: FIT_ITERATIONS_MAX, step_sigmas })
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

/// `(H + λ diag H)⁻¹ g`; `None` when the information is singular.
fn damped_step(at: &Likelihood, damping: f64) -> Option<Vector6<f64>> {
    let scale = at.information.diagonal().map(|value| 1.0 / libm::sqrt(value));
    let scaling = Matrix6::from_diagonal(&scale);
    let scaled = scaling * at.information * scaling + Matrix6::identity() * damping;
    Some(scaling * scaled.cholesky()?.solve(&(scaling * at.gradient)))
}
