//! The bank of filters: its step, its honesty, its thrift.

use super::*;
use crate::benchmark_tank::{BASE_MASS_KG, TANK};
use crate::seeded_noise::SeededNoise;
use nalgebra::vector;
use physics::slosh::SloshPropagator;

const SIGMA: f64 = 0.008 / 60.0;

fn record(seed: u64, seconds: u32) -> Vec<SloshSample> {
    let mut motion = SloshPropagator::new(TANK, BASE_MASS_KG, SloshState::default());
    let mut noise = SeededNoise::new(seed);
    (0..seconds)
        .map(|k| {
            let force_n = 44.0 * libm::sin(2.0 * core::f64::consts::PI * 0.01 * (f64::from(k) + 0.5));
            let acceleration_m_s2 = motion.step(1.0, force_n) + SIGMA * noise.normal();
            SloshSample { interval_s: 1.0, force_n, acceleration_m_s2, sigma_m_s2: SIGMA }
        })
        .collect()
}

fn prior() -> SloshPrior {
    let SloshParameters { slosh_mass_kg: m, stiffness_n_m: k, damping_n_s_m: c } = TANK;
    SloshPrior {
        parameters: SloshParameters { slosh_mass_kg: 0.55 * m, stiffness_n_m: 0.55 * k, damping_n_s_m: 0.55 * c },
        log_sigma: vector![0.6, 0.6, 1.0],
        state_sigma: vector![1e-3, 1e-4],
        bias_sigma_m_s2: 0.0,
    }
}

#[test]
fn the_step_in_closed_form_is_that_of_the_matrix_exponential() {
    // Light and heavy damping, critical damping, a spring that hardly is one.
    for (k, c) in
        [(0.16, 0.03), (0.16, 9.0), (1e-7, 0.01), (0.16, 2.0 * libm::sqrt(0.16 * TANK.reduced_mass_kg(BASE_MASS_KG)))]
    {
        let tank = SloshParameters { stiffness_n_m: k, damping_n_s_m: c, ..TANK };
        let start = SloshState { displacement_m: 0.4, velocity_m_s: -0.03 };
        let mut exact = SloshPropagator::new(tank, BASE_MASS_KG, start);
        let mu = tank.reduced_mass_kg(BASE_MASS_KG);
        let beta = mu / BASE_MASS_KG;
        let state = vector![0.4 * beta, -0.03 * beta, beta, libm::log(k / mu), c / mu];
        let (next, acceleration) = SloshStep { base_mass_kg: BASE_MASS_KG, interval_s: 2.0 }.run(&state, 12.0);
        let next = next / beta;
        let expected = exact.step(2.0, 12.0);
        assert!((acceleration - expected).abs() < 1e-12 * expected.abs(), "{k} {c}"); // rounding of exp and ln
        assert!((next[0] - exact.state().displacement_m).abs() < 1e-9, "{k} {c}"); // fifth power of γ t in the series
        assert!((next[1] - exact.state().velocity_m_s).abs() < 1e-12, "{k} {c}");
    }
}

#[test]
fn one_pass_from_half_the_truth_is_honest_and_so_are_two() {
    let (mut sums, seeds) = ([0.0; 2], 40);
    for seed in 0..seeds {
        let passes = filter_twice::<SLOSH_STATES>(&record(seed, 1000), BASE_MASS_KG, &prior()).expect("feasible");
        for (sum, pass) in sums.iter_mut().zip(passes) {
            let p = pass.parameters;
            let error = vector![p.slosh_mass_kg - 28.7, p.stiffness_n_m - 0.16, p.damping_n_s_m - 0.03];
            *sum +=
                estimation::consistency::nees(&error, &pass.covariance).expect("positive") / f64::from(seeds as u32);
        }
    }
    // 40 values of χ²(3): their mean spreads by √(6/40) = 0.39.
    assert!(sums.iter().all(|sum| *sum > 1.9 && *sum < 4.4), "{sums:?}");
}

#[test]
fn a_wide_prior_is_a_sum_of_filters_of_which_the_record_leaves_few() {
    let mut filter = SloshFilter::<SLOSH_STATES>::new(BASE_MASS_KG, &prior());
    let (begun, mut squares) = (filter.filters(), 0.0);
    assert!(begun > 30 && begun < FILTERS_MAX, "{begun}");
    for sample in record(3, 600) {
        let seen = filter.step(&sample).expect("feasible").expect("measured");
        squares += seen.innovation * seen.innovation / seen.variance / 600.0;
    }
    assert!(filter.filters() <= 10, "{}", filter.filters());
    assert!((squares - 1.0).abs() < 0.25, "{squares}"); // 600 unit normal squares: 0.058, and four of those
}

#[test]
fn thrust_without_acceleration_moves_the_slosh_and_teaches_nothing() {
    let mut filter = SloshFilter::<SLOSH_STATES>::new(BASE_MASS_KG, &prior());
    let before = filter.estimate();
    assert_eq!(filter.step(&SloshSample::thrust_alone(1.0, 44.0)), Ok(None));
    let after = filter.estimate();
    assert!((after.parameters.slosh_mass_kg / before.parameters.slosh_mass_kg - 1.0).abs() < 1e-14); // rounding
    assert!(after.state.displacement_m < -0.02); // −f t²/2m0
}
