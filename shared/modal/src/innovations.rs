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
use crate::maximum_likelihood::{Evaluation, Feedthrough, Fit, Model, Outputs, frequency_and_damping, solve};
use crate::projection::{Basis, dot};
use crate::record::Record;
use faer::{Mat, c64};
use predictor::{Predictor, Step};

const INNOVATIONS_ITERATIONS_MAX: usize = 30;
/// Predicted gain in log-likelihood below which the iteration ends: 1e-2 of a standard deviation.
const INNOVATIONS_GAIN_MIN: f64 = 1e-4;
/// First damping of a step that made matters worse, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps.
const DAMPING_MAX: f64 = 1e8;
/// Lags of the long autoregression at most, and its regressors.
const LAGS_MAX: usize = 40;
const REGRESSORS_MAX: usize = 120;
/// Channels of which the innovations are inputs of the start.
const SOURCES_MAX: usize = 3;
/// Multiply-adds of an iteration beyond which the form is not tried: a second of one core.
const WORK_MAX: f64 = 1e9;

/// A record with innovations of some channels as inputs behind its own.
pub(crate) struct Driven {
    pub record: Record,
    /// The channel of each.
    channels: Vec<usize>,
}

/// The record with innovations as further inputs: residuals of an autoregression of the outputs on
/// the past of outputs and input (and the input of the sample itself if `model` has it), of at most
/// three channels, those that the past predicts best.
///
/// `None` with several inputs or a record too short.
pub(crate) fn with_innovations(record: &Record, model: Model, outputs: &Outputs) -> Option<Driven> {
    let (l, n) = (record.channels, outputs.samples);
    let lags = LAGS_MAX.min(REGRESSORS_MAX / (1 + l)).min(n / (10 * (1 + l)));
    if record.inputs != 1 || lags < 4 {
        return None;
    }
    let channels: Vec<Vec<f64>> = outputs.channels.iter().map(|y| outputs.spread(y)).collect();
    let rows = n - lags;
    let series = std::iter::once(&record.input).chain(&channels);
    let past = series.flat_map(|x| (1..=lags).flat_map(move |lag| x[lags - lag..n - lag].iter().copied()));
    let same = (model.feedthrough == Feedthrough::SameSample).then(|| record.input[lags..].iter().copied());
    let basis =
        Basis::new(std::iter::repeat_n(1.0, rows).chain(same.into_iter().flatten()).chain(past).collect(), rows);
    let mut found: Vec<(f64, usize, Vec<f64>)> = Vec::new();
    for (i, y) in channels.iter().enumerate() {
        let mut e = y[lags..].to_vec();
        basis.project_out(&mut e);
        found.push((dot(&y[lags..], &y[lags..]) / dot(&e, &e).max(f64::MIN_POSITIVE), i, e));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    found.truncate(SOURCES_MAX);
    found.sort_by_key(|(_, i, _)| *i);
    let there = outputs.spread(&vec![1.0; outputs.present.len()]);
    let heard = |e: &[f64], t: usize| if t < lags { 0.0 } else { there[t] * e[t - lags] };
    let row = |t: usize| std::iter::once(record.input[t]).chain(found.iter().map(move |(_, _, e)| heard(e, t)));
    let inputs = 1 + found.len();
    let input = (0..n).flat_map(|t| row(t).collect::<Vec<_>>()).collect();
    let channels = found.iter().map(|(_, i, _)| *i).collect();
    Some(Driven { record: record.clone().with_input(inputs, input), channels })
}

/// Maximum likelihood of the innovations form from the poles of a fit with innovations as inputs,
/// and `−2 ln L + unknowns · ln(samples · channels)`.
///
/// `None` with several inputs, with too much work, or if the record does not determine the
/// unknowns.
pub(crate) fn fit(
    (record, driven): (&Record, &Driven),
    model: Model,
    outputs: &Outputs,
    poles: &[c64],
) -> Option<(f64, Fit)> {
    if !affordable(record, outputs, poles.len()) {
        return None;
    }
    let start = Evaluation::new(&driven.record, model, outputs, poles);
    let mut at = Predictor::of_residues(&start, poles, &driven.channels, 1.0 / record.sample_rate_hz);
    if at.cost(record, model, outputs).is_none() {
        at.without_gains();
    }
    let mut now = at.linearised(record, model, outputs)?;
    let (mut damping, mut iterations, mut converged) = (0.0, 0, false);
    while iterations < INNOVATIONS_ITERATIONS_MAX && damping < DAMPING_MAX {
        iterations += 1;
        let full = solve(&now.information, &now.score, 1e-12)?;
        let gain: f64 = full.iter().zip(&now.score).map(|(step, score)| 0.5 * step * score).sum();
        converged = gain < INNOVATIONS_GAIN_MIN;
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
    let values = (outputs.present.len() * record.channels) as f64;
    let criterion = 2.0 * now.cost + unknowns(poles.len(), record.channels) * libm::log(values);
    Some((criterion, at.finish(now, outputs, (iterations, converged))?))
}

/// Standard deviations of f \[Hz\] and ζ of an output-error fit at `poles`, mode by mode, if the
/// gains were free: one linearisation at gain zero.
///
/// `None` as for [`fit`].
pub(crate) fn deviations(record: &Record, model: Model, outputs: &Outputs, poles: &[c64]) -> Option<Vec<(f64, f64)>> {
    if !affordable(record, outputs, poles.len()) {
        return None;
    }
    let at = Predictor::of_residues(&Evaluation::new(record, model, outputs, poles), poles, &[], 1.0);
    let found = at.finish(at.linearised(record, model, outputs)?, outputs, (0, true))?;
    Some((0..poles.len()).map(|k| (found.variances(k).0.sqrt(), found.variances(k).1.sqrt())).collect())
}

/// One input, enough samples, and an iteration within [`WORK_MAX`].
fn affordable(record: &Record, outputs: &Outputs, modes: usize) -> bool {
    let (l, n) = (record.channels as f64, outputs.present.len() as f64);
    let unknowns = unknowns(modes, record.channels);
    record.inputs == 1 && n >= 2.0 * unknowns && n * unknowns * unknowns * l <= 2.0 * WORK_MAX
}

fn unknowns(modes: usize, channels: usize) -> f64 {
    (modes * (4 + 4 * channels) + 2 * channels) as f64
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
