//! Spectra of all channels of a record behind a Hann window, zero padded to a power of two.

use super::baseband::{Samples, hann};
use super::fourier::transform;
use faer::c64;

/// Bins `0 … n/2 − 1` of every channel; samples that do not exist are zeros.
pub(super) struct Spectra {
    channels: Vec<Vec<c64>>,
    /// Bins per cell, a cell being the inverse of the record's duration.
    per_cell: f64,
}

impl Spectra {
    /// Cost: a transform of twice the rows for every two channels.
    pub fn new(samples: &Samples) -> Self {
        let (rows, l) = (samples.rows(), samples.channels);
        let length = (2 * rows).next_power_of_two();
        let mut channels = Vec::with_capacity(l);
        let mut x = vec![c64::new(0.0, 0.0); length];
        // Two real channels per transform.
        for pair in (0..l).step_by(2) {
            x.fill(c64::new(0.0, 0.0));
            for (t, row) in samples.values.chunks_exact(l).enumerate() {
                let w = hann(t, rows);
                let value = |c: usize| row.get(c).filter(|y| y.is_finite() && c < l).map_or(0.0, |y| w * y);
                x[t] = c64::new(value(pair), value(pair + 1));
            }
            transform(&mut x);
            let mirrored = |k: usize| x[(length - k) % length].conj();
            channels.push((0..length / 2).map(|k| (x[k] + mirrored(k)) * 0.5).collect());
            if pair + 1 < l {
                let turned = c64::new(0.0, -0.5);
                channels.push((0..length / 2).map(|k| (x[k] - mirrored(k)) * turned).collect());
            }
        }
        Self { channels, per_cell: length as f64 / rows as f64 }
    }

    /// Bins per cell.
    pub fn per_cell(&self) -> f64 {
        self.per_cell
    }

    /// Sum over the channels, each in units of its variance; zero at zero frequency.
    pub fn power(&self, variances: &[f64]) -> Vec<f64> {
        let mut power = vec![0.0; self.channels[0].len()];
        for (channel, variance) in self.channels.iter().zip(variances).filter(|(_, variance)| **variance > 0.0) {
            power.iter_mut().zip(channel).skip(1).for_each(|(sum, y)| *sum += y.norm_sqr() / variance);
        }
        power
    }

    /// All channels in the bin nearest to so many cells; `None` beyond the spectrum.
    pub fn at(&self, cells: f64) -> Option<Vec<c64>> {
        let bin = libm::round(cells * self.per_cell);
        let is_inside = bin >= 1.0 && (bin as usize) < self.channels[0].len();
        is_inside.then(|| self.channels.iter().map(|channel| channel[bin as usize]).collect())
    }
}
