//! What actuators do between the command and the plant: range, delay, lag, noise; and prescribed
//! motions.

use super::plants::{self, q};
use crate::{SimulationError, Simulator};
use catalogue::EFFECTS;
use dynamics::description::{
    ActuatorKind, EffectUse, Initial, InitialValue, Integrator, Plant, Prescribed, SensorKind, SignalKind, Site,
    SiteKind,
};
use dynamics::effect::Law;
use dynamics::lags::FilterKind;

/// A catalogue entry whose filter is of the wanted kind at the value `amplitude` of its first
/// parameter.
fn filter_effect(amplitude: f64, wanted: impl Fn(FilterKind) -> bool) -> Option<EffectUse> {
    let site = Site { kind: SiteKind::Actuator, name: "force".to_owned() };
    for effect in EFFECTS {
        let Law::ActuatorFilter(filter) = effect.law else { continue };
        let mut values: Vec<f64> = effect.parameters.iter().map(|parameter| parameter.default).collect();
        values[0] = amplitude;
        if wanted(filter(&values)) {
            let named = effect.parameters.iter().zip(&values).map(|(p, v)| (p.name.to_owned(), q(*v))).collect();
            return Some(EffectUse { kind: effect.kind.to_owned(), site, values: named });
        }
    }
    None
}

/// Position and rate at the end of each period under a constant force of 3 N.
fn pushed(plant: &Plant, periods: usize) -> Vec<(f64, f64, f64)> {
    let mut simulator = Simulator::new(plant, 0, "cart").unwrap();
    (0..periods)
        .map(|_| {
            simulator.step();
            let truth = simulator.truth();
            (truth.time_s, truth.readings[0], truth.readings[1])
        })
        .collect()
}

fn cart() -> Plant {
    plants::cart(plants::always(SignalKind::Constant { value: q(3.0) }))
}

#[test]
fn a_fractional_delay_of_the_command_is_exact() {
    for integrator in [Integrator::RungeKutta4, Integrator::Midpoint, Integrator::ExactZeroOrderHold] {
        let delay = 0.0237;
        let mut plant = cart();
        plant.simulation.integrator = integrator;
        let is_delay = |kind| matches!(kind, FilterKind::Delay { delay_s } if delay_s == delay);
        plant.effects.push(filter_effect(delay, is_delay).expect("the catalogue has a delay"));
        for (t, position, rate) in pushed(&plant, 100) {
            let since = (t - delay).max(0.0);
            // constant force: all three integrators are exact, what is left is rounding
            assert!((rate - 1.5 * since).abs() < 1e-13, "{integrator:?} {t}: {rate}");
            assert!((position - 0.75 * since * since).abs() < 1e-13, "{integrator:?} {t}: {position}");
        }
    }
}

#[test]
fn a_lagged_command_gives_the_exact_impulse() {
    for tau in [0.05, 1e-4] {
        let mut plant = cart();
        let is_lag = |kind| matches!(kind, FilterKind::FirstOrder { time_constant_s } if time_constant_s == tau);
        plant.effects.push(filter_effect(tau, is_lag).expect("the catalogue has a first-order lag"));
        for (t, _, rate) in pushed(&plant, 100) {
            let expected = 1.5 * (t - tau * (1.0 - (-t / tau).exp()));
            assert!((rate - expected).abs() < 1e-13, "τ {tau}, {t}: {rate} {expected}"); // rounding
        }
    }
}

#[test]
fn commands_stay_within_their_range() {
    let mut plant = cart();
    plant.actuators[0].range = Some(q(2.0));
    let mut simulator = Simulator::new(&plant, 0, "cart").unwrap();
    let row = simulator.step();
    assert_eq!((row.commands[0], row.inputs[0], row.value(2)), (2.0, 2.0, 2.0));
}

#[test]
fn noise_of_an_actuator_acts_but_is_not_commanded() {
    let mut plant = cart();
    plant.actuators[0].noise = q(0.5);
    let mut simulator = Simulator::new(&plant, 0, "cart").unwrap();
    let n = 4000;
    let mut sum = 0.0;
    for _ in 0..n {
        let row = simulator.step();
        assert_eq!(row.commands[0], 3.0);
        assert_eq!(row.inputs[0], row.value(2), "a torque sensor reads what acts");
        sum += (row.inputs[0] - 3.0).powi(2);
    }
    let sigma = (sum / f64::from(n)).sqrt();
    assert!((sigma / 0.5 - 1.0).abs() < 4.5 / (2.0 * f64::from(n)).sqrt(), "{sigma}");
}

#[test]
fn the_excited_clock_stands_still_while_not_excited() {
    let command = SignalKind::Sine { amplitude: q(1.0), frequency_hz: q(1.0), phase_rad: q(0.0) };
    let mut simulator = Simulator::new(&plants::cart(plants::always(command)), 0, "cart").unwrap();
    let before: Vec<f64> = (0..10).map(|_| simulator.step().commands[0]).collect();
    simulator.set_excited(false);
    assert!((0..5).all(|_| simulator.step().commands[0] == 0.0));
    simulator.set_excited(true);
    let after = simulator.step().commands[0];
    let expected = (core::f64::consts::TAU * 0.105).sin();
    assert!((after - expected).abs() < 1e-15 && before[9] < after);
}

/// Whichever derivative of `0.3 sin 2πt` the file states, the joint goes where the sine goes.
#[test]
fn a_prescribed_joint_moves_as_stated_by_any_of_its_derivatives() {
    let omega = core::f64::consts::TAU;
    let sine = |amplitude: f64, phase: f64| {
        plants::always(SignalKind::Sine { amplitude: q(amplitude), frequency_hz: q(1.0), phase_rad: q(phase) })
    };
    let quarter = core::f64::consts::FRAC_PI_2;
    for (what, signal) in [
        (Prescribed::Position, sine(0.3, 0.0)),
        (Prescribed::Rate, sine(0.3 * omega, quarter)),
        (Prescribed::Acceleration, sine(0.3 * omega * omega, 2.0 * quarter)),
    ] {
        let mut plant = plants::cart(signal);
        plant.actuators[0].kind = ActuatorKind::PrescribedJoint { joint: "cart".to_owned(), what };
        plant.sensors.truncate(2);
        let position = plants::q3([0.0; 3]);
        let axis = [1.0, 0.0, 0.0];
        plant.sensors.push(plants::sensor(
            "acceleration",
            SensorKind::Accelerometer { body: "cart".to_owned(), position_m: position, axis, point: None },
        ));
        let value = InitialValue { coordinate: "joint:cart".to_owned(), position: q(0.0), rate: q(0.3 * omega) };
        if what != Prescribed::Position {
            plant.initial = Initial { values: vec![value], ..Initial::default() };
        }
        let mut simulator = Simulator::new(&plant, 0, "cart").unwrap();
        for k in 0..200 {
            let row = simulator.step();
            let (sin, cos) = (omega * 0.01 * f64::from(k)).sin_cos();
            // Gauss quadrature of 10 ms: (0.01 ω)⁷/2016000 a step, 1e-15; 200 steps
            assert!((row.value(0) - 0.3 * sin).abs() < 1e-12, "{what:?} position");
            assert!((row.value(1) - 0.3 * omega * cos).abs() < 1e-11, "{what:?} rate");
            assert!((row.value(2) + 0.3 * omega * omega * sin).abs() < 1e-10, "{what:?} acceleration");
        }
    }
}

#[test]
fn exact_hold_is_refused_where_it_would_be_wrong() {
    let mut arm = plants::arm(&crate::oracle::arm::ArmNoise::none());
    arm.simulation.integrator = Integrator::ExactZeroOrderHold;
    assert!(matches!(Simulator::new(&arm, 0, "arm"), Err(SimulationError::NotLinear { .. })));
    let mut shaken = plants::cart(vec![]);
    shaken.simulation.integrator = Integrator::ExactZeroOrderHold;
    shaken.sensors.truncate(2);
    shaken.actuators[0].kind = ActuatorKind::PrescribedJoint { joint: "cart".to_owned(), what: Prescribed::Position };
    assert!(matches!(Simulator::new(&shaken, 0, "cart"), Err(SimulationError::NotHeld { .. })));
}

/// A stiff oscillator with dry friction, by the exact hold as far as the file says: what a user
/// hides must simply work.
#[test]
fn an_effect_on_a_plant_of_exact_hold_is_simulated_by_fine_steps_of_runge_kutta() {
    let mut plant = cart();
    plant.bodies[0].joint.stiffness = q(4e4);
    plant.simulation.integrator = Integrator::ExactZeroOrderHold;
    assert_eq!(Simulator::new(&plant, 0, "cart").unwrap().warning(), None);
    let site = format!("joint:{}", plant.bodies[0].joint.name).parse().unwrap();
    let run = |plant: &Plant| {
        let mut simulator = Simulator::new(plant, 0, "cart").unwrap();
        let warned = simulator.warning().is_some();
        (0..200).for_each(|_| {
            simulator.step();
        });
        (simulator.truth().state.to_vec(), warned)
    };
    let mut coulomb = plant.clone();
    coulomb.add_effect("joint_coulomb", &site, &[("force", 0.3), ("smooth_rate", 1e-3)]).unwrap();
    let (by_hold, warned) = run(&coulomb);
    assert!(warned);
    coulomb.simulation.integrator = Integrator::RungeKutta4;
    coulomb.simulation.step_s = 1e-5;
    let (fine, warned) = run(&coulomb);
    assert!(!warned);
    let size = fine.iter().fold(1e-6_f64, |most, x| most.max(x.abs()));
    for (a, b) in by_hold.iter().zip(&fine) {
        assert!((a - b).abs() < 1e-4 * size, "{by_hold:?} {fine:?}"); // 0.1 rad a step: 1e-6 a radian over some hundred
    }
    // an effect that stays linear keeps the hold
    let mut heavier = plant.clone();
    let body = format!("body:{}", plant.bodies[0].name).parse().unwrap();
    heavier.add_effect("mass_error", &body, &[]).unwrap();
    assert_eq!(Simulator::new(&heavier, 0, "cart").unwrap().warning(), None);
}

#[test]
fn settings_without_meaning_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Plant)| {
        let mut plant = cart();
        change(&mut plant);
        Simulator::new(&plant, 0, "cart").err().expect("must be refused").to_string()
    };
    assert!(refused(&|plant| plant.simulation.period_s = 0.0).contains("simulation.period"));
    assert!(refused(&|plant| plant.sensors[0].period_s = Some(q(-1.0))).contains("displacement"));
    assert!(refused(&|plant| plant.sensors[1].delay_s = q(-1.0)).contains("rate"));
    assert!(refused(&|plant| plant.sensors[1].source = Some("imu".to_owned())).contains("imu"));
}
