//! Filter, smoother and weak form on the same records: truth, bound, honesty.

use crate::arm_smoother::{SmootherSettings, SmootherStep, bound, smooth};
use crate::simulated_arm::{H_NMS, INTERVAL_S, TORQUE_SIGMA_N_M, benchmark_arm, benchmark_sigma, record};
use estimation::consistency::nees;
use physics::arm_filter::{ArmFilter, ArmFilterSettings, self_start};
use physics::dynamic_equation::ArmSample;
use physics::free_floating::{Alpha, PlanarArm};
use physics::momentum::MomentumSample;
use physics::weak_form::{WeakSettings, weak_form};

const MOMENTUM: (f64, f64) = (H_NMS, 1e-6);

fn skewed() -> Alpha {
    PlanarArm { base_to_joint_m: [0.99, 0.40], ..benchmark_arm() }.minimal_parameters()
}

fn settings(truth: &Alpha, start: f64) -> ArmFilterSettings<8> {
    ArmFilterSettings {
        start: truth * start,
        start_sd: truth.map(|value| 0.3 * value.abs()),
        scale: truth.map(f64::abs),
        sigma: benchmark_sigma(),
        torque_sigma_n_m: TORQUE_SIGMA_N_M,
        interval_s: INTERVAL_S,
        h_nms: None,
    }
}

fn smoother(momentum_nms: Option<(f64, f64)>) -> SmootherSettings {
    SmootherSettings {
        sigma: benchmark_sigma(),
        torque_sigma_n_m: TORQUE_SIGMA_N_M,
        interval_s: INTERVAL_S,
        momentum_nms,
    }
}

fn filtered(samples: &[ArmSample], settings: &ArmFilterSettings<8>) -> ArmFilter<8, 13> {
    let mut filter = ArmFilter::new(settings);
    samples.iter().for_each(|sample| filter.push(sample).expect("feasible"));
    filter
}

#[test]
fn bounds_along_trajectory_b_equal_those_of_an_independent_smoother() {
    let truth = benchmark_arm().minimal_parameters();
    let perfect = record(&truth, &benchmark_sigma(), 60, 0, 0.0);
    let mut steps = vec![SmootherStep::<13>::default(); perfect.len()];
    let printed = [
        (None, [0.0171, 0.0178, 0.0140, 0.0180, 0.0181, 0.0256, 0.0240, 0.0178]),
        (Some(MOMENTUM), [0.0048, 0.0068, 0.0077, 0.0115, 0.0115, 0.0200, 0.0203, 0.0123]),
    ];
    for (momentum_nms, printed) in printed {
        let covariance = bound(&perfect, &truth, &smoother(momentum_nms), &mut steps).expect("physical");
        for i in 0..8 {
            let percent = 100.0 * covariance[(i, i)].sqrt() / truth[i];
            assert!((percent / printed[i] - 1.0).abs() < 0.02, "a{}: {percent} {}", i + 1, printed[i]); // four decimals
        }
    }
}

#[test]
fn filter_and_smoother_agree_to_a_part_of_a_sigma_and_their_covariances_are_honest() {
    let truth = skewed();
    let mut steps = vec![SmootherStep::<13>::default(); 6000];
    let (mut filter_nees, mut smoother_nees, mut nis, seeds) = (0.0, 0.0, 0.0, 16);
    for seed in 0..seeds {
        let samples = record(&truth, &benchmark_sigma(), 60, seed, 1.0);
        let start = self_start(&samples[..2000], &settings(&truth, 0.55)).expect("excited");
        let filter = filtered(&samples, &start);
        let smoothed = smooth(&samples, &start.start, &smoother(None), 2, &mut steps).expect("physical");
        let (one, two) = (filter.estimate(), smoothed.estimate);
        let difference = nees(&(one.alpha - two.alpha), &two.covariance).expect("positive");
        assert!(difference < 0.5, "seed {seed}: {difference}"); // a hundredth of the information is counted twice, and curvature
        filter_nees += nees(&(one.alpha - truth), &one.covariance).expect("positive") / seeds as f64;
        smoother_nees += nees(&(two.alpha - truth), &two.covariance).expect("positive") / seeds as f64;
        nis += smoothed.nis.per_degree().expect("6000 samples") / seeds as f64;
    }
    println!("NEES filter {filter_nees:.2}, smoother {smoother_nees:.2} for 8; NIS {nis:.4}");
    // √(16/16) = 1, four of them: enough to see a covariance wrong by 1.5. `obsid bench bp1a` has
    // the long campaign.
    assert!((filter_nees - 8.0).abs() < 4.0 && (smoother_nees - 8.0).abs() < 4.0);
    assert!((nis - 1.0).abs() < 0.01, "{nis}"); // √(2 / (30 000 · 16)) = 0.002
}

#[test]
fn starts_from_a_fifth_to_nearly_twice_the_truth_all_arrive() {
    let truth = skewed();
    let samples = record(&truth, &benchmark_sigma(), 40, 3, 1.0);
    for share in [0.2, 0.55, 1.8] {
        let start = self_start(&samples[..2000], &settings(&truth, share)).expect("excited");
        let worst = (filtered(&samples, &start).estimate().alpha - truth).component_div(&truth).amax();
        assert!(worst < 2e-3, "from {share}: {worst}"); // five sigmas of 40 s
    }
}

#[test]
fn a_stretch_at_rest_starts_nothing() {
    let truth = skewed();
    let still = vec![record(&truth, &benchmark_sigma(), 1, 3, 0.0)[0]; 2000];
    assert_eq!(self_start(&still, &settings(&truth, 0.55)), None);
}

#[test]
fn weak_form_is_honest_and_its_bias_falls_with_the_square_of_nothing_but_noise() {
    let truth = skewed();
    let settings = |window_samples, sigma: f64| WeakSettings {
        interval_s: INTERVAL_S,
        window_samples,
        channel_sigma: benchmark_sigma().in_channel_order().map(|value| value * sigma),
        torque_sigma_n_m: TORQUE_SIGMA_N_M * sigma,
    };
    // Without noise: quadrature of smooth windows, torque held exactly.
    let perfect = record(&truth, &benchmark_sigma(), 60, 0, 0.0);
    let found = weak_form::<8>(&perfect, &settings(400, 1.0)).expect("excited").estimate;
    assert!((found.alpha - truth).component_div(&truth).amax() < 1e-5);
    let (mut sum, mut chi_square, seeds) = (0.0, 0.0, 30);
    for seed in 0..seeds {
        let samples = record(&truth, &benchmark_sigma(), 60, 100 + seed, 1.0);
        let found = weak_form::<8>(&samples, &settings(400, 1.0)).expect("excited");
        sum += nees(&(found.estimate.alpha - truth), &found.estimate.covariance).expect("positive") / seeds as f64;
        chi_square += found.chi_square_per_row * 87.0 / (79.0 * seeds as f64);
    }
    println!("weak form: NEES {sum:.2} for 8, chi2 per degree {chi_square:.3}");
    assert!((sum - 8.0).abs() < 4.0 * libm::sqrt(16.0 / 30.0), "{sum}");
    assert!((chi_square - 1.0).abs() < 4.0 * libm::sqrt(2.0 / (79.0 * 30.0)), "{chi_square}");
}

#[test]
fn momentum_methods_agree_with_each_other_within_the_noise() {
    use crate::momentum_methods::{
        KnownMomentum, generalised_total_least_squares, instrumental, least_squares, total_least_squares, weighted,
    };
    use physics::excitation::FourierTrajectory;
    let (truth, sigma) = (skewed(), benchmark_sigma());
    let momentum = KnownMomentum { h_nms: H_NMS, sigma_h_nms: 0.0 };
    let command = FourierTrajectory::trajectory_b();
    let motions: Vec<MomentumSample> = record(&truth, &sigma, 60, 9, 1.0).iter().map(|sample| sample.motion).collect();
    let best = weighted(&motions, momentum, &sigma, &(truth * 0.55)).expect("excited").0;
    let others: [Alpha; 4] = [
        least_squares(&motions, momentum, &sigma).expect("excited").alpha,
        total_least_squares::<8, 9>(&motions, momentum).expect("generic"),
        generalised_total_least_squares::<8, 9>(&motions, momentum, &sigma).expect("generic"),
        instrumental(&motions, |k| command.at(k as f64 * INTERVAL_S), momentum, &sigma).expect("excited").alpha,
    ];
    let own = nees(&(best.alpha - truth), &best.covariance).expect("positive");
    assert!(own < 26.1, "{own}"); // χ²(8), 99.9 %
    for (i, other) in others.iter().enumerate() {
        let away = nees(&(other - best.alpha), &best.covariance).expect("positive");
        assert!(away < 8.0, "{i}: {away}"); // they share most of the noise: 2–8 % of the accuracy apart
    }
}
