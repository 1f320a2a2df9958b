//! Laws of the planar model: momenta, its one-dimensional limit, small swings.

use super::*;
use crate::benchmark_tank::TANK;
use nalgebra::vector;
use physics::slosh::{SloshPropagator, SloshState};

const HUB: PlanarHub = PlanarHub { mass_kg: 1004.5, inertia_com_kg_m2: 480.0, sensor_m: Vector2::new(0.5, -0.3) };

fn all_kinds() -> [PlanarSlosh; 3] {
    [
        PlanarSlosh {
            mass_kg: 28.7,
            suspension: Suspension::Springs {
                position_m: vector![-0.45, 0.2],
                stiffness_n_m: vector![0.16, 0.12],
                damping_n_s_m: vector![0.0, 0.0],
            },
        },
        PlanarSlosh {
            mass_kg: 9.0,
            suspension: Suspension::Rail {
                position_m: vector![0.35, -0.15],
                direction: vector![0.6, 0.8],
                stiffness_n_m: 0.2,
                damping_n_s_m: 0.0,
            },
        },
        PlanarSlosh {
            mass_kg: 15.0,
            suspension: Suspension::Pendulum { pivot_m: vector![-0.3, 0.1], length_m: 0.6, damping_n_s_m: 0.0 },
        },
    ]
}

/// Linear momentum in inertial axes, angular momentum about the inertial origin and energy, from
/// positions.
struct World {
    angle: f64,
    position: Vector2<f64>,
    velocity: Vector2<f64>,
}

fn energy(state: &PlanarState<3>, velocity_body: &Vector2<f64>) -> f64 {
    let omega = state.rate_rad_s;
    let mut sum = 0.5 * HUB.mass_kg * velocity_body.norm_squared() + 0.5 * HUB.inertia_com_kg_m2 * omega * omega;
    for (i, mass) in all_kinds().iter().enumerate() {
        let (s, v) = (state.place[i], state.speed[i]);
        let (q, q_dot, stored) = match mass.suspension {
            Suspension::Springs { position_m, stiffness_n_m, .. } => {
                (position_m + s, v, 0.5 * stiffness_n_m.dot(&s.component_mul(&s)))
            }
            Suspension::Rail { position_m, direction, stiffness_n_m, .. } => {
                (position_m + direction * s[0], direction * v[0], 0.5 * stiffness_n_m * s[0] * s[0])
            }
            Suspension::Pendulum { pivot_m, length_m, .. } => {
                let (sine, cosine) = (s[0].sin(), s[0].cos());
                (pivot_m + vector![-cosine, sine] * length_m, vector![sine, cosine] * (length_m * v[0]), 0.0)
            }
        };
        let velocity = velocity_body + turned(&q) * omega + q_dot;
        sum += 0.5 * mass.mass_kg * velocity.norm_squared() + stored;
    }
    sum
}

#[test]
fn without_forces_and_damping_the_energy_stays_as_the_order_of_the_integrator_demands() {
    let drift = |dt: f64| {
        let mut state = PlanarState::<3> { rate_rad_s: 0.02, ..PlanarState::default() };
        state.speed = [vector![0.05, -0.02], vector![0.03, 0.0], vector![0.04, 0.0]];
        let hub = PlanarHub { sensor_m: Vector2::zeros(), ..HUB };
        let mut world = World { angle: 0.0, position: Vector2::zeros(), velocity: vector![0.1, 0.0] };
        let before = energy(&state, &world.velocity);
        for _ in 0..(400.0 / dt) as u32 {
            let omega = state.rate_rad_s;
            let seen = state.step(&hub, &all_kinds(), &Wrench::default(), dt).expect("masses are positive");
            let middle = world.angle + seen[2] * dt / 2.0;
            let (sine, cosine) = (middle.sin(), middle.cos());
            let inertial = vector![cosine * seen[0] - sine * seen[1], sine * seen[0] + cosine * seen[1]];
            world.velocity += inertial * dt;
            world.position += world.velocity * dt;
            world.angle += seen[2] * dt;
            assert!((seen[2] - (omega + state.rate_rad_s) / 2.0).abs() < 1e-4);
        }
        let (sine, cosine) = (world.angle.sin(), world.angle.cos());
        let body = vector![
            cosine * world.velocity[0] + sine * world.velocity[1],
            -sine * world.velocity[0] + cosine * world.velocity[1]
        ];
        (energy(&state, &body) / before - 1.0).abs()
    };
    let (coarse, fine) = (drift(1.0), drift(0.5));
    assert!(fine < 1e-8, "{fine}");
    assert!(coarse / fine > 12.0, "{coarse} {fine}"); // fourth order: 16, with the fifth-order drift of energy up to 32
}

#[test]
fn a_mass_on_the_axis_of_the_thrust_is_the_tank_on_one_axis() {
    let suspension = Suspension::Rail {
        position_m: Vector2::zeros(),
        direction: Vector2::x(),
        stiffness_n_m: TANK.stiffness_n_m,
        damping_n_s_m: TANK.damping_n_s_m,
    };
    let masses = [PlanarSlosh { mass_kg: TANK.slosh_mass_kg, suspension }];
    let (mut state, mut exact) =
        (PlanarState::<1>::default(), SloshPropagator::new(TANK, HUB.mass_kg, SloshState::default()));
    for k in 0..2000 {
        let force_n = if k % 160 < 80 { 44.0 } else { -44.0 };
        let wrench = Wrench { force_n: vector![force_n, 0.0], torque_n_m: 0.0 };
        let seen = state.step(&HUB, &masses, &wrench, 0.5).expect("positive");
        let expected = exact.step(0.5, force_n);
        assert!((seen[0] - expected).abs() < 5e-8, "{k}"); // (ω dt)⁵/120 = 7e-10 per step, 2000 steps, 0.03 m/s²
        assert!(seen[1].abs() < 1e-15 && seen[2].abs() < 1e-15);
    }
}

#[test]
fn stiffnesses_solved_from_modes_have_these_modes() {
    let position = vector![-0.45, 0.2];
    let w = turned(&position);
    let (per_mu, i0) = (1.0 / HUB.mass_kg + 1.0 / 28.7, HUB.inertia_com_kg_m2);
    let b = nalgebra::Matrix2::identity() * per_mu + w * w.transpose() / i0;
    let k = vector![0.16, 0.12];
    let product = b * nalgebra::Matrix2::from_diagonal(&k);
    let (sum, determinant) = (product.trace(), product.determinant());
    let root = (sum * sum / 4.0 - determinant).sqrt();
    let found = stiffness_from_modes(&HUB, 28.7, &position, [sum / 2.0 - root, sum / 2.0 + root]);
    assert!(found.iter().flatten().any(|pair| (pair - k).amax() < 1e-12), "{found:?}"); // rounding
    // Printed in the benchmark page, section 4: 10.498 and 12.066 mHz.
    for (lambda, hertz) in [(sum / 2.0 - root, 0.010_498), (sum / 2.0 + root, 0.012_066)] {
        assert!((lambda.sqrt() / (2.0 * core::f64::consts::PI) - hertz).abs() < 1e-6);
    }
}
