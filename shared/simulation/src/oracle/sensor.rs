//! A sensor of the special simulators: white noise, then quantisation.

use crate::sensor::quantise;
use dynamics::noise::Stream;

/// One scalar channel: `measured = quantise(true + σ n_k, lsb)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    stream: Stream,
    /// Standard deviation of one sample [unit of the channel].
    sigma: f64,
    /// Least significant bit [unit of the channel]; 0 = not quantised.
    lsb: f64,
}

impl Channel {
    /// Channel with white noise of standard deviation `sigma` per sample.
    pub fn white(stream: Stream, sigma: f64) -> Self {
        Self::quantised(stream, sigma, 0.0)
    }

    /// Channel with white noise of standard deviation `sigma`, rounded to multiples of `lsb` (0 =
    /// not rounded).
    pub fn quantised(stream: Stream, sigma: f64, lsb: f64) -> Self {
        assert!(sigma >= 0.0 && sigma.is_finite());
        assert!(lsb >= 0.0 && lsb.is_finite());
        Self { stream, sigma, lsb }
    }

    /// Measurement number `sample` of the value `truth`.
    pub fn measure(&self, truth: f64, sample: u64) -> f64 {
        quantise(truth + self.sigma * self.stream.normal(sample), self.lsb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantisation_error_is_uniform_and_adds_lsb_squared_over_twelve() {
        let (sigma, lsb) = (1.2e-5, 1.198e-5);
        let channel = Channel::quantised(Stream::new(1, "angle"), sigma, lsb);
        let n = 200_000u64;
        // a moving truth, so that the quantiser sees all phases
        let sum: f64 =
            (0..n).map(|k| 1e-3 * k as f64).enumerate().map(|(k, t)| (channel.measure(t, k as u64) - t).powi(2)).sum();
        let expected = sigma * sigma + lsb * lsb / 12.0;
        // relative standard error of a variance √(2/N) = 0.32 %; 4.5 of them
        assert!((sum / n as f64 / expected - 1.0).abs() < 4.5 * (2.0 / n as f64).sqrt());
    }
}
