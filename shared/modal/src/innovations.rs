//! The innovations form: known input, a disturbance that moves the modes, and sensor noise.
//!
//! `z_k(t+1) = e^{λ_k Δ} z_k(t) + g_k u(t) + κ_kᵀ e(t)`,
//! `y(t) = Σ_k Re(c_k z_k(t)) + d u + b + e(t)`, e white with any covariance between channels; κ is
//! the gain of the Kalman filter, free (Ljung 1999, section 4.3). e is the error of the prediction
//! from the past, so the estimate is consistent with and without feedback of y into u, where that
//! of output error is not once a disturbance circulates in the loop.
//!
//! All unknowns are sought together, by Gauss–Newton on `N/2 ln det Σ e eᵀ`; the sensitivities
//! `∂z/∂p`, `∂e/∂p` obey the recursion of the predictor itself. Cost per iteration:
//! N P (6 m l + P l/2) multiply-adds for P = m (4 + 4 l) + 2 l unknowns of m modes, l channels.

mod predictor;

use crate::mac::normalised;
use crate::maximum_likelihood::{Evaluation, Fit, Model, Outputs, frequency_and_damping, solve};
use crate::record::Record;
use faer::{Mat, c64};
use predictor::{Predictor, Step};

const ITERATIONS_MAX: usize = 60;
/// Predicted gain in log-likelihood below which the iteration ends: 1e-2 of a standard deviation.
const GAIN_MIN: f64 = 1e-4;
/// First damping of a step that made matters worse, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps.
const DAMPING_MAX: f64 = 1e8;
/// Multiply-adds of an iteration beyond which the form is not tried: a second of one core.
const WORK_MAX: f64 = 1e9;

/// Maximum likelihood of the innovations form from the poles of an output-error fit, and
/// `−2 ln L + unknowns · ln(samples · channels)`.
///
/// `None` with several inputs, with too much work, or if the record does not determine the unknowns.
pub(crate) fn fit(record: &Record, model: Model, outputs: &Outputs, poles: &[c64]) -> Option<(f64, Fit)> {
    let (m, l, n) = (poles.len(), record.channels, outputs.present.len() as f64);
    let unknowns = (m * (4 + 4 * l) + 2 * l) as f64;
    if record.inputs != 1 || n < 2.0 * unknowns || n * unknowns * unknowns * l as f64 > 2.0 * WORK_MAX {
        return None;
    }
    let mut at = Predictor::of_output_error(&Evaluation::new(record, model, outputs, poles), poles);
    let mut now = at.linearised(record, model, outputs)?;
    let (mut damping, mut iterations, mut converged) = (0.0, 0, false);
    while iterations < ITERATIONS_MAX && damping < DAMPING_MAX {
        iterations += 1;
        let full = solve(&now.information, &now.score, 1e-12)?;
        let gain: f64 = full.iter().zip(&now.score).map(|(step, score)| 0.5 * step * score).sum();
        converged = gain < GAIN_MIN;
        if converged || !gain.is_finite() {
            break;
        }
        let tried = at.moved(&solve(&now.information, &now.score, damping)?);
        match tried.cost(record, model, outputs) {
            Some(cost) if cost <= now.cost => {
                now = tried.linearised(record, model, outputs)?;
                at = tried;
                damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
            }
            _ => damping = (10.0 * damping).max(FIRST_DAMPING),
        }
    }
    let criterion = 2.0 * now.cost + unknowns * libm::log(n * l as f64);
    Some((criterion, at.finish(now, outputs, (iterations, converged))?))
}

impl Predictor {
    fn finish(&self, now: Step, outputs: &Outputs, (iterations, converged): (usize, bool)) -> Option<Fit> {
        let m = self.poles.len();
        let size = now.score.len();
        // The poles come first among the unknowns of each mode.
        let at = |k: usize| self.first_of(k / 2) + k % 2;
        let mut marginal = Mat::<f64>::zeros(2 * m, 2 * m);
        for column in 0..2 * m {
            let unit: Vec<f64> = (0..size).map(|row| f64::from(u8::from(row == at(column)))).collect();
            let solved = solve(&now.information, &unit, 1e-12)?;
            (0..2 * m).for_each(|row| marginal[(row, column)] = solved[at(row)]);
        }
        let unsorted = frequency_and_damping(&marginal, &self.poles);
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|a, b| self.poles[*a].norm_sqr().total_cmp(&self.poles[*b].norm_sqr()));
        let from = |sorted: usize| 2 * order[sorted / 2] + sorted % 2;
        let n = outputs.present.len() as f64;
        let power = |e: &Vec<f64>| e.iter().map(|e| e * e).sum::<f64>() / n;
        Some(Fit {
            poles: order.iter().map(|k| self.poles[*k]).collect(),
            covariance: (0..4 * m * m).map(|k| unsorted[from(k / (2 * m)) * 2 * m + from(k % (2 * m))]).collect(),
            mode_shapes: order.iter().map(|k| normalised(self.shapes[*k].iter().copied())).collect(),
            channel_sigma: now.innovations.iter().map(|e| power(e).sqrt()).collect(),
            residuals: now.innovations,
            iterations,
            converged,
        })
    }
}
