//! Structures drawn at random, and what their sensors show under white noise.

use super::generator::Generator;
use core::f64::consts::TAU;

/// A mode of a structure.
#[derive(Clone, Debug)]
pub struct TrueMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Real, per channel; its largest part between 0.3 and 1.
    pub shape: Vec<f64>,
    /// Root mean square of the modal coordinate.
    pub rms: f64,
}

/// A structure with sensors, and how it is recorded.
#[derive(Clone, Debug)]
pub struct Structure {
    pub sample_rate_hz: f64,
    pub samples: usize,
    pub channels: usize,
    /// In order of frequency.
    pub modes: Vec<TrueMode>,
    /// Of one sample of a channel, relative to the rms of its motion.
    pub sensor_noise: f64,
}

/// Least distance of modes that are no close pair, relative to the frequency.
const APART: f64 = 0.15;

impl Structure {
    /// 2–4 modes between 0.012 and 0.35 of the sample rate, one close pair (2–5 % apart) in three
    /// structures, 3–10 channels, damping 0.3–3 %, 12 000 samples at 50 Hz, sensor noise 1–5 %.
    pub fn draw(random: &mut Generator) -> Self {
        let (sample_rate_hz, samples) = (50.0, 12_000);
        let channels = random.whole(3, 10);
        let count = random.whole(2, 4);
        let close = random.uniform() < 1.0 / 3.0;
        let mut frequencies: Vec<f64> = Vec::new();
        while frequencies.len() < count {
            let second_of_pair = close && frequencies.len() == 1;
            let f = if second_of_pair {
                frequencies[0] * (1.0 + random.between(0.02, 0.05))
            } else {
                0.012 * sample_rate_hz * libm::pow(0.35 / 0.012, random.uniform())
            };
            let apart = |other: &f64| (f / other - 1.0).abs() > APART && (other / f - 1.0).abs() > APART;
            if second_of_pair || frequencies.iter().all(apart) {
                frequencies.push(f);
            }
        }
        frequencies.sort_by(f64::total_cmp);
        let mode = |frequency_hz: &f64| TrueMode {
            frequency_hz: *frequency_hz,
            damping_ratio: 0.003 * libm::pow(10.0, random.uniform()),
            shape: (0..channels).map(|_| random.between(0.3, 1.0) * random.sign()).collect(),
            rms: random.between(0.5, 1.5),
        };
        let modes = frequencies.iter().map(mode).collect();
        Self { sample_rate_hz, samples, channels, modes, sensor_noise: random.between(0.01, 0.05) }
    }

    /// The motion of every channel, so many samples more in front.
    pub fn motion(&self, random: &mut Generator, lead: usize) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![0.0; lead + self.samples]; self.channels];
        for mode in &self.modes {
            let coordinate = self.coordinate(mode, random, lead + self.samples);
            for (column, part) in columns.iter_mut().zip(&mode.shape) {
                column.iter_mut().zip(&coordinate).for_each(|(y, q)| *y += part * q);
            }
        }
        columns
    }

    /// One mode under white noise, stationary from its first sample on.
    fn coordinate(&self, mode: &TrueMode, random: &mut Generator, samples: usize) -> Vec<f64> {
        let omega = TAU * mode.frequency_hz / self.sample_rate_hz;
        let rho = libm::exp(-mode.damping_ratio * omega);
        let turn = omega * (1.0 - mode.damping_ratio * mode.damping_ratio).sqrt();
        let (a, b) = (2.0 * rho * libm::cos(turn), -rho * rho);
        let warm_up = (8.0 / (mode.damping_ratio * omega)) as usize;
        let (mut newer, mut older) = (0.0, 0.0);
        let mut all = Vec::with_capacity(samples);
        for t in 0..warm_up + samples {
            let next = a * newer + b * older + random.normal();
            (older, newer) = (newer, next);
            if t >= warm_up {
                all.push(next);
            }
        }
        // Of an AR(2): σ² (1 − b) / ((1 + b) ((1 − b)² − a²)), σ = 1.
        let variance = (1.0 - b) / ((1.0 + b) * ((1.0 - b) * (1.0 - b) - a * a));
        let gain = mode.rms / variance.sqrt();
        all.iter_mut().for_each(|q| *q *= gain);
        all
    }

    /// Root mean square of the motion of a channel.
    pub fn channel_rms(&self, channel: usize) -> f64 {
        let power = |mode: &TrueMode| (mode.shape[channel] * mode.rms) * (mode.shape[channel] * mode.rms);
        self.modes.iter().map(power).sum::<f64>().sqrt()
    }
}
