//! Where a record decides alone, the second mass is ten numbers fitted jointly; a record of an independent simulator where it
//! does not is tested with the benchmarks.

use super::*;
use crate::seeded_noise::SeededNoise;
use crate::slosh_planar::{PlanarState, Wrench};
use crate::slosh_planar_fit::PlanarNoise;
use crate::slosh_planar_scan::PlanarSample;
use nalgebra::vector;
use std::vec::Vec;

const HUB: PlanarHub = PlanarHub { mass_kg: 1004.5, inertia_com_kg_m2: 480.0, sensor_m: Vector2::new(0.5, -0.3) };
const FIRST: [f64; ONE_AXIS] = [28.7, 0.16, 0.03, -0.45, 0.2];
const SECOND: [f64; ONE_AXIS] = [9.0, 0.21, 0.02, 0.35, -0.15];
const INTERVAL_S: f64 = 3.0;
/// 0.008 (m/s)/√h and 0.09 °/√h over three seconds.
const NOISE: PlanarNoise = PlanarNoise { acceleration_m_s2: 7.698e-5, rate_rad_s: 1.5115e-5 };

/// Bursts at both modes: four cycles of 42 s along x, four of 84 s along y, three of 84 s about z.
fn wrench(t: f64) -> Wrench {
    let burst = |amplitude: f64, cycle_s: f64, cycles: f64, begin_s: f64| {
        let phase = (t - begin_s) / cycle_s;
        let sign = if phase - libm::floor(phase) < 0.5 { amplitude } else { -amplitude };
        if (0.0..cycles).contains(&phase) { sign } else { 0.0 }
    };
    Wrench {
        force_n: vector![burst(2.0, 42.0, 4.0, 0.0), burst(0.4, 84.0, 4.0, 180.0)],
        torque_n_m: burst(0.2, 84.0, 3.0, 540.0),
    }
}

fn samples(truth: &SVector<f64, TWO_MASSES>, seed: u64) -> Vec<PlanarSample> {
    let craft = two_masses(HUB, SecondAxis::X, truth).expect("exists");
    let (mut state, mut noise) = (PlanarState::default(), SeededNoise::new(seed));
    (0..500_u32)
        .map(|k| {
            // Parts of a second: another step of integration than the estimator's.
            let (wrench, mut mean) = (wrench(f64::from(k) * INTERVAL_S), nalgebra::Vector3::zeros());
            for _ in 0..3 {
                mean += state.step(&HUB, &craft.masses, &wrench, INTERVAL_S / 3.0).expect("positive") / 3.0;
            }
            let mut noisy = |value: f64, sigma: f64| value + sigma * noise.normal();
            PlanarSample {
                wrench,
                acceleration_m_s2: vector![
                    noisy(mean[0], NOISE.acceleration_m_s2),
                    noisy(mean[1], NOISE.acceleration_m_s2)
                ],
                rate_rad_s: noisy(mean[2], NOISE.rate_rad_s),
                ..PlanarSample::default()
            }
        })
        .collect()
}

#[test]
fn a_second_mass_that_swings_is_found_with_its_axis_and_all_ten_numbers() {
    let mut truth = SVector::<f64, TWO_MASSES>::zeros();
    truth.fixed_rows_mut::<ONE_AXIS>(0).copy_from_slice(&FIRST);
    truth.fixed_rows_mut::<ONE_AXIS>(ONE_AXIS).copy_from_slice(&SECOND);
    let samples = samples(&truth, 1);
    let record = PlanarRecord { samples: &samples, interval_s: INTERVAL_S, noise: NOISE };
    let search = PlanarSearch { band_hz: [0.006, 0.03], reach_m: 1.0, starts: 3 };
    // The first as it is found alone: off by what the second does.
    let first = SVector::<f64, ONE_AXIS>::from(FIRST).component_mul(&vector![0.96, 0.96, 1.1, 1.03, 1.0]);
    let found = identify_second(&record, HUB, &search, &first).expect("a minimum");
    assert!(found.is_joint && found.along_x == 1.0, "{found:?}");
    let z = (found.theta - truth).component_div(&found.sigmas());
    assert!(z.amax() < 4.0, "{z} {found:?}"); // ten unit normal numbers
    assert!(found.z_score().abs() < 4.0, "{}", found.z_score());
    assert!(found.frequency_sigma_hz < 1e-4 && (found.frequency_hz - 0.02443).abs() < 4e-4, "{found:?}");
}
