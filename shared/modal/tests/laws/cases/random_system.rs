//! Seeded random structures: 1–6 modes, 1–12 channels, any sample rate; free decays and records
//! driven by white noise.

use super::TrueMode;
use super::noise::Noise;

pub struct RandomRecord {
    pub sample_rate_hz: f64,
    pub channels: usize,
    pub modes: Vec<TrueMode>,
    pub samples: Vec<Vec<f64>>,
}

/// How the structure moves.
#[derive(Clone, Copy, PartialEq)]
pub enum Excitation {
    Decay,
    WhiteNoise,
}

/// Modes between 0.004 and 0.4 of the sample rate, at least 12 % apart, damping 0.3–4 %, sensor
/// noise 1–5 % of the motion's rms.
pub fn random_record(seed: u64, excitation: Excitation) -> RandomRecord {
    let mut noise = Noise::new(seed);
    let sample_rate_hz = libm::pow(10.0, noise.between(0.7, 3.3));
    let channels = 1 + (noise.uniform() * 11.999) as usize;
    let count = 1 + (noise.uniform() * 5.999) as usize;
    let centre = libm::pow(10.0, noise.between(-1.9, -0.9));
    let mut relative: Vec<f64> = Vec::new();
    while relative.len() < count {
        let f = (centre * libm::pow(10.0, noise.between(-0.5, 0.5))).min(0.4);
        if relative.iter().all(|other| (f / other - 1.0).abs() > 0.12) {
            relative.push(f);
        }
    }
    relative.sort_by(f64::total_cmp);
    let damping: Vec<f64> = relative.iter().map(|_| libm::pow(10.0, noise.between(-2.5, -1.4))).collect();
    let slowest = relative.iter().zip(&damping).map(|(f, z)| f * z).fold(f64::INFINITY, f64::min);
    let samples = match excitation {
        // Two time constants of the slowest mode; 400 decay times of an ambient record are what
        // standards ask for.
        Excitation::Decay => (2.0 / (2.0 * std::f64::consts::PI * slowest)) as usize,
        Excitation::WhiteNoise => (400.0 / (2.0 * std::f64::consts::PI * slowest)) as usize,
    }
    .clamp(300, 60_000);
    let mut record = vec![vec![0.0; channels]; samples];
    for (f, zeta) in relative.iter().zip(&damping) {
        add_mode(&mut record, *f, *zeta, excitation, &mut noise);
    }
    let energy: f64 = record.iter().flatten().map(|y| y * y).sum();
    let level = noise.between(0.01, 0.05) * (energy / (samples * channels) as f64).sqrt();
    record.iter_mut().flatten().for_each(|y| *y += level * noise.normal());
    let modes = relative
        .iter()
        .zip(&damping)
        .map(|(f, z)| TrueMode { frequency_hz: f * sample_rate_hz, damping_ratio: *z })
        .collect();
    RandomRecord { sample_rate_hz, channels, modes, samples: record }
}

/// One mode as a second-order recursion with poles `exp(2πf(−ζ ± j√(1−ζ²)))`, unit rms, random real
/// shape.
pub fn add_mode(record: &mut [Vec<f64>], f: f64, zeta: f64, excitation: Excitation, noise: &mut Noise) {
    let omega = 2.0 * std::f64::consts::PI * f;
    let rho = libm::exp(-zeta * omega);
    let a_1 = 2.0 * rho * libm::cos(omega * (1.0 - zeta * zeta).sqrt());
    let a_2 = -rho * rho;
    let channels = record[0].len();
    let shape: Vec<f64> = (0..channels)
        .map(|_| {
            let size = noise.between(0.3, 1.0);
            if noise.uniform() < 0.5 { -size } else { size }
        })
        .collect();
    let mut coordinate = Vec::with_capacity(record.len());
    let (mut y_1, mut y_2) = (noise.normal(), noise.normal());
    let warm_up = if excitation == Excitation::WhiteNoise { (8.0 / (zeta * omega)) as usize } else { 0 };
    for t in 0..warm_up + record.len() {
        let drive = if excitation == Excitation::WhiteNoise { noise.normal() } else { 0.0 };
        let y = a_1 * y_1 + a_2 * y_2 + drive;
        (y_2, y_1) = (y_1, y);
        if t >= warm_up {
            coordinate.push(y);
        }
    }
    let rms = (coordinate.iter().map(|y| y * y).sum::<f64>() / record.len() as f64).sqrt();
    let gain = noise.between(0.5, 1.5) / rms;
    for (sample, y) in record.iter_mut().zip(&coordinate) {
        for (out, s) in sample.iter_mut().zip(&shape) {
            *out += gain * s * y;
        }
    }
}
