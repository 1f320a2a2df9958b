//! A target is noticed by the ninth parameter.

use crate::momentum_methods::{KnownMomentum, weighted};
use crate::simulated_arm::{H_NMS, benchmark_arm, benchmark_sigma, record};
use physics::mated::{MatedAlpha, OFF_AXIS_SIGMAS, Target, mated_parameters, minimal_parameters, off_axis_sigmas};

#[test]
fn a_target_is_noticed_by_the_ninth_parameter_and_its_absence_too() {
    let arm = benchmark_arm();
    let target = Target { mass_kg: 5.0, inertia_com_kg_m2: 1.0, grasp_to_com_m: [0.2, 0.1] };
    let (sigma, momentum) = (benchmark_sigma(), KnownMomentum { h_nms: H_NMS, sigma_h_nms: 0.0 });
    let sigmas = |truth: MatedAlpha| {
        let motions: Vec<_> = record(&truth, &sigma, 60, 5, 1.0).iter().map(|sample| sample.motion).collect();
        let start = truth.map(|value| if value == 0.0 { 0.1 } else { 0.8 * value });
        let found = weighted(&motions, momentum, &sigma, &start).expect("excited").0;
        off_axis_sigmas(&found.alpha, &found.covariance).expect("a variance")
    };
    assert!(sigmas(mated_parameters(&arm, 1.898, &target)).abs() > 2.0 * OFF_AXIS_SIGMAS);
    assert!(sigmas(minimal_parameters(&arm, [arm.joint_to_com_m[1], 0.0])).abs() < OFF_AXIS_SIGMAS);
}
