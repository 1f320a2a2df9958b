//! Modes from the magnitude of a spectrum: peaks above the local floor, each fitted as one
//! resonance.
//!
//! Without phase and input neither sign nor size of a mode can be estimated; its frequency and
//! damping can. The floor is the median of the logarithm over a band around each line; a peak
//! exceeds the largest of all lines of pure noise. Each peak is fitted over some half-power widths
//! by `|X| = |A x² / (1 − x² + 2 i ζ x) + c|`, x = f / f_0, in the logarithm, whose scatter is the
//! same on the flank and at the top. The complex c is the contribution of the other modes, without
//! which they bias the peak. The residual gives the standard errors. A peak as narrow as the lines
//! has the width of the window in its damping, and its frequency is not known better than a part of
//! a line.

use nalgebra::{Cholesky, Complex, SMatrix, SVector};

type Vector5 = SVector<f64, 5>;
type Matrix5 = SMatrix<f64, 5, 5>;

/// A measured resonance.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredMode {
    pub frequency_hz: f64,
    /// Standard deviation of the frequency \[Hz\].
    pub sigma_hz: f64,
    /// With the width of the window in it; NaN where it was not measured.
    pub damping_ratio: f64,
    pub damping_sigma: f64,
    /// Peak over the floor beside it, as a ratio of magnitudes.
    pub prominence: f64,
    /// Up to one complex factor; empty where it was not measured.
    pub shape: Vec<ShapeComponent>,
}

/// One channel's component of a mode shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeComponent {
    pub channel: String,
    pub value: Complex<f64>,
    /// Of its real and its imaginary part, in the unit of `value`; zero where it is unknown.
    pub sigma: f64,
}

/// Magnitude over frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    pub name: String,
    /// Rising.
    pub frequency_hz: Vec<f64>,
    /// Of any response: a displacement, an acceleration, a frequency response.
    pub magnitude: Vec<f64>,
}

/// Probability that noise alone gives a peak anywhere.
const ALPHA: f64 = 1e-3;
/// Half width of the band of the floor: share of the frequency, and lines at least.
const FLOOR_SHARE: f64 = 0.15;
const FLOOR_LINES: usize = 25;
/// Part of a line below which a frequency is not known.
const LINE_SHARE: f64 = 0.1;
/// A peak this much weaker beside a stronger one, this close, belongs to its skirt or to the
/// window.
const BESIDE_SHARE: f64 = 0.03;

/// Lines within the half-power bandwidth below which the window is in the damping: that of Hann is
/// 1.4 lines wide, and `√(5² + 1.4²)` is 4 % more than 5, less than a damping ratio is trusted to.
const DAMPING_LINES: f64 = 5.0;

impl Spectrum {
    /// Peaks by rising frequency, the damping only of those that are wide against the lines (NaN
    /// otherwise), and how many are not.
    pub(super) fn modes_with_own_damping(&self) -> (Vec<MeasuredMode>, usize) {
        let mut modes = self.modes();
        let mut narrow = 0;
        for mode in &mut modes {
            let k = self.frequency_hz.partition_point(|f| *f < mode.frequency_hz).clamp(1, self.frequency_hz.len() - 1);
            let line = self.frequency_hz[k] - self.frequency_hz[k - 1];
            let wide = 2.0 * mode.damping_ratio * mode.frequency_hz > DAMPING_LINES * line;
            if !wide {
                (mode.damping_ratio, mode.damping_sigma) = (f64::NAN, f64::NAN);
                narrow += 1;
            }
        }
        (modes, narrow)
    }

    /// Resonances by rising frequency \[Hz\], each with the standard errors of its fit; the damping
    /// ratio includes the width of the window.
    ///
    /// Cost: O(n log n) for the floor, one five-parameter fit for each peak.
    pub fn modes(&self) -> Vec<MeasuredMode> {
        let n = self.frequency_hz.len().min(self.magnitude.len());
        let lines: Vec<usize> = (0..n)
            .filter(|i| self.frequency_hz[*i] > 0.0 && self.magnitude[*i] > 0.0 && self.magnitude[*i].is_finite())
            .collect();
        if lines.len() < 4 * FLOOR_LINES {
            return Vec::new();
        }
        let f: Vec<f64> = lines.iter().map(|i| self.frequency_hz[*i]).collect();
        let log: Vec<f64> = lines.iter().map(|i| libm::log(self.magnitude[*i])).collect();
        // of a Rayleigh magnitude, the largest of n over the median
        let level = 0.5 * libm::log(libm::log(f.len() as f64 / ALPHA) / core::f64::consts::LN_2);
        let mut tops: Vec<(usize, f64)> = Vec::new();
        for i in 2..f.len() - 2 {
            let top = log[i] >= log[i - 1] && log[i] > log[i + 1] && log[i] > log[i - 2] && log[i] > log[i + 2];
            // cheap before expensive: a maximum exceeds the lines some way off
            if top {
                let over = log[i] - floor(&f, &log, i);
                if over > level {
                    tops.push((i, over));
                }
            }
        }
        tops.sort_by(|a, b| log[b.0].total_cmp(&log[a.0]).then(a.0.cmp(&b.0)));
        let mut kept: Vec<(usize, f64)> = Vec::new();
        for (i, over) in tops {
            let beside = |(j, _): &(usize, f64)| (f[i] - f[*j]).abs() < BESIDE_SHARE * f[*j];
            let deep = |(j, _): &(usize, f64)| {
                let between = log[i.min(*j)..=i.max(*j)].iter().copied().fold(f64::INFINITY, f64::min);
                log[i] - between > level
            };
            if kept.iter().all(|k| !beside(k) && deep(k)) {
                kept.push((i, over));
            }
        }
        kept.sort_by_key(|k| k.0);
        kept.iter().map(|(i, over)| twice(&f, &log, *i, *over)).collect()
    }
}

/// Median of the logarithm around line i.
fn floor(f: &[f64], log: &[f64], i: usize) -> f64 {
    let low = f.partition_point(|x| *x < f[i] * (1.0 - FLOOR_SHARE)).min(i.saturating_sub(FLOOR_LINES));
    let high = f.partition_point(|x| *x <= f[i] * (1.0 + FLOOR_SHARE)).max((i + FLOOR_LINES).min(f.len()));
    // at most some 400 of them: a median needs no more
    let stride = (high - low).div_ceil(400);
    estimation::quantiles::median(&mut log[low..high].iter().copied().step_by(stride).collect::<Vec<f64>>())
}

/// Fits over a wide and a narrow stretch: their difference is the model error of one resonance on a
/// constant, and enters the standard errors.
fn twice(f: &[f64], log: &[f64], top: usize, over: f64) -> MeasuredMode {
    let (wide, narrow) = (resonance(f, log, top, over, 4.0), resonance(f, log, top, over, 2.5));
    // of two fits of the same lines, one the more precise, the difference has this variance
    let beyond =
        |apart: f64, narrow: f64, wide: f64| (apart * apart - (narrow * narrow - wide * wide).max(0.0)).max(0.0).sqrt();
    let line = 0.5 * (f[top + 1] - f[top - 1]);
    let least =
        if 2.0 * wide.damping_ratio * wide.frequency_hz > DAMPING_LINES * line { 0.0 } else { LINE_SHARE * line };
    let sigma_hz =
        libm::hypot(wide.sigma_hz, beyond(wide.frequency_hz - narrow.frequency_hz, narrow.sigma_hz, wide.sigma_hz));
    let damping_sigma = libm::hypot(
        wide.damping_sigma,
        beyond(wide.damping_ratio - narrow.damping_ratio, narrow.damping_sigma, wide.damping_sigma),
    );
    MeasuredMode {
        sigma_hz: sigma_hz.max(least),
        damping_sigma: damping_sigma.max(0.5 * least / wide.frequency_hz),
        ..wide
    }
}

/// Variance of a sum over neighbouring lines over that of independent ones.
fn inflation(residuals: &[f64]) -> f64 {
    let power: f64 = residuals.iter().map(|e| e * e).sum();
    let rho = |lag: usize| residuals.iter().skip(lag).zip(residuals).map(|(a, b)| a * b).sum::<f64>() / power;
    if power > 0.0 && residuals.len() > 8 { (1.0 + 2.0 * (rho(1) + rho(2))).max(1.0) } else { 1.0 }
}

/// Fit of one resonance about line `top` over `widths` half-power widths on each side.
fn resonance(f: &[f64], log: &[f64], top: usize, over: f64, widths: f64) -> MeasuredMode {
    let n = f.len();
    let line = 0.5 * (f[top + 1] - f[top - 1]);
    // first place on each side that is 3 dB down
    let down = |mut i: usize, forward: bool| {
        while i > 0 && i + 1 < n && log[i] > log[top] - 0.5 * core::f64::consts::LN_2 {
            i = if forward { i + 1 } else { i - 1 };
        }
        f[i]
    };
    let width = (down(top, true) - down(top, false)).max(line);
    let reach = (widths * width).max(5.0 * line);
    let low = f.partition_point(|x| *x < f[top] - reach);
    let high = f.partition_point(|x| *x <= f[top] + reach);
    let zeta = (0.5 * width / f[top]).max(1e-9);
    let unit = libm::exp(log[top] - over);
    // [f_0 in widths from the top, ln ζ, ln A, c in floors]
    let mut p = Vector5::new(0.0, libm::log(zeta), log[top] + libm::log(2.0 * zeta), 0.0, 0.0);
    let model = |p: &Vector5, i: usize| {
        let x = f[i] / (f[top] + width * p[0]);
        let (a, b) = (1.0 - x * x, 2.0 * libm::exp(p[1]) * x);
        let size = libm::exp(p[2]) * x * x / (a * a + b * b);
        libm::log(libm::hypot(size * a + unit * p[3], unit * p[4] - size * b).max(1e-300))
    };
    let cost = |p: &Vector5| (low..high).map(|i| (log[i] - model(p, i)).powi(2)).sum::<f64>();
    let mut damping = 1e-2;
    let mut at = cost(&p);
    let mut normal = Matrix5::zeros();
    for _ in 0..40 {
        let (jtj, jtr) = normal_equations(&p, &model, log, low..high);
        normal = jtj;
        let scaled = jtj + Matrix5::from_diagonal(&(jtj.diagonal() * damping).add_scalar(1e-9));
        let Some(factor) = Cholesky::new(scaled) else { break };
        let next = p + factor.solve(&jtr).map(|step| step.clamp(-1.0, 1.0));
        let fresh = cost(&next);
        if fresh < at {
            let gained = at - fresh;
            (p, at) = (next, fresh);
            damping = (damping * 0.3).max(1e-9);
            if gained < 1e-9 * at {
                break;
            }
        } else {
            damping *= 5.0;
            if damping > 1e9 {
                break;
            }
        }
    }
    let freedom = ((high - low) as f64 - 5.0).max(1.0);
    let residuals: Vec<f64> = (low..high).map(|i| log[i] - model(&p, i)).collect();
    let variance = (normal + Matrix5::identity() * 1e-9)
        .try_inverse()
        .map(|inverse| inverse * (at / freedom * inflation(&residuals)));
    let sigma = |k: usize| variance.map_or(f64::INFINITY, |v| v[(k, k)].max(0.0).sqrt());
    // a fit that diverged keeps the line it began at
    let ran_away = p[0].abs() > 2.0;
    let frequency_hz = if ran_away { f[top] } else { f[top] + width * p[0] };
    let sigma_hz = if ran_away { 0.5 * width } else { (width * sigma(0)).min(0.5 * width.max(line)) };
    let damping_ratio = if ran_away { zeta } else { libm::exp(p[1]) };
    let damping_sigma = damping_ratio * sigma(1).min(1.0);
    MeasuredMode {
        frequency_hz,
        sigma_hz,
        damping_ratio,
        damping_sigma,
        prominence: libm::exp(over),
        shape: Vec::new(),
    }
}

fn normal_equations(
    p: &Vector5,
    model: &dyn Fn(&Vector5, usize) -> f64,
    log: &[f64],
    lines: core::ops::Range<usize>,
) -> (Matrix5, Vector5) {
    const STEP: f64 = 1e-5;
    let (mut jtj, mut jtr) = (Matrix5::zeros(), Vector5::zeros());
    for i in lines {
        let j = Vector5::from_fn(|k, _| {
            let (mut up, mut below) = (*p, *p);
            up[k] += STEP;
            below[k] -= STEP;
            (model(&up, i) - model(&below, i)) / (2.0 * STEP)
        });
        jtj += j * j.transpose();
        jtr += j * (log[i] - model(p, i));
    }
    (jtj, jtr)
}
