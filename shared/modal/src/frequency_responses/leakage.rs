//! Errors of responses that were measured under random force in windowed segments: how leakage
//! makes them, line with line and channel with channel.
//!
//! Of a segment, `U_k = ∫ W(ω_k − ν) dU(ν)` is the force and `Y_ck = ∫ W(ω_k − ν) H_c(ν) dU(ν)` the
//! motion of channel c at line k. What the response seen through the window, H_ck, does not explain
//! of it is `e_ck = ∫ W(ω_k − ν) (H_c(ν) − H_ck) dU(ν)`, and the response is wrong by the mean of
//! `e_ck Ū_k` over the segments, `E|U|² = 1`. Of normal force (Isserlis 1918)
//!
//! `E[e_ck Ū_k ē_dl U_l] = E[e_ck ē_dl] E[Ū_k U_l]`,
//! `E[e_ck Ū_k e_dl Ū_l] = E[e_ck Ū_l] E[e_dl Ū_k]`.
//!
//! Channels share the force: averaging them does not lessen these errors. The second moment, which
//! the noise of a sensor does not have, adds to the variance of the damping and takes from that of
//! the frequency: where a mode is much wider than a line, neighbours have covariances of 1/3 along
//! the damping and −1/3 along the frequency, in units of the variance of one line.
//!
//! Segments are taken for independent of each other. Half-overlapped ones change these figures by
//! less than a quarter.

use super::lines::{Noise, ResponseLines};
use crate::lag_window::Window;
use crate::residual_correlation::lines_of;
use crate::separable::Evaluation;
use faer::{Mat, c64};

/// Cells of the window's transform on either side of a line: the main lobe of the widest window has
/// five.
const WINDOW_CELLS: usize = 8;
/// Neighbours that share some of the force with a line.
const SHARED: usize = 6;
/// Points per cell of the integrals: one per half width of the narrowest mode, by which trapezia
/// err by e^(−2π); within these limits.
const POINTS_PER_CELL: (f64, f64) = (4.0, 32.0);

/// The window's transform at points about a line, `∫ W² = 1`.
struct Kernel {
    fine: usize,
    values: Vec<f64>,
}

impl Kernel {
    fn new(window: Window, fine: usize) -> Self {
        let at = |j: usize| window.transform((j as f64 - (WINDOW_CELLS * fine) as f64) / fine as f64);
        let values: Vec<f64> = (0..=2 * WINDOW_CELLS * fine).map(at).collect();
        let power = values.iter().map(|w| w * w).sum::<f64>() / fine as f64;
        Self { fine, values: values.iter().map(|w| w / power.sqrt()).collect() }
    }

    /// `∫ a(ν) b(ν) dν` of functions about lines that are `apart` cells apart, the second further
    /// on.
    fn product<A: Copy, B: Copy>(&self, a: &[A], b: &[B], apart: isize, times: impl Fn(A, B) -> c64) -> c64 {
        let shift = apart * self.fine as isize;
        let (skip_a, skip_b) = (shift.max(0) as usize, (-shift).max(0) as usize);
        let both = a.iter().skip(skip_a).zip(b.iter().skip(skip_b));
        both.fold(c64::new(0.0, 0.0), |sum, (a, b)| sum + times(*a, *b)) / self.fine as f64
    }
}

/// Correlations of the normalised residuals of neighbouring lines, from the next on: of the
/// sensors' noise the products of two transforms, of what leaks those of one transform and of `e`.
pub(super) fn neighbours(lines: &ResponseLines, window: Window, at: &Evaluation, noise: &Noise) -> Vec<f64> {
    let of_neighbours = window.of_neighbours();
    let kernel = Kernel::new(window, POINTS_PER_CELL.0 as usize);
    let mut sums = vec![0.0; of_neighbours.len()];
    for (c, weights) in noise.weights.iter().enumerate() {
        let channel = OfChannel::new(lines, at, c, &noise.weights, &kernel);
        let mut recent: Vec<(f64, Vec<c64>)> = Vec::new();
        for (line, weight) in weights.iter().step_by(2).enumerate() {
            let about = channel.response[line * kernel.fine..].iter().zip(&kernel.values);
            recent.insert(0, (*weight, about.map(|(h, w)| (h - channel.seen[line]) * *w).collect()));
            recent.truncate(sums.len());
            for (back, (earlier, rho)) in recent.iter().zip(&of_neighbours).enumerate() {
                let moment = kernel.product(&earlier.1, &recent[0].1, back as isize, |a: c64, b: c64| a.conj() * b).re;
                sums[back] += earlier.0 * weight * rho * (noise.floors[c] * rho + noise.proportion * moment);
            }
        }
    }
    sums[1..].iter().map(|sum| sum / sums[0]).collect()
}

/// Covariance of the score of (Re λ₁, Im λ₁, …) in shares of one segment, all channels together.
///
/// Cost: lines × points of the window × (channels × parameters + 3 parameters²).
pub(super) fn score_covariance(
    lines: &ResponseLines,
    window: Window,
    at: &Evaluation,
    weights: &[Vec<f64>],
) -> Mat<f64> {
    let n = 2 * at.poles.len();
    let cell = lines.cell();
    let narrowest = at.poles.iter().map(|pole| -pole.re / cell).fold(f64::INFINITY, f64::min);
    let kernel = Kernel::new(window, (1.0 / narrowest).ceil().clamp(POINTS_PER_CELL.0, POINTS_PER_CELL.1) as usize);
    let channels: Vec<OfChannel> = (0..weights.len()).map(|c| OfChannel::new(lines, at, c, weights, &kernel)).collect();
    let (count, of_neighbours) = (lines.count(), window.of_neighbours());
    // e of every parameter about the last lines, newest first.
    let mut recent: Vec<Vec<Vec<c64>>> = Vec::new();
    let mut with_force: Vec<Vec<Vec<c64>>> = Vec::with_capacity(count);
    let mut sum = Mat::<f64>::zeros(n, n);
    for line in 0..count {
        let about: Vec<Vec<c64>> = (0..n).map(|p| about_line(&channels, p, line, &kernel)).collect();
        recent.insert(0, about);
        recent.truncate(of_neighbours.len());
        for (back, (earlier, shared)) in recent.iter().zip(&of_neighbours).enumerate() {
            let moment = |p: usize, q: usize| {
                kernel.product(&earlier[p], &recent[0][q], back as isize, |a: c64, b: c64| a.conj() * b).re * shared
            };
            for p in 0..n {
                for q in 0..n {
                    sum[(p, q)] += moment(p, q) + if back > 0 { moment(q, p) } else { 0.0 };
                }
            }
        }
        let force = |e: &Vec<c64>, m: isize| kernel.product(e, &kernel.values, m, |a: c64, w: f64| a * w);
        let shared = SHARED as isize;
        with_force.push(recent[0].iter().map(|e| (-shared..=shared).map(|m| force(e, m)).collect()).collect());
    }
    for (line, of_line) in with_force.iter().enumerate() {
        for m in 0..=2 * SHARED {
            let Some(other) = (line + m).checked_sub(SHARED).and_then(|other| with_force.get(other)) else { continue };
            for p in 0..n {
                for q in 0..n {
                    sum[(p, q)] += (of_line[p][m] * other[q][2 * SHARED - m]).re;
                }
            }
        }
    }
    sum
}

/// What the errors of a channel need.
struct OfChannel {
    /// Of the modes, at the points of all lines.
    response: Vec<c64>,
    /// The same through the window, line by line.
    seen: Vec<c64>,
    /// Conjugate Jacobian over the deviation, per parameter and line.
    slopes: Vec<Vec<c64>>,
}

impl OfChannel {
    fn new(lines: &ResponseLines, at: &Evaluation, channel: usize, weights: &[Vec<f64>], kernel: &Kernel) -> Self {
        let q = &at.channels[channel].coefficients;
        let residues: Vec<c64> = (0..at.poles.len()).map(|k| c64::new(q[2 * k], q[2 * k + 1])).collect();
        let response = |j: usize| {
            let cells = j as f64 / kernel.fine as f64 - WINDOW_CELLS as f64;
            let s = c64::new(0.0, lines.first() + cells * lines.cell());
            let of = |(pole, r): (&c64, &c64)| r / (s - pole) + r.conj() / (s - pole.conj());
            at.poles.iter().zip(&residues).map(of).fold(c64::new(0.0, 0.0), |sum, x| sum + x)
        };
        let mut seen = vec![0.0; 2 * lines.count()];
        for (column, q) in at.columns.of_poles.iter().zip(q) {
            seen.iter_mut().zip(column).for_each(|(sum, x)| *sum += q * x);
        }
        let weights = &weights[channel];
        let slope = |row: &Vec<f64>| -> Vec<c64> {
            lines_of(row, 2).iter().zip(weights.iter().step_by(2)).map(|(x, w)| x.conj() * *w).collect()
        };
        Self {
            response: (0..=(lines.count() - 1 + 2 * WINDOW_CELLS) * kernel.fine).map(response).collect(),
            seen: lines_of(&seen, 2),
            slopes: at.jacobian(channel, weights).iter().map(slope).collect(),
        }
    }
}

/// `Σ_c J̄_cp/σ_c (H_c(ν) − H_ck) W(ω_k − ν)` at the points about a line.
fn about_line(channels: &[OfChannel], parameter: usize, line: usize, kernel: &Kernel) -> Vec<c64> {
    let first = line * kernel.fine;
    let mut sums = vec![c64::new(0.0, 0.0); kernel.values.len()];
    for channel in channels {
        let (slope, seen) = (channel.slopes[parameter][line], channel.seen[line]);
        sums.iter_mut().zip(&channel.response[first..]).for_each(|(sum, h)| *sum += slope * (h - seen));
    }
    sums.iter().zip(&kernel.values).map(|(sum, w)| sum * *w).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lag_window::{LagWindow, WINDOWS};

    /// Variance of the score over the information of as much white noise, for damping and
    /// frequency.
    fn ratios(channels: usize) -> [f64; 2] {
        // Lines at 1 Hz … 200 Hz, a mode 20 lines wide.
        let frequency_hz: Vec<f64> = (1..=200).map(f64::from).collect();
        let pole = c64::new(-20.0, 100.0) * core::f64::consts::TAU;
        let at = |f: &f64| {
            let s = c64::new(0.0, core::f64::consts::TAU * f);
            c64::new(0.0, -1.0) / (s - pole) + c64::new(0.0, 1.0) / (s - pole.conj())
        };
        let responses = vec![frequency_hz.iter().map(at).collect::<Vec<_>>(); channels];
        let lines = ResponseLines::new(&frequency_hz, &responses);
        let lines = lines.clone().seen_through(LagWindow::of(WINDOWS[0], lines.segment_s()));
        let evaluate =
            |weights: &[Vec<f64>]| Evaluation::new(lines.columns(&[pole]), &[pole], lines.outputs(), weights);
        let first = evaluate(&lines.first_noise().weights);
        let of_leakage = |c: usize| -> Vec<f64> {
            lines.leakage(&first, c).iter().flat_map(|x| [1.0 / x.max(1e-30).sqrt(); 2]).collect()
        };
        let weights: Vec<Vec<f64>> = (0..channels).map(of_leakage).collect();
        let at = evaluate(&weights);
        let (score, information) = (score_covariance(&lines, WINDOWS[0], &at, &weights), at.information(&weights).0);
        [0, 1].map(|p| score[(p, p)] / information[(p, p)])
    }

    #[test]
    fn leakage_scatters_the_damping_and_not_the_frequency_and_is_common_to_the_channels() {
        let [damping, frequency] = ratios(1);
        // By sums over the window's transform with eight points per cell, in another program. Where
        // the residue and the powers of s are known they are 1.66 and 0.43.
        assert!((damping - 1.181).abs() < 0.01 && (frequency - 0.232).abs() < 0.01, "{damping} {frequency}");
        let of_two = ratios(2);
        assert!((of_two[0] / damping - 2.0).abs() < 1e-6, "{of_two:?}");
    }
}
