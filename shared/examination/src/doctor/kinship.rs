//! Channels that must be derivatives of each other (angle and rate, rate and acceleration) or the
//! same: lag, clock skew, units, sign, scale, offset.
//!
//! Weak form: with a smooth window w, `-∫ w'(s - t) a(s) ds = ∫ w(s - t) ȧ(s) ds` exactly, whatever
//! the motion: both channels are seen through the same window and nothing is differenced. The lag
//! enters by shifting the window, at any fraction of a sample. The window's width is the one under
//! which the pair correlates best. Standard deviations allow for correlated residuals (Newey–West).

mod judge;
mod pairs;

use super::derived::own_noise;
use super::{FALSE_ALARM, Finding, usable};
use crate::spectrum::correlation;
use channels::{Channel, Recording, common_grid};
use identification::statistics::{
    correlation_length, deviation, fisher_tail, least_squares, mean, rms, squared_correlation_tail,
};
use pairs::related_by_name;
use std::collections::HashSet;

/// Correlation squared below which nothing is said about a pair.
const RELATED_R2_MIN: f64 = 0.9;
/// Parts of the record whose lags are compared.
const SKEW_PARTS: usize = 16;
/// Tests made on a pair.
const TESTS: f64 = 5.0;

/// What binds two channels: `D^k a(t) ≈ scale b(t + lag) + offset`.
struct Relation {
    scale: f64,
    scale_sigma: f64,
    lag_s: f64,
    lag_sigma_s: f64,
    offset: f64,
    offset_sigma: f64,
    r2: f64,
    freedom: f64,
    dt_s: f64,
    half_s: f64,
    /// Residual, what it could not fall below if b were measured, and half width [s], where the
    /// first is too small.
    computed: Option<(f64, f64, f64)>,
    /// Change of the lag per second of record, its sigma and degrees of freedom.
    skew: Option<(f64, f64, f64)>,
}

/// Findings for all related pairs but those of `derived`; `progress` receives the share done.
pub fn examine(recording: &Recording, derived: &[(String, String)], progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let channels = usable(recording, 48);
    let known: HashSet<(&str, &str)> = derived.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let is_known = |a: &Channel, b: &Channel| {
        known.contains(&(a.name.as_str(), b.name.as_str())) || known.contains(&(b.name.as_str(), a.name.as_str()))
    };
    let pairs: Vec<(&Channel, &Channel, usize)> = related_by_name(&channels)
        .into_iter()
        .map(|(i, j, order)| (channels[i], channels[j], order))
        .filter(|(a, b, _)| !is_known(a, b))
        .collect();
    let level = FALSE_ALARM / (pairs.len().max(1) as f64 * TESTS);
    let mut findings = Vec::new();
    for (k, (a, b, order)) in pairs.iter().enumerate() {
        progress(k as f64 / pairs.len() as f64);
        if let Some(relation) = relate(a, b, *order, level) {
            findings.extend(judge::Judged::new(a, b, *order, &relation, level).findings());
        }
    }
    findings
}

fn relate(a: &Channel, b: &Channel, order: usize, level: f64) -> Option<Relation> {
    let (ua, ub) = common_grid(a, b, 48)?;
    let (n, dt) = (ua.value.len(), ua.dt_s);
    let mut best: Option<(f64, usize, f64)> = None;
    let mut half = 4;
    while half <= (n / 12).max(4) {
        if let Some((r2, sharpness, lag)) = coarse(&ua.value, &ub.value, order, half)
            && r2 > 0.5 * RELATED_R2_MIN
        {
            // Information on the lag: slope of b squared per noise, times independent windows.
            // Correlated pairs go before weakly correlated ones.
            let merit = if r2 < RELATED_R2_MIN { r2 - 2.0 } else { sharpness / ((1.0 - r2).max(1e-12) * half as f64) };
            if best.is_none_or(|(m, ..)| merit > m) {
                best = Some((merit, half, lag));
            }
        }
        half *= 2;
    }
    let (_, half, mut lag) = best?;
    let mut windows = Windows::new(&ua.value, &ub.value, order, half);
    for _ in 0..12 {
        let (fit, _) = windows.fit(lag, dt)?;
        let step = fit.coefficients[1] / fit.coefficients[0];
        lag -= step.clamp(-0.5 * half as f64, 0.5 * half as f64);
        if step.abs() < 1e-7 {
            break;
        }
    }
    let (fit, positions) = windows.fit(lag, dt)?;
    let independent = positions.len() as f64 / correlation_length(&windows.left);
    let freedom = (independent - 3.0).max(1.0);
    if fit.r2 < RELATED_R2_MIN || squared_correlation_tail(fit.r2, 2.0, freedom) > level {
        return None;
    }
    let scale = fit.coefficients[0];
    Some(Relation {
        scale,
        scale_sigma: fit.sigma[0],
        lag_s: lag * dt,
        lag_sigma_s: (fit.sigma[1] / scale).abs() * dt,
        offset: fit.coefficients[2],
        offset_sigma: fit.sigma[2],
        r2: fit.r2,
        freedom,
        dt_s: dt,
        half_s: half as f64 * dt,
        computed: computed(&ua.value, &ub.value, order, lag, dt, level),
        skew: skew(&ua.value, &ub.value, order, half, lag, dt),
    })
}

/// Slope of the lags of parts of the record over time, its sigma from their own scatter, degrees of
/// freedom.
///
/// Windows narrow enough that each part holds two dozen of them.
fn skew(a: &[f64], b: &[f64], order: usize, half: usize, lag: f64, dt: f64) -> Option<(f64, f64, f64)> {
    let half = half.min(a.len() / (6 * SKEW_PARTS)).max(4);
    let mut windows = Windows::new(a, b, order, half);
    let (_, positions) = windows.fit(lag, dt)?;
    let size = positions.len() / SKEW_PARTS;
    if size < 16 {
        return None;
    }
    let (mut times, mut lags, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    for part in 0..SKEW_PARTS {
        let range = part * size..(part + 1) * size;
        let columns: Vec<Vec<f64>> = windows.columns.iter().map(|c| c[range.clone()].to_vec()).collect();
        let fit = least_squares(&columns, &windows.left[range.clone()], 8.min(size / 4))?;
        if fit.r2 < RELATED_R2_MIN || fit.sigma[1] <= 0.0 {
            continue;
        }
        times.push(mean(&positions[range].iter().map(|&p| p as f64 * dt).collect::<Vec<_>>()));
        lags.push((lag - fit.coefficients[1] / fit.coefficients[0]) * dt);
        weights.push((fit.coefficients[0] / fit.sigma[1]).abs());
    }
    if times.len() < 5 {
        return None;
    }
    let heaviest = weights.iter().fold(0.0_f64, |m, w| m.max(*w));
    let weights: Vec<f64> = weights.iter().map(|w| w.min(heaviest) / heaviest).collect();
    let weighted = |x: &[f64]| x.iter().zip(&weights).map(|(v, w)| v * w).collect::<Vec<f64>>();
    let fit = least_squares(&[weights.clone(), weighted(&times)], &weighted(&lags), 0)?;
    let centre =
        times.iter().zip(&weights).map(|(t, w)| t * w * w).sum::<f64>() / weights.iter().map(|w| w * w).sum::<f64>();
    let lever: f64 = times.iter().zip(&weights).map(|(t, w)| (w * (t - centre)).powi(2)).sum();
    let freedom = times.len() as f64 - 2.0;
    let scatter = fit.residual.iter().map(|e| e * e).sum::<f64>() / freedom;
    Some((fit.coefficients[1], (scatter / lever).sqrt(), freedom))
}

/// The argument of `derived` through windows of all widths: were b measured apart from a,
/// `D a - s b` would keep the noise of a seen through the window.
fn computed(a: &[f64], b: &[f64], order: usize, lag: f64, dt: f64, level: f64) -> Option<(f64, f64, f64)> {
    let noise = own_noise(a)?;
    let mut best: Option<(f64, f64, f64)> = None;
    let mut half = 4;
    while half <= a.len() / 12 {
        let mut windows = Windows::new(a, b, order, half);
        if let Some((fit, positions)) = windows.fit(lag, dt) {
            let unit: f64 = (0..order).map(|_| 1.0 / dt).product();
            let least = noise.sigma * unit * kernel(half, order, 0.0).iter().map(|w| w * w).sum::<f64>().sqrt();
            // Windows at a quarter of their half width share data over eight neighbours; three
            // coefficients are fitted.
            let freedom = positions.len() as f64 / 8.0 - 3.0;
            let residual = rms(&fit.residual) * ((freedom + 3.0) / freedom.max(1.0)).sqrt();
            let share = (residual / least).powi(2);
            let proved =
                freedom > 3.0 && share < noise.share_max && fisher_tail(1.0 / share, noise.freedom, freedom) < level;
            if proved && best.is_none_or(|(r, l, _)| share < (r / l) * (r / l)) {
                best = Some((residual, least, half as f64 * dt));
            }
        }
        half *= 2;
    }
    best
}

/// Squared correlation at the best whole-stride lag, mean square slope of b over its variance, and
/// that lag in samples: of equally good ones the smallest.
fn coarse(a: &[f64], b: &[f64], order: usize, half: usize) -> Option<(f64, f64, f64)> {
    let stride = (half / 4).max(1);
    let (ka, kb) = (kernel(half, order, 0.0), kernel(half, 0, 0.0));
    let positions: Vec<usize> = (half + 1..a.len().saturating_sub(half + 1)).step_by(stride).collect();
    if positions.len() < 24 {
        return None;
    }
    let left: Vec<f64> = positions.iter().map(|&p| seen(a, &ka, p)).collect();
    let right: Vec<f64> = positions.iter().map(|&p| seen(b, &kb, p)).collect();
    let shift_max = positions.len() / 4;
    let rho = correlation(&left, &right, shift_max);
    let peak = rho.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let top = |k: usize| {
        let at = |i: usize| rho[i].abs();
        at(k) >= 0.97 * peak && (k == 0 || at(k) >= at(k - 1)) && (k + 1 == rho.len() || at(k) >= at(k + 1))
    };
    let k = (0..rho.len()).filter(|&k| top(k)).min_by_key(|k| k.abs_diff(shift_max))?;
    let kd = kernel(half, 1, 0.0);
    let slope: Vec<f64> = positions.iter().map(|&p| seen(b, &kd, p)).collect();
    let sharpness = (rms(&slope) / deviation(&right).max(1e-300)).powi(2);
    Some((rho[k] * rho[k], sharpness, (k as f64 - shift_max as f64) * stride as f64))
}

/// Both channels through the same windows.
struct Windows<'a> {
    a: &'a [f64],
    b: &'a [f64],
    order: usize,
    half: usize,
    left: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl<'a> Windows<'a> {
    fn new(a: &'a [f64], b: &'a [f64], order: usize, half: usize) -> Self {
        Windows { a, b, order, half, left: Vec::new(), columns: Vec::new() }
    }

    /// Least squares of `D^k a` on b, its rate of change (per sample) and one, b read `lag` samples
    /// later.
    fn fit(&mut self, lag: f64, dt: f64) -> Option<(identification::statistics::LeastSquares, Vec<usize>)> {
        let whole = libm::round(lag);
        let part = lag - whole;
        let (n, reach) = (self.a.len() as f64, self.half as f64 + 1.0);
        let from = reach + (-whole).max(0.0);
        let to = n - reach - whole.max(0.0);
        let stride = (self.half / 4).max(1);
        let positions: Vec<usize> = (from as usize..to.max(from) as usize).step_by(stride).collect();
        if positions.len() < 16 {
            return None;
        }
        let (ka, kb, kd) = (kernel(self.half, self.order, 0.0), kernel(self.half, 0, part), kernel(self.half, 1, part));
        let per_s = 1.0 / dt;
        let unit: f64 = (0..self.order).map(|_| per_s).product();
        let at = |p: usize| (p as f64 + whole) as usize;
        self.left = positions.iter().map(|&p| unit * seen(self.a, &ka, p)).collect();
        self.columns = vec![
            positions.iter().map(|&p| seen(self.b, &kb, at(p))).collect(),
            positions.iter().map(|&p| -seen(self.b, &kd, at(p))).collect(),
            vec![1.0; positions.len()],
        ];
        // Neighbouring windows share data over eight strides; the residual adds its own memory.
        let first = least_squares(&self.columns, &self.left, 0)?;
        let memory = 2.0 * correlation_length(&first.residual);
        let lag_window = (40.0 + memory).min(positions.len() as f64 / 6.0) as usize;
        Some((least_squares(&self.columns, &self.left, lag_window)?, positions))
    }
}

pub(super) fn seen(x: &[f64], kernel: &[f64], at: usize) -> f64 {
    let first = at - kernel.len() / 2;
    kernel.iter().zip(&x[first..]).map(|(w, v)| w * v).sum()
}

/// Weights of the window `(1 - u²)⁴`, u = (i - shift)/half, or of its derivative of `order` with
/// the sign of partial integration, i from `-(half + 1)` to `half + 1`; scaled so that 1, t and
/// t²/2 give exactly 1.
pub(super) fn kernel(half: usize, order: usize, shift: f64) -> Vec<f64> {
    let h = half as f64;
    let offsets: Vec<f64> = (0..2 * half + 3).map(|i| i as f64 - h - 1.0 - shift).collect();
    let bump = |u: f64, power: usize| {
        let v = (1.0 - u * u).max(0.0);
        (0..power).map(|_| v).product::<f64>()
    };
    let smooth: Vec<f64> = offsets.iter().map(|s| bump(s / h, 4)).collect();
    let total: f64 = smooth.iter().sum();
    match order {
        0 => smooth.iter().map(|w| w / total).collect(),
        1 => {
            let mut w: Vec<f64> = offsets.iter().map(|s| s / h * bump(s / h, 3)).collect();
            let sum: f64 = w.iter().sum();
            w.iter_mut().zip(&smooth).for_each(|(w, s)| *w -= sum * s / total);
            let moment: f64 = w.iter().zip(&offsets).map(|(w, s)| w * s).sum();
            w.iter().map(|w| w / moment).collect()
        }
        _ => {
            let mut w: Vec<f64> = offsets
                .iter()
                .map(|s| {
                    let u = s / h;
                    6.0 * u * u * bump(u, 2) - bump(u, 3)
                })
                .collect();
            let sum: f64 = w.iter().sum();
            w.iter_mut().zip(&smooth).for_each(|(w, s)| *w -= sum * s / total);
            let moment: f64 = w.iter().zip(&offsets).map(|(w, s)| 0.5 * w * s * s).sum();
            w.iter().map(|w| w / moment).collect()
        }
    }
}
