//! Claims on seeded random structures the method has never seen: 1–6 modes, 1–12 channels, 5–2000
//! Hz.

use crate::cases::random_system::{Excitation, random_record};
use modal::{Config, ModalIdentifier};

/// Modes present, found (within 3 %), reported beside those, and 95 % intervals that hold for
/// (frequency, damping).
struct Count {
    present: usize,
    found: usize,
    spurious: usize,
    held: (usize, usize),
}

fn count(seeds: std::ops::Range<u64>, excitation: Excitation) -> Count {
    let mut count = Count { present: 0, found: 0, spurious: 0, held: (0, 0) };
    for seed in seeds {
        let record = random_record(seed, excitation);
        let mut identifier = ModalIdentifier::new(Config::new(record.channels, record.sample_rate_hz));
        record.samples.iter().for_each(|sample| identifier.push(sample));
        let mut modes = identifier.identify().unwrap();
        for truth in &record.modes {
            count.present += 1;
            let near = |f: f64| (f / truth.frequency_hz - 1.0).abs() < 0.03;
            if let Some(position) = modes.iter().position(|mode| near(mode.frequency_hz)) {
                let mode = modes.remove(position);
                let (e_f, e_z) = (mode.frequency_hz - truth.frequency_hz, mode.damping_ratio - truth.damping_ratio);
                count.found += 1;
                count.held.0 += usize::from(e_f.abs() < 1.96 * mode.sigma_frequency_hz);
                count.held.1 += usize::from(e_z.abs() < 1.96 * mode.sigma_damping);
            }
        }
        count.spurious += modes.len();
    }
    println!("present {} found {} spurious {} held {:?}", count.present, count.found, count.spurious, count.held);
    count
}

fn assert_found_and_honest(count: &Count) {
    // At least 95 of 100 found, at most 10 spurious; intervals: 0.95 less three standard deviations
    // of `found` draws, less 0.03 for first order.
    assert!(20 * count.found >= 19 * count.present);
    assert!(10 * count.spurious <= count.present);
    let least = 0.92 - 3.0 * (0.95 * 0.05 / count.found as f64).sqrt();
    assert!(count.held.0 as f64 > least * count.found as f64);
    assert!(count.held.1 as f64 > least * count.found as f64);
}

#[test]
fn modes_of_random_structures_are_found_from_free_decays_with_honest_intervals() {
    assert_found_and_honest(&count(1000..1020, Excitation::Decay));
}

#[test]
fn modes_of_random_structures_are_found_under_white_noise_with_honest_intervals() {
    assert_found_and_honest(&count(1000..1012, Excitation::WhiteNoise));
}
