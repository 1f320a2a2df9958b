//! Delays between channels of like quantity, from the slope of phase over frequency.
//!
//! A channel that is τ late has the cross spectrum `|S| e^{i(φ - 2π f τ)}` with one that is not. On
//! a lightly damped structure φ is 0 or π at every mode, so the doubled phase, `2φ = 0 mod 2π`,
//! leaves `-4π f τ`. Lines whose coherence C is beyond chance are used; the phase of K averages
//! scatters by `σ² = (1 - C)/(2 K C)` (Bendat and Piersol), and, in common to the lines of a band,
//! by what modes are complex and their neighbours add, `MODAL_PHASE`. τ maximises
//! `Σ cos 2(θ - 2π f τ) / v`, `v = σ² + MODAL_PHASE²`; its variance comes from least squares about
//! the maximum with an unknown phase of each band beside τ, and grows with what the lines scatter
//! beyond v.
//!
//! A constant phase (rate against angle, a wave's quadrature) or one that bends (a filter, a loop)
//! is no delay: the lines must agree with the slope, reach over a factor in frequency, and prefer
//! the slope to any other by a likelihood; and both halves of the record must show the same. A
//! filter of first order below its corner is one.

use crate::spectrum::{Averaging, cross_spectrum};
use core::f64::consts::PI;
use identification::statistics::normal_two_sided;

/// Probability that a delay is reported between any two channels that have none.
const DELAY_FALSE_ALARM: f64 = 1e-3;
/// Phase of a mode of a real structure [rad]: a tenth, what modes of 1 % damping that lie 10 %
/// apart add to each other.
const MODAL_PHASE: f64 = 0.1;
/// Delays below this share of a sample are not reported: at half the Nyquist frequency, 22°.
const SAMPLE_SHARE_MIN: f64 = 0.5;
/// Mean resultant of the doubled phases about the slope; a scatter of 0.3 rad gives 0.83.
const RESULTANT_MIN: f64 = 0.8;
/// Highest over lowest frequency: below, a constant phase is as good.
const BAND_RATIO_MIN: f64 = 1.5;
/// Log-likelihood by which the best delay exceeds any other: odds of `e⁻¹⁰`.
const AMBIGUITY: f64 = 10.0;
/// Fewest rows: 31 half-overlapping segments of 64.
const ROWS_MIN: usize = 1024;
/// Longest segment; lines of a narrower mode need longer records than most.
const SEGMENT_MAX: usize = 4096;
/// Fewest coherent lines, a slope and a phase having two unknowns.
const LINES_MIN: usize = 8;
/// Channels compared at most: pairs grow with their square.
const CHANNELS_MAX: usize = 16;

/// A delay with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// How much later the channel shows the same \[s\].
    pub delay_s: f64,
    /// Standard deviation \[s\].
    pub sigma_s: f64,
}

impl Delay {
    fn significant(&self, level: f64) -> bool {
        self.delay_s.abs() > level * self.sigma_s
    }
}

/// A phase difference of a coherent line.
struct Line {
    frequency_hz: f64,
    /// Phase by which the first channel leads \[rad\].
    phase: f64,
    variance: f64,
    /// Number of the band, counted from the lowest.
    band: usize,
}

/// How late `y` is against `x`, both at the same rows of an even clock of step `dt_s`; `None` where
/// the phase over frequency shows no delay: too few rows, too little coherence, a phase that is no
/// straight line, several delays that explain it.
///
/// Looked for up to the period of the slowest frequency at which they are coherent.
///
/// # Panics
/// When lengths differ.
#[must_use]
pub fn between(x: &[f64], y: &[f64], dt_s: f64) -> Option<Delay> {
    assert_eq!(x.len(), y.len());
    if x.len() < ROWS_MIN {
        return None;
    }
    let segment = (x.len() / 16).min(SEGMENT_MAX) & !1;
    let lines = lines(x, y, dt_s, segment)?;
    let (low, high) = (lines[0].frequency_hz, lines[lines.len() - 1].frequency_hz);
    if high < BAND_RATIO_MIN * low {
        return None;
    }
    let reach = (1.0 / low).min(0.25 * segment as f64 * dt_s);
    let best = strongest(&lines, reach, high)?;
    let fit = refined(&lines, best)?;
    (resultant(&lines, fit.delay_s) >= RESULTANT_MIN).then_some(fit)
}

/// Lines whose coherence is beyond chance: with a probability of 1 % any at all by chance.
fn lines(x: &[f64], y: &[f64], dt_s: f64, segment: usize) -> Option<Vec<Line>> {
    let s = cross_spectrum(x, y, dt_s, Averaging::Welch { segment });
    let count = s.frequency_hz.len();
    let averages = 0.5 * s.freedom;
    let level = s.coherence_level(0.01 / count as f64);
    let power = |k: usize| s.density_xy[k].norm();
    // the mean and the trend of a segment are in its first two lines, aliases in its last
    let coherent: Vec<usize> = (2..count - 1).filter(|&k| s.coherence(k) > level).collect();
    let total: f64 = coherent.iter().map(|&k| power(k)).sum();
    // what is far below the modes is drift and leakage
    let mut below = 0.0;
    let slowest = coherent.iter().position(|&k| {
        below += power(k);
        below > 0.01 * total
    })?;
    let mut lines: Vec<Line> = Vec::new();
    let mut last = 0;
    for &k in &coherent[slowest..] {
        let c = s.coherence(k).min(1.0 - 1e-9);
        let band = lines.last().map_or(0, |line| line.band + usize::from(k > last + 2));
        let variance = (1.0 - c) / (2.0 * averages * c) + MODAL_PHASE * MODAL_PHASE;
        let phase = -s.density_xy[k].arg();
        lines.push(Line { frequency_hz: s.frequency_hz[k], phase, variance, band });
        last = k;
    }
    (lines.len() >= LINES_MIN).then_some(lines)
}

/// `Σ cos 2(θ - 2π f τ) / v`, over its largest value.
fn resultant(lines: &[Line], delay_s: f64) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for line in lines {
        let weight = 1.0 / line.variance;
        sum += weight * libm::cos(2.0 * (line.phase - 2.0 * PI * line.frequency_hz * delay_s));
        all += weight;
    }
    sum / all
}

/// The delay of the highest resultant, if no other comes near it.
fn strongest(lines: &[Line], reach: f64, high: f64) -> Option<f64> {
    // eight places in the narrowest lobe, 1/(2 f)
    let step = 1.0 / (16.0 * high);
    let places = libm::ceil(reach / step) as i64;
    let at: Vec<f64> = (-places..=places).map(|place| resultant(lines, place as f64 * step)).collect();
    let best = (0..at.len()).max_by(|&i, &j| at[i].total_cmp(&at[j]))?;
    // the lobe of the best ends where the resultant rises again
    let (mut from, mut to) = (best, best);
    while from > 0 && at[from - 1] < at[from] {
        from -= 1;
    }
    while to + 1 < at.len() && at[to + 1] < at[to] {
        to += 1;
    }
    let other = at[..from].iter().chain(&at[(to + 1).min(at.len())..]).copied().fold(-1.0, f64::max);
    // a doubled phase has four times the variance; neighbouring lines of a window share half
    let information: f64 = lines.iter().map(|line| 1.0 / (4.0 * line.variance)).sum::<f64>() / 1.5;
    ((at[best] - other) * information > AMBIGUITY).then(|| (best as i64 - places) as f64 * step)
}

/// Least squares about a delay, an unknown phase of each band with deviation [`MODAL_PHASE`] beside
/// it.
fn refined(lines: &[Line], start: f64) -> Option<Delay> {
    let mut delay_s = start;
    let mut variance = f64::INFINITY;
    for _ in 0..6 {
        let (mut normal, mut right) = (0.0, 0.0);
        let (mut misfit, mut count) = (0.0, 0.0);
        for band in lines.chunk_by(|a, b| a.band == b.band) {
            // weights 1/v; the phase of the band is eliminated: Schur complement of its normal
            // equation
            let (mut w, mut wf, mut wff, mut wr, mut wfr) = (1.0 / (MODAL_PHASE * MODAL_PHASE), 0.0, 0.0, 0.0, 0.0);
            for line in band {
                let turn = 2.0 * PI * line.frequency_hz;
                let off = line.phase - turn * delay_s;
                let off = off - PI * libm::round(off / PI);
                let weight = 1.0 / line.variance;
                w += weight;
                wf += weight * turn;
                wff += weight * turn * turn;
                wr += weight * off;
                wfr += weight * turn * off;
                misfit += weight * off * off;
                count += 1.0;
            }
            normal += wff - wf * wf / w;
            right += wfr - wf * wr / w;
        }
        if normal <= 0.0 {
            return None;
        }
        delay_s += right / normal;
        variance = 1.5 / normal * (misfit / count).max(1.0);
    }
    Some(Delay { delay_s, sigma_s: variance.sqrt() })
}

/// The delay of each channel against the majority of them, `None` where none is reported: below
/// half a sample, below chance, not the same in both halves, or not determined by the phases. All
/// at the same rows of an even clock of step `dt_s`, of one quantity in one unit; the first 16 are
/// compared.
///
/// The majority is the largest set of channels without a delay to one of them; of two channels the
/// later one is delayed. Over all pairs a delay is reported where none exists with probability 10⁻³
/// at most.
///
/// # Panics
/// When lengths differ.
#[must_use]
pub fn delays(channels: &[&[f64]], dt_s: f64) -> Vec<Option<Delay>> {
    let mut told = vec![None; channels.len()];
    let count = channels.len().min(CHANNELS_MAX);
    if count < 2 {
        return told;
    }
    let level = normal_two_sided(DELAY_FALSE_ALARM / (count * (count - 1) / 2) as f64);
    let mut pairs: Vec<Vec<Option<Delay>>> = vec![vec![None; count]; count];
    for i in 0..count {
        for j in i + 1..count {
            pairs[i][j] = between(channels[i], channels[j], dt_s);
            pairs[j][i] = pairs[i][j].map(|d| Delay { delay_s: -d.delay_s, ..d });
        }
    }
    let material = |d: &Delay| d.significant(level) && d.delay_s.abs() >= SAMPLE_SHARE_MIN * dt_s;
    let with = |i: usize| (0..count).filter(|&j| pairs[i][j].is_some_and(|d| !material(&d))).count();
    let late = |i: usize| pairs[i].iter().flatten().filter(|d| material(d) && d.delay_s < 0.0).count();
    // a delay of the chain is the same in every part of the record, a chance of its motion is not
    let lasts = |i: usize, j: usize, whole: &Delay| {
        let (half, n) = (channels[i].len() / 2, channels[i].len());
        [0..half, half..n].into_iter().all(|part| {
            let own = between(&channels[i][part.clone()], &channels[j][part], dt_s);
            own.is_some_and(|d| (d.delay_s - whole.delay_s).abs() <= level * d.sigma_s.hypot(whole.sigma_s))
        })
    };
    // of sets of one size the one with the earliest
    let reference = (0..count).max_by_key(|&i| (with(i), core::cmp::Reverse(late(i)), core::cmp::Reverse(i)));
    for (j, told) in told.iter_mut().enumerate().take(count) {
        let against = reference.and_then(|reference| pairs[reference][j].map(|delay| (reference, delay)));
        *told = against.filter(|(i, d)| material(d) && lasts(*i, j, d)).map(|(_, delay)| delay);
    }
    told
}

#[cfg(test)]
mod tests {
    use super::{between, delays};
    use crate::noise::Noise;

    /// Displacements of two places of a structure under white noise at both, `late` of them read
    /// that many samples later; noise of 2 %.
    fn structure(seed: u64, modes: &[(f64, f64)], rate: f64, n: usize, late: [f64; 3]) -> Vec<Vec<f64>> {
        const FINE: usize = 4;
        let mut noise = Noise::new(seed);
        let dt = 1.0 / (rate * FINE as f64);
        let shapes: Vec<[f64; 3]> = modes.iter().map(|_| [0; 3].map(|_| noise.normal())).collect();
        let mut state = vec![[0.0_f64; 2]; modes.len()];
        let mut fine = vec![Vec::new(); 3];
        for _ in 0..(n + 200) * FINE {
            let mut sum = [0.0; 3];
            for ((hz, damping), (q, shape)) in modes.iter().zip(state.iter_mut().zip(&shapes)) {
                let omega = 2.0 * core::f64::consts::PI * hz;
                // exact turn of the undamped mode, damping and force beside it
                let (s, c) = (omega * dt).sin_cos();
                let (x, v) = (q[0], q[1]);
                q[0] = c * x + s / omega * v;
                q[1] = (-omega * s * x + c * v) * (-2.0 * damping * omega * dt).exp() + noise.normal() * omega;
                (0..3).for_each(|k| sum[k] += shape[k] * q[0]);
            }
            (0..3).for_each(|k| fine[k].push(sum[k]));
        }
        let read = |k: usize| {
            let at = |i: usize| fine[k][(i + 100) * FINE - (late[k] * FINE as f64) as usize];
            let clean: Vec<f64> = (0..n).map(at).collect();
            let sigma = identification::statistics::deviation(&clean);
            clean.iter().map(|v| v + 0.02 * sigma * noise.normal()).collect()
        };
        (0..3).map(read).collect()
    }

    #[test]
    fn a_delay_of_one_channel_is_found_to_its_sigma_whatever_the_signs_of_the_modes() {
        for (seed, samples) in [(1, 7.0), (2, 2.0), (3, 15.0), (4, 1.0), (5, 4.5)] {
            let x = structure(seed, &[(1.5, 0.01), (4.5, 0.015)], 50.0, 12_000, [0.0, samples, 0.0]);
            let found = delays(&[&x[0], &x[1], &x[2]], 0.02);
            let d = found[1].unwrap_or_else(|| panic!("{seed} {samples}: {:?}", between(&x[0], &x[1], 0.02)));
            assert!((d.delay_s - 0.02 * samples).abs() < 4.0 * d.sigma_s + 1e-3, "{seed} {samples} {d:?}");
            assert!(d.sigma_s < 0.01, "{d:?}");
            assert_eq!((found[0], found[2]), (None, None), "{seed}");
        }
    }

    #[test]
    fn structures_without_delay_have_none() {
        let mut told = 0;
        for seed in 0..60 {
            let mut noise = Noise::new(5000 + seed);
            let count = 1 + (4.0 * noise.uniform()) as usize;
            let mode = |noise: &mut Noise| (0.4 * 50.0_f64.powf(noise.uniform()), 0.003 + 0.02 * noise.uniform());
            let modes: Vec<(f64, f64)> = (0..count).map(|_| mode(&mut noise)).collect();
            let x = structure(6000 + seed, &modes, 50.0, 6000, [0.0; 3]);
            told += delays(&[&x[0], &x[1], &x[2]], 0.02).iter().flatten().count();
        }
        assert_eq!(told, 0);
    }

    #[test]
    fn a_derivative_a_filter_and_unrelated_noise_are_no_delay() {
        let mut noise = Noise::new(77);
        let x = &structure(7, &[(1.5, 0.01), (4.5, 0.015)], 50.0, 8000, [0.0; 3])[0];
        let rate: Vec<f64> =
            (0..x.len()).map(|k| if k == 0 { 0.0 } else { x[(k + 1).min(x.len() - 1)] - x[k - 1] }).collect();
        assert_eq!(between(x, &rate, 0.02), None);
        assert_eq!(between(&noise.series(8000, 1.0), &noise.series(8000, 1.0), 0.02), None);
    }
}
