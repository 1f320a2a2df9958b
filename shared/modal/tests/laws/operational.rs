//! Laws of records as they are: gaps, tones, late channels.

use crate::cases::noise::Noise;
use modal::operational::{Evidence, Known, Operational, identify};
use modal::record::Record;
use modal::{Config, Mode, Rejection};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 50.0;
const MODES: [(f64, f64); 2] = [(1.5, 0.01), (4.5, 0.015)];
const SHAPES: [[f64; 3]; 2] = [[1.0, 0.6, -0.4], [0.5, -0.8, 0.9]];

/// Three channels under white noise with 3 % of sensor noise, `late` samples of lead.
fn motion(seed: u64, rows: usize) -> Vec<f64> {
    of_structure(seed, rows, &MODES, &SHAPES)
}

/// Under white noise with 3 % of sensor noise.
fn of_structure<const L: usize>(seed: u64, rows: usize, modes: &[(f64, f64)], shapes: &[[f64; L]]) -> Vec<f64> {
    let mut noise = Noise::new(seed);
    let mut values = vec![0.0; L * rows];
    for ((f, zeta), shape) in modes.iter().zip(shapes) {
        let omega = TAU * f / RATE_HZ;
        let rho = (-zeta * omega).exp();
        let (a, b) = (2.0 * rho * (omega * (1.0 - zeta * zeta).sqrt()).cos(), -rho * rho);
        let variance = (1.0 - b) / ((1.0 + b) * ((1.0 - b) * (1.0 - b) - a * a));
        let (mut newer, mut older) = (0.0, 0.0);
        for t in 0..rows + 4000 {
            let next = a * newer + b * older + noise.normal() / variance.sqrt();
            (older, newer) = (newer, next);
            if t >= 4000 {
                (0..L).for_each(|c| values[L * (t - 4000) + c] += shape[c] * next);
            }
        }
    }
    values.iter_mut().for_each(|y| *y += 0.03 * noise.normal());
    values
}

fn found(values: Vec<f64>, delays_s: &[f64]) -> Operational {
    identify(&Record::of_outputs(RATE_HZ, 3, values), Known { delays_s, clipped: false }, &Config::new(3, RATE_HZ))
        .unwrap()
}

/// Both modes within four deviations, and nothing else.
fn assert_both(modes: &[Mode]) {
    assert_eq!(modes.len(), 2, "{modes:#?}");
    for (mode, (f, zeta)) in modes.iter().zip(MODES) {
        assert!((mode.frequency_hz - f).abs() < 4.0 * mode.sigma_frequency_hz, "{mode:#?}");
        assert!((mode.damping_ratio - zeta).abs() < 4.0 * mode.sigma_damping, "{mode:#?}");
        assert!(mode.sigma_frequency_hz < 0.005 * f && mode.sigma_damping < 0.4 * zeta, "{mode:#?}");
    }
}

#[test]
fn samples_missing_at_random_leave_the_modes() {
    let mut values = motion(21, 12_000);
    let mut noise = Noise::new(22);
    values.chunks_exact_mut(3).for_each(|row| {
        if noise.uniform() < 0.15 {
            row.fill(f64::NAN);
        }
    });
    let missing = values.iter().filter(|y| !y.is_finite()).count();
    let found = found(values, &[]);
    assert!(found.filled > 9 * missing / 10, "{} of {missing} filled", found.filled);
    assert_both(&found.modes);
}

/// Loses this share of the packets of so many rows, none at the ends.
fn without_packets(values: &mut [f64], rows: usize, share: f64) {
    let mut noise = Noise::new(22);
    let inside = 3 * 100..values.len() - 3 * 100;
    for packet in values[inside].chunks_exact_mut(3 * rows) {
        if noise.uniform() < share {
            packet.fill(f64::NAN);
        }
    }
}

#[test]
fn packets_that_are_lost_leave_the_modes() {
    let mut values = motion(21, 12_000);
    without_packets(&mut values, 20, 0.15);
    let missing = values.iter().filter(|y| !y.is_finite()).count();
    let found = found(values, &[]);
    assert_eq!((found.evidence, found.filled), (Evidence::Windows, missing));
    assert_both(&found.modes);
}

#[test]
fn a_record_filled_in_packets_has_the_covariances_of_the_whole_one() {
    let whole = motion(21, 60_000);
    let mut left = whole.clone();
    without_packets(&mut left, 20, 0.2);
    let rest = found(left, &[]).rest.unwrap();
    let lagged = |of: &[f64], rows: usize, c: usize| {
        let pairs = of.iter().skip(3 * rows + c).step_by(3).zip(of.iter().skip(c).step_by(3));
        let products: Vec<f64> = pairs.map(|(a, b)| a * b).filter(|product| product.is_finite()).collect();
        products.iter().sum::<f64>() / products.len() as f64
    };
    for c in 0..3 {
        for rows in [0, 5, 10, 20] {
            let apart = (lagged(&rest, rows, c) - lagged(&whole, rows, c)) / lagged(&whole, 0, c);
            assert!(apart.abs() < 0.01, "channel {c}, {rows} rows: {apart}");
        }
    }
}

#[test]
fn packets_longer_than_the_windows_leave_the_modes_by_the_pairs_that_exist() {
    let mut values = motion(21, 12_000);
    without_packets(&mut values, 100, 0.15);
    let found = found(values, &[]);
    assert_eq!(found.evidence, Evidence::Pairs);
    assert_both(&found.modes);
}

#[test]
fn a_tone_is_no_mode_and_a_mode_is_no_tone() {
    let values = motion(23, 12_000);
    let clean = found(values.clone(), &[]);
    assert_both(&clean.modes);
    assert!(clean.tones.is_empty(), "{:?}", clean.tones);
    let mut with_tone = values;
    for (t, row) in with_tone.chunks_exact_mut(3).enumerate() {
        let tone = (TAU * 6.3 * t as f64 / RATE_HZ).sin();
        (0..3).for_each(|c| row[c] += [0.5, 0.7, 1.0][c] * tone);
    }
    let noisy = found(with_tone, &[]);
    assert_both(&noisy.modes);
    assert_eq!(noisy.tones.len(), 1, "{:?}", noisy.tones);
    assert!((noisy.tones[0].frequency_hz - 6.3).abs() < 1e-4);
    assert!((noisy.tones[0].amplitude[2].norm_sqr().sqrt() - 1.0).abs() < 0.01);
}

#[test]
fn a_tone_of_the_rms_of_a_mode_that_it_lies_on_is_named_and_the_mode_stays() {
    for (seed, tone_hz) in [(26, 1.5), (27, 1.507), (28, 1.495), (29, 4.5), (30, 4.46)] {
        let mut values = motion(seed, 12_000);
        for (t, row) in values.chunks_exact_mut(3).enumerate() {
            let tone = std::f64::consts::SQRT_2 * (TAU * tone_hz * t as f64 / RATE_HZ + 0.7).sin();
            (0..3).for_each(|c| row[c] += [0.9, -0.5, 0.6][c] * tone);
        }
        let found = found(values, &[]);
        assert_both(&found.modes);
        assert_eq!(found.tones.len(), 1, "{tone_hz}: {:?}", found.tones);
        // A hundredth of a cell.
        assert!((found.tones[0].frequency_hz - tone_hz).abs() < 0.01 / 240.0, "{tone_hz}: {:?}", found.tones);
    }
}

#[test]
fn a_free_decay_is_no_tone() {
    let mut noise = Noise::new(24);
    let decay = |t: usize| (-0.02 * TAU * t as f64 / RATE_HZ).exp() * (TAU * 5.0 * t as f64 / RATE_HZ).sin();
    let values = (0..3 * 1500).map(|k| [1.0, 0.6, -0.4][k % 3] * decay(k / 3) + 0.002 * noise.normal()).collect();
    let found = found(values, &[]);
    assert!(found.tones.is_empty(), "{:?}", found.tones);
    assert_eq!(found.modes.len(), 1, "{:?}", found.modes);
    assert!((found.modes[0].damping_ratio - 0.004).abs() < 4.0 * found.modes[0].sigma_damping);
}

#[test]
fn a_late_channel_leaves_the_modes_and_its_delay_known_the_phases() {
    let ahead = motion(25, 12_000);
    let late = |k: usize| if k % 3 == 1 { ahead[k] } else { ahead[k + 3 * 7] };
    let values: Vec<f64> = (0..3 * 11_990).map(late).collect();
    let unknown = found(values.clone(), &[]);
    assert_both(&unknown.modes);
    let known = found(values, &[0.0, 7.0 / RATE_HZ, 0.0]);
    assert_both(&known.modes);
    assert!(known.modes.iter().all(|mode| mode.phase_collinearity > 0.95), "{:?}", known.modes);
}

#[test]
fn a_close_pair_is_two_modes_and_not_the_one_of_models_too_small_for_both() {
    let modes = [(1.7, 0.011), (3.3, 0.008), (3.45, 0.009), (8.1, 0.02)];
    let shapes = [[1.0, 0.8, 0.5, 0.3], [1.0, -0.3, -0.9, 0.6], [0.4, 0.9, -0.2, 0.8], [0.7, -0.8, 0.6, 0.9]];
    // Seven of 45 such records had a mode of 3.35 Hz, which repeats in six orders below eight.
    for seed in [16, 18] {
        let record = Record::of_outputs(RATE_HZ, 4, of_structure(seed, 15_000, &modes, &shapes));
        let found = identify(&record, Known::default(), &Config::new(4, RATE_HZ)).unwrap();
        assert_eq!(found.modes.len(), modes.len(), "{:#?}", found.modes);
        for (mode, (f, _)) in found.modes.iter().zip(modes) {
            assert!((mode.frequency_hz - f).abs() < 4.0 * mode.sigma_frequency_hz, "{mode:#?}");
        }
        let of_small_models = |pole: &modal::RejectedPole| matches!(pole.reason, Rejection::NotInModel { .. });
        assert!(found.rejected.iter().any(of_small_models));
    }
}
