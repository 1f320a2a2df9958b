//! Where a record decides alone, the second mass is ten numbers fitted jointly; a record of an
//! independent simulator where it does not is tested with the benchmarks.

use super::*;
use crate::seeded_noise::SeededNoise;
use crate::slosh_planar::{PlanarState, Wrench};
use crate::slosh_planar_record::PlanarNoise;
use crate::slosh_planar_scan::PlanarSample;
use nalgebra::{Vector2, vector};

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

fn truth() -> SVector<f64, TWO_MASSES> {
    SVector::from_iterator(FIRST.into_iter().chain(SECOND))
}

const SEARCH: PlanarSearch = PlanarSearch { band_hz: [0.006, 0.03], reach_m: 1.0, starts: 3 };

/// A cell of one line of 1 mHz whose ten numbers are known but for its width.
fn cell(axis: SecondAxis, hertz: f64, log_weight: f64) -> Cell {
    let (theta, covariance) = (truth() * hertz, SMatrix::zeros());
    Cell { axis, hertz, width_hz: 1e-3, log_weight, theta, covariance }
}

fn mixed(cells: &[Cell]) -> SecondMass {
    let mut mixture = Mixture::new();
    cells.iter().for_each(|cell| mixture.add(cell));
    let (theta, covariance) = (SVector::zeros(), SMatrix::zeros());
    let fit = Fit { theta, covariance, chi_square: 0.0, degrees_of_freedom: 1.0, iterations: 0, is_converged: true };
    mixture.report(&fit)
}

#[test]
fn axes_that_explain_a_record_alike_at_one_frequency_are_not_sharp() {
    use SecondAxis::{X, Y};
    assert!(mixed(&[cell(X, 0.02, 0.0)]).is_sharp(1e-3) && mixed(&[cell(Y, 0.02, 0.0)]).is_sharp(1e-3));
    assert!(!mixed(&[cell(X, 0.02, 0.0), cell(Y, 0.02, 0.0)]).is_sharp(1e-3));
    assert!(mixed(&[cell(X, 0.02, 0.0), cell(Y, 0.02, -8.0)]).is_sharp(1e-3)); // e⁻⁸ of the weight
    assert!(!mixed(&[cell(X, 0.02, 0.0), cell(X, 0.023, 0.0)]).is_sharp(1e-3));
}

#[test]
fn a_point_of_the_grid_is_as_wide_as_its_cell() {
    let one = mixed(&[cell(SecondAxis::X, 0.02, 0.0)]);
    assert!((one.frequency_sigma_hz - 1e-3 / 12.0_f64.sqrt()).abs() < 1e-9, "{one:?}"); // rounding of hertz²
}

#[test]
fn damping_ratios_have_the_moments_of_the_stated_prior() {
    let moment = |power: i32| {
        let sum =
            |power: i32| RATIOS.iter().map(|(ratio, ln_w)| ln_w.exp() * (ratio / 0.01).ln().powi(power)).sum::<f64>();
        sum(power) / sum(0)
    };
    for (power, normal) in [(1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)] {
        assert!((moment(power) - normal).abs() < 1e-3, "{power}: {}", moment(power)); // digits of the table
    }
}

#[test]
fn what_the_grid_cannot_tell_is_an_error() {
    let truth = truth();
    let samples = samples(&truth, 1);
    let (record, first) = (PlanarRecord::new(&samples, INTERVAL_S, NOISE), SVector::from(FIRST));
    // 1500 s: 256 lines are 0.171 Hz.
    let wide = PlanarSearch { band_hz: [0.006, 0.18], ..SEARCH };
    let refused = identify_second(&record, HUB, &wide, &first);
    assert!(matches!(refused, Err(PlanarError::BandTooWide { most: GRID_POINTS_MAX, .. })), "{refused:?}");
    let blind = PlanarNoise { acceleration_m_s2: f64::INFINITY, rate_rad_s: f64::INFINITY };
    let blind = PlanarRecord::new(&samples, INTERVAL_S, blind);
    assert_eq!(identify_second(&blind, HUB, &SEARCH, &first), Err(PlanarError::NotObserved));
    // An axis whose points fail does not leave the other as the certain one.
    let walk = Search::new(&record, HUB, &SEARCH, &first);
    let mut eight = SVector::<f64, AT_A_POINT>::from([28.7, 0.16, 0.03, -0.45, 0.2, 9.0, 0.35, -0.15]);
    let mut grid = [[None; GRID_POINTS_MAX]; 2];
    grid[0][8] = Some((0.0, eight)); // 24.7 mHz
    assert!(walk.mixed(&SEARCH, &grid).is_some());
    eight[5] = -1.0;
    grid[1][8] = Some((0.0, eight));
    assert!(walk.mixed(&SEARCH, &grid).is_none());
}

#[test]
fn a_second_mass_that_swings_is_found_with_its_axis_and_all_ten_numbers() {
    let truth = truth();
    let samples = samples(&truth, 1);
    let record = PlanarRecord::new(&samples, INTERVAL_S, NOISE);
    // The first as it is found alone: off by what the second does.
    let first = SVector::<f64, ONE_AXIS>::from(FIRST).component_mul(&vector![0.96, 0.96, 1.1, 1.03, 1.0]);
    let found = identify_second(&record, HUB, &SEARCH, &first).expect("a minimum");
    assert!(found.is_joint && found.along_x == 1.0, "{found:?}");
    let z = (found.theta - truth).component_div(&found.sigmas());
    assert!(z.amax() < 4.0, "{z} {found:?}"); // ten unit normal numbers
    assert!(found.z_score().abs() < 4.0, "{}", found.z_score());
    assert!(found.frequency_sigma_hz < 1e-4 && (found.frequency_hz - 0.02443).abs() < 4e-4, "{found:?}");
}
