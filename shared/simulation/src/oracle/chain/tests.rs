//! Laws of the chain: Lagrange's equations, conservation, energy, order of the integrator,
//! symmetry.

use super::*;
use dynamics::noise::Stream;

/// A three-body chain with no symmetry at all: every CM off its axis, every number from a noise
/// stream.
fn random_chain(seed: u64) -> (Chain<3, 5>, Motion<5>) {
    let stream = Stream::new(seed, "chain");
    let mut sample = 0;
    let mut next = || {
        sample += 1;
        stream.uniform_pair(sample)[1]
    };
    let bodies = [(); 3].map(|()| Body {
        mass_kg: 5.0 + 100.0 * next(),
        inertia_com_kg_m2: 1.0 + 50.0 * next(),
        com_m: [2.0 * next() - 1.0, 2.0 * next() - 1.0],
        outboard_joint_m: [3.0 * next() - 1.0, 2.0 * next() - 1.0],
    });
    let motion =
        Motion { q: SVector::from_fn(|_, _| 6.0 * next() - 3.0), q_dot: SVector::from_fn(|_, _| 2.0 * next() - 1.0) };
    (Chain::new(bodies), motion)
}

/// Kinetic energy written from positions alone: the velocity of each CM by a central difference
/// along q̇.
fn energy_from_positions(chain: &Chain<3, 5>, motion: &Motion<5>) -> f64 {
    let coms = |q: &SVector<f64, 5>| {
        let (mut at, mut angle) = ([q[0], q[1]], 0.0);
        chain.bodies.map(|body| {
            let index = chain.bodies.iter().position(|other| other == &body).unwrap();
            angle += q[2 + index];
            let turn = |r: [f64; 2]| [angle.cos() * r[0] - angle.sin() * r[1], angle.sin() * r[0] + angle.cos() * r[1]];
            let com = add(at, turn(body.com_m));
            at = add(at, turn(body.outboard_joint_m));
            com
        })
    };
    let h = 1e-5;
    let (ahead, behind) = (coms(&(motion.q + motion.q_dot * h)), coms(&(motion.q - motion.q_dot * h)));
    let (mut energy, mut rate) = (0.0, 0.0);
    for (i, body) in chain.bodies.iter().enumerate() {
        rate += motion.q_dot[2 + i];
        let v = scale(0.5 / h, sub(ahead[i], behind[i]));
        energy += 0.5 * body.mass_kg * dot(v, v) + 0.5 * body.inertia_com_kg_m2 * rate * rate;
    }
    energy
}

#[test]
fn mass_matrix_gives_the_kinetic_energy_of_the_moving_points() {
    for seed in 0..32 {
        let (chain, motion) = random_chain(seed);
        let from_matrix = chain.invariants(&motion).kinetic_energy_j;
        // central difference with h = 1e-5: truncation h² = 1e-10, rounding ε/h = 1e-11, times
        // squared angle rates of order 5
        assert!((from_matrix / energy_from_positions(&chain, &motion) - 1.0).abs() < 1e-8, "seed {seed}");
    }
}

#[test]
fn velocity_terms_are_the_christoffel_terms_of_the_mass_matrix() {
    let h = 1e-5;
    for seed in 0..32 {
        let (chain, motion) = random_chain(seed);
        let mass_at = |q: SVector<f64, 5>| chain.mass_and_bias(&Motion { q, ..motion }).0;
        let derivative: Vec<Matrix<5>> = (0..5)
            .map(|k| {
                let shift = SVector::<f64, 5>::from_fn(|row, _| if row == k { h } else { 0.0 });
                (mass_at(motion.q + shift) - mass_at(motion.q - shift)) / (2.0 * h)
            })
            .collect();
        // Lagrange: b = Ṁ q̇ − ½ ∂(q̇ᵀ M q̇)/∂q
        let mass_rate = (0..5).fold(Matrix::<5>::zeros(), |sum, k| sum + derivative[k] * motion.q_dot[k]);
        let gradient = SVector::<f64, 5>::from_fn(|k, _| motion.q_dot.dot(&(derivative[k] * motion.q_dot)));
        let (mass, bias) = chain.mass_and_bias(&motion);
        let difference = (mass_rate * motion.q_dot - gradient * 0.5 - bias).norm();
        // same central difference; relative to the size of M, which multiplies rates of order 1
        assert!(difference < 1e-8 * mass.norm(), "seed {seed}: {difference}");
    }
}

#[test]
fn joint_torques_leave_the_momenta_alone_and_the_drift_falls_with_the_step() {
    let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 20.0, -7.0]);
    for seed in 0..8 {
        let drift = |steps: usize| {
            let (chain, mut motion) = random_chain(seed);
            let before = chain.invariants(&motion);
            (0..steps).for_each(|_| chain.advance(&mut motion, &force, 2.0 / steps as f64));
            let after = chain.invariants(&motion);
            let scale = before.kinetic_energy_j.max(1.0);
            let h = (after.angular_momentum_com_nms - before.angular_momentum_com_nms).abs();
            let p = (0..2).map(|axis| (after.linear_momentum_n_s[axis] - before.linear_momentum_n_s[axis]).abs());
            (h + p.sum::<f64>()) / scale
        };
        let (coarse, fine) = (drift(400), drift(3200));
        // truncation 8⁴ smaller, down to the rounding of 3200 steps (3200 ε = 7e-13)
        assert!(fine < coarse / 1000.0 + 2e-12, "seed {seed}: {coarse:e} -> {fine:e}");
        assert!(fine < 1e-9, "seed {seed}: {fine:e}");
    }
}

#[test]
fn kinetic_energy_grows_by_the_work_of_the_joint_torques() {
    let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 20.0, -7.0]);
    for seed in 0..8 {
        let (chain, mut motion) = random_chain(seed);
        let start = motion;
        (0..8000).for_each(|_| chain.advance(&mut motion, &force, 2.5e-4));
        let gained = chain.invariants(&motion).kinetic_energy_j - chain.invariants(&start).kinetic_energy_j;
        let work = force.dot(&(motion.q - start.q)); // torque held, so work = torque × angle exactly
        let scale = chain.invariants(&motion).kinetic_energy_j + work.abs();
        // truncation of RK4 at this step, seen in the drift test above
        assert!((gained - work).abs() < 1e-9 * scale, "seed {seed}: {gained} against {work}");
    }
}

#[test]
fn halving_the_step_divides_the_error_by_sixteen() {
    let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 20.0, -7.0]);
    let (chain, start) = random_chain(4);
    let end = |steps: usize| {
        let mut motion = start;
        (0..steps).for_each(|_| chain.advance(&mut motion, &force, 1.0 / steps as f64));
        motion
    };
    let exact = end(4096);
    let error = |steps| (end(steps).q - exact.q).norm();
    let order = libm::log2(error(128) / error(256));
    assert!((3.9..=4.1).contains(&order), "order {order}");
}

#[test]
fn inverse_dynamics_inverts_the_dynamics_of_a_free_base() {
    for seed in 0..32 {
        let (chain, motion) = random_chain(seed);
        let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 11.0, -3.0]);
        let acceleration = chain.acceleration(&motion, &force);
        let mut joints_only = acceleration;
        joints_only.fixed_rows_mut::<3>(0).fill(f64::NAN); // must be ignored
        let recovered = chain.inverse_dynamics(&motion, joints_only);
        let (mass, bias) = chain.mass_and_bias(&motion);
        let terms = (mass * acceleration).norm() + bias.norm();
        // rounding of two solves, relative to the terms that cancel
        assert!((recovered - force).norm() < 1e-11 * terms, "seed {seed}: {}", (recovered - force).norm());
    }
}

#[test]
fn turning_and_moving_the_whole_system_changes_nothing_in_the_joints() {
    let force = SVector::<f64, 5>::from([0.0, 0.0, 0.0, 20.0, -7.0]);
    let (chain, motion) = random_chain(9);
    let mut moved = motion;
    moved.q[0] += 100.0;
    moved.q[2] += 1.3;
    let (sin, cos) = libm::sincos(1.3);
    moved.q_dot[0] = cos * motion.q_dot[0] - sin * motion.q_dot[1] + 5.0; // and a steady drift
    moved.q_dot[1] = sin * motion.q_dot[0] + cos * motion.q_dot[1];
    let here = chain.acceleration(&motion, &force);
    let there = chain.acceleration(&moved, &force);
    // rounding only
    assert!((2..5).all(|k| (here[k] - there[k]).abs() < 1e-12 * here.norm()));
}

#[test]
fn momentum_from_the_com_inertia_is_the_momentum_when_the_centre_of_mass_rests() {
    for seed in 0..16 {
        let (chain, mut motion) = random_chain(seed);
        chain.set_base_velocity_from_momentum(&mut motion, 68.0);
        let invariants = chain.invariants(&motion);
        let inertia = chain.inertia_about_com(&motion);
        let terms = inertia.norm() * motion.q_dot.norm();
        let from_inertia = (inertia.row(2) * motion.q_dot)[0];
        assert!((invariants.angular_momentum_com_nms - 68.0).abs() < 1e-13 * terms, "seed {seed}");
        assert!((from_inertia - 68.0).abs() < 1e-13 * terms, "seed {seed}");
        assert!(invariants.linear_momentum_n_s.iter().all(|p| p.abs() < 1e-13 * terms), "seed {seed}");
    }
}
