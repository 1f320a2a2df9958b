//! Spectra and cross spectra with their confidence: Welch's method and sine multitapers.
//!
//! One estimator serves both: segments, each seen through K orthogonal tapers. K = 1 with the Hann
//! window and half overlap is Welch's; one segment with K sine tapers is Riedel and Sidorenko's
//! (1995). The mean of each segment is removed.
//!
//! Densities are one-sided, [unit²/Hz]: their sum over the lines times the line spacing is the
//! variance. Deterministic: one thread, planned by `realfft`.

use core::f64::consts::PI;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use identification::statistics::{chi_squared_quantile, mean};

/// How a spectrum is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Averaging {
    /// Hann segments of this many samples, half overlapping.
    Welch { segment: usize },
    /// The whole record through this many sine tapers.
    Multitaper { tapers: usize },
}

impl Averaging {
    /// Welch with segments of about `n / 8`, or multitapers where `n` is too short for eight
    /// segments of 64.
    #[must_use]
    pub fn for_length(n: usize) -> Self {
        if n >= 512 {
            Averaging::Welch { segment: (n / 8).min(4096) & !1 }
        } else {
            Averaging::Multitaper { tapers: 7 }
        }
    }
}

/// Auto and cross spectra of two series.
#[derive(Clone, Debug)]
pub struct CrossSpectrum {
    pub frequency_hz: Vec<f64>,
    pub density_x: Vec<f64>,
    pub density_y: Vec<f64>,
    /// `E[conj(X) Y]`: the argument is the phase by which y leads x.
    pub density_xy: Vec<Complex<f64>>,
    /// Degrees of freedom of each line (two per independent average).
    pub freedom: f64,
    /// Lines over which neighbouring estimates are correlated.
    pub line_width: f64,
}

impl CrossSpectrum {
    /// Squared coherence of line `k`.
    #[must_use]
    pub fn coherence(&self, k: usize) -> f64 {
        let power = self.density_x[k] * self.density_y[k];
        if power > 0.0 { (self.density_xy[k].norm_sqr() / power).min(1.0) } else { 0.0 }
    }

    /// Squared coherence that unrelated series exceed with probability `p` in one line:
    /// `1 - p^(1/(m - 1))`, m averages.
    #[must_use]
    pub fn coherence_level(&self, p: f64) -> f64 {
        1.0 - libm::pow(p, 1.0 / (0.5 * self.freedom - 1.0).max(1e-9))
    }

    /// Independent lines in `count` neighbouring ones.
    #[must_use]
    pub fn independent_lines(&self, count: usize) -> f64 {
        (count as f64 / self.line_width).max(1.0)
    }
}

/// Power spectral density with its degrees of freedom.
#[derive(Clone, Debug)]
pub struct Density {
    pub frequency_hz: Vec<f64>,
    /// One-sided [unit²/Hz].
    pub density: Vec<f64>,
    pub freedom: f64,
    pub line_width: f64,
}

impl Density {
    /// Factors on the density that bound its expectation with probability `confidence`.
    #[must_use]
    pub fn confidence_factors(&self, confidence: f64) -> [f64; 2] {
        let tail = 0.5 * (1.0 - confidence);
        let nu = self.freedom;
        [nu / chi_squared_quantile(1.0 - tail, nu), nu / chi_squared_quantile(tail, nu)]
    }

    /// Mean density over the lines in `[low_hz, high_hz)` and the degrees of freedom of that mean.
    #[must_use]
    pub fn band(&self, low_hz: f64, high_hz: f64) -> Option<(f64, f64)> {
        let lines: Vec<usize> = (1..self.frequency_hz.len())
            .filter(|&k| self.frequency_hz[k] >= low_hz && self.frequency_hz[k] < high_hz)
            .collect();
        if lines.is_empty() {
            return None;
        }
        let level = lines.iter().map(|&k| self.density[k]).sum::<f64>() / lines.len() as f64;
        Some((level, self.freedom * (lines.len() as f64 / self.line_width).max(1.0)))
    }
}

/// Power spectral density of an equally spaced series.
#[must_use]
pub fn density(x: &[f64], dt_s: f64, averaging: Averaging) -> Density {
    let s = cross_spectrum(x, x, dt_s, averaging);
    Density { frequency_hz: s.frequency_hz, density: s.density_x, freedom: s.freedom, line_width: s.line_width }
}

/// Spectra of two equally long, equally spaced series.
///
/// Degrees of freedom: 2 K for K tapers; Welch's `2 L / (1 + ρ² 2 (L - 1)/L)`, ρ = 1/6 for
/// half-overlapping Hann segments. Cost: O(n log n) per taper.
///
/// # Panics
/// When the lengths differ or fall below eight samples, or the step is not positive.
#[must_use]
pub fn cross_spectrum(x: &[f64], y: &[f64], dt_s: f64, averaging: Averaging) -> CrossSpectrum {
    assert!(x.len() == y.len());
    assert!(x.len() >= 8);
    assert!(dt_s > 0.0);
    let n = x.len();
    let (segment, tapers) = match averaging {
        Averaging::Welch { segment } => (segment.clamp(8, n), vec![hann(segment.clamp(8, n))]),
        Averaging::Multitaper { tapers } => (n, sine_tapers(n, tapers.max(1))),
    };
    let hop = if tapers.len() == 1 { (segment / 2).max(1) } else { segment };
    let count = 1 + (n - segment) / hop;
    let lines = segment / 2 + 1;
    let mut sum = Sums { x: vec![0.0; lines], y: vec![0.0; lines], xy: vec![Complex::default(); lines] };
    let fft = RealFftPlanner::<f64>::new().plan_fft_forward(segment);
    let (mut in_x, mut in_y) = (fft.make_input_vec(), fft.make_input_vec());
    let (mut out_x, mut out_y) = (fft.make_output_vec(), fft.make_output_vec());
    for s in 0..count {
        let (xs, ys) = (&x[s * hop..s * hop + segment], &y[s * hop..s * hop + segment]);
        let (mx, my) = (mean(xs), mean(ys));
        for taper in &tapers {
            for i in 0..segment {
                in_x[i] = (xs[i] - mx) * taper[i];
                in_y[i] = (ys[i] - my) * taper[i];
            }
            fft.process(&mut in_x, &mut out_x).expect("buffers come from the plan");
            fft.process(&mut in_y, &mut out_y).expect("buffers come from the plan");
            sum.add(&out_x, &out_y);
        }
    }
    let averages = (count * tapers.len()) as f64;
    let overlap = if tapers.len() == 1 { 1.0 + (count as f64 - 1.0) / (18.0 * count as f64) } else { 1.0 };
    let scale = |k: usize| {
        let two_sided = k == 0 || (segment % 2 == 0 && k == lines - 1);
        dt_s / averages * if two_sided { 1.0 } else { 2.0 }
    };
    CrossSpectrum {
        frequency_hz: (0..lines).map(|k| k as f64 / (segment as f64 * dt_s)).collect(),
        density_x: (0..lines).map(|k| sum.x[k] * scale(k)).collect(),
        density_y: (0..lines).map(|k| sum.y[k] * scale(k)).collect(),
        density_xy: (0..lines).map(|k| sum.xy[k] * scale(k)).collect(),
        freedom: 2.0 * averages / overlap,
        line_width: if tapers.len() == 1 { 1.5 } else { 0.5 * (tapers.len() + 1) as f64 },
    }
}

struct Sums {
    x: Vec<f64>,
    y: Vec<f64>,
    xy: Vec<Complex<f64>>,
}

impl Sums {
    fn add(&mut self, x: &[Complex<f64>], y: &[Complex<f64>]) {
        for k in 0..self.x.len() {
            self.x[k] += x[k].norm_sqr();
            self.y[k] += y[k].norm_sqr();
            self.xy[k] += x[k].conj() * y[k];
        }
    }
}

/// Hann window of unit energy.
fn hann(n: usize) -> Vec<f64> {
    let scale = (8.0 / (3.0 * n as f64)).sqrt();
    (0..n).map(|i| scale * 0.5 * (1.0 - libm::cos(2.0 * PI * i as f64 / n as f64))).collect()
}

/// `√(2/(n+1)) sin(π k (i+1)/(n+1))`, k = 1..=count: orthonormal.
fn sine_tapers(n: usize, count: usize) -> Vec<Vec<f64>> {
    let scale = (2.0 / (n as f64 + 1.0)).sqrt();
    (1..=count.min(n))
        .map(|k| (0..n).map(|i| scale * libm::sin(PI * k as f64 * (i as f64 + 1.0) / (n as f64 + 1.0))).collect())
        .collect()
}

/// Correlation of `x` and `y` at the shifts `-shift_max..=shift_max`: entry `shift_max + s` is
/// `Σ x(i) y(i + s)` over the product of the norms, means removed, zero-padded.
#[must_use]
pub fn correlation(x: &[f64], y: &[f64], shift_max: usize) -> Vec<f64> {
    let n = x.len().max(y.len());
    let padded = (n + shift_max + 1).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(padded), planner.plan_fft_inverse(padded));
    let transform = |v: &[f64]| {
        let m = mean(v);
        let mut input = forward.make_input_vec();
        for (slot, value) in input.iter_mut().zip(v) {
            *slot = value - m;
        }
        let norm = input.iter().map(|s| s * s).sum::<f64>().sqrt();
        let mut output = forward.make_output_vec();
        forward.process(&mut input, &mut output).expect("buffers come from the plan");
        (output, norm)
    };
    let ((fx, norm_x), (fy, norm_y)) = (transform(x), transform(y));
    let mut product: Vec<Complex<f64>> = fx.iter().zip(&fy).map(|(a, b)| a.conj() * b).collect();
    product[0].im = 0.0;
    product[padded / 2].im = 0.0;
    let mut out = inverse.make_output_vec();
    inverse.process(&mut product, &mut out).expect("first and last line are real");
    let scale = norm_x * norm_y * padded as f64;
    (0..=2 * shift_max)
        .map(|k| {
            let at = if k >= shift_max { k - shift_max } else { padded + k - shift_max };
            if scale > 0.0 { out[at] / scale } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Averaging, correlation, cross_spectrum, density};
    use crate::noise::Noise;

    #[test]
    fn the_lines_of_a_density_sum_to_the_variance() {
        for averaging in [Averaging::Welch { segment: 256 }, Averaging::Multitaper { tapers: 7 }] {
            let x = Noise::new(1).series(16_384, 2.0);
            let s = density(&x, 0.01, averaging);
            let sum: f64 = s.density.iter().sum::<f64>() * (s.frequency_hz[1] - s.frequency_hz[0]);
            // Variance of 16384 samples scatters by 1.1 %, four of these, and the removed means
            // take under 1 %.
            assert!((sum / 4.0 - 1.0).abs() < 0.055, "{averaging:?} {sum}");
        }
    }

    #[test]
    fn unrelated_series_exceed_the_coherence_level_as_often_as_stated() {
        let (mut above, mut lines) = (0, 0);
        for seed in 0..40 {
            let mut noise = Noise::new(seed);
            let (x, y) = (noise.series(4096, 1.0), noise.series(4096, 1.0));
            let s = cross_spectrum(&x, &y, 1.0, Averaging::Welch { segment: 256 });
            let level = s.coherence_level(0.01);
            above += (1..s.frequency_hz.len() - 1).filter(|&k| s.coherence(k) > level).count();
            lines += s.frequency_hz.len() - 2;
        }
        let share = above as f64 / lines as f64;
        // 5000 lines, some 3400 independent: 1 % scatters by 0.17 %.
        assert!((0.004..0.017).contains(&share), "{share}");
    }

    #[test]
    fn confidence_factors_hold_the_true_density_as_often_as_stated() {
        let (mut inside, mut lines) = (0, 0);
        for seed in 0..40 {
            let s = density(&Noise::new(seed).series(4096, 1.0), 1.0, Averaging::Welch { segment: 256 });
            let [low, high] = s.confidence_factors(0.95);
            for k in 2..s.density.len() - 2 {
                inside += usize::from((s.density[k] * low..s.density[k] * high).contains(&2.0));
                lines += 1;
            }
        }
        let share = inside as f64 / lines as f64;
        assert!((0.935..0.965).contains(&share), "{share}");
    }

    #[test]
    fn correlation_peaks_at_the_shift_given() {
        let x = Noise::new(3).series(500, 1.0);
        let y: Vec<f64> = (0..500).map(|i| if i >= 7 { x[i - 7] } else { 0.0 }).collect();
        let rho = correlation(&x, &y, 20);
        let peak = (0..41).max_by(|&i, &j| rho[i].total_cmp(&rho[j])).unwrap();
        assert_eq!(peak, 27);
    }
}
