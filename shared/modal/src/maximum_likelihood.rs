//! Maximum likelihood modes of a record with known input, or of a free decay, by variable
//! projection.
//!
//! `y_i(t) = Σ_k Re(c_ik z_k(t)) + d_i u(t) + b_i + e_i(t)`, `z_k' = λ_k z_k + u`, e white with a
//! variance per channel. A row of which an output is not a number is absent from the likelihood;
//! the states run through it. Only the poles are sought by iteration; residues, direct terms and
//! biases follow from them by least squares (Golub & Pereyra 1973), and the Jacobian is that of
//! Kaufman 1975, `P⊥ (∂Φ/∂λ) c`, whose Gram matrix is the Fisher information of the poles with all
//! linear unknowns marginalised. Nothing is fed back from the output into the regressors, so a
//! controller that closes a loop around the structure does no harm as long as its commands are
//! known.
//!
//! Cost per iteration: 4 N m² + 2 N m l multiply-adds for m linear columns and l channels.

mod basis;
mod evaluation;
pub(crate) mod information;
pub(crate) mod scan;
mod start;

use crate::mac::modal_phase_collinearity;
use crate::projection::{add, dot};
use crate::record::Record;
use evaluation::mode_shape;
use faer::c64;
use information::covariance;

pub(crate) use basis::{driven, exp, free_columns};
pub(crate) use evaluation::{Evaluation, Outputs};
pub(crate) use information::{frequency_and_damping, solve};
pub use start::start;

const ITERATIONS_MAX: usize = 60;
/// Predicted gain in log-likelihood below which the iteration ends: 1e-4 of a standard deviation.
const GAIN_MIN: f64 = 1e-8;
/// First damping of a step that made matters worse, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;

/// Terms of the model besides forced modes and direct terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    /// The structure moves at the first sample: two more columns per mode.
    pub initial_motion: bool,
    /// A constant per channel.
    pub bias: bool,
    /// The sample at which the direct term of an input arrives.
    pub feedthrough: Feedthrough,
}

/// The sample of the outputs that the direct term of an input reaches first.
///
/// Held inputs of which `u_t` is computed from `y_t` contain the noise of that very sample: with a
/// direct term at the same sample the inverse of the controller explains the record, noise and all.
/// A model of a loop is identifiable only if plant or controller has a delay (Söderström & Stoica
/// 1989, section 10.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedthrough {
    /// `d u_t`: acceleration just after the input has switched.
    SameSample,
    /// `d u_{t−1}`: all that moves faster than the samples has arrived by the next one.
    NextSample,
}

impl Model {
    /// At rest until the input acts, sensors with bias.
    pub const FORCED: Model = Model { initial_motion: false, bias: true, feedthrough: Feedthrough::SameSample };
    /// Moving from the first sample on, sensors with bias.
    pub const FREE: Model = Model { initial_motion: true, ..Model::FORCED };

    /// Columns per channel for a number of modes, dependent ones included.
    #[must_use]
    pub fn columns(self, modes: usize, inputs: usize) -> usize {
        2 * modes * (inputs + usize::from(self.initial_motion)) + inputs + usize::from(self.bias)
    }
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum MlError {
    /// As many unknowns as samples, or too few of them to find a start.
    RecordTooShort { samples: usize, need: usize },
    /// All channels are flat.
    NoSignal,
    /// The record does not distinguish the poles.
    NotIdentifiable { modes: usize },
    /// No poles to start from.
    NoStart { found: usize, asked: usize },
}

impl std::fmt::Display for MlError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::RecordTooShort { samples, need } => write!(f, "{samples} samples in the record, {need} needed"),
            Self::NoSignal => write!(f, "all channels are flat"),
            Self::NotIdentifiable { modes } => write!(f, "{modes} modes leave no trace that could be told apart"),
            Self::NoStart { found, asked } => write!(f, "{found} oscillations to start from, {asked} asked for"),
        }
    }
}

impl std::error::Error for MlError {}

/// Poles with everything that belongs to them.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Continuous-time poles [1/s], imaginary part positive, in order of frequency.
    pub poles: Vec<c64>,
    /// Covariance of (f₁ \[Hz\], ζ₁, f₂, ζ₂, …), row by row, from the Fisher information at the
    /// variances found.
    pub covariance: Vec<f64>,
    /// Residues per channel of the input (or initial motion) that moves the mode most, largest
    /// component 1.
    pub mode_shapes: Vec<Vec<c64>>,
    /// Standard deviation of the residuals, per channel.
    pub channel_sigma: Vec<f64>,
    /// `y − ŷ`, channel by channel; zero where the sample is absent.
    pub residuals: Vec<Vec<f64>>,
    pub iterations: usize,
    /// The gain fell below `GAIN_MIN` before the iterations ended.
    pub converged: bool,
}

impl Fit {
    /// Natural frequency `|λ| / 2π` \[Hz\].
    #[must_use]
    pub fn frequency_hz(&self, mode: usize) -> f64 {
        self.poles[mode].norm_sqr().sqrt() / (2.0 * std::f64::consts::PI)
    }

    /// `−Re λ / |λ|`.
    #[must_use]
    pub fn damping_ratio(&self, mode: usize) -> f64 {
        -self.poles[mode].re / self.poles[mode].norm_sqr().sqrt()
    }

    /// Variance of f, variance of ζ and their covariance.
    #[must_use]
    pub fn variances(&self, mode: usize) -> (f64, f64, f64) {
        let (n, f) = (2 * self.poles.len(), 2 * mode);
        (self.covariance[f * n + f], self.covariance[(f + 1) * n + f + 1], self.covariance[f * n + f + 1])
    }

    /// Modal phase collinearity of the shape: 1 for a real mode.
    #[must_use]
    pub fn phase_collinearity(&self, mode: usize) -> f64 {
        modal_phase_collinearity(&self.mode_shapes[mode])
    }

    /// Mean square of the residuals' correlations at lags 1–20 over that of white noise: 1 if the
    /// residuals are white.
    #[must_use]
    pub fn residual_correlation(&self) -> f64 {
        correlation(&self.residuals)
    }
}

/// Mean square of the correlations at lags 1–20 of some residuals over that of white noise.
fn correlation(residuals: &[Vec<f64>]) -> f64 {
    const LAGS: usize = 20;
    let mut sum = 0.0;
    for residual in residuals {
        let power = dot(residual, residual).max(f64::MIN_POSITIVE);
        for lag in 1..=LAGS.min(residual.len() - 1) {
            let at_lag = dot(&residual[lag..], &residual[..residual.len() - lag]) / power;
            sum += at_lag * at_lag * residual.len() as f64;
        }
    }
    sum / (LAGS * residuals.len()) as f64
}

/// Maximum likelihood poles from `start` (continuous time, imaginary parts positive).
///
/// # Errors
/// [`MlError`] when the record is shorter than the unknowns, flat, or blind to the poles.
pub fn fit(record: &Record, model: Model, start: &[c64]) -> Result<Fit, MlError> {
    let unknowns = 2 * start.len() * (record.inputs + usize::from(model.initial_motion)) + record.inputs + 1;
    let need = unknowns + 2 * start.len() + 1;
    let outputs = Outputs::new(record);
    if outputs.present.len() < need {
        return Err(MlError::RecordTooShort { samples: outputs.present.len(), need });
    }
    if outputs.floor.iter().all(|floor| *floor == 0.0) {
        return Err(MlError::NoSignal);
    }
    let blind = || MlError::NotIdentifiable { modes: start.len() };
    let mut poles = start.to_vec();
    let mut now = Evaluation::new(record, model, &outputs, &poles);
    let (mut damping, mut iterations, mut converged) = (0.0, 0, false);
    while iterations < ITERATIONS_MAX && !converged {
        iterations += 1;
        let weights: Vec<f64> = now.squares.iter().map(|s| weight(*s, now.columns.rows as f64)).collect();
        let (information, score) = now.information(&weights);
        // judged undamped: a short step is no minimum
        let full = solve(&information, &score, 0.0).ok_or_else(blind)?;
        let gain = 0.5 * dot(&full, &score);
        if !gain.is_finite() {
            return Err(blind());
        }
        converged = gain < GAIN_MIN;
        if converged {
            break;
        }
        let step = solve(&information, &score, damping).ok_or_else(blind)?;
        let tried: Vec<c64> = poles.iter().zip(step.chunks_exact(2)).map(|(p, d)| p + c64::new(d[0], d[1])).collect();
        let next = tried.iter().all(|pole| pole.im > 0.0).then(|| Evaluation::new(record, model, &outputs, &tried));
        match next {
            Some(next) if next.cost() <= now.cost() => {
                (poles, now) = (tried, next);
                damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
            }
            _ => damping = (10.0 * damping).max(FIRST_DAMPING),
        }
    }
    let mut order: Vec<usize> = (0..poles.len()).collect();
    order.sort_by(|a, b| poles[*a].norm_sqr().total_cmp(&poles[*b].norm_sqr()));
    finish(&outputs, now, &poles, &order, (iterations, converged)).ok_or_else(blind)
}

/// As [`fit`]; of a record that moves before its input acts, the fit with that motion, and the
/// model it is of.
///
/// The motion is part of the model when `2 ln L` gains more by it than its unknowns cost (Schwarz
/// 1978): `Σ_i N ln(RSS_i / RSS_i')` against `unknowns · ln(samples · channels)`, at the poles of
/// the fit without.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_motion(record: &Record, model: Model, start: &[c64]) -> Result<(Fit, Model), MlError> {
    let at_rest = fit(record, model, start)?;
    if model.initial_motion {
        return Ok((at_rest, model));
    }
    let moving = Model { initial_motion: true, ..model };
    let outputs = Outputs::new(record);
    let cost = |model: Model| Evaluation::new(record, model, &outputs, &at_rest.poles).cost();
    let price = (2 * start.len() * record.channels) as f64 * libm::log((record.samples() * record.channels) as f64);
    if 2.0 * (cost(model) - cost(moving)) <= price {
        return Ok((at_rest, model));
    }
    Ok(fit(record, moving, start).map_or((at_rest, model), |found| (found, moving)))
}

/// Covariance of (f₁, ζ₁, …) that no unbiased estimator can undercut: poles and outputs without
/// noise, `sigma` per channel.
///
/// The Cramér–Rao bound with residues, direct terms and biases unknown. `None` when a pole leaves
/// no trace.
#[must_use]
pub fn bound(noise_free: &Record, model: Model, poles: &[c64], sigma: &[f64]) -> Option<Vec<f64>> {
    let evaluation = Evaluation::new(noise_free, model, &Outputs::new(noise_free), poles);
    let weights: Vec<f64> = sigma.iter().map(|s| 1.0 / (s * s)).collect();
    covariance(&evaluation.information(&weights).0, poles)
}

fn weight(squares: f64, freedom: f64) -> f64 {
    if squares > 0.0 { freedom / squares } else { 0.0 }
}

fn finish(
    outputs: &Outputs,
    now: Evaluation,
    poles: &[c64],
    order: &[usize],
    (iterations, converged): (usize, bool),
) -> Option<Fit> {
    let freedom =
        (now.columns.rows - now.basis.rank()) as f64 - 2.0 * poles.len() as f64 / outputs.channels.len() as f64;
    let weights: Vec<f64> = now.squares.iter().map(|s| weight(*s, freedom)).collect();
    let unsorted = covariance(&now.information(&weights).0, poles)?;
    let n = 2 * poles.len();
    let at = |sorted: usize| 2 * order[sorted / 2] + sorted % 2;
    let sorted = (0..n * n).map(|k| unsorted[at(k / n) * n + at(k % n)]).collect();
    Some(Fit {
        poles: order.iter().map(|k| poles[*k]).collect(),
        covariance: sorted,
        mode_shapes: order.iter().map(|k| mode_shape(&now, *k)).collect(),
        channel_sigma: now.squares.iter().map(|s| (s / freedom).sqrt()).collect(),
        residuals: now.residuals.iter().map(|residual| outputs.spread(residual)).collect(),
        iterations,
        converged,
    })
}

/// Shape of a mode at an evaluation.
pub(crate) use evaluation::mode_shape as shape_of;

/// Shapes of the modes at `poles` in a record: one linear least squares.
pub(crate) fn linear_shapes(record: &Record, model: Model, poles: &[c64]) -> Vec<Vec<c64>> {
    let evaluation = Evaluation::new(record, model, &Outputs::new(record), poles);
    (0..poles.len()).map(|k| mode_shape(&evaluation, k)).collect()
}

/// The part of a record that modes at given `poles` explain, channel by channel: one linear least
/// squares, also where samples are absent.
#[must_use]
pub fn explained(record: &Record, model: Model, poles: &[c64]) -> Vec<Vec<f64>> {
    let at = Evaluation::new(record, model, &Outputs::new(record), poles);
    let columns = basis::Columns::new(record, model, poles);
    let of = |coefficients: &Vec<f64>| {
        let mut y = vec![0.0; columns.rows];
        for (c, column) in coefficients.iter().zip(columns.linear.chunks_exact(columns.rows)) {
            add(&mut y, *c, column);
        }
        y
    };
    at.coefficients.iter().map(of).collect()
}
