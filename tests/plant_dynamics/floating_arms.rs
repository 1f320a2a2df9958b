//! Free-floating arm before capture (BP1A, eight parameters) and after it (mated, nine).

use crate::subject::{ROUNDING, SKEWED, STATES, Subject, Worst, arm_of, plant, value};
use dynamics::description::Plant;
use dynamics::multibody::{Data, PARAMETERS_PER_LINK, inverse_dynamics_regressor, momentum};
use nalgebra::{DMatrix, DVector, Matrix3, SVector, Vector3};
use physics::dynamic_equation::{ArmMotion, torque_regressor};
use physics::free_floating::{accelerations, dynamics};
use physics::mated::{Target, mated_parameters};
use physics::momentum::{MomentumSample, momentum_regressor};

/// What the closed form makes of the numbers in the file.
fn alpha<const P: usize>(plant: &Plant) -> SVector<f64, P> {
    let arm = arm_of(plant);
    if P == 8 {
        return SVector::from_column_slice(arm.minimal_parameters().as_slice());
    }
    let target = Target {
        mass_kg: value(plant, "target.mass"),
        inertia_com_kg_m2: value(plant, "target.inertia.zz"),
        grasp_to_com_m: ["target.com.x", "target.com.y"].map(|name| value(plant, name)),
    };
    SVector::from_column_slice(mated_parameters(&arm, value(plant, "grasp.position.x"), &target).as_slice())
}

/// A target beside the arm's axis: the ninth parameter as large as the eighth.
const OFF_AXIS: [(&str, f64); 2] = [("target.com.x", -1.0), ("target.com.y", 1.5)];

fn before() -> [Plant; 2] {
    [plant("free_floating_arm", &[]), plant("free_floating_arm", &SKEWED)]
}

fn after() -> [Plant; 2] {
    [plant("mated", &[]), plant("mated", &[&SKEWED[..], &OFF_AXIS].concat())]
}

/// What is done to the closed form's parameters before they are compared.
type Spoil<const P: usize> = fn(&mut SVector<f64, P>);

fn leave<const P: usize>(_: &mut SVector<f64, P>) {}

fn motion(subject: &Subject, accelerations_rad_s2: [f64; 3]) -> ArmMotion {
    let (joint_angle_rad, rates_rad_s) = subject.arm_state();
    ArmMotion { joint_angle_rad, rates_rad_s, accelerations_rad_s2 }
}

/// Forward dynamics of the plant against `H q̈ + C = [0, τ]`, error over
/// `|H⁻¹| (|τ| + Σ|terms of C|)`.
fn accelerations_differ<const P: usize>(plant: Plant, spoil: Spoil<P>) -> Worst {
    let mut alpha = alpha::<P>(&plant);
    spoil(&mut alpha);
    let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
    for k in 0..STATES {
        subject.draw(k);
        subject.push(k, 20.0);
        let torque = [subject.input("shoulder_motor"), subject.input("elbow_motor")];
        let found = subject.rates(["body:hub.rz.rate", "joint:shoulder.rate", "joint:elbow.rate"]);
        let (angle, rates) = subject.arm_state();
        let closed = accelerations(&alpha, angle, rates, torque).expect("physical");
        let inverse: Matrix3<f64> = dynamics(&alpha, angle, rates).0.try_inverse().expect("positive");
        let terms = torque_regressor::<P>(&motion(&subject, [0.0; 3])).abs() * alpha.abs();
        let size = inverse.abs() * (terms + Vector3::new(0.0, torque[0], torque[1]).abs());
        (0..3).for_each(|i| worst.see(found[i] - closed[i], size[i]));
    }
    worst
}

#[test]
fn accelerations_before_capture_are_those_of_the_closed_form() {
    before()
        .into_iter()
        .for_each(|plant| accelerations_differ::<8>(plant, leave).demand("accelerations, BP1A", ROUNDING));
}

#[test]
fn accelerations_after_capture_are_those_of_the_closed_form() {
    after()
        .into_iter()
        .for_each(|plant| accelerations_differ::<9>(plant, leave).demand("accelerations, mated", ROUNDING));
}

/// Momentum about the centre of mass of the whole, the base drifting anyhow, error over `Σ|terms|`.
fn momentum_differs<const P: usize>(plant: Plant, spoil: Spoil<P>) -> Worst {
    let mut alpha = alpha::<P>(&plant);
    spoil(&mut alpha);
    let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
    for k in 0..STATES {
        subject.draw(k);
        // The two sums of the plant are taken about its origin: positions of order one, or
        // cancellation is all there is.
        let found = subject.totals().angular_momentum_com_n_m_s[2];
        let (joint_angle_rad, [omega0_z_rad_s, d1, d2]) = subject.arm_state();
        let sample = MomentumSample { omega0_z_rad_s, joint_rate_rad_s: [d1, d2], joint_angle_rad };
        let terms = momentum_regressor::<P>(&sample).component_mul(&alpha);
        worst.see(found - terms.sum(), terms.abs().sum());
    }
    worst
}

#[test]
fn momentum_before_and_after_capture_is_the_regressor_times_the_parameters() {
    before().into_iter().for_each(|plant| momentum_differs::<8>(plant, leave).demand("momentum, BP1A", ROUNDING));
    after().into_iter().for_each(|plant| momentum_differs::<9>(plant, leave).demand("momentum, mated", ROUNDING));
}

/// Regressor of the bodies times their standard parameters (ten each), at random accelerations of
/// the joints and of the base's rate, the base's translation being what no external force demands;
/// against `Y_τ α`. Error over `Σ|terms|` of both.
fn regressors_differ<const P: usize>(plant: Plant, spoil: Spoil<P>) -> Worst {
    let mut alpha = alpha::<P>(&plant);
    spoil(&mut alpha);
    let (mut subject, mut worst) = (Subject::new(plant), Worst::default());
    let model = subject.system.model().clone();
    let standard = DVector::from_vec(model.standard_parameters());
    let mut data = Data::new(&model);
    let mut regressor = DMatrix::zeros(5, PARAMETERS_PER_LINK * model.links_len());
    for k in 0..STATES {
        subject.draw(k);
        subject.push(k, 1.0);
        let (q, v) = subject.model_state();
        let stream = dynamics::noise::Stream::new(k, "acceleration");
        let mut acceleration: Vec<f64> = (0..5).map(|i| stream.normal(i)).collect();
        inverse_dynamics_regressor(&model, &mut data, &q, &v, &acceleration, &mut regressor);
        let push = &regressor * &standard;
        let mass = momentum(&model, &mut data, &q, &v).mass;
        (1..3).for_each(|i| acceleration[i] -= push[i] / mass);
        inverse_dynamics_regressor(&model, &mut data, &q, &v, &acceleration, &mut regressor);
        let (efforts, bodies) = (&regressor * &standard, regressor.abs() * standard.abs());
        let closed = torque_regressor::<P>(&motion(&subject, [0, 3, 4].map(|i| acceleration[i])));
        let (equation, terms) = (closed * alpha, closed.abs() * alpha.abs());
        for (row, effort) in [0, 3, 4].into_iter().enumerate() {
            worst.see(efforts[effort] - equation[row], terms[row] + bodies[effort]);
        }
    }
    worst
}

#[test]
fn torque_regressor_before_and_after_capture_says_what_that_of_the_bodies_says() {
    before().into_iter().for_each(|plant| regressors_differ::<8>(plant, leave).demand("Y_τ α, BP1A", ROUNDING));
    after().into_iter().for_each(|plant| regressors_differ::<9>(plant, leave).demand("Y_τ α, mated", ROUNDING));
}

/// A millionth of the way to the two being swapped; all of it would be no arm any more.
fn mix<const P: usize>(alpha: &mut SVector<f64, P>, i: usize, j: usize) {
    let step = 1e-6 * (alpha[j] - alpha[i]);
    alpha[i] += step;
    alpha[j] -= step;
}

#[test]
fn one_wrong_parameter_turns_every_comparison_red() {
    let eight: [Spoil<8>; 4] = [|a| mix(a, 3, 4), |a| mix(a, 5, 6), |a| a[7] *= 1.0 + 1e-9, |a| a[0] *= 1.0 + 1e-9];
    let nine: [Spoil<9>; 3] = [|a| a[8] *= 1.0 - 1e-9, |a| mix(a, 7, 8), |a| a[2] *= 1.0 + 1e-9];
    let [_, before] = before();
    let [_, after] = after();
    let red = |worst: Worst| assert!(worst.0 > 2.0 * ROUNDING, "{:e}", worst.0);
    for spoil in eight {
        red(accelerations_differ(before.clone(), spoil));
        red(momentum_differs(before.clone(), spoil));
        red(regressors_differ(before.clone(), spoil));
    }
    for spoil in nine {
        red(accelerations_differ(after.clone(), spoil));
        red(momentum_differs(after.clone(), spoil));
        red(regressors_differ(after.clone(), spoil));
    }
}
