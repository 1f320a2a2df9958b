//! Weighted least squares that are linear but for the poles: variable projection over several
//! channels, each line of each with a standard deviation of its own.
//!
//! `y_c = Φ(λ) q_c + e_c`, Φ (rows × columns) common to the channels c = 1…C: a pair of columns per
//! pole and fixed ones. With the weights 1/σ of every row, only the poles λ (K of them, 2K real
//! numbers) are sought by iteration; `q_c` follows by least squares (Golub & Pereyra 1973), and the
//! Jacobian is Kaufman's, `P⊥ (∂Φ/∂λ) q_c`. Its Gram matrix is the Fisher information of the poles
//! with all `q_c` unknown.
//!
//! Cost per evaluation: 4 · C · rows · columns² multiply-adds.

use crate::maximum_likelihood::information::{inverse, solve};
use crate::projection::{Basis, add, dot};
use faer::{Mat, c64};

/// Steps of one search with weights held.
const STEPS_MAX: usize = 30;
/// Gain of the log-likelihood below which a search ends: a hundredth of a standard deviation.
const SEPARABLE_GAIN_MIN: f64 = 5e-5;
/// First damping of a step that made matters worse, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-3;

/// Columns of the model at some poles; complex lines are stacked as real and imaginary rows.
pub(crate) struct Columns {
    /// Two per pole.
    pub of_poles: Vec<Vec<f64>>,
    /// Their slopes `D₁, D₂`: a channel with coefficients (x, y) of a pole moves by `x D₁ + y D₂`
    /// along Re λ and by `x D₂ − y D₁` along Im λ.
    pub slopes: Vec<Vec<f64>>,
    /// Columns that no pole moves.
    pub fixed: Vec<Vec<f64>>,
}

/// One channel at its best coefficients.
pub(crate) struct Channel {
    pub basis: Basis,
    pub coefficients: Vec<f64>,
    /// `Φ q`, without weights.
    pub model: Vec<f64>,
    /// `(y − Φ q) / σ`.
    pub residual: Vec<f64>,
}

/// The model at some poles and weights.
pub(crate) struct Evaluation {
    pub poles: Vec<c64>,
    pub columns: Columns,
    pub channels: Vec<Channel>,
    /// Sum of the squared residuals.
    pub squares: f64,
}

fn weighted(column: &[f64], weights: &[f64]) -> Vec<f64> {
    column.iter().zip(weights).map(|(x, w)| x * w).collect()
}

impl Evaluation {
    /// Coefficients and residuals of `outputs` (per channel, of `rows` rows) with `weights` 1/σ.
    pub fn new(columns: Columns, poles: &[c64], outputs: &[Vec<f64>], weights: &[Vec<f64>]) -> Self {
        let channels: Vec<Channel> = outputs
            .iter()
            .zip(weights)
            .map(|(y, weights)| {
                let all = columns.of_poles.iter().chain(&columns.fixed);
                let basis = Basis::new(all.clone().flat_map(|column| weighted(column, weights)).collect(), y.len());
                let mut residual = weighted(y, weights);
                let coefficients = basis.coefficients(basis.project_out(&mut residual));
                let mut model = vec![0.0; y.len()];
                all.zip(&coefficients).for_each(|(column, q)| add(&mut model, *q, column));
                Channel { basis, coefficients, model, residual }
            })
            .collect();
        let squares = channels.iter().map(|channel| dot(&channel.residual, &channel.residual)).sum();
        Self { poles: poles.to_vec(), columns, channels, squares }
    }

    /// `∂(Φ q_c)/∂(Re λ₁, Im λ₁, …) / σ` of a channel, not yet beside its linear columns.
    pub fn slopes(&self, channel: usize, weights: &[f64]) -> Vec<Vec<f64>> {
        let q = &self.channels[channel].coefficients;
        let mut all = Vec::with_capacity(2 * self.poles.len());
        for (k, pair) in self.columns.slopes.chunks_exact(2).enumerate() {
            let (x, y) = (q[2 * k], q[2 * k + 1]);
            for (along_1, along_2) in [(x, y), (-y, x)] {
                let sum = pair[0].iter().zip(&pair[1]).zip(weights);
                all.push(sum.map(|((d_1, d_2), w)| (along_1 * d_1 + along_2 * d_2) * w).collect());
            }
        }
        all
    }

    /// The same with what the linear columns follow taken out: rows of Kaufman's Jacobian.
    pub fn jacobian(&self, channel: usize, weights: &[f64]) -> Vec<Vec<f64>> {
        let mut slopes = self.slopes(channel, weights);
        slopes.iter_mut().for_each(|slope| drop(self.channels[channel].basis.project_out(slope)));
        slopes
    }

    /// Fisher information and score of (Re λ₁, Im λ₁, …).
    pub fn information(&self, weights: &[Vec<f64>]) -> (Mat<f64>, Vec<f64>) {
        let n = 2 * self.poles.len();
        let (mut information, mut score) = (Mat::zeros(n, n), vec![0.0; n]);
        for (channel, weights) in weights.iter().enumerate() {
            let jacobian = self.jacobian(channel, weights);
            for p in 0..n {
                score[p] += dot(&jacobian[p], &self.channels[channel].residual);
                for q in 0..=p {
                    let product = dot(&jacobian[p], &jacobian[q]);
                    information[(p, q)] += product;
                    if q < p {
                        information[(q, p)] += product;
                    }
                }
            }
        }
        (information, score)
    }
}

/// Searches the poles of least squares with the weights held, from `poles`; `None` where the lines
/// do not determine them.
///
/// A pole stays above the real axis and decays: a step beyond is shortened.
pub(crate) fn search(
    columns: &dyn Fn(&[c64]) -> Columns,
    poles: &[c64],
    outputs: &[Vec<f64>],
    weights: &[Vec<f64>],
) -> Option<Evaluation> {
    let mut now = Evaluation::new(columns(poles), poles, outputs, weights);
    let mut damping = 0.0;
    for _ in 0..STEPS_MAX {
        if now.poles.is_empty() {
            break;
        }
        let (information, score) = now.information(weights);
        let step = solve(&information, &score, damping)?;
        let gain = 0.5 * dot(&step, &score);
        if !gain.is_finite() {
            return None;
        }
        if gain < SEPARABLE_GAIN_MIN && damping == 0.0 {
            break;
        }
        let tried: Vec<c64> =
            now.poles.iter().zip(step.chunks_exact(2)).map(|(pole, d)| pole + c64::new(d[0], d[1])).collect();
        let decays = tried.iter().all(|pole| pole.im > 0.0 && pole.re < 0.0);
        let next = decays.then(|| Evaluation::new(columns(&tried), &tried, outputs, weights));
        match next {
            Some(next) if next.squares <= now.squares => {
                now = next;
                damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
            }
            _ if damping > 1e8 => break,
            _ => damping = (10.0 * damping).max(FIRST_DAMPING),
        }
    }
    Some(now)
}

/// Covariance of (Re λ₁, Im λ₁, …): `F⁻¹ M F⁻¹` with F the information and M the covariance of the
/// score.
pub(crate) fn sandwich(information: &Mat<f64>, meat: &Mat<f64>) -> Option<Mat<f64>> {
    let inverse = inverse(information)?;
    Some(&inverse * meat * &inverse)
}

/// Standard deviations of frequency \[Hz\] and damping ratio of a pole with the covariance of its
/// real and imaginary part.
pub(crate) fn deviations(pole: c64, covariance: [[f64; 2]; 2]) -> (f64, f64) {
    let omega = pole.norm_sqr().sqrt();
    // f = |λ|/2π, ζ = −Re λ/|λ|
    let along = |slope: [f64; 2]| {
        let sum: f64 = (0..4).map(|k| slope[k / 2] * slope[k % 2] * covariance[k / 2][k % 2]).sum();
        sum.max(0.0).sqrt()
    };
    let frequency = along([pole.re / (core::f64::consts::TAU * omega), pole.im / (core::f64::consts::TAU * omega)]);
    let cube = omega * omega * omega;
    (frequency, along([-pole.im * pole.im / cube, pole.re * pole.im / cube]))
}

/// Natural frequency \[Hz\] and damping ratio of a pole.
pub(crate) fn frequency_and_damping(pole: c64) -> (f64, f64) {
    let omega = pole.norm_sqr().sqrt();
    (omega / core::f64::consts::TAU, -pole.re / omega)
}

/// Share of the rows of every channel that linear columns and poles take up.
pub(crate) fn leverages(at: &Evaluation, weights: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let inverse = inverse(&at.information(weights).0);
    let of_channel = |(channel, weights): (usize, &Vec<f64>)| {
        let mut sums = at.channels[channel].basis.leverage();
        let Some(inverse) = &inverse else { return sums };
        let jacobian = at.jacobian(channel, weights);
        for (p, of_p) in jacobian.iter().enumerate() {
            for (q, of_q) in jacobian.iter().enumerate() {
                let product = of_p.iter().zip(of_q).map(|(x, y)| x * y * inverse[(p, q)]);
                sums.iter_mut().zip(product).for_each(|(sum, x)| *sum += x);
            }
        }
        sums
    };
    weights.iter().enumerate().map(of_channel).collect()
}
