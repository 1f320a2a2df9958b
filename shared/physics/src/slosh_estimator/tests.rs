//! Claims about the slosh estimator, each against two bodies integrated in absolute coordinates.

use super::*;
use crate::seeded_noise::SeededNoise;
use crate::slosh::tests::{BASE_MASS_KG, TANK, two_body_oracle};
use crate::slosh::{SloshParameters, SloshPropagator};
use crate::slosh_plan::{SloshPlan, predicted_sigma};
use estimation::consistency::{ChiSquareMean, nees};
use std::boxed::Box;
use std::println;
use std::vec::Vec;

const QUIESCENT: SloshSettings = SloshSettings { base_mass_kg: BASE_MASS_KG, unknowns: SloshUnknowns::Parameters };
const EVERYTHING: SloshSettings =
    SloshSettings { base_mass_kg: BASE_MASS_KG, unknowns: SloshUnknowns::ParametersStateBias };

/// The seed's experiment: 44 N at 0.01 Hz, accelerometer 0.008 (m/s)/√h, 10 Hz.
const SEED_SINE: SloshPlan = SloshPlan {
    amplitude_n: 44.0,
    frequency_hz: 0.01,
    duration_s: 1000.0,
    interval_s: 0.1,
    velocity_random_walk_m_s_per_sqrt_s: 0.008 / 60.0,
};

struct Experiment {
    interval_s: f64,
    sigma_m_s2: f64,
    forces_n: Vec<f64>,
    accelerations_m_s2: Vec<f64>,
}

impl Experiment {
    fn new(tank: &SloshParameters, start: SloshState, plan: &SloshPlan, force: impl Fn(f64) -> f64) -> Self {
        let samples = (plan.duration_s / plan.interval_s).round() as u32;
        let forces_n: Vec<f64> = (0..samples).map(|k| force(f64::from(k) * plan.interval_s)).collect();
        let accelerations_m_s2 = two_body_oracle(tank, start, plan.interval_s, &forces_n, 4);
        Self { interval_s: plan.interval_s, sigma_m_s2: plan.sigma_m_s2(), forces_n, accelerations_m_s2 }
    }

    fn fly(&self, settings: SloshSettings, bias_m_s2: f64, seed: u64) -> Box<SloshEstimator> {
        let (mut noise, mut estimator) = (SeededNoise::new(seed), Box::new(SloshEstimator::new(settings)));
        for (force_n, acceleration) in self.forces_n.iter().zip(&self.accelerations_m_s2) {
            let acceleration_m_s2 = acceleration + bias_m_s2 + self.sigma_m_s2 * noise.normal();
            let sample = SloshSample {
                interval_s: self.interval_s,
                force_n: *force_n,
                acceleration_m_s2,
                sigma_m_s2: self.sigma_m_s2,
            };
            estimator.push(&sample).expect("finite");
        }
        estimator
    }
}

fn vector(parameters: &SloshParameters) -> Vector3<f64> {
    Vector3::new(parameters.slosh_mass_kg, parameters.stiffness_n_m, parameters.damping_n_s_m)
}

/// RMSE in per cent of truth, RMSE over bound, NEES, coverage of 95 % intervals, mean χ²/dof.
fn campaign(experiment: &Experiment, settings: SloshSettings, plan: &SloshPlan, bias: f64, seeds: u64) -> Vector3<f64> {
    let truth = vector(&TANK);
    let at = SloshHypothesis { parameters: TANK, ..Default::default() };
    let bound = predicted_sigma(&at, &settings, plan).expect("exciting");
    let (mut squares, mut statistic, mut covered) = (Vector3::zeros(), ChiSquareMean::default(), 0);
    let (mut per_degree, mut worst_z) = (0.0, f64::NEG_INFINITY);
    for seed in 0..seeds {
        let estimate = experiment.fly(settings, bias, seed).estimate().expect("slosh is there");
        let error = vector(&estimate.hypothesis.parameters) - truth;
        squares += error.component_mul(&error);
        statistic.push(nees(&error, &estimate.covariance).expect("positive"), 3);
        covered += (0..3).filter(|i| error[*i].abs() < 1.96 * estimate.sigmas()[*i]).count();
        per_degree += estimate.chi_square_per_degree() / seeds as f64;
        worst_z = f64::max(worst_z, estimate.whiteness.worst_z_score());
    }
    let rmse = squares.map(|square| (square / seeds as f64).sqrt());
    let (percent, ratio) = (100.0 * rmse.component_div(&truth), rmse.component_div(&bound));
    let (nees, coverage) = (statistic.mean().expect("seeds"), covered as f64 / (3 * seeds) as f64);
    let bound = 100.0 * bound.component_div(&truth);
    println!("RMSE % {percent:.3?} bound % {bound:.3?} ratio {ratio:.3?}");
    println!("NEES {nees:.3} coverage {coverage:.3} chi2/dof {per_degree:.4} worst whiteness z {worst_z:.2}");
    // 200 seeds: NEES(3) spreads by √(6/200) = 0.17, coverage by 0.9 %; residuals of 200 × 3 scales
    // beyond 5: 1 in 10³.
    assert!(nees > 2.6 && nees < 3.4, "{nees}");
    assert!(coverage > 0.92 && coverage < 0.98, "{coverage}");
    assert!((per_degree - 1.0).abs() < 0.01, "{per_degree}"); // √(2/1250/200) = 0.3 %
    assert!(worst_z < 5.5, "{worst_z}");
    ratio
}

#[test]
fn seed_sine_reaches_the_bound_with_an_honest_covariance() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let ratio = campaign(&experiment, QUIESCENT, &SEED_SINE, 0.0, 200);
    assert!(ratio.max() < 1.10, "{ratio}"); // 200 seeds: spread 5 %
}

#[test]
fn unknown_start_and_bias_cost_what_the_bound_says_and_no_more() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let ratio = campaign(&experiment, EVERYTHING, &SEED_SINE, 2e-5, 100);
    assert!(ratio.max() < 1.18, "{ratio}"); // 100 seeds: spread 7 %
}

#[test]
fn bound_of_the_seed_sine_equals_the_independent_prototype() {
    // Percent of ms, ks, cs; benchmark page 2, section 1.1.
    let at = SloshHypothesis { parameters: TANK, ..Default::default() };
    for (duration_s, settings, printed) in [
        (100.0, QUIESCENT, [2.34, 1.43, 122.7]),
        (300.0, QUIESCENT, [0.52, 0.56, 9.2]),
        (1000.0, QUIESCENT, [0.155, 0.155, 1.02]),
        (1000.0, EVERYTHING, [0.181, 0.188, 1.44]),
        (3600.0, QUIESCENT, [0.081, 0.079, 0.355]),
    ] {
        let plan = SloshPlan { duration_s, ..SEED_SINE };
        let sigma = predicted_sigma(&at, &settings, &plan).expect("exciting");
        for (i, print) in printed.into_iter().enumerate() {
            let percent = 100.0 * sigma[i] / vector(&TANK)[i];
            assert!((percent / print - 1.0).abs() < 0.015, "{duration_s} s, unknown {i}: {percent}"); // printed digits
        }
    }
}

#[test]
fn block_length_does_not_change_the_estimate() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let mut coarse = experiment.fly(QUIESCENT, 0.0, 7);
    let mut noise = SeededNoise::new(7);
    let mut fine = Box::new(SloshEstimator::<16384>::new(QUIESCENT));
    for (force_n, acceleration) in experiment.forces_n.iter().zip(&experiment.accelerations_m_s2) {
        let acceleration_m_s2 = acceleration + experiment.sigma_m_s2 * noise.normal();
        let sigma_m_s2 = experiment.sigma_m_s2;
        fine.push(&SloshSample { interval_s: 0.1, force_n: *force_n, acceleration_m_s2, sigma_m_s2 }).expect("finite");
    }
    let (coarse, fine) = (coarse.estimate().expect("slosh"), fine.estimate().expect("slosh"));
    let moved = vector(&coarse.hypothesis.parameters) - vector(&fine.hypothesis.parameters);
    // 0.8 s blocks lose (ωB)²/12 of the information at most: a few hundredths of a sigma.
    assert!(moved.component_div(&fine.sigmas()).amax() < 0.05, "{moved}");
}

#[test]
fn global_start_finds_random_tanks() {
    let mut noise = SeededNoise::new(1);
    let plan = SloshPlan { duration_s: 1000.0, ..SEED_SINE };
    let (mut found, tanks) = (0, 60);
    for seed in 0..tanks {
        let mut log_between = |low: f64, high: f64| low * libm::pow(high / low, noise.uniform());
        let (mass, frequency, zeta) = (log_between(10.0, 150.0), log_between(0.006, 0.04), log_between(0.002, 0.05));
        let mut tank = SloshParameters { slosh_mass_kg: mass, ..Default::default() };
        let (mu, omega) = (tank.reduced_mass_kg(BASE_MASS_KG), 2.0 * core::f64::consts::PI * frequency);
        tank.stiffness_n_m = omega * omega * mu;
        tank.damping_n_s_m = 2.0 * zeta * omega * mu;
        // Square wave swept from 3 to 50 mHz in 250 s, then coasting.
        let force = |t: f64| {
            let cycles = 0.003 * t + 0.5 * (0.047 / 250.0) * t * t;
            if t > 250.0 { 0.0 } else { libm::copysign(44.0, libm::sin(2.0 * core::f64::consts::PI * cycles)) }
        };
        let experiment = Experiment::new(&tank, SloshState::default(), &plan, force);
        if let Ok(estimate) = experiment.fly(EVERYTHING, 1e-5, seed).estimate() {
            let error = vector(&estimate.hypothesis.parameters) - vector(&tank);
            found += usize::from(error.component_div(&estimate.sigmas()).amax() < 5.0);
        }
    }
    println!("found {found} of {tanks}");
    assert!(found as u64 == tanks, "{found}");
}

#[test]
fn a_rigid_spacecraft_yields_no_slosh() {
    let rigid = SloshParameters { slosh_mass_kg: 1e-9, stiffness_n_m: 1e-9, damping_n_s_m: 0.0 };
    let experiment = Experiment::new(&rigid, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    for seed in 0..20 {
        for settings in [QUIESCENT, EVERYTHING] {
            let outcome = experiment.fly(settings, 0.0, seed).estimate();
            assert!(matches!(outcome, Err(SloshError::NoSloshFound { .. })), "{outcome:?}");
        }
    }
}

#[test]
fn a_second_tank_shows_in_block_means() {
    // 6 kg at about 0.016 Hz beside the first: the model is wrong, and the residual must say so.
    let second = SloshParameters { slosh_mass_kg: 6.0, stiffness_n_m: 0.06, damping_n_s_m: 0.006 };
    let mut experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let other = Experiment::new(&second, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let rigid = |k: usize| SEED_SINE.force_n(k as f64 * 0.1) / BASE_MASS_KG;
    for (k, acceleration) in experiment.accelerations_m_s2.iter_mut().enumerate() {
        *acceleration += other.accelerations_m_s2[k] - rigid(k);
    }
    let estimate = experiment.fly(EVERYTHING, 0.0, 1).estimate().expect("something fits");
    println!("z {:?}", estimate.whiteness.verdicts().map(|verdict| verdict.z_score));
    assert!(estimate.whiteness.worst_z_score() > 10.0);
}

#[test]
fn warm_start_agrees_with_a_fresh_scan() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let mut noise = SeededNoise::new(3);
    let mut warm = Box::new(SloshEstimator::<2048>::new(QUIESCENT));
    let mut last = None;
    for (k, (force_n, acceleration)) in experiment.forces_n.iter().zip(&experiment.accelerations_m_s2).enumerate() {
        let acceleration_m_s2 = acceleration + experiment.sigma_m_s2 * noise.normal();
        let sigma_m_s2 = experiment.sigma_m_s2;
        warm.push(&SloshSample { interval_s: 0.1, force_n: *force_n, acceleration_m_s2, sigma_m_s2 }).expect("finite");
        if k % 250 == 249 {
            last = Some(warm.estimate());
        }
    }
    let warm = last.expect("asked").expect("slosh");
    let fresh = experiment.fly(QUIESCENT, 0.0, 3).estimate().expect("slosh");
    assert!(fresh.scanned && !warm.scanned);
    let moved = vector(&warm.hypothesis.parameters) - vector(&fresh.hypothesis.parameters);
    assert!(moved.component_div(&fresh.sigmas()).amax() < 2.0 * STEP_SIGMAS, "{moved}"); // both within the tolerance
}

#[test]
fn too_short_an_arc_is_refused_by_name() {
    let mut estimator = Box::new(SloshEstimator::<2048>::new(QUIESCENT));
    assert_eq!(estimator.estimate(), Err(SloshError::ArcTooShort { got: 0, need: 6 }));
}

#[test]
fn a_checkpoint_continues_to_the_same_estimate() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let mut original = experiment.fly(QUIESCENT, 0.0, 5);
    original.estimate().expect("slosh");
    let bytes = postcard::to_stdvec(&*original).expect("plain numbers");
    println!("checkpoint {} bytes", bytes.len());
    let mut restored: Box<SloshEstimator> = Box::new(postcard::from_bytes(&bytes).expect("own bytes"));
    assert_eq!(original.estimate(), restored.estimate());
}

/// A tank of `mass_kg` whose mode has the frequency and damping ratio.
fn tank_of(mass_kg: f64, frequency_hz: f64, damping_ratio: f64) -> SloshParameters {
    let mut tank = SloshParameters { slosh_mass_kg: mass_kg, ..Default::default() };
    let (mu, omega) = (tank.reduced_mass_kg(BASE_MASS_KG), 2.0 * core::f64::consts::PI * frequency_hz);
    tank.stiffness_n_m = omega * omega * mu;
    tank.damping_n_s_m = 2.0 * damping_ratio * omega * mu;
    tank
}

impl Experiment {
    /// As [`Self::fly`], without the samples for which `is_lost`.
    fn fly_with_gaps(&self, settings: SloshSettings, seed: u64, is_lost: impl Fn(f64) -> bool) -> Box<SloshEstimator> {
        let (mut noise, mut estimator) = (SeededNoise::new(seed), Box::new(SloshEstimator::new(settings)));
        for (k, (force_n, acceleration)) in self.forces_n.iter().zip(&self.accelerations_m_s2).enumerate() {
            let (interval_s, sigma_m_s2) = (self.interval_s, self.sigma_m_s2);
            let acceleration_m_s2 = acceleration + sigma_m_s2 * noise.normal();
            let begin_s = k as f64 * interval_s;
            let sample = SloshSample { interval_s, force_n: *force_n, acceleration_m_s2, sigma_m_s2 };
            if !is_lost(begin_s) {
                estimator.push_at(begin_s, &sample).expect("in order");
            }
        }
        estimator
    }
}

/// Mean NEES over seeds and the largest error in sigma.
fn honesty(tank: &SloshParameters, seeds: u64, estimate: impl Fn(u64) -> SloshEstimate) -> (f64, f64) {
    let (mut statistic, mut worst) = (ChiSquareMean::default(), 0.0);
    for seed in 0..seeds {
        let estimate = estimate(seed);
        let error = vector(&estimate.hypothesis.parameters) - vector(tank);
        statistic.push(nees(&error, &estimate.covariance).expect("positive"), 3);
        worst = f64::max(worst, error.component_div(&estimate.sigmas()).amax());
    }
    (statistic.mean().expect("seeds"), worst)
}

#[test]
fn a_record_with_gaps_is_as_honest_as_the_full_one() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let within = |t: f64, from: f64, length: f64| t >= from - 1e-6 && t < from + length - 1e-6;
    let cases: [(&str, &dyn Fn(f64) -> bool); 6] = [
        ("0.1 s at 400 s", &|t| within(t, 400.0, 0.1)),
        ("1 s at 400 s", &|t| within(t, 400.0, 1.0)),
        ("30 s at 400 s", &|t| within(t, 400.0, 30.0)),
        ("0.5 s at 100 s", &|t| within(t, 100.0, 0.5)),
        ("2 s at 950 s", &|t| within(t, 950.0, 2.0)),
        ("2 s every 100 s", &|t| within(t % 100.0, 50.0, 2.0)),
    ];
    for settings in [QUIESCENT, EVERYTHING] {
        for (name, is_lost) in &cases {
            let seeds = 12;
            let (nees, worst) = honesty(&TANK, seeds, |seed| {
                experiment.fly_with_gaps(settings, seed, is_lost).estimate().expect("slosh is there")
            });
            println!("{:?} {name}: NEES {nees:.2}, worst {worst:.2} sigma", settings.unknowns);
            // 12 seeds: NEES(3) spreads by √(6/12) = 0.7, four of them; 36 errors beyond 4.5 sigma:
            // 2 in 10⁴.
            assert!(nees > 0.2 && nees < 5.8 && worst < 4.5, "{name}: {nees} {worst}");
        }
    }
}

#[test]
fn a_gap_costs_what_it_hides_and_no_more() {
    // Half a minute behind which the slosh state is solved again: the full record's estimate,
    // within its own sigma.
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    for seed in 0..10 {
        let full = experiment.fly(EVERYTHING, 0.0, seed).estimate().expect("slosh");
        let gap =
            experiment.fly_with_gaps(EVERYTHING, seed, |t| (500.0..530.0).contains(&t)).estimate().expect("slosh");
        assert!(gap.sigmas().component_div(&full.sigmas()).min() > 0.99, "less data, less sigma");
        let moved = vector(&gap.hypothesis.parameters) - vector(&full.hypothesis.parameters);
        // The difference of an estimate from part of the data and from all spreads by √(σ² −
        // σ_full²) ≤ σ.
        assert!(moved.component_div(&gap.sigmas()).amax() < 3.0, "{moved}");
    }
}

#[test]
fn samples_without_acceleration_are_no_gap() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let (nees, worst) = honesty(&TANK, 20, |seed| {
        let (mut noise, mut estimator) = (SeededNoise::new(seed), Box::new(SloshEstimator::<2048>::new(QUIESCENT)));
        for (k, (force_n, acceleration)) in experiment.forces_n.iter().zip(&experiment.accelerations_m_s2).enumerate() {
            let (interval_s, sigma_m_s2) = (experiment.interval_s, experiment.sigma_m_s2);
            let acceleration_m_s2 = acceleration + sigma_m_s2 * noise.normal();
            let measured = SloshSample { interval_s, force_n: *force_n, acceleration_m_s2, sigma_m_s2 };
            let is_lost = k % 53 == 7 || (3000..3100).contains(&k);
            let sample = if is_lost { SloshSample::thrust_alone(interval_s, *force_n) } else { measured };
            estimator.push(&sample).expect("finite");
        }
        assert_eq!(estimator.arc().segments(), 1);
        estimator.estimate().expect("slosh")
    });
    assert!(nees > 0.9 && nees < 5.2 && worst < 4.5, "{nees} {worst}"); // 20 seeds: spread 0.55, four of them
}

#[test]
fn crumbs_of_a_record_are_refused_by_name() {
    let experiment = Experiment::new(&TANK, SloshState::default(), &SEED_SINE, |t| SEED_SINE.force_n(t));
    let outcome = experiment.fly_with_gaps(EVERYTHING, 1, |t| t % 1.0 > 0.75).estimate();
    assert!(matches!(outcome, Err(SloshError::Fragmented { .. })), "{outcome:?}");
}

#[test]
fn a_fast_mode_over_a_long_record_is_unbiased_or_refused_by_name() {
    for (rate_hz, frequency_hz) in [(20.0, 0.1), (20.0, 0.3), (20.0, 0.45), (20.0, 1.0)] {
        let tank = tank_of(60.0, frequency_hz, 0.02);
        let plan =
            SloshPlan { interval_s: 1.0 / rate_hz, duration_s: 1500.0, frequency_hz: 0.93 * frequency_hz, ..SEED_SINE };
        let force = |t: f64| plan.force_n(t + plan.interval_s / 2.0);
        let experiment = Experiment::new(&tank, SloshState::default(), &plan, force);
        for settings in [QUIESCENT, EVERYTHING] {
            let (nees, worst) = honesty(&tank, 3, |seed| {
                let mut estimator = experiment.fly(settings, 0.0, seed);
                let estimate = estimator.estimate().expect("a mode that the first blocks show");
                let omega_times_block = 2.0 * core::f64::consts::PI * frequency_hz * estimator.arc().resolution_s();
                assert!(omega_times_block <= estimator.arc().resolved_product(), "{omega_times_block}");
                estimate
            });
            println!(
                "{rate_hz} Hz, mode {frequency_hz} Hz, {:?}: NEES {nees:.2}, worst {worst:.2} sigma",
                settings.unknowns
            );
            // 3 seeds: NEES(3) spreads by 1.4; 9 errors beyond 4 sigma: 6 in 10⁴.
            assert!(nees < 8.7 && worst < 4.0, "{rate_hz} {frequency_hz}: {nees} {worst}");
        }
    }
}

#[test]
fn what_blocks_lose_falls_with_the_second_power_of_omega_times_block_at_least() {
    // No noise, so what is left is what blocks lose; the force's edges fall inside blocks.
    let mut errors = std::vec![];
    for samples_per_block in [8_u32, 16, 32] {
        let tank = tank_of(60.0, 0.05, 0.02);
        let plan = SloshPlan { duration_s: 600.0, ..SEED_SINE };
        let force = |t: f64| libm::copysign(44.0, libm::sin(2.0 * core::f64::consts::PI * 0.043 * t));
        let experiment = Experiment::new(&tank, SloshState::default(), &plan, force);
        let mut arc = SloshArc::<8192>::default();
        for (force_n, acceleration_m_s2) in experiment.forces_n.iter().zip(&experiment.accelerations_m_s2) {
            let sigma_m_s2 = experiment.sigma_m_s2;
            let sample =
                SloshSample { interval_s: 0.1, force_n: *force_n, acceleration_m_s2: *acceleration_m_s2, sigma_m_s2 };
            arc.push(&sample).expect("finite");
        }
        for _ in 0..samples_per_block.ilog2() {
            arc.merge();
        }
        let truth = SloshHypothesis { parameters: tank, ..Default::default() };
        let at = likelihood(&arc, BASE_MASS_KG, &truth, SloshUnknowns::Parameters, |_| {});
        errors.push(at.chi_square.sqrt());
    }
    println!("χ of noise-free blocks, ωB = 0.25, 0.5, 1.0: {errors:.4?}");
    assert!(errors[1] / errors[0] > 4.0 && errors[2] / errors[1] > 4.0, "{errors:?}");
    assert!(errors[0] < 1.0, "at the limit of resolution, blocks lose less than noise hides");
}

#[test]
fn a_mode_beyond_what_the_blocks_tell_is_refused_and_the_band_is_named() {
    // A quiet quarter of an hour in which nothing shows, so blocks are merged; then a mode far
    // above them rings.
    let tank = tank_of(60.0, 1.0, 0.005);
    let plan = SloshPlan { interval_s: 0.05, duration_s: 1500.0, ..SEED_SINE };
    let force =
        |t: f64| if t > 900.0 { libm::copysign(44.0, libm::sin(2.0 * core::f64::consts::PI * 0.97 * t)) } else { 0.0 };
    let experiment = Experiment::new(&tank, SloshState::default(), &plan, force);
    for seed in 0..3 {
        let mut estimator = experiment.fly(EVERYTHING, 0.0, seed);
        let outcome = estimator.estimate();
        println!("{outcome:?} searched {:?}", estimator.searched_hz);
        assert!(estimator.searched_hz[1] < 0.1);
        // Whatever is tried on it: nothing that the residual would not call wrong.
        assert!(outcome.is_err() || outcome.is_ok_and(|estimate| estimate.whiteness.worst_z_score() > 10.0));
    }
}

#[test]
fn jittered_stamps_give_the_estimate_of_equal_intervals() {
    let mut noise = SeededNoise::new(11);
    let (mut equal, mut jittered) =
        (Box::new(SloshEstimator::<2048>::new(EVERYTHING)), Box::new(SloshEstimator::<2048>::new(EVERYTHING)));
    for (estimator, jitter) in [(&mut equal, 0.0), (&mut jittered, 0.06)] {
        let mut model =
            SloshPropagator::new(TANK, BASE_MASS_KG, SloshState { displacement_m: 0.3, velocity_m_s: 0.02 });
        let (mut begin_s, mut wander) = (0.0, SeededNoise::new(5));
        for _ in 0..6000 {
            let interval_s = 0.1 * (1.0 + jitter * (2.0 * wander.uniform() - 1.0));
            let (force_n, sigma_m_s2) = (SEED_SINE.force_n(begin_s), 0.008 / 60.0 / libm::sqrt(interval_s));
            let acceleration_m_s2 = model.step(interval_s, force_n) + sigma_m_s2 * noise.normal();
            let sample = SloshSample { interval_s, force_n, acceleration_m_s2, sigma_m_s2 };
            estimator.push_at(begin_s, &sample).expect("in order");
            begin_s += interval_s;
        }
    }
    for estimator in [&mut equal, &mut jittered] {
        let begin = std::time::Instant::now();
        let estimate = estimator.estimate().expect("slosh");
        println!("{:.3} s", begin.elapsed().as_secs_f64());
        assert_eq!(estimator.arc().segments(), 1);
        let error = vector(&estimate.hypothesis.parameters) - vector(&TANK);
        assert!(error.component_div(&estimate.sigmas()).amax() < 4.0, "{error}"); // 6 errors: 4 in 10⁴
    }
}
