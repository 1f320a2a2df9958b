//! A narrow band of a record, moved to zero frequency: its complex envelope.

use super::fourier::turn;
use core::f64::consts::{PI, TAU};
use faer::c64;

/// Rows of a record that an envelope is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Present {
    /// With a value of any channel.
    Any,
    /// With a value of every channel: what the weights take out, they take out of whole rows.
    All,
}

/// Multichannel samples without their means; NaN where none exists.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub values: Vec<f64>,
    pub channels: usize,
    pub rate_hz: f64,
}

impl Samples {
    /// Takes the mean and the trend out of every channel.
    pub fn new(values: &[f64], channels: usize, rate_hz: f64) -> Self {
        let mut samples = Self { values: values.to_vec(), channels, rate_hz };
        for c in 0..channels {
            samples.detrend(c);
        }
        samples
    }

    fn detrend(&mut self, channel: usize) {
        let rows = self.rows();
        let centre = 0.5 * (rows as f64 - 1.0);
        let (mut n, mut t, mut tt, mut y, mut ty) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for row in 0..rows {
            let (x, value) = (row as f64 - centre, self.values[row * self.channels + channel]);
            if value.is_finite() {
                (n, t, tt, y, ty) = (n + 1.0, t + x, tt + x * x, y + value, ty + x * value);
            }
        }
        let determinant = n * tt - t * t;
        let slope = if determinant > 0.0 { (n * ty - t * y) / determinant } else { 0.0 };
        let level = if n > 0.0 { (y - slope * t) / n } else { 0.0 };
        for row in 0..rows {
            self.values[row * self.channels + channel] -= level + slope * (row as f64 - centre);
        }
    }

    pub fn rows(&self) -> usize {
        self.values.len() / self.channels
    }

    /// Duration [s]; its inverse is one cell of frequency.
    pub fn duration_s(&self) -> f64 {
        self.rows() as f64 / self.rate_hz
    }

    /// Mean square per channel.
    pub fn variances(&self) -> Vec<f64> {
        (0..self.channels)
            .map(|c| {
                let existing = self.values.iter().skip(c).step_by(self.channels).filter(|y| y.is_finite());
                let (count, sum) = existing.fold((0.0, 0.0), |(n, sum), y| (n + 1.0, sum + y * y));
                if count > 0.0 { sum / count } else { 0.0 }
            })
            .collect()
    }

    /// Spectrum of every channel at one frequency behind a Hann window.
    pub fn at(&self, frequency_hz: f64) -> Vec<c64> {
        let (rows, step) = (self.rows(), TAU * frequency_hz / self.rate_hz);
        let mut sums = vec![c64::new(0.0, 0.0); self.channels];
        let (mut carrier, mut window) = (Phasor::new(-step), Phasor::new(TAU / rows as f64));
        for row in self.values.chunks_exact(self.channels) {
            let e = carrier.next() * (0.5 * (1.0 - window.next().re));
            for (sum, y) in sums.iter_mut().zip(row).filter(|(_, y)| y.is_finite()) {
                *sum += e * *y;
            }
        }
        sums
    }

    /// The weights of the channels that make the most of a line at `frequency_hz`.
    pub fn weights(&self, frequency_hz: f64) -> Vec<c64> {
        let variances = self.variances();
        let of = |(y, variance): (&c64, &f64)| if *variance > 0.0 { y.conj() / *variance } else { c64::new(0.0, 0.0) };
        self.at(frequency_hz).iter().zip(&variances).map(of).collect()
    }

    /// Complex envelope of the band `frequency_hz` ± `half_cells` cells, 4 × `half_cells` values
    /// over the record, of the channels' weighted sum.
    ///
    /// Every value is a Hann-weighted mean over the samples that exist within two of its steps each
    /// way; at the edges of the band its gain is one half ([`gain`]).
    pub fn envelope(&self, weights: &[c64], frequency_hz: f64, half_cells: usize, rows_used: Present) -> Vec<c64> {
        let (rows, count) = (self.rows(), 4 * half_cells);
        let step = TAU * frequency_hz / self.rate_hz;
        let apart = rows as f64 / count as f64;
        // Per row: the weighted sum, demodulated, and how much of the weight exists.
        let whole: f64 = weights.iter().map(c64::norm_sqr).sum();
        let rows_of = self.values.chunks_exact(self.channels);
        let mut carrier = Phasor::new(-step);
        let demodulated: Vec<(c64, f64)> = rows_of
            .map(|row| {
                let (mut sum, mut present) = (c64::new(0.0, 0.0), 0.0);
                for (y, weight) in row.iter().zip(weights).filter(|(y, _)| y.is_finite()) {
                    sum += *weight * *y;
                    present += weight.norm_sqr();
                }
                let demodulated = sum * carrier.next();
                // The whole is the same sum: equal when nothing is missing.
                if rows_used == Present::All && present < whole {
                    return (c64::new(0.0, 0.0), 0.0);
                }
                (demodulated, present / whole)
            })
            .collect();
        let value = |j: usize| {
            let centre = (j as f64 + 0.5) * apart;
            let (from, to) =
                ((centre - 2.0 * apart).max(0.0) as usize, ((centre + 2.0 * apart) as usize).min(rows - 1));
            let (mut sum, mut total) = (c64::new(0.0, 0.0), 0.0);
            for (t, (y, present)) in demodulated.iter().enumerate().take(to + 1).skip(from) {
                let w = 0.5 * (1.0 + libm::cos(0.5 * PI * ((t as f64 + 0.5 - centre) / apart).clamp(-2.0, 2.0)));
                sum += *y * w;
                total += present * w;
            }
            if total > 0.0 { sum / total } else { c64::new(0.0, 0.0) }
        };
        (0..count).map(value).collect()
    }
}

/// `e^{iφt}`, t = 0, 1, …: by recurrence, set right every thousand steps.
struct Phasor {
    step: f64,
    turn: c64,
    value: c64,
    t: u32,
}

impl Phasor {
    fn new(step: f64) -> Self {
        Self { step, turn: turn(step), value: c64::new(1.0, 0.0), t: 0 }
    }

    fn next(&mut self) -> c64 {
        if self.t.is_multiple_of(1024) {
            self.value = turn(self.step * f64::from(self.t));
        }
        let value = self.value;
        self.value = value * self.turn;
        self.t += 1;
        value
    }
}

/// Gain of [`Samples::envelope`] at `cells` from its centre: that of a Hann window of four steps.
pub(super) fn gain(cells: f64, half_cells: usize) -> f64 {
    let x = (cells / half_cells as f64).abs();
    if x < 1e-9 {
        return 1.0;
    }
    if (x - 1.0).abs() < 1e-9 {
        return 0.5;
    }
    libm::sin(PI * x) / (PI * x * (1.0 - x * x))
}

/// Hann window over `count` values.
pub(super) fn hann(j: usize, count: usize) -> f64 {
    0.5 * (1.0 - libm::cos(TAU * (j as f64 + 0.5) / count as f64))
}
