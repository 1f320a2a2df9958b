//! Standard deviations of poles and shapes at the optimum.
//!
//! Poles: `F⁻¹ M F⁻¹`, F the Fisher information and M the covariance of its score. Of windowed
//! segments M has two parts: the sensors' noise, correlated as the window makes it, and what leaks
//! ([`super::leakage`]). Of other correlated residuals M is that of their correlation
//! ([`crate::residual_correlation`]) and, where the residual is not noise alone, that of the scores
//! of the lines (White 1982), the larger of the two and nowhere below `F⁻¹`. Shapes: a residue
//! moves with the noise through the linear columns and with the poles,
//! `δr = Φ⁺ e − Φ⁺ (∂Φ/∂λ r) δλ`, the two independent; a component `ψ = r/r_max` by
//! `δψ = (δr − ψ δr_max)/r_max`. What the fit misses of the optimum is an error of the model, and
//! its square beside the variance.

use super::lines::ResponseLines;
use super::refinement::{Fit, Refined};
use super::{ResponseMode, leakage};
use crate::lag_window::Window;
use crate::maximum_likelihood::information::inverse;
use crate::residual_correlation::{inflation, lines_of, score_covariance, score_scatter};
use crate::separable::{deviations, frequency_and_damping, sandwich};
use faer::{Mat, Scale, c64};

/// Modes of a fit, in the order of its poles.
pub(super) fn modes(lines: &ResponseLines, found: &Refined) -> Option<Vec<ResponseMode>> {
    let at = &found.fit.at;
    if at.poles.is_empty() {
        return Some(Vec::new());
    }
    let covariance = covariance(lines, found)?;
    let residues = Residues::new(&found.fit, inflation(&found.correlations));
    let mode = |k: usize| {
        let block = [
            [covariance[(2 * k, 2 * k)], covariance[(2 * k, 2 * k + 1)]],
            [covariance[(2 * k + 1, 2 * k)], covariance[(2 * k + 1, 2 * k + 1)]],
        ];
        let (frequency_hz, damping_ratio) = frequency_and_damping(at.poles[k]);
        let (frequency_sd, damping_sd) = deviations(at.poles[k], block);
        let (mode_shape, shape_sd) = residues.shape(k, &covariance);
        ResponseMode { pole: at.poles[k], frequency_hz, damping_ratio, frequency_sd, damping_sd, mode_shape, shape_sd }
    };
    // A mode above the lines is part of the model, and not measured.
    Some((0..at.poles.len()).filter(|k| at.poles[*k].im <= lines.last()).map(mode).collect())
}

/// Of (Re λ₁, Im λ₁, …), with what the model misses.
fn covariance(lines: &ResponseLines, found: &Refined) -> Option<Mat<f64>> {
    let fit = &found.fit;
    let information = fit.at.information(&fit.noise.weights).0;
    let mut covariance = inverse(&information)?;
    if let Some(window) = fit.window {
        covariance = sandwich(&information, &of_windows(lines, fit, window))?;
    }
    // Residuals that are correlated over more lines than a window makes them have a remainder of
    // the model in them.
    if found.correlations.len() > fit.reach() {
        let (by_correlation, by_lines) = scores(found);
        covariance = at_least(&sandwich(&information, &by_correlation)?, &covariance);
        covariance = at_least(&sandwich(&information, &by_lines)?, &covariance);
    }
    for (p, error) in fit.model_error.iter().enumerate() {
        covariance[(p, p)] += error * error;
    }
    Some(covariance)
}

/// Covariance of the score of lines of windowed segments.
fn of_windows(lines: &ResponseLines, fit: &Fit, window: Window) -> Mat<f64> {
    let of_leakage = leakage::score_covariance(lines, window, &fit.at, &fit.noise.weights);
    let mut sum = of_leakage * Scale(fit.noise.proportion);
    // Products of two transforms.
    let neighbours: Vec<c64> = window.of_neighbours()[1..].iter().map(|rho| c64::new(rho * rho, 0.0)).collect();
    for (channel, weights) in fit.noise.weights.iter().enumerate() {
        let share = |row: usize| fit.noise.floors[channel].sqrt() * weights[2 * row];
        let of_noise = |row: &Vec<f64>| -> Vec<c64> {
            lines_of(row, 2).iter().enumerate().map(|(line, x)| x * share(line)).collect()
        };
        let jacobian: Vec<Vec<c64>> = fit.at.jacobian(channel, weights).iter().map(of_noise).collect();
        sum += score_covariance(&jacobian, &neighbours);
    }
    sum
}

/// Covariances of the score: by the correlation of all residuals, and by the lines' own scores.
fn scores(found: &Refined) -> (Mat<f64>, Mat<f64>) {
    let fit = &found.fit;
    let n = 2 * fit.at.poles.len();
    let mut by_correlation = Mat::<f64>::zeros(n, n);
    let mut of_lines: Vec<Vec<f64>> = vec![Vec::new(); n];
    for (channel, weights) in fit.noise.weights.iter().enumerate() {
        let jacobian = fit.at.jacobian(channel, weights);
        let residual = &fit.at.channels[channel].residual;
        for (sums, slope) in of_lines.iter_mut().zip(&jacobian) {
            sums.resize(slope.len() / 2, 0.0);
            let products = slope.chunks_exact(2).zip(residual.chunks_exact(2));
            sums.iter_mut().zip(products).for_each(|(sum, (x, e))| *sum += x[0] * e[0] + x[1] * e[1]);
        }
        let of_channel: Vec<Vec<c64>> = jacobian.iter().map(|row| lines_of(row, 2)).collect();
        by_correlation += score_covariance(&of_channel, &found.correlations);
    }
    (by_correlation, score_scatter(&of_lines, found.correlations.len()))
}

/// `wide` with every variance that is below that of `least` raised to it.
fn at_least(wide: &Mat<f64>, least: &Mat<f64>) -> Mat<f64> {
    let n = wide.nrows();
    let factor: Vec<f64> =
        (0..n).map(|p| (least[(p, p)] / wide[(p, p)].max(f64::MIN_POSITIVE)).max(1.0).sqrt()).collect();
    Mat::from_fn(n, n, |p, q| wide[(p, q)] * factor[p] * factor[q])
}

/// Residues of every channel and how they move.
struct Residues {
    /// Per channel and pole.
    values: Vec<Vec<c64>>,
    /// Covariance of (Re r, Im r) by noise alone, per channel and pole.
    by_noise: Vec<Vec<[[f64; 2]; 2]>>,
    /// Slope of every linear coefficient by every real number of the poles, per channel.
    by_poles: Vec<Vec<Vec<f64>>>,
}

impl Residues {
    fn new(fit: &Fit, inflation: f64) -> Self {
        let poles = fit.at.poles.len();
        let (mut values, mut by_noise, mut by_poles) = (Vec::new(), Vec::new(), Vec::new());
        for (c, channel) in fit.at.channels.iter().enumerate() {
            let q = &channel.coefficients;
            values.push((0..poles).map(|k| c64::new(q[2 * k], q[2 * k + 1])).collect());
            // Columns of R⁻¹.
            let unit = |j: usize| (0..q.len()).map(|k| f64::from(u8::from(k == j))).collect::<Vec<f64>>();
            let inverse: Vec<Vec<f64>> = (0..q.len()).map(|j| channel.basis.coefficients(unit(j))).collect();
            let product =
                |a: usize, b: usize| inflation * inverse.iter().map(|column| column[a] * column[b]).sum::<f64>();
            by_noise.push(
                (0..poles)
                    .map(|k| [2 * k, 2 * k + 1].map(|a| [product(a, 2 * k), product(a, 2 * k + 1)]))
                    .collect::<Vec<_>>(),
            );
            let slopes = fit.at.slopes(c, &fit.noise.weights[c]).into_iter().map(|mut slope| {
                let parts = channel.basis.project_out(&mut slope);
                channel.basis.coefficients(parts).into_iter().map(|x| -x).collect::<Vec<f64>>()
            });
            by_poles.push(slopes.collect::<Vec<_>>());
        }
        Self { values, by_noise, by_poles }
    }

    /// Shape of a mode and the standard deviations of its components.
    fn shape(&self, k: usize, covariance: &Mat<f64>) -> (Vec<c64>, Vec<c64>) {
        let residues: Vec<c64> = self.values.iter().map(|of_channel| of_channel[k]).collect();
        let mut largest = 0;
        for (c, r) in residues.iter().enumerate() {
            if r.norm_sqr() > residues[largest].norm_sqr() {
                largest = c;
            }
        }
        let whole = residues[largest];
        if whole.norm_sqr() == 0.0 {
            return (residues.clone(), vec![c64::new(0.0, 0.0); residues.len()]);
        }
        let shape: Vec<c64> = residues.iter().map(|r| r / whole).collect();
        let deviation = |c: usize| {
            if c == largest {
                return c64::new(0.0, 0.0);
            }
            // δψ = a δr_c + b δr_max
            let (a, b) = (c64::new(1.0, 0.0) / whole, -shape[c] / whole);
            let along: Vec<c64> = (0..covariance.nrows())
                .map(|p| {
                    let slope = |c: usize| c64::new(self.by_poles[c][p][2 * k], self.by_poles[c][p][2 * k + 1]);
                    a * slope(c) + b * slope(largest)
                })
                .collect();
            let (mut re, mut im) = (0.0, 0.0);
            for (p, x) in along.iter().enumerate() {
                for (q, y) in along.iter().enumerate() {
                    re += x.re * y.re * covariance[(p, q)];
                    im += x.im * y.im * covariance[(p, q)];
                }
            }
            for (factor, noise) in [(a, &self.by_noise[c][k]), (b, &self.by_noise[largest][k])] {
                let turned = |u: f64, v: f64| u * u * noise[0][0] + 2.0 * u * v * noise[0][1] + v * v * noise[1][1];
                re += turned(factor.re, -factor.im);
                im += turned(factor.im, factor.re);
            }
            c64::new(re.max(0.0).sqrt(), im.max(0.0).sqrt())
        };
        let deviations = (0..shape.len()).map(deviation).collect();
        (shape, deviations)
    }
}
