//! Tones of the innovations that last for a part of a recording.
//!
//! Of a tone that lasts for a share `s` of a recording the whole spectrum shows `s²` of its power
//! in one line, the spectrum of its own time all of it.

use super::lines::{LINES, PERIODS_MIN, SAMPLES_MIN};
use realfft::RealFftPlanner;

/// Halvings of the recording: windows of a half to a sixteenth, each a half of its length behind
/// the last. A budget.
const HALVINGS: u32 = 4;

/// A tone in its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burst {
    pub frequency_hz: f64,
    pub begin_s: f64,
    pub duration_s: f64,
}

/// Samples of one channel about their mean.
pub(super) struct Even {
    pub begin_s: f64,
    pub period_s: f64,
    pub values: Vec<f64>,
}

/// The strongest tones of windows of all `channels`, each once, and how many were tested; power is
/// relative to the mean of the channel over the whole recording.
///
/// Cost: O(n log n) for each channel and halving.
pub(super) fn bursts(channels: impl Iterator<Item = Even>) -> (Vec<Burst>, usize) {
    let (mut pool, mut looked) = (Vec::new(), 0);
    for channel in channels {
        let n = channel.values.len();
        let level = channel.values.iter().map(|value| value * value).sum::<f64>() / n as f64;
        for halving in 1..=HALVINGS {
            let window = (n >> halving) & !1;
            if window < SAMPLES_MIN || level <= 0.0 {
                break;
            }
            for first in (0..=n - window).step_by(window / 2) {
                looked += window / 2;
                pool.extend(strongest(&channel, first, window, level));
            }
        }
    }
    pool.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<Burst> = Vec::new();
    for (_, own) in pool {
        if found.len() < LINES && !found.iter().any(|other| are_one(&own, other)) {
            found.push(own);
        }
    }
    (found, looked)
}

/// The strongest tone of a window, with its power over that of white noise.
fn strongest(channel: &Even, first: usize, window: usize, level: f64) -> Option<(f64, Burst)> {
    let power = power(channel.values[first..first + window].to_vec())?;
    let all = (PERIODS_MIN - 1..power.len()).map(|k| (power[k] / (level * window as f64), k));
    let (height, k) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let duration_s = window as f64 * channel.period_s;
    let begin_s = channel.begin_s + first as f64 * channel.period_s;
    Some((height, Burst { frequency_hz: (k + 1) as f64 / duration_s, begin_s, duration_s }))
}

/// Both overlap in time, and are within a line's width of each other.
fn are_one(a: &Burst, b: &Burst) -> bool {
    let overlap = a.begin_s < b.begin_s + b.duration_s && b.begin_s < a.begin_s + a.duration_s;
    overlap && (a.frequency_hz - b.frequency_hz).abs() <= 1.5 / a.duration_s.min(b.duration_s)
}

/// `|X|²` from the first frequency on, without the last one, of an even number of `values`.
pub(super) fn power(mut values: Vec<f64>) -> Option<Vec<f64>> {
    let n = values.len();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut values, &mut spectrum).ok()?;
    Some(spectrum[1..n / 2].iter().map(|x| x.norm_sqr()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    #[test]
    fn a_tone_of_a_twelfth_of_the_recording_comes_first_at_its_frequency_and_time() {
        for seed in 1..=5 {
            let mut values: Vec<f64> = Noise::new(seed).series(4000, 1.0);
            let phase = |k: usize| core::f64::consts::TAU * 0.9 * k as f64 * 0.01;
            // d of 14: the whole spectrum's line of 16 nats is no higher than what noise reaches
            (2700..3033).for_each(|k| values[k] += 1.1 * libm::sin(phase(k)));
            let (found, _) = bursts([Even { begin_s: 5.0, period_s: 0.01, values }].into_iter());
            let first = found[0];
            assert!((first.frequency_hz - 0.9).abs() < 0.5 / first.duration_s, "{first:?}");
            let [begin, end] = [first.begin_s, first.begin_s + first.duration_s];
            assert!(begin < 32.0 + 1.67 && end > 32.0 + 1.67, "{first:?}");
            assert!(first.duration_s < 6.0, "{first:?}");
        }
    }
}
