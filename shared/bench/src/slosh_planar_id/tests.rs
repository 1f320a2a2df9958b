//! The planar search on records of the model itself; truth from another formulation is tested with
//! the benchmarks.

use super::*;
use crate::seeded_noise::SeededNoise;
use crate::slosh_calibration::ThrustCalibration;
use crate::slosh_planar::Wrench;
use crate::slosh_planar_fit::{PlanarPrior, bound, whiteness};
use crate::slosh_planar_record::PlanarNoise;
use crate::slosh_planar_scan::PlanarSample;
use crate::slosh_planar_thrust::{SPRINGS_AND_THRUST, identify_springs_and_thrust, scale_of};
use nalgebra::vector;

const HUB: PlanarHub = PlanarHub { mass_kg: 1004.5, inertia_com_kg_m2: 480.0, sensor_m: Vector2::new(0.5, -0.3) };
const TRUTH: [f64; SPRINGS] = [28.7, 0.16, 0.12, 0.03, 0.025, -0.45, 0.2];
const SEARCH: PlanarSearch = PlanarSearch { band_hz: [0.004, 0.03], reach_m: 1.0, starts: STARTS_MAX };
/// 0.008 (m/s)/√h and 0.09 °/√h at 1 Hz.
const NOISE: PlanarNoise = PlanarNoise { acceleration_m_s2: 0.008 / 60.0, rate_rad_s: 2.618e-5 };

/// Square bursts of three cycles: along x, along y, about z (benchmark page 2, section 4).
fn wrench(t: f64) -> Wrench {
    let burst = |amplitude: f64, hertz: f64, begin: f64| {
        let phase = (t + 0.5 - begin) * hertz;
        if !(0.0..3.0).contains(&phase) {
            0.0
        } else if phase % 1.0 < 0.5 {
            amplitude
        } else {
            -amplitude
        }
    };
    Wrench {
        force_n: vector![burst(0.14, 0.0121, 0.0), burst(0.112, 0.01046, 300.0)],
        torque_n_m: burst(0.12, 0.01046, 650.0),
    }
}

fn samples(truth: &SVector<f64, SPRINGS>, seconds: u32, seed: Option<u64>) -> Vec<PlanarSample> {
    let PlanarCraft { hub, masses, mut start, .. } = springs(HUB, truth).expect("exists");
    let mut noise = SeededNoise::new(seed.unwrap_or(0));
    let scale = if seed.is_some() { 1.0 } else { 0.0 };
    (0..seconds)
        .map(|k| {
            let wrench = wrench(f64::from(k));
            let seen = start.step(&hub, &masses, &wrench, 1.0).expect("positive");
            let mut noisy = |value: f64, sigma: f64| value + scale * sigma * noise.normal();
            PlanarSample {
                wrench,
                acceleration_m_s2: vector![
                    noisy(seen[0], NOISE.acceleration_m_s2) + 1e-5,
                    noisy(seen[1], NOISE.acceleration_m_s2) - 2e-5
                ],
                rate_rad_s: noisy(seen[2], NOISE.rate_rad_s) + 3e-6,
                ..PlanarSample::default()
            }
        })
        .collect()
}

#[test]
fn bound_of_the_planar_experiment_is_that_of_an_independent_study() {
    let truth = SVector::from(TRUTH);
    let samples = samples(&truth, 1800, None);
    let record = PlanarRecord::new(&samples, 1.0, NOISE);
    let covariance =
        bound(&record, &|theta| springs(HUB, theta), (&truth, &truth.abs()), &PlanarPrior::none()).expect("seen");
    for (i, printed) in [0.57, 0.55, 0.55, 1.43, 1.23, 0.45, 0.65].into_iter().enumerate() {
        let percent = 100.0 * covariance[(i, i)].sqrt() / truth[i].abs();
        assert!((percent / printed - 1.0).abs() < 0.03, "{i}: {percent} {printed}"); // edges of the bursts, digits
    }
}

#[test]
fn all_seven_numbers_are_found_from_the_scan_alone() {
    let truth = SVector::from(TRUTH);
    for seed in 1..3 {
        let samples = samples(&truth, 1800, Some(seed));
        let record = PlanarRecord::new(&samples, 1.0, NOISE);
        let answer = identify_springs(&record, HUB, PlanarThrust::default(), &SEARCH).expect("a minimum");
        assert!(answer.is_explained, "{answer:?}");
        let z = (answer.estimate.theta - truth).component_div(&answer.estimate.sigmas());
        assert!(z.amax() < 4.0, "{z}"); // 7 unit normal numbers
        let white = whiteness(&record, &|theta| springs(HUB, theta), &answer.estimate).expect("exists");
        assert!(white.iter().all(|white| white.worst_z_score() < 5.0), "{white:?}");
    }
}

/// What a burst says of a thruster whose scale is 1 + `error`, good to `sigma`.
fn calibration(error: f64, sigma: f64) -> ThrustCalibration {
    ThrustCalibration {
        scale_error: error,
        delay_s: 0.0,
        scale_sigma: sigma,
        delay_sigma_s: 1e-4,
        scale_delay_covariance_s: 0.3 * sigma * 1e-4,
        chi_square: 0.0,
        degrees_of_freedom: 0.0,
    }
}

#[test]
fn what_a_calibration_leaves_of_the_thrusts_scale_is_part_of_every_sigma() {
    let truth = SVector::from(TRUTH);
    let mut samples = samples(&truth, 1800, Some(1));
    for sample in &mut samples {
        sample.wrench.force_n.component_mul_assign(&vector![1.0 / 1.01, 1.0 / 0.994]); // what was commanded
    }
    let record = PlanarRecord::new(&samples, 1.0, NOISE);
    // Both wrong by one of their own sigmas.
    let identified = |sigma: f64| {
        let both = [calibration(0.01 + sigma, sigma), calibration(-0.006 - sigma, sigma)];
        identify_springs_and_thrust(&record, HUB, &SEARCH, &both).expect("a minimum")
    };
    let (good, poor) = (identified(4e-4), identified(1e-2));
    for found in [&good, &poor] {
        assert!(found.is_explained, "{found:?}");
        let error = found.estimate.theta.fixed_rows::<SPRINGS>(0) - truth;
        let z = error.component_div(&found.estimate.sigmas().fixed_rows::<SPRINGS>(0));
        assert!(z.amax() < 4.0, "{z}"); // 7 unit normal numbers
    }
    // Known thrusters: 0.57 %. A scale good to 0.04 % costs less than a tenth of that, one good to
    // 1 % more than all of it.
    let percent = |found: &PlanarAnswer<SPRINGS_AND_THRUST>| 100.0 * found.estimate.sigmas()[0] / truth[0];
    assert!(percent(&good) > 0.5 && percent(&good) < 0.62, "{}", percent(&good));
    assert!(percent(&poor) > 2.0 * percent(&good), "{} {}", percent(&poor), percent(&good));
}

#[test]
fn a_tank_on_an_axis_has_steps_of_its_place_and_sums_with_edges_within_tell_no_delay() {
    let mut theta = SVector::<f64, SPRINGS_AND_THRUST>::repeat(1.0);
    theta.fixed_rows_mut::<SPRINGS>(0).copy_from_slice(&[28.7, 0.16, 0.12, 0.03, 0.025, 0.0, 0.0]);
    assert!(scale_of(&theta).min() > 0.0, "{}", scale_of(&theta));
    let samples = samples(&SVector::from(TRUTH), 200, None);
    let sums: Vec<PlanarSample> = samples.chunks_exact(4).map(PlanarSample::mean).collect();
    let both = [calibration(0.0, 1e-3); 2];
    let refused = identify_springs_and_thrust(&PlanarRecord::new(&sums, 4.0, NOISE), HUB, &SEARCH, &both);
    assert_eq!(refused.err(), Some(PlanarError::DelayedSums));
}
