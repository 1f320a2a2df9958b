//! A plant without friction and without anything from outside keeps its momentum and its energy.

use crate::subject::plant;
use dynamics::description::{InitialValue, Integrator, Plant, Quantity};
use dynamics::system::{System, Totals, Workspace};
use simulation::Simulator;

/// The planar study case, undamped, uncommanded, released bent, sloshing and turning.
fn released() -> Plant {
    let mut plant = plant("study_case", &[]);
    let names: Vec<String> = plant.parameters().into_iter().map(|parameter| parameter.name).collect();
    let dissipates = |name: &str| name.ends_with(".friction") || name.contains(".damping");
    let acts = |name: &str| {
        let loops = name.starts_with("shoulder_loop.") || name.starts_with("elbow_loop.");
        let gain = [".kp", ".ki", ".kd", ".feed_forward"].iter().any(|gain| name.ends_with(gain));
        (loops && gain) || name.ends_with(".command.1.size") || name.ends_with(".command.1.rms")
    };
    let actuators: Vec<String> = plant.actuators.iter().map(|actuator| format!("{}.noise", actuator.name)).collect();
    for name in names.iter().filter(|name| dissipates(name) || acts(name) || actuators.contains(name)) {
        plant.set_parameter(name, 0.0).unwrap();
    }
    let known = Quantity::known;
    let value = |coordinate: &str, position: f64, rate: f64| InitialValue {
        coordinate: coordinate.to_owned(),
        position: known(position),
        rate: known(rate),
    };
    plant.initial.on_reference = false;
    plant.initial.values = vec![
        value("body:hub.x", 0.3, 0.05),
        value("body:hub.y", -0.2, -0.03),
        value("body:hub.rz", 0.4, 0.1),
        value("joint:shoulder", 0.8, -0.2),
        value("joint:elbow", -1.8, 0.3),
        value("tank:fuel", 0.05, 0.02),
        value("tank:fuel.2", -0.03, 0.04),
        value("mode:bending_1", 0.08, 0.1),
        value("mode:bending_2", 0.01, -0.1),
    ];
    plant
}

/// Largest departure over 20 s of the energy, and of the momenta (linear in both axes, angular
/// about inertial zero), each over its size.
struct Drift {
    energy: f64,
    momentum: f64,
}

fn drift(integrator: Integrator, step_s: f64) -> Drift {
    let mut plant = released();
    (plant.simulation.step_s, plant.simulation.integrator) = (step_s, integrator);
    let mut simulator = Simulator::new(&plant, 1, "drift").unwrap();
    let system = System::new(&plant).unwrap();
    let mut workspace = Workspace::<f64>::new(&system);
    let u = vec![0.0; system.inputs().len()];
    let mut conserved = |simulator: &mut Simulator| {
        let totals = system.totals(&mut workspace, simulator.truth().state, &u);
        let [x, y, _] = totals.linear_momentum_n_s;
        [totals.kinetic_energy_j + totals.potential_energy_j, x, y, totals.angular_momentum_origin_n_m_s[2]]
    };
    let [energy, x, y, turn] = conserved(&mut simulator);
    let mut worst = Drift { energy: 0.0, momentum: 0.0 };
    for _ in 0..2000 {
        simulator.step();
        let now = conserved(&mut simulator);
        worst.energy = worst.energy.max((now[0] / energy - 1.0).abs());
        let linear = (now[1] - x).hypot(now[2] - y) / (x).hypot(y);
        worst.momentum = worst.momentum.max(linear).max((now[3] / turn - 1.0).abs());
    }
    println!("{integrator:?} {step_s} s: energy {:.2e}, momentum {:.2e}", worst.energy, worst.momentum);
    worst
}

/// Orders (of the energy, of the momentum) seen between a step, its half and its quarter.
fn orders(integrator: Integrator, step_s: f64) -> [(f64, f64); 2] {
    let [a, b, c] = [1.0, 0.5, 0.25].map(|part| drift(integrator, part * step_s));
    let order = |coarse: f64, fine: f64| (coarse / fine).log2();
    [(&a, &b), (&b, &c)].map(|(a, b)| (order(a.energy, b.energy), order(a.momentum, b.momentum)))
}

/// Of the vibrating modes Runge–Kutta of fourth order takes `(ω h)⁶/72` a step of their energy, an
/// order more than its own; the fastest mode has `ω h = 0.6` at 10 ms, from where higher powers are
/// seen.
#[test]
fn drift_of_momentum_and_energy_falls_with_the_fourth_order_of_runge_kutta() {
    for (energy, momentum) in orders(Integrator::RungeKutta4, 0.01) {
        assert!((energy - 5.0).abs() < 0.15, "energy: order {energy}");
        assert!((momentum - 4.0).abs() < 0.15, "momentum: order {momentum}");
    }
}

#[test]
fn drift_of_momentum_and_energy_falls_down_to_rounding() {
    let fine = drift(Integrator::RungeKutta4, 0.000_312_5);
    assert!(fine.momentum < 2e-13, "{}", fine.momentum); // 64 000 steps of 1e-16, as a random walk with some drift
    assert!(fine.energy < 2e-12, "{}", fine.energy); // 2.04e-8 at 2.5 ms falls by 8⁵ to 6.2e-13
}

/// The midpoint rule gives a mode `(ω h)⁴/4` of its energy a step: at 10 ms the fastest one grows
/// to nonsense, at 1.25 ms by 5e-6.
#[test]
fn drift_of_momentum_and_energy_falls_with_the_second_order_of_the_midpoint_rule() {
    for (energy, momentum) in orders(Integrator::Midpoint, 0.00125) {
        assert!((energy - 3.0).abs() < 0.15, "energy: order {energy}");
        assert!((momentum - 2.0).abs() < 0.15, "momentum: order {momentum}");
    }
}

/// `E(T) − E(0) = −∫ P dt`, the integral by trapezia of 10 ms: `(ω h)²/12 = 0.3 %` of the part that
/// swings at twice the first bending mode.
#[test]
fn friction_takes_the_energy_that_it_is_said_to_take_and_leaves_the_momentum() {
    let mut plant = released();
    let frictions = [
        ("shoulder.friction", 4.0),
        ("fuel.damping.x", 3.0),
        ("bending_1.damping_ratio", 0.02),
        ("wheel.friction", 1e-4),
    ];
    for (name, value) in frictions {
        plant.set_parameter(name, value).unwrap();
    }
    plant.simulation.step_s = 0.002_5;
    let mut simulator = Simulator::new(&plant, 1, "drift").unwrap();
    let system = System::new(&plant).unwrap();
    let mut workspace = Workspace::<f64>::new(&system);
    let u = vec![0.0; system.inputs().len()];
    let mut totals = |simulator: &mut Simulator| system.totals(&mut workspace, simulator.truth().state, &u);
    let energy = |t: &Totals<f64>| t.kinetic_energy_j + t.potential_energy_j;
    let start = totals(&mut simulator);
    let (mut before, mut taken) = (start, 0.0);
    for _ in 0..2000 {
        simulator.step();
        let now = totals(&mut simulator);
        taken += 0.5 * (before.dissipated_w + now.dissipated_w) * plant.simulation.period_s;
        before = now;
    }
    let lost = energy(&start) - energy(&before);
    assert!(lost > 1.0 && (taken / lost - 1.0).abs() < 1e-3, "{lost} J lost, {taken} J taken");
    let turned = before.angular_momentum_origin_n_m_s[2] / start.angular_momentum_origin_n_m_s[2] - 1.0;
    assert!(turned.abs() < 1e-11, "{turned:e}"); // the drift of this step
}
