//! Spectral lines of the innovations: candidate frequencies of an unmodelled tone, ripple or mode.

use identification::filter::Linear;
use identification::problem::Timeline;
use realfft::RealFftPlanner;

/// Lines of each list.
pub const LINES: usize = 3;
/// Samples below which there is no spectrum.
const SAMPLES_MIN: usize = 32;
/// Periods in a recording below which a line counts as a drift.
const PERIODS_MIN: usize = 3;
/// An interval may differ from the mean one by this share.
const UNEVENNESS_MAX: f64 = 0.1;

/// Lines of every channel and of all together \[Hz\], and the number of frequencies tested.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    pub channels: Vec<Vec<f64>>,
    pub pooled: Vec<f64>,
    pub looked: usize,
}

/// Strongest lines of the innovations of one run, strongest first; none of a channel that is too
/// short or not evenly sampled.
///
/// Power of each channel is relative to its mean, so that channels of any unit may be pooled. Cost:
/// O(n log n) per channel.
pub fn lines(linear: &Linear, timeline: &Timeline, channels: usize) -> Lines {
    let mut found = Lines::default();
    let mut pool: Vec<(f64, f64)> = Vec::new();
    // where the pass starts elsewhere than at the prior's mean, the oscillation from that mean is
    // no line
    let nu: Vec<f64> = linear.nu.iter().zip(&linear.pull).map(|(nu, pull)| nu - pull).collect();
    for channel in 0..channels {
        let peaks = periodogram(&nu, timeline, channel).map_or_else(Vec::new, |(step_hz, power)| {
            found.looked = found.looked.max(power.len());
            peaks(step_hz, &power)
        });
        found.channels.push(peaks.iter().take(LINES).map(|(_, f)| *f).collect());
        pool.extend(peaks);
    }
    pool.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.pooled = pool.into_iter().take(LINES).map(|(_, f)| f).collect();
    found
}

/// Spacing of the frequencies and power relative to the mean, from the first frequency on.
fn periodogram(nu: &[f64], timeline: &Timeline, channel: usize) -> Option<(f64, Vec<f64>)> {
    let own: Vec<usize> = (0..nu.len()).filter(|s| timeline.channel[*s] == channel).collect();
    let n = own.len() & !1;
    if n < SAMPLES_MIN {
        return None;
    }
    let period_s = (timeline.stamp_s[own[n - 1]] - timeline.stamp_s[own[0]]) / (n - 1) as f64;
    let even = |pair: &[usize]| {
        (timeline.stamp_s[pair[1]] - timeline.stamp_s[pair[0]] - period_s).abs() <= UNEVENNESS_MAX * period_s
    };
    if !own[..n].windows(2).all(even) {
        return None;
    }
    let mean = own[..n].iter().map(|s| nu[*s]).sum::<f64>() / n as f64;
    let mut series: Vec<f64> = own[..n].iter().map(|s| nu[*s] - mean).collect();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut series, &mut spectrum).ok()?;
    let mut power: Vec<f64> = spectrum[1..n / 2].iter().map(|x| x.norm_sqr()).collect();
    let level = power.iter().sum::<f64>() / power.len() as f64;
    power.iter_mut().for_each(|p| *p /= level);
    (level > 0.0 && level.is_finite()).then_some((1.0 / (n as f64 * period_s), power))
}

/// Power and frequency of the local maxima, largest first.
fn peaks(step_hz: f64, power: &[f64]) -> Vec<(f64, f64)> {
    let last = power.len() - 1;
    let top = |k: &usize| power[*k] >= power[k.saturating_sub(1)] && power[*k] >= power[(*k + 1).min(last)];
    let mut list: Vec<(f64, f64)> =
        (PERIODS_MIN - 1..power.len()).filter(top).map(|k| (power[k], step_hz * (k + 1) as f64)).collect();
    list.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    list.truncate(LINES);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strongest_lines_come_first_at_their_frequencies() {
        let tau = core::f64::consts::TAU;
        let at = |hz: f64, k: usize| libm::sin(tau * hz * k as f64 / 64.0);
        let mut series: Vec<f64> = (0..256).map(|k| at(3.0, k) + 2.0 * at(11.25, k)).collect();
        let plan = RealFftPlanner::<f64>::new().plan_fft_forward(256);
        let mut spectrum = plan.make_output_vec();
        plan.process(&mut series, &mut spectrum).unwrap();
        let power: Vec<f64> = spectrum[1..128].iter().map(|x| x.norm_sqr()).collect();
        let found = peaks(0.25, &power);
        assert_eq!((found[0].1, found[1].1), (11.25, 3.0));
    }
}
