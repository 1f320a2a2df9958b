use super::*;
use crate::seeded_noise::SeededNoise;
use libm::{cos, sin};

const BASE_COM_M: [f64; 2] = [-0.07, 0.12];

fn skewed() -> PlanarArm {
    PlanarArm { base_to_joint_m: [0.99, 0.40], ..Default::default() }
}

fn random_motion(noise: &mut SeededNoise) -> FlyingMotion {
    let mut draw = || noise.normal();
    FlyingMotion {
        acceleration_m_s2: [draw(), draw()],
        joint_angle_rad: [2.0 * draw(), 2.0 * draw()],
        rates_rad_s: [draw(), draw(), draw()],
        accelerations_rad_s2: [draw(), draw(), draw()],
    }
}

/// Newton and Euler body by body, no minimal parameter: efforts for a motion, and the sizes of the
/// terms that were added.
fn newton_euler(arm: &PlanarArm, base_com_m: [f64; 2], motion: &FlyingMotion) -> (Five, Five) {
    let ([w0, d1, d2], [b0, dd1, dd2]) = (motion.rates_rad_s, motion.accelerations_rad_s2);
    let [th1, th2] = motion.joint_angle_rad;
    let angle = [0.0, th1, th1 + th2];
    let (w, b) = ([w0, w0 + d1, w0 + d1 + d2], [b0, b0 + dd1, b0 + dd1 + dd2]);
    let moved = |a: Vector2<f64>, r: Vector2<f64>, i: usize| a + across(r) * b[i] - r * (w[i] * w[i]);
    let along = |x: f64, i: usize| Vector2::new(x * cos(angle[i]), x * sin(angle[i]));
    let reference = Vector2::zeros();
    let joint_1 = reference + Vector2::from(base_com_m) + Vector2::from(arm.base_to_joint_m);
    let joint_2 = joint_1 + along(arm.joint_to_com_m[0] + arm.com_to_next_m, 1);
    let com = [
        Vector2::from(base_com_m),
        joint_1 + along(arm.joint_to_com_m[0], 1),
        joint_2 + along(arm.joint_to_com_m[1], 2),
    ];
    let a_b = Vector2::from(motion.acceleration_m_s2);
    let a_1 = moved(a_b, joint_1, 0);
    let a_2 = moved(a_1, joint_2 - joint_1, 1);
    let a = [moved(a_b, com[0], 0), moved(a_1, com[1] - joint_1, 1), moved(a_2, com[2] - joint_2, 2)];
    let (mut sum, mut size) = (Five::zeros(), Five::zeros());
    for i in 0..3 {
        let force = a[i] * arm.mass_kg[i];
        let spin = arm.inertia_com_kg_m2[i] * b[i];
        let about = |point: Vector2<f64>| (com[i] - point).perp(&force) + spin;
        let bound = |point: Vector2<f64>| (com[i] - point).norm() * force.norm() + spin.abs();
        sum += Five::from([
            force.x,
            force.y,
            about(reference),
            if i > 0 { about(joint_1) } else { 0.0 },
            if i > 1 { about(joint_2) } else { 0.0 },
        ]);
        size += Five::from([force.norm(), force.norm(), bound(reference), bound(joint_1), bound(joint_2)]);
    }
    (sum, size)
}

fn agree(what: &str, a: &Five, b: &Five, size: &Five, tolerance: f64) {
    for row in 0..5 {
        assert!((a[row] - b[row]).abs() <= tolerance * size[row], "{what}, row {row}: {} {}", a[row], b[row]);
    }
}

#[test]
fn wrench_regressor_times_parameters_is_newton_and_euler_of_the_bodies() {
    let mut noise = SeededNoise::new(21);
    let (arm, geometry) = (skewed(), FlyingGeometry::of(&skewed(), BASE_COM_M));
    let pi = parameters(&arm, BASE_COM_M);
    for _ in 0..500 {
        let motion = random_motion(&mut noise);
        let (wrench, size) = newton_euler(&arm, BASE_COM_M, &motion);
        // rounding of some forty products
        agree("Y π", &(wrench_regressor(&geometry, &motion) * pi), &wrench, &size, 1e-14);
    }
}

#[test]
fn mass_matrix_times_acceleration_and_bias_is_newton_and_euler_of_the_bodies() {
    let mut noise = SeededNoise::new(22);
    let (arm, geometry) = (skewed(), FlyingGeometry::of(&skewed(), BASE_COM_M));
    let pi = parameters(&arm, BASE_COM_M);
    for _ in 0..500 {
        let motion = random_motion(&mut noise);
        let (wrench, size) = newton_euler(&arm, BASE_COM_M, &motion);
        let ([ax, ay], [b0, dd1, dd2]) = (motion.acceleration_m_s2, motion.accelerations_rad_s2);
        let (mass, bias) = dynamics(&geometry, &pi, motion.joint_angle_rad, motion.rates_rad_s);
        // relative accelerations are added up in another order: some more roundings
        agree("H q̈ + C", &(mass * Five::from([ax, ay, b0, dd1, dd2]) + bias), &wrench, &size, 1e-13);
        let found =
            accelerations(&geometry, &pi, motion.joint_angle_rad, motion.rates_rad_s, &wrench).expect("physical");
        let error = (found - Five::from([ax, ay, b0, dd1, dd2])).amax();
        assert!(error < 1e-11, "{error}"); // rounding of 1e3 N m × condition of the mass matrix, 1e2, over its size
    }
}

/// `d/dt(momentum)` by fourth-order differences along a motion of constant accelerations.
#[test]
fn momentum_form_is_the_dynamic_equation_integrated_by_parts() {
    let mut noise = SeededNoise::new(23);
    let geometry = FlyingGeometry::of(&skewed(), BASE_COM_M);
    for _ in 0..100 {
        let motion = random_motion(&mut noise);
        let at = |t: f64| {
            let mut later = motion;
            for i in 0..3 {
                later.rates_rad_s[i] += motion.accelerations_rad_s2[i] * t;
            }
            for i in 0..2 {
                later.joint_angle_rad[i] +=
                    t * (motion.rates_rad_s[i + 1] + 0.5 * t * motion.accelerations_rad_s2[i + 1]);
            }
            momentum_form(&geometry, &later).momentum
        };
        let step = 1e-4; // truncation 1e-16 × fifth derivative, rounding 1e-15/1e-4
        let slope = ((at(step) - at(-step)) * 8.0 - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
        let error = slope + momentum_form(&geometry, &motion).remainder - wrench_regressor(&geometry, &motion);
        assert!(error.amax() < 1e-9, "{error}");
    }
}

#[test]
fn momentum_form_does_not_read_angular_accelerations() {
    let mut noise = SeededNoise::new(24);
    let geometry = FlyingGeometry::of(&skewed(), BASE_COM_M);
    let motion = random_motion(&mut noise);
    let still = FlyingMotion { accelerations_rad_s2: [0.0; 3], ..motion };
    assert_eq!(momentum_form(&geometry, &motion), momentum_form(&geometry, &still));
}

#[test]
fn benchmark_parameters_equal_the_printed_ones() {
    let printed = [423.8, 23.562, 23.562, 113.3228, 47.1856, 110.9875, 20.241, 49.1169];
    let pi = parameters(&PlanarArm::default(), [0.0; 2]);
    for (value, print) in pi.iter().zip(printed) {
        assert!((value - print).abs() < 6e-5, "{pi}"); // half of the last printed digit
    }
}

#[test]
fn without_wrench_the_flying_arm_moves_like_the_floating_one() {
    let mut noise = SeededNoise::new(25);
    let (arm, geometry) = (skewed(), FlyingGeometry::of(&skewed(), BASE_COM_M));
    let (pi, alpha) = (parameters(&arm, BASE_COM_M), arm.minimal_parameters());
    for _ in 0..100 {
        let motion = random_motion(&mut noise);
        let (angle, rates) = (motion.joint_angle_rad, motion.rates_rad_s);
        let torque = [10.0 * noise.normal(), 10.0 * noise.normal()];
        let wrench = Five::from([0.0, 0.0, 0.0, torque[0], torque[1]]);
        let flying = accelerations(&geometry, &pi, angle, rates, &wrench).expect("physical");
        let floating = crate::free_floating::accelerations(&alpha, angle, rates, torque).expect("physical");
        let error = (flying.fixed_rows::<3>(2) - floating).amax();
        assert!(error < 1e-11, "{error}"); // rounding × condition
    }
}
