//! The model at one set of poles: coefficients, residuals, and the information on the poles.

use super::Model;
use super::basis::Columns;
use crate::projection::{Basis, dot};
use crate::record::Record;
use faer::{Mat, c64};

/// Part of a channel's power that counts as rounding.
const ROUNDING: f64 = 1e-26;

/// The model at one set of poles.
pub(crate) struct Evaluation {
    pub columns: Columns,
    pub basis: Basis,
    /// Coefficients of the linear columns, per channel.
    pub coefficients: Vec<Vec<f64>>,
    pub residuals: Vec<Vec<f64>>,
    /// Residual sum of squares per channel.
    pub squares: Vec<f64>,
}

/// Outputs channel by channel, and the power below which a channel's residual is rounding.
pub(crate) struct Outputs {
    pub channels: Vec<Vec<f64>>,
    pub floor: Vec<f64>,
    /// Rows of the record that are there: every output is a number.
    pub present: Vec<usize>,
    /// Rows of the record.
    pub samples: usize,
}

impl Outputs {
    /// Outputs of a record by channel, with the rounding floor of their squares.
    pub fn new(record: &Record) -> Self {
        let rows = record.outputs.chunks_exact(record.channels).enumerate();
        let present: Vec<usize> = rows.filter(|(_, row)| row.iter().all(|y| y.is_finite())).map(|(t, _)| t).collect();
        let of = |c: usize| present.iter().map(|t| record.outputs[t * record.channels + c]).collect();
        let channels: Vec<Vec<f64>> = (0..record.channels).map(of).collect();
        let floor = channels.iter().map(|y| ROUNDING * dot(y, y)).collect();
        Self { channels, floor, present, samples: record.samples() }
    }

    /// A column over the rows present as one over all, zero where a row is absent.
    pub fn spread(&self, column: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.samples];
        self.present.iter().zip(column).for_each(|(t, x)| all[*t] = *x);
        all
    }
}

impl Evaluation {
    /// Projects the outputs on the columns of `poles`: coefficients, residuals and squares per
    /// channel.
    pub fn new(record: &Record, model: Model, outputs: &Outputs, poles: &[c64]) -> Self {
        let mut columns = Columns::new(record, model, poles);
        if outputs.present.len() < columns.rows {
            columns = columns.at(&outputs.present);
        }
        let basis = Basis::new(columns.linear.clone(), columns.rows);
        let (mut coefficients, mut residuals, mut squares) = (Vec::new(), Vec::new(), Vec::new());
        for (y, floor) in outputs.channels.iter().zip(&outputs.floor) {
            let mut residual = y.clone();
            coefficients.push(basis.coefficients(basis.project_out(&mut residual)));
            squares.push(dot(&residual, &residual).max(*floor));
            residuals.push(residual);
        }
        Self { columns, basis, coefficients, residuals, squares }
    }

    /// `Σ N/2 ln RSS_i`: minus the log-likelihood with the variances at their best.
    pub fn cost(&self) -> f64 {
        let logarithms = self.squares.iter().filter(|s| **s > 0.0).map(|s| libm::log(*s));
        0.5 * self.columns.rows as f64 * logarithms.sum::<f64>()
    }

    /// `s`: the derivative of one channel by one real or imaginary part, as coefficients of the
    /// derivative columns of that mode.
    fn direction(&self, channel: usize, parameter: usize) -> Vec<f64> {
        let (mode, imaginary) = (parameter / 2, parameter % 2 == 1);
        let width = 2 * self.columns.pairs;
        let of_mode = &self.coefficients[channel][mode * width..(mode + 1) * width];
        // y = a Re z + b Im z; ∂z/∂Re λ = w, ∂z/∂Im λ = i w.
        let turn = |ab: &[f64]| if imaginary { [ab[1], -ab[0]] } else { [ab[0], ab[1]] };
        of_mode.chunks_exact(2).flat_map(turn).collect()
    }

    /// Information matrix and score of (Re λ₁, Im λ₁, …) with a weight (inverse variance) per
    /// channel.
    pub fn information(&self, weights: &[f64]) -> (Mat<f64>, Vec<f64>) {
        let rows = self.columns.rows;
        let width = 2 * self.columns.pairs;
        let mut beside = self.columns.derivative.clone();
        for column in beside.chunks_exact_mut(rows) {
            self.basis.project_out(column);
        }
        let columns: Vec<&[f64]> = beside.chunks_exact(rows).collect();
        let gram =
            Mat::from_fn(columns.len(), columns.len(), |a, b| if a <= b { dot(columns[a], columns[b]) } else { 0.0 });
        let parameters = columns.len() / self.columns.pairs;
        let mut information = Mat::zeros(parameters, parameters);
        let mut score = vec![0.0; parameters];
        for (channel, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let directions: Vec<Vec<f64>> = (0..parameters).map(|p| self.direction(channel, p)).collect();
            let pull: Vec<f64> = columns.iter().map(|w| dot(w, &self.residuals[channel])).collect();
            for p in 0..parameters {
                let at_p = p / 2 * width;
                score[p] += weight * dot(&directions[p], &pull[at_p..at_p + width]);
                for q in 0..=p {
                    let at_q = q / 2 * width;
                    let mut sum = 0.0;
                    for (j, s) in directions[p].iter().enumerate() {
                        for (k, t) in directions[q].iter().enumerate() {
                            let (a, b) = (at_p + j, at_q + k);
                            sum += s * t * gram[(a.min(b), a.max(b))];
                        }
                    }
                    information[(p, q)] += weight * sum;
                }
            }
        }
        for p in 0..parameters {
            for q in p + 1..parameters {
                information[(p, q)] = information[(q, p)];
            }
        }
        (information, score)
    }
}

/// Residues of the pair of columns that carries most of the mode's power.
pub(crate) fn mode_shape(at: &Evaluation, mode: usize) -> Vec<c64> {
    let (pairs, rows) = (at.columns.pairs, at.columns.rows);
    let residues = |pair: usize| -> Vec<c64> {
        let column = 2 * (mode * pairs + pair);
        at.coefficients.iter().map(|c| c64::new(c[column], -c[column + 1])).collect()
    };
    let power = |pair: usize| {
        let column = 2 * (mode * pairs + pair);
        let z = &at.columns.linear[column * rows..(column + 2) * rows];
        dot(z, z) * residues(pair).iter().map(c64::norm_sqr).sum::<f64>()
    };
    let mut best = 0;
    for pair in 1..pairs {
        if power(pair) > power(best) {
            best = pair;
        }
    }
    crate::mac::normalised(residues(best).into_iter())
}
