use super::*;
use crate::simulated_arm::{PLAN, benchmark_arm, benchmark_sigma};
use physics::excitation::{FourierJoint, predicted_sigma};

fn design() -> Design {
    Design {
        alpha: benchmark_arm().minimal_parameters(),
        h_nms: 68.0,
        sigma: benchmark_sigma(),
        rate_hz: 100.0,
        duration_s: 60.0,
        limits: ArmLimits {
            joint_angle_rad: 2.64, // the trajectory reaches 2.633
            joint_rate_rad_s: 0.355,
            base_rate_rad_s: 0.405,
            torque_n_m: 20.0,
            slosh_stroke_m: 0.05,
        },
        tank: None,
    }
}

fn tank(frequency_hz: f64) -> Tank {
    Tank { arm: benchmark_arm(), position_m: [-0.4, 0.1], frequency_hz, damping_ratio: 0.05 }
}

#[test]
fn coarse_instants_promise_what_every_sample_would() {
    let (design, trajectory) = (design(), FourierTrajectory::trajectory_b());
    let coarse = design.assess(&trajectory).expect("exciting").relative_sigma;
    let fine = predicted_sigma(&design.alpha, &trajectory, &PLAN, &benchmark_sigma()).expect("exciting");
    for i in 0..8 {
        assert!((coarse[i] / (fine[i] / design.alpha[i]) - 1.0).abs() < 1e-3); // a rectangle rule over a whole period
    }
}

#[test]
fn peaks_of_trajectory_b_are_the_printed_ones_and_a_tighter_limit_is_violated() {
    let mut design = design();
    let found = design.assess_at(&FourierTrajectory::trajectory_b(), 3000).expect("exciting");
    assert!((found.peaks.joint_rate_rad_s - 0.354).abs() < 2e-3 && (found.peaks.base_rate_rad_s - 0.403).abs() < 2e-3);
    assert!((found.peaks.torque_n_m - 17.6).abs() < 0.5); // printed with the feedback's part
    assert_eq!(design.violations(&found), [0.0; LIMITS]);
    let inside = design.cost(&found);
    design.limits.torque_n_m = 10.0;
    let found = design.assess_at(&FourierTrajectory::trajectory_b(), 3000).expect("exciting");
    assert!(design.cost(&found) > inside + 1.0);
}

#[test]
fn the_tanks_acceleration_is_the_second_derivative_of_its_place_in_inertial_axes() {
    let (design, trajectory, tank) = (design(), FourierTrajectory::trajectory_b(), tank(0.5));
    let PlanarArm { mass_kg: [m0, m1, m2], base_to_joint_m, joint_to_com_m: [l1, l2], com_to_next_m, .. } = tank.arm;
    // Attitude by quadrature, place from the bodies' centres of mass.
    let step = 1e-3;
    let omega = |k: usize| design.motion(&trajectory, step * k as f64).expect("physical").omega0_rad_s;
    let mut attitude = vec![0.0];
    for k in 0..4000 {
        let last = attitude[k];
        attitude.push(last + 0.5 * step * (omega(k) + omega(k + 1)));
    }
    let place = |k: usize| {
        let [th1, th2] = trajectory.at(step * k as f64).angle_rad;
        let direction = |angle: f64| Vector2::new(libm::cos(angle), libm::sin(angle));
        let (phi0, shoulder) = (attitude[k], Vector2::from(base_to_joint_m));
        let turn = nalgebra::Rotation2::new(phi0);
        let first = turn * (shoulder + direction(th1) * l1);
        let second = turn * (shoulder + direction(th1) * (l1 + com_to_next_m) + direction(th1 + th2) * l2);
        turn * Vector2::from(tank.position_m) - (first * m1 + second * m2) / (m0 + m1 + m2)
    };
    for k in [500, 1700, 3900] {
        let reach = 20;
        let h = step * reach as f64;
        let second = (place(k + reach) + place(k - reach) - place(k) * 2.0) / (h * h);
        let motion = design.motion(&trajectory, step * k as f64).expect("physical");
        let found = nalgebra::Rotation2::new(attitude[k]) * tank.acceleration(&motion);
        assert!((found - second).norm() < 1e-3 * found.norm(), "{found} {second}"); // truncation h² ω²/12 ≈ 1e-4
    }
}

#[test]
fn stiff_propellant_is_displaced_by_what_its_spring_must_carry_and_by_at_most_twice_that_as_it_starts() {
    // Far above the motion's frequencies the spring carries a: the displacement is max |a| / Ω²,
    // after a start at rest up to twice a / Ω².
    let (mut design, trajectory, tank) = (design(), FourierTrajectory::trajectory_b(), tank(5.0));
    design.tank = Some(tank);
    let instants = 3000;
    let mut strokes = std::vec::Vec::new();
    design.slosh(&trajectory, &tank, instants, |stroke_m| strokes.push(stroke_m)).expect("physical");
    let largest = |strokes: &[f64]| strokes.iter().copied().fold(0.0, f64::max);
    let (whole, settled) = (largest(&strokes), largest(&strokes[instants..]));
    let judged = design.assess_at(&trajectory, instants).expect("exciting").peaks.slosh_stroke_m;
    assert_eq!(judged, whole, "the start of the record is flown and counts");
    let at = |k: usize| {
        let motion = design.motion(&trajectory, 30.0 * k as f64 / instants as f64).expect("physical");
        tank.acceleration(&motion).norm()
    };
    let expected = (0..instants).map(at).fold(0.0, f64::max) / (tank.omega_rad_s() * tank.omega_rad_s());
    assert!((settled / expected - 1.0).abs() < 0.02, "{settled} {expected}"); // (f / 5 Hz)² and the turning of the base
    assert!((0.98..2.02).contains(&(whole / expected)), "{whole} {expected}");
}

#[test]
fn a_coarse_grid_sees_the_stroke_that_a_fine_one_does_although_its_steps_are_long() {
    let (mut design, trajectory) = (design(), FourierTrajectory::trajectory_b());
    design.tank = Some(tank(0.5));
    let stroke = |instants| design.assess_at(&trajectory, instants).expect("exciting").peaks.slosh_stroke_m;
    let (coarse, fine, finer) = (stroke(120), stroke(3000), stroke(12_000));
    assert!((fine / finer - 1.0).abs() < 1e-3, "{fine} {finer}");
    assert!((coarse / finer - 1.0).abs() < 0.1, "{coarse} {finer}"); // half a second's steps on a period of two
}

#[test]
fn an_arm_at_rest_throws_nothing_and_shows_nothing() {
    let still = FourierJoint { offset_rad: 0.5, cosine_rate_rad_s: [0.0; 5], sine_rate_rad_s: [0.0; 5] };
    let trajectory = FourierTrajectory { period_s: 30.0, joints: [still; 2] };
    assert_eq!(design().assess(&trajectory), None);
}
