//! Halving the sample rate of a stream behind a half-band anti-alias filter, output only where the
//! filter is full.
//!
//! A filtered free decay is a free decay with the same poles (every output is a fixed sum of
//! shifted decays), as long as the filter sees nothing from before the segment; therefore the first
//! outputs of a segment are withheld. Linear-phase FIR of 47 taps, Kaiser window for 70 dB: pass
//! band to 0.40, stop band from 0.60 of the output rate, so that nothing folds onto the pass band.
//! Kaiser 1974; Oppenheim & Schafer section 7.6.

use serde::{Deserialize, Serialize};

use crate::history::SlidingHistory;

const TAPS: usize = 47;
/// Kaiser shape for 70 dB: 0.1102 (70 − 8.7).
pub(crate) const KAISER_BETA: f64 = 6.755;
/// Upper edge of the pass band, relative to the output sample rate.
pub const PASS_BAND: f64 = 0.40;

/// One halving of the sample rate.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HalfBand {
    history: SlidingHistory,
    taps: Vec<f64>,
    filled: usize,
    output: Vec<f64>,
}

impl HalfBand {
    /// A decimator of `channels` channels with an empty filter. All memory is allocated here.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            history: SlidingHistory::new(channels, TAPS),
            taps: half_band_taps(),
            filled: 0,
            output: vec![0.0; channels],
        }
    }

    /// Adds a sample; every second one gives an output once the filter is full. Cost: 24
    /// multiply-adds per channel and output.
    pub fn push(&mut self, sample: &[f64]) -> Option<&[f64]> {
        self.history.push(sample);
        self.filled += 1;
        if self.filled < TAPS {
            return None;
        }
        if self.filled > TAPS {
            self.filled = TAPS - 1; // the next sample fills it again
            return None;
        }
        let channels = sample.len();
        self.output.fill(0.0);
        for (tap, lagged) in self.taps.iter().zip(self.history.newest_first().chunks_exact(channels)) {
            if *tap != 0.0 {
                for (out, y) in self.output.iter_mut().zip(lagged) {
                    *out += tap * y;
                }
            }
        }
        Some(&self.output)
    }

    /// Clears the filter: a new segment begins.
    pub fn clear(&mut self) {
        self.history.clear();
        self.filled = 0;
    }
}

/// `g_n = Σ_m h_m h_{m+n}` of the filter, n from −46 to 46: what it does to covariances.
pub(crate) fn autocorrelation() -> Vec<f64> {
    let taps = half_band_taps();
    let shifted = |n: i32| {
        let product = |m: i32| taps[m as usize] * taps.get((m + n) as usize).copied().unwrap_or(0.0);
        (0.max(-n)..TAPS as i32).map(product).sum()
    };
    (1 - TAPS as i32..TAPS as i32).map(shifted).collect()
}

fn half_band_taps() -> Vec<f64> {
    let centre = (TAPS / 2) as i32;
    let mut taps: Vec<f64> = (0..TAPS as i32)
        .map(|index| {
            let offset = index - centre;
            if offset == 0 {
                return 0.5;
            }
            if offset % 2 == 0 {
                return 0.0;
            }
            let x = std::f64::consts::PI * f64::from(offset);
            let across = f64::from(offset) / (f64::from(centre) + 1.0);
            libm::sin(0.5 * x) / x * bessel_i0(KAISER_BETA * libm::sqrt(1.0 - across * across)) / bessel_i0(KAISER_BETA)
        })
        .collect();
    let gain: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|tap| *tap /= gain);
    taps
}

/// Modified Bessel function of order zero by its power series; 40 terms reach rounding for
/// arguments below 10.
pub(crate) fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        let half = 0.5 * x / f64::from(k);
        term *= half * half;
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(frequency: f64) -> f64 {
        let centre = (TAPS / 2) as f64;
        half_band_taps()
            .iter()
            .enumerate()
            .map(|(n, tap)| tap * libm::cos(2.0 * std::f64::consts::PI * frequency * (n as f64 - centre)))
            .sum::<f64>()
            .abs()
    }

    #[test]
    fn pass_band_is_flat_and_stop_band_is_70_db_down_so_that_nothing_folds_onto_the_pass_band() {
        for step in 0..=100 {
            let across = f64::from(step) / 100.0;
            // Frequencies relative to the input rate: pass band 0 .. 0.2, stop band 0.3 .. 0.5; 70
            // dB is 3.2e-4 (design: 1e-3 bound).
            assert!((gain(0.2 * across) - 1.0).abs() < 1e-3, "pass {across}");
            assert!(gain(0.3 + 0.2 * across) < 1e-3, "stop {across}");
        }
    }

    #[test]
    fn a_filtered_free_decay_is_the_same_free_decay_from_its_first_output_on() {
        // z² − 2 ρ cos θ z + ρ² annihilates a decay; after decimation by 2 the poles are squared.
        let (rho, theta) = (0.97, 0.2);
        let mut stage = HalfBand::new(1);
        let outputs: Vec<f64> = (0..300)
            .filter_map(|t| {
                let t = f64::from(t);
                stage.push(&[libm::pow(rho, t) * libm::cos(theta * t + 0.3)]).map(|out| out[0])
            })
            .collect();
        assert_eq!(outputs.len(), (300 - TAPS) / 2 + 1);
        for w in outputs.windows(3) {
            let residual = w[2] - 2.0 * rho * rho * libm::cos(2.0 * theta) * w[1] + libm::pow(rho, 4.0) * w[0];
            assert!(residual.abs() < 1e-14); // rounding of 47 products of numbers below one
        }
    }
}
