//! Cumulative sums: a small lasting change of a mean, seen as early as a stated rate of false
//! alarms allows.
//!
//! Page's two-sided CUSUM over normalised values `x`:
//!
//! `S⁺ ← max(0, S⁺ + x − k)`, `S⁻ ← max(0, S⁻ − x − k)`, alarm when either exceeds `H`.
//!
//! `H` follows from the false-alarm probability over a stated number of samples through Siegmund's
//! mean run length `(e^{2kb} − 2kb − 1)/(2k²)`, `b = H + 1.166`, for each side (Siegmund 1985). A
//! shift of δ sigmas is seen after about `H/(δ − k)` samples.
//!
//! *Why not a χ² per sample?* It needs 5 σ in one sample for the same rate; the CUSUM sees 1 σ
//! within 35 samples.

use serde::{Deserialize, Serialize};

/// Slack of the cumulative sum \[sigma\]: half the smallest shift that is to be seen.
pub const SLACK: f64 = 0.5;
/// Mean overshoot of a Gaussian random walk, twice 0.583 (Siegmund 1985).
const OVERSHOOT: f64 = 1.166;

/// Probability of a false alarm over a number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FalseAlarm {
    /// Probability of a false alarm over all `samples`.
    pub probability: f64,
    pub samples: f64,
}

/// Mean number of samples until one side alone passes `limit` on white unit noise (Siegmund's
/// approximation).
fn mean_run_length(limit: f64) -> f64 {
    let x = 2.0 * SLACK * (limit + OVERSHOOT);
    (libm::exp(x) - x - 1.0) / (2.0 * SLACK * SLACK)
}

/// Limit at which both sides together alarm with the stated probability: alarms come as a Poisson
/// process of rate `2/ARL`, so `ARL = −2 N / ln(1 − P)`.
pub fn cusum_limit(alarm: FalseAlarm) -> f64 {
    const BISECTIONS: u32 = 60;
    assert!(alarm.probability > 0.0);
    assert!(alarm.probability < 1.0);
    assert!(alarm.samples >= 1.0);
    let wanted = -2.0 * alarm.samples / libm::log(1.0 - alarm.probability);
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if mean_run_length(middle) < wanted { low = middle } else { high = middle }
    }
    high
}

/// Two-sided cumulative sum of normalised values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cusum {
    limit: f64,
    upper: f64,
    lower: f64,
}

impl Cusum {
    /// A detector with the limit of `alarm`, both sums zero.
    pub fn new(alarm: FalseAlarm) -> Self {
        Self { limit: cusum_limit(alarm), upper: 0.0, lower: 0.0 }
    }

    /// Limit of the statistic \[sigma\].
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// The larger of both sums after `normalised`; a slack beyond [`SLACK`] can only lower the rate
    /// of false alarms.
    pub fn push(&mut self, normalised: f64, slack: f64) -> f64 {
        self.upper = (self.upper + normalised - slack).max(0.0);
        self.lower = (self.lower - normalised - slack).max(0.0);
        self.upper.max(self.lower)
    }
}

/// Samples from which the scatter is learned, and over which the mean follows slow changes.
pub const BASELINE_SAMPLES: u32 = 100;
/// Samples before the first decision: the scatter of fewer is too uncertain.
const BASELINE_MIN: u32 = 8;
/// Errors of the learned mean and scatter that are allowed for [standard deviations].
const BASELINE_SIGMAS: f64 = 3.0;

/// A jump of a signal away from its own running mean, by a CUSUM that starts itself (after Hawkins
/// 1987).
///
/// With `n` samples behind it, at most [`BASELINE_SAMPLES`], mean and scatter are known to `σ/√n`
/// and `σ/√(2n)`. The scatter is taken larger and the slack wider by three of these, so alarms come
/// no oftener than stated from the first decision on. The scatter is never taken smaller than the
/// noise the sensors must have. Afterwards the mean follows with gain `1/n`: it does not detect a
/// constant error, nor a drift of up to half a sigma in `n` samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JumpDetector {
    cusum: Cusum,
    samples: u32,
    mean: f64,
    /// Sum of squared deviations over the first [`BASELINE_SAMPLES`].
    squares: f64,
}

impl JumpDetector {
    /// A detector with the limit of `alarm`, before its first sample.
    pub fn new(alarm: FalseAlarm) -> Self {
        Self { cusum: Cusum::new(alarm), samples: 0, mean: 0.0, squares: 0.0 }
    }

    /// Limit of the statistic \[sigma\].
    pub fn limit(&self) -> f64 {
        self.cusum.limit()
    }

    /// Gain with which the next sample enters the mean.
    pub fn gain(&self) -> f64 {
        1.0 / f64::from((self.samples + 1).min(BASELINE_SAMPLES))
    }

    /// Takes a value with the sensor noise it must have (0: not known) and the error `drift_sigma`
    /// that a model may have made since the baseline, which widens the slack by three times itself.
    /// `None` while too little is known, else the statistic: a jump when it exceeds
    /// [`Self::limit`].
    ///
    /// Values must be finite.
    pub fn push(&mut self, value: f64, noise_sigma: f64, drift_sigma: f64) -> Option<f64> {
        let statistic = (self.samples >= BASELINE_MIN).then(|| self.decide(value, noise_sigma, drift_sigma)).flatten();
        let deviation = value - self.mean;
        self.mean += self.gain() * deviation;
        if self.samples < BASELINE_SAMPLES {
            self.squares += deviation * (value - self.mean);
            self.samples += 1;
        }
        statistic
    }

    fn decide(&mut self, value: f64, noise_sigma: f64, drift_sigma: f64) -> Option<f64> {
        let n = f64::from(self.samples);
        let scatter = libm::sqrt(self.squares / (n - 1.0)) * (1.0 + BASELINE_SIGMAS / libm::sqrt(2.0 * n));
        let sigma = scatter.max(noise_sigma);
        // A signal without any noise (a dead sensor, a constant) has no scale on which a jump could
        // be judged.
        (sigma > 0.0).then(|| {
            let slack = SLACK + BASELINE_SIGMAS * (1.0 / libm::sqrt(n) + drift_sigma / sigma);
            self.cusum.push((value - self.mean) / sigma, slack)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;

    #[test]
    fn alarms_on_unit_noise_come_as_often_as_stated() {
        // 2000 runs of 2000 samples at 20 %: 400 ± 18; Siegmund's approximation is good to about 5
        // % here.
        let often = FalseAlarm { probability: 0.2, samples: 2000.0 };
        let mut alarms = 0;
        for seed in 0..2000 {
            let (mut noise, mut cusum) = (SeededNoise::new(seed), Cusum::new(often));
            alarms += u32::from((0..2000).any(|_| cusum.push(noise.normal(), SLACK) > cusum.limit()));
        }
        assert!((300..=480).contains(&alarms), "{alarms}");
    }

    #[test]
    fn a_shift_is_seen_after_the_limit_over_its_excess() {
        let rare = FalseAlarm { probability: 1e-3, samples: 1e5 };
        for shift in [1.0, 2.0, 5.0] {
            let (mut sum, limit) = (0.0, cusum_limit(rare));
            for seed in 0..200 {
                let (mut noise, mut cusum) = (SeededNoise::new(seed), Cusum::new(rare));
                let seen = (1..1000).find(|_| cusum.push(noise.normal() - shift, SLACK) > limit);
                sum += f64::from(seen.expect("a persistent shift is seen"));
            }
            // (H + overshoot + start-up)/(δ − k), overshoot and start-up together up to 2 sigmas +
            // one sample.
            let (mean, expected) = (sum / 200.0, limit / (shift - SLACK));
            assert!(
                mean > 0.9 * expected && mean < expected + 2.0 / (shift - SLACK) + 1.0,
                "{shift}: {mean} {expected}"
            );
        }
    }

    #[test]
    fn a_jump_detector_alarms_no_oftener_than_stated_whatever_the_offset_and_the_scale() {
        // 2000 runs at 20 %, so at most 400 + 4 · 18 alarms, with the noise known and not known.
        let often = FalseAlarm { probability: 0.2, samples: 2000.0 };
        for (scale, noise_sigma) in [(1.0, 1.0), (1.0, 0.0), (1e-4, 0.0), (30.0, 1.0)] {
            let mut alarms = 0;
            for seed in 0..2000 {
                let (mut noise, mut jump) = (SeededNoise::new(seed), JumpDetector::new(often));
                let limit = jump.limit();
                alarms += u32::from(
                    (0..2000)
                        .any(|_| jump.push(7.0 + scale * noise.normal(), noise_sigma, 0.0).is_some_and(|s| s > limit)),
                );
            }
            assert!(alarms <= 472, "{scale} {noise_sigma}: {alarms}");
        }
    }

    #[test]
    fn a_drift_of_half_a_sigma_per_baseline_is_no_jump_and_four_sigmas_are() {
        let rare = FalseAlarm { probability: 1e-3, samples: 1e5 };
        for seed in 0..100 {
            let (mut noise, mut jump) = (SeededNoise::new(seed), JumpDetector::new(rare));
            for k in 0..3000 {
                let drift = 0.5 * f64::from(k) / f64::from(BASELINE_SAMPLES);
                let statistic = jump.push(drift + noise.normal(), 1.0, 0.0).unwrap_or(0.0);
                assert!(statistic <= jump.limit(), "seed {seed}, sample {k}");
            }
            // Scatter taken 1.2 times: 3.3 sigmas at first against a slack of 0.8 and a limit of
            // 18, the mean behind by 100.
            let mean = jump.mean;
            let seen = (0..100).find(|_| jump.push(mean + 4.0 + noise.normal(), 1.0, 0.0) > Some(jump.limit()));
            assert!(seen.is_some(), "seed {seed}");
        }
    }

    #[test]
    fn a_constant_without_noise_decides_nothing() {
        let mut jump = JumpDetector::new(FalseAlarm { probability: 1e-3, samples: 1e5 });
        assert!((0..200).all(|_| jump.push(0.25, 0.0, 0.0).is_none()));
    }
}
