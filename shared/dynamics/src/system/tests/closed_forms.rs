//! Against the closed forms of BP1 and BP2, and against themselves in another dimension.

use super::*;
use crate::system::JointReference;
use nalgebra::SVector;
use simulation::oracle::arm_parameters::ArmParameters;
use simulation::oracle::chain::Motion;

/// The chain's state (inertial velocity) as the system's (body axes).
fn planar_state(motion: &Motion<5>) -> Vec<f64> {
    let (sin, cos) = libm::sincos(motion.q[2]);
    let (vx, vy) = (motion.q_dot[0], motion.q_dot[1]);
    let mut x = motion.q.as_slice().to_vec();
    x.extend([motion.q_dot[2], cos * vx + sin * vy, cos * vy - sin * vx, motion.q_dot[3], motion.q_dot[4]]);
    x
}

fn random_motion(seed: u64) -> Motion<5> {
    let stream = Stream::new(seed, "arm");
    let draw = |k: u64, size: f64| size * (2.0 * stream.uniform_pair(k)[0] - 1.0);
    Motion { q: SVector::from_fn(|i, _| draw(i as u64, 3.0)), q_dot: SVector::from_fn(|i, _| draw(10 + i as u64, 1.0)) }
}

#[test]
fn planar_arm_accelerates_as_the_chain_of_bp1_on_a_thousand_states() {
    let system = System::new(&arm(Space::Planar)).unwrap();
    let chain = ArmParameters::paper_table_ii().chain();
    for seed in 0..1000 {
        let motion = random_motion(seed);
        let [u, _] = Stream::new(seed, "torque").uniform_pair(0);
        let torque = [60.0 * u - 30.0, 20.0 - 40.0 * u];
        let wanted = chain.acceleration(&motion, &SVector::from([0.0, 0.0, 0.0, torque[0], torque[1]]));
        let x_dot = rates(&system, &planar_state(&motion), &torque);
        let angular = [(2, 5), (3, 8), (4, 9)];
        for (own, state) in angular {
            // rounding of two eliminations
            assert!((x_dot[state] - wanted[own]).abs() < 1e-11 * wanted.norm().max(1.0), "seed {seed}");
        }
        for (found, rate) in x_dot.iter().zip(&motion.q_dot) {
            assert!((found - rate).abs() < 1e-14 * 10.0); // rounding of a turn and back
        }
        // inertial acceleration of the base from rates of body components
        let (sin, cos) = libm::sincos(motion.q[2]);
        let x = planar_state(&motion);
        let (ax, ay) = (x_dot[6] - x[5] * x[7], x_dot[7] + x[5] * x[6]);
        let found = [cos * ax - sin * ay, sin * ax + cos * ay];
        assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-11 * wanted.norm().max(1.0)), "seed {seed}");
    }
}

#[test]
fn a_spatial_plant_that_stays_in_the_plane_moves_as_the_planar_one() {
    let (flat, full) = (System::new(&arm(Space::Planar)).unwrap(), System::new(&arm(Space::Spatial)).unwrap());
    for seed in 0..100 {
        let motion = random_motion(seed);
        let x = planar_state(&motion);
        let half = 0.5 * motion.q[2];
        let mut y = vec![x[0], x[1], 0.0, libm::cos(half), 0.0, 0.0, libm::sin(half), x[3], x[4]];
        y.extend([0.0, 0.0, x[5], x[6], x[7], 0.0, x[8], x[9]]);
        let (flat, full) = (rates(&flat, &x, &[5.0, -3.0]), rates(&full, &y, &[5.0, -3.0]));
        for (planar, spatial) in [(5, 11), (6, 12), (7, 13), (8, 15), (9, 16)] {
            // rounding of two eliminations
            assert!((flat[planar] - full[spatial]).abs() < 1e-12 * 10.0, "seed {seed}: {planar}");
        }
        assert!([9, 10, 14].iter().all(|k| full[*k].abs() < 1e-12), "out of the plane: {full:?}");
    }
}

#[test]
fn feed_forward_is_the_chains_inverse_dynamics_at_its_momentum() {
    let system = System::new(&arm(Space::Planar)).unwrap();
    let chain = ArmParameters::paper_table_ii().chain();
    for seed in 0..50 {
        let mut motion = random_motion(seed);
        motion.q.fixed_rows_mut::<3>(0).fill(0.0);
        chain.set_base_velocity_from_momentum(&mut motion, 68.0);
        let wanted = chain.inverse_dynamics(&motion, SVector::from([0.0, 0.0, 0.0, 0.4, -0.7]));
        let reference = |joint: usize, acceleration: f64| JointReference {
            joint,
            position: motion.q[3 + joint],
            rate: motion.q_dot[3 + joint],
            acceleration,
        };
        let mut out = [0.0; 2];
        let mut ws = Workspace::new(&system);
        system.feed_forward(&mut ws, &[reference(0, 0.4), reference(1, -0.7)], [0.0, 0.0, 68.0], &mut out);
        // rounding of two solves beside terms of 100 N m
        assert!((0..2).all(|k| (out[k] - wanted[3 + k]).abs() < 1e-11 * 100.0), "seed {seed}: {out:?} {wanted:?}");
    }
}

/// Craft and slosh mass on one axis, m_0 ẍ_0 = f + F, m_s ẍ_s = −F.
#[test]
fn a_tank_on_one_axis_has_the_two_mass_equations_of_bp2() {
    let tank = simulation::oracle::slosh::SloshParameters::benchmark();
    let rail = joint("rail", JointKind::Prismatic { axis: [1.0, 0.0, 0.0] }, [0.0; 3]);
    let thrust =
        ActuatorKind::BodyForce { body: "craft".to_owned(), position_m: three([0.0; 3]), direction: [1.0, 0.0, 0.0] };
    let plant = Plant {
        bodies: vec![body("craft", None, rail, tank.m_0_kg, [0.0; 3], [0.0; 3])],
        tanks: vec![spring_tank(
            "tank",
            "craft",
            [0.0; 3],
            tank.m_s_kg,
            &[[1.0, 0.0, 0.0]],
            tank.k_s_n_m,
            tank.c_s_n_s_m,
        )],
        actuators: vec![actuator("thrust", thrust)],
        ..Plant::default()
    };
    let system = System::new(&plant).unwrap();
    for seed in 0..100 {
        let x = random_state(&system, seed);
        let force = 44.0 * (seed as f64 / 50.0 - 1.0);
        let spring = tank.k_s_n_m * x[1] + tank.c_s_n_s_m * x[3];
        let (craft, mass) = ((force + spring) / tank.m_0_kg, -spring / tank.m_s_kg);
        let x_dot = rates(&system, &x, &[force]);
        // rounding
        assert!((x_dot[2] - craft).abs() < 1e-12 && (x_dot[3] - (mass - craft)).abs() < 1e-12, "seed {seed}");
        assert_eq!((x_dot[0], x_dot[1]), (x[2], x[3]));
    }
}

/// Where the tank's axes are not orthogonal, the mass feels the force that does the springs' work.
#[test]
fn a_slosh_mass_on_skew_axes_falls_freely_without_springs() {
    let skew = [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.6, 0.8]];
    let mut plant = Plant { space: Space::Spatial, ..Plant::default() };
    plant.bodies = vec![free("hub", 100.0, [0.0; 3], [10.0, 20.0, 30.0])];
    plant.tanks = vec![spring_tank("tank", "hub", [0.3, 0.2, 0.1], 5.0, &skew, 0.0, 0.0)];
    let torque = ActuatorKind::BodyTorque { body: "hub".to_owned(), direction: Z };
    plant.actuators = vec![actuator("torque", torque)];
    let system = System::new(&plant).unwrap();
    for seed in 0..32 {
        let x = random_state(&system, seed);
        let x_dot = rates(&system, &x, &[7.0]);
        // the hub turns as if alone: Euler's equations
        let [wx, wy, wz] = [x[10], x[11], x[12]];
        let euler =
            [(20.0 - 30.0) * wy * wz / 10.0, (30.0 - 10.0) * wz * wx / 20.0, (7.0 + (10.0 - 20.0) * wx * wy) / 30.0];
        // rounding of an elimination in which a mass of 5 kg comes and goes
        assert!((0..3).all(|k| (x_dot[10 + k] - euler[k]).abs() < 1e-12), "{:?} {euler:?}", &x_dot[10..13]);
    }
}
