//! Are innovations white? Block means at several lengths, lag one, and Ljung and Box's statistic.

use super::{ChiSquareMean, DEGREES_MIN, z_score_limit};
use serde::{Deserialize, Serialize};

/// Block lengths of [`Whiteness`], in samples.
pub const WHITENESS_SCALES: [u32; 3] = [1, 10, 100];

/// One scale of [`Whiteness`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct BlockMeans {
    partial_sum: f64,
    partial_count: u32,
    squares: ChiSquareMean,
}

/// Result of [`Whiteness`] at one scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScaleVerdict {
    pub block_samples: u32,
    pub blocks: u64,
    /// Mean of `(block mean / its predicted standard deviation)²`; one when white.
    pub mean_square: f64,
    /// `(χ² − n) / √(2n)`.
    pub z_score: f64,
}

/// Multi-scale test that normalised innovations are unit, independent and of zero mean. Fixed
/// memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Whiteness {
    scales: [BlockMeans; WHITENESS_SCALES.len()],
    previous: Option<f64>,
    lag_one_sum: f64,
    square_sum: f64,
    lag_one_count: u64,
}

impl Whiteness {
    /// Takes one normalised innovation (innovation over its predicted standard deviation).
    pub fn push(&mut self, normalised: f64) {
        for (scale, samples) in self.scales.iter_mut().zip(WHITENESS_SCALES) {
            scale.partial_sum += normalised;
            scale.partial_count += 1;
            if scale.partial_count == samples {
                scale.squares.push(scale.partial_sum * scale.partial_sum / f64::from(samples), 1);
                scale.partial_sum = 0.0;
                scale.partial_count = 0;
            }
        }
        if let Some(previous) = self.previous {
            self.lag_one_sum += previous * normalised;
            self.lag_one_count += 1;
        }
        self.square_sum += normalised * normalised;
        self.previous = Some(normalised);
    }

    /// One verdict per scale of [`WHITENESS_SCALES`]; a scale without a complete block has
    /// `blocks = 0`.
    pub fn verdicts(&self) -> [ScaleVerdict; WHITENESS_SCALES.len()] {
        core::array::from_fn(|i| ScaleVerdict {
            block_samples: WHITENESS_SCALES[i],
            blocks: self.scales[i].squares.count(),
            mean_square: self.scales[i].squares.mean().unwrap_or(0.0),
            z_score: self.scales[i].squares.z_score().unwrap_or(0.0),
        })
    }

    /// Largest z-score over the scales.
    pub fn worst_z_score(&self) -> f64 {
        self.verdicts().iter().map(|verdict| verdict.z_score).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Autocorrelation at lag one; `None` before two samples. Its standard deviation is `1/√n` for
    /// white input.
    pub fn lag_one_autocorrelation(&self) -> Option<f64> {
        (self.lag_one_count > 0 && self.square_sum > 0.0).then(|| self.lag_one_sum / self.square_sum)
    }
}

/// The block lengths on which white innovations can be tested, each as (z-score, limit);
/// `false_alarm` is shared by all of them (Bonferroni).
///
/// `scales` are (complete blocks, z-score of their mean square). A length of which no three blocks
/// were completed is not tested.
pub fn tested_scales(
    scales: impl Iterator<Item = (f64, f64)> + Clone,
    false_alarm: f64,
) -> impl Iterator<Item = (f64, f64)> {
    let tested = scales.clone().filter(|(blocks, _)| *blocks >= DEGREES_MIN).count();
    let shared = false_alarm / tested.max(1) as f64;
    scales.filter_map(move |(blocks, z_score)| Some((z_score, z_score_limit(blocks, shared)?)))
}

/// The tested scale that exceeds its limit by the largest factor, as (z-score, limit); `None` when
/// all are white.
pub fn coloured_scale(tested: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    // A NaN is no proof of whiteness.
    let coloured = |(z_score, limit): &(f64, f64)| {
        let white = z_score <= limit;
        !white
    };
    tested.filter(coloured).max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))
}

/// Ljung and Box's portmanteau statistic `n (n + 2) Σ_l ρ_l² / (n − l)` over `lags`
/// autocorrelations about zero: χ² with `lags` degrees of freedom when `x` is white. `None` below
/// three samples a lag or without power.
///
/// Sees colour of any shape but of short memory; small lasting errors are for [`Whiteness`]. Cost:
/// O(n lags).
pub fn ljung_box(x: &[f64], lags: usize) -> Option<f64> {
    let n = x.len();
    let power: f64 = x.iter().map(|value| value * value).sum();
    if n < 3 * lags || power.is_nan() || power <= 0.0 {
        return None;
    }
    let share = |lag: usize| {
        let rho = x[lag..].iter().zip(x).map(|(later, earlier)| later * earlier).sum::<f64>() / power;
        rho * rho / (n - lag) as f64
    };
    Some(n as f64 * (n as f64 + 2.0) * (1..=lags).map(share).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;

    #[test]
    fn white_noise_stays_inside_its_band_at_every_scale() {
        // z of 3 scales × 100 seeds; a unit-variance z beyond 4.5 happens once in 10⁵ (χ² skew
        // included).
        for seed in 0..100 {
            let (mut noise, mut white) = (SeededNoise::new(seed), Whiteness::default());
            for _ in 0..20_000 {
                white.push(noise.normal());
            }
            for verdict in white.verdicts() {
                assert!(verdict.z_score.abs() < 4.5, "seed {seed}: {verdict:?}");
            }
            assert!(white.lag_one_autocorrelation().expect("20 000 samples").abs() < 4.5 / 20_000.0_f64.sqrt());
        }
    }

    #[test]
    fn a_tenth_of_a_sigma_is_invisible_per_sample_and_evident_in_block_means() {
        let (mut noise, mut white) = (SeededNoise::new(1), Whiteness::default());
        for _ in 0..100_000 {
            white.push(noise.normal() + 0.1);
        }
        let [single, _, hundred] = white.verdicts();
        assert!(single.z_score < 5.0, "{single:?}"); // expected 0.01 · √(10⁵/2) = 2.2, spread 1
        assert!(hundred.z_score > 15.0, "{hundred:?}"); // expected 1 · √(10³/2) = 22, spread √3
    }

    #[test]
    fn alternating_innovations_are_caught_by_lag_one_only() {
        let mut white = Whiteness::default();
        for k in 0..1000 {
            white.push(if k % 2 == 0 { 1.0 } else { -1.0 });
        }
        assert!(white.lag_one_autocorrelation().expect("1000 samples") < -0.99);
        assert!(white.verdicts()[0].z_score.abs() < 1e-12);
    }

    #[test]
    fn ljung_box_of_white_noise_is_chi_square_of_its_lags_and_of_coloured_noise_far_above() {
        let (mut noise, mut sum, mut above) = (SeededNoise::new(5), 0.0, 0);
        for _ in 0..400 {
            let white: [f64; 500] = core::array::from_fn(|_| noise.normal());
            let statistic = ljung_box(&white, 20).expect("500 samples");
            sum += statistic / 400.0;
            above += u32::from(statistic > 31.41); // chi-square of 20, 95 %
        }
        assert!((sum - 20.0).abs() < 4.0 * 40.0_f64.sqrt() / 20.0, "{sum}"); // four sigmas of a mean of 400
        assert!((4..=38).contains(&above), "{above}"); // 20 expected, four sigmas of a binomial
        let mut state = 0.0;
        let coloured: [f64; 500] = core::array::from_fn(|_| {
            state = 0.3 * state + noise.normal();
            state
        });
        // n rho^2 / (1 - rho^2) = 49 expected of the first lags alone
        assert!(ljung_box(&coloured, 20).expect("500 samples") > 45.0);
    }

    #[test]
    fn ljung_box_says_nothing_of_a_short_or_a_silent_series() {
        assert_eq!(ljung_box(&[1.0; 59], 20), None);
        assert_eq!(ljung_box(&[0.0; 60], 20), None);
        assert_eq!(ljung_box(&[f64::NAN; 60], 20), None);
    }

    #[test]
    fn the_worst_coloured_scale_is_named_and_one_without_three_blocks_is_not_tested() {
        let scales = [(6000.0, 1.0), (600.0, 9.0), (60.0, 5.0), (2.0, 99.0)];
        let tested = || tested_scales(scales.into_iter(), 1e-3);
        assert_eq!(tested().count(), 3);
        let (z_score, limit) = coloured_scale(tested()).expect("nine sigmas");
        assert_eq!((z_score, Some(limit)), (9.0, z_score_limit(600.0, 1e-3 / 3.0)));
        assert_eq!(coloured_scale(tested_scales([(60.0, 1.0)].into_iter(), 1e-3)), None);
        assert!(coloured_scale(tested_scales([(60.0, f64::NAN)].into_iter(), 1e-3)).is_some());
    }
}
