//! Cramér–Rao bound of decays side by side: poles, shapes and biases common, the modes' amplitudes
//! those of each segment.
//!
//! `y_i(t) = Re Σ_k ψ_ik η_sk e^{λ_k t} + b_i` in segment s; one η of each mode is 1. Every pole
//! but the one looked at, and every other unknown, is a nuisance.

use super::linear::TrueMode;
use nalgebra::{Complex, DMatrix, DVector};

/// Noise-free rows of the segments, and the poles in them.
pub struct Decays<'a> {
    pub modes: &'a [TrueMode],
    /// Each with one row of all channels per sample.
    pub segments: Vec<&'a [Vec<f64>]>,
    pub rate_hz: f64,
}

impl Decays<'_> {
    /// Standard deviations of (f, ζ) of the vibrations among the modes, white noise of `sigma` per
    /// sample and channel.
    ///
    /// `None` when the segments do not tell the unknowns apart.
    pub fn bounds(&self, sigma: f64) -> Option<Vec<(f64, f64)>> {
        let jacobian = self.jacobian()?;
        let information = jacobian.transpose() * &jacobian / (sigma * sigma);
        // Scaled before it is inverted: what is known of the unknowns differs by decades.
        let n = information.nrows();
        let scale = DVector::from_fn(n, |p, _| 1.0 / information[(p, p)].sqrt());
        let scaled = DMatrix::from_fn(n, n, |p, q| information[(p, q)] * scale[p] * scale[q]);
        let inverse = scaled.cholesky()?.inverse();
        let covariance = |p: usize, q: usize| inverse[(p, q)] * scale[p] * scale[q];
        let (mut deviations, mut at) = (Vec::new(), 0);
        for mode in self.modes {
            if is_real(mode) {
                at += 1;
                continue;
            }
            let (re, im, omega) = (mode.pole.re, mode.pole.im, mode.pole.norm_sqr().sqrt());
            let variance = |a: f64, b: f64| {
                a * a * covariance(at, at) + 2.0 * a * b * covariance(at, at + 1) + b * b * covariance(at + 1, at + 1)
            };
            let (cube, turn) = (omega * omega * omega, core::f64::consts::TAU * omega);
            deviations.push((variance(re / turn, im / turn).sqrt(), variance(-im * im / cube, re * im / cube).sqrt()));
            at += 2;
        }
        Some(deviations)
    }

    /// Of all samples by poles, shapes, amplitudes, biases. A real pole has no imaginary parts.
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let residues = self.residues()?;
        let channels = self.segments[0][0].len();
        let samples: usize = self.segments.iter().map(|segment| segment.len() * channels).sum();
        let mut columns: Vec<DVector<f64>> = Vec::new();
        let all = self.modes.iter().enumerate();
        // Derivative by one complex unknown: Re and, of a vibration, Re i times what stands before
        // it.
        let mut add = |mode: &TrueMode, before: &dyn Fn(usize, usize, f64) -> Complex<f64>| {
            let turns = if is_real(mode) { 1 } else { 2 };
            for turn in [Complex::new(1.0, 0.0), Complex::i()].into_iter().take(turns) {
                columns.push(self.column(samples, |s, i, t| (before(s, i, t) * turn).re));
            }
        };
        let grown = |k: usize, t: f64| (pole(&self.modes[k]) * t).exp();
        for (k, mode) in all.clone() {
            add(mode, &|s, i, t| residues[s][k][i] * t * grown(k, t));
        }
        for (k, mode) in all {
            let reference = strongest(&residues, k);
            let shape = &residues[reference][k];
            let amplitude = |s: usize| along(shape, &residues[s][k]);
            for channel in 0..channels {
                add(mode, &|s, i, t| if i == channel { amplitude(s) * grown(k, t) } else { 0.0.into() });
            }
            for segment in (0..self.segments.len()).filter(|segment| *segment != reference) {
                add(mode, &|s, i, t| if s == segment { shape[i] * grown(k, t) } else { 0.0.into() });
            }
        }
        for channel in 0..channels {
            columns.push(self.column(samples, |_, i, _| f64::from(u8::from(i == channel))));
        }
        Some(DMatrix::from_columns(&columns))
    }

    fn column(&self, samples: usize, value: impl Fn(usize, usize, f64) -> f64) -> DVector<f64> {
        let mut column = Vec::with_capacity(samples);
        for (s, segment) in self.segments.iter().enumerate() {
            for (t, row) in segment.iter().enumerate() {
                column.extend((0..row.len()).map(|i| value(s, i, t as f64 / self.rate_hz)));
            }
        }
        DVector::from_vec(column)
    }

    /// `residues[segment][mode][channel]`, by least squares.
    fn residues(&self) -> Option<Vec<Vec<Vec<Complex<f64>>>>> {
        let of_segment = |segment: &&[Vec<f64>]| {
            let place: Vec<(usize, bool)> = self
                .modes
                .iter()
                .enumerate()
                .flat_map(|(k, mode)| [(k, false), (k, true)].into_iter().take(if is_real(mode) { 1 } else { 2 }))
                .collect();
            let basis = DMatrix::from_fn(segment.len(), place.len() + 1, |t, column| {
                place.get(column).map_or(1.0, |(k, imaginary)| {
                    let z = (pole(&self.modes[*k]) * (t as f64 / self.rate_hz)).exp();
                    if *imaginary { -z.im } else { z.re }
                })
            });
            let y = DMatrix::from_fn(segment.len(), segment[0].len(), |t, i| segment[t][i]);
            let factor = basis.qr();
            let found = factor.r().solve_upper_triangular(&(factor.q().transpose() * y))?;
            let at = |k: usize, imaginary: bool| place.iter().position(|p| *p == (k, imaginary));
            let part = |column: Option<usize>, i: usize| column.map_or(0.0, |column| found[(column, i)]);
            let of_mode = |k: usize| {
                (0..segment[0].len()).map(|i| Complex::new(part(at(k, false), i), part(at(k, true), i))).collect()
            };
            Some((0..self.modes.len()).map(of_mode).collect())
        };
        self.segments.iter().map(of_segment).collect()
    }
}

fn is_real(mode: &TrueMode) -> bool {
    mode.pole.im < 1e-6
}

fn pole(mode: &TrueMode) -> Complex<f64> {
    Complex::new(mode.pole.re, mode.pole.im)
}

/// Segment in which a mode moves most.
fn strongest(residues: &[Vec<Vec<Complex<f64>>>], mode: usize) -> usize {
    let power = |s: &usize| residues[*s][mode].iter().map(Complex::norm_sqr).sum::<f64>();
    (0..residues.len()).max_by(|a, b| power(a).total_cmp(&power(b))).expect("there is a segment")
}

/// `η` in `other ≈ η shape`.
fn along(shape: &[Complex<f64>], other: &[Complex<f64>]) -> Complex<f64> {
    let cross: Complex<f64> = shape.iter().zip(other).map(|(a, b)| a.conj() * b).sum();
    cross / shape.iter().map(Complex::norm_sqr).sum::<f64>()
}
