//! Toy laws at every kind of site: they act at their site, receive its state, and vanish at zero
//! amplitude.

use super::*;
use crate::description::{EffectUse, Site, SiteKind};
use crate::effect::{Action, Both, Catalogue, Effect, EffectParameter, Law, Local};
use crate::lags::FilterKind;
use crate::real::Real;
use crate::system::FilterPlace;

const fn toy(kind: &'static str, hidden_states: usize, law: Law) -> Effect {
    const AMPLITUDE: EffectParameter = EffectParameter::new("size", "1", [-10.0, 10.0], 1.0, "how much").amplitude();
    Effect { kind, title: kind, sites: &SiteKind::ALL, parameters: &[AMPLITUDE], hidden_states, law, ..Effect::PLAIN }
}

/// Force −size (coordinate + 2 rate + 3 command).
fn spring<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force = -(local.coordinate + local.rate.scale(2.0) + local.command.scale(3.0)).scale(p[0]);
}

/// A force along y of the body, as large as its speed along x.
fn sail<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.wrench[4] = local.body.velocity_m_s[0].scale(p[0]);
}

fn amplified<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value = local.command.scale(1.0 + p[0]);
    action.wrench[5] = local.command.scale(p[0]);
}

/// Reading shifted by the specific force along y.
fn shifted<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value = local.reading + local.body.specific_force_m_s2[1].scale(p[0]);
}

/// A hidden state follows the coordinate's rate, another one the first.
fn memory<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.hidden_rate[0] = local.rate - local.hidden[0];
    action.hidden_rate[1] = local.hidden[0].scale(2.0);
    action.force = local.hidden[1].scale(p[0]);
}

/// The same in a sensor.
fn sensor_memory<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.hidden_rate[0] = local.reading;
    action.value = local.reading + local.hidden[0].scale(p[0]);
}

/// Mass that grows with what its thrusters push.
fn growing<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.added_mass_kg = local.command.scale(p[0]);
}

fn lag(p: &[f64]) -> FilterKind {
    FilterKind::FirstOrder { time_constant_s: p[0] }
}

fn heavier(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let body = plant.bodies.iter_mut().find(|body| body.name == site.name).ok_or("no such body")?;
    body.mass_kg.value += p[0];
    Ok(())
}

pub const CATALOGUE: Catalogue = Catalogue::new(&[
    &toy("spring", 0, Law::Coordinate(Both { real: spring::<f64>, dual: spring::<Dual> })),
    &toy("sail", 0, Law::Body(Both { real: sail::<f64>, dual: sail::<Dual> })),
    &toy("growing", 0, Law::Body(Both { real: growing::<f64>, dual: growing::<Dual> })),
    &toy("amplified", 0, Law::Actuator(Both { real: amplified::<f64>, dual: amplified::<Dual> })),
    &toy("shifted", 0, Law::Sensor(Both { real: shifted::<f64>, dual: shifted::<Dual> })),
    &toy("memory", 2, Law::Coordinate(Both { real: memory::<f64>, dual: memory::<Dual> })),
    &toy("sensor_memory", 1, Law::Sensor(Both { real: sensor_memory::<f64>, dual: sensor_memory::<Dual> })),
    &toy("lag", 0, Law::ActuatorFilter(lag)),
    &toy("heavier", 0, Law::Structure(heavier)),
]);

fn with(mut plant: Plant, uses: &[(&str, &str, f64)]) -> Plant {
    plant.catalogue = CATALOGUE;
    for (kind, site, size) in uses {
        let values = vec![("size".to_owned(), known(*size))];
        plant.effects.push(EffectUse { kind: (*kind).to_owned(), site: site.parse().unwrap(), values });
    }
    plant
}

fn system_with(plant: Plant, uses: &[(&str, &str, f64)]) -> System {
    System::new(&with(plant, uses)).unwrap()
}

fn arm_with_sensor() -> Plant {
    let mut plant = arm(Space::Planar);
    plant.sensors = vec![
        sensor("encoder", SensorKind::Encoder { joint: "joint2".to_owned() }),
        sensor("torque", SensorKind::JointTorque { joint: "joint1".to_owned() }),
    ];
    plant
}

#[test]
fn a_law_on_a_coordinate_adds_to_its_force() {
    let plain = System::new(&arm_with_sensor()).unwrap();
    let system = system_with(arm_with_sensor(), &[("spring", "joint:joint2", 0.7)]);
    let (x, u) = (random_state(&plain, 1), [4.0, -2.0]);
    let force = -0.7 * (x[4] + 2.0 * x[9] + 3.0 * u[1]);
    // the same as a torque in the joint
    let expected = rates(&plain, &x, &[u[0], u[1] + force]);
    for (found, expected) in rates(&system, &x, &u).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15); // one rounding
    }
    assert_eq!(readings(&system, &x, &u)[1], 4.0, "what actuators apply does not hold the law's force");
}

#[test]
fn a_law_at_a_tank_acts_along_each_of_its_axes() {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let plant = |k: f64, c: f64| Plant {
        bodies: vec![free("hub", 100.0, [0.0; 3], [0.0, 0.0, 10.0])],
        tanks: vec![spring_tank("tank", "hub", [0.3, 0.2, 0.0], 5.0, &axes, k, c)],
        ..Plant::default()
    };
    let (soft, stiff) = (System::new(&plant(2.0, 0.4)).unwrap(), System::new(&plant(2.5, 1.4)).unwrap());
    let system = system_with(plant(2.0, 0.4), &[("spring", "tank:tank", 0.5)]);
    let x = random_state(&soft, 1);
    for (found, expected) in rates(&system, &x, &[]).iter().zip(rates(&stiff, &x, &[])) {
        assert!((found - expected).abs() < 1e-14); // rounding
    }
}

#[test]
fn a_law_on_a_body_pushes_it_along_its_own_axes() {
    let system = system_with(arm_with_sensor(), &[("sail", "body:base", 6.0)]);
    let mut pushed = arm_with_sensor();
    let kind =
        ActuatorKind::BodyForce { body: "base".to_owned(), position_m: three([0.0; 3]), direction: [0.0, 1.0, 0.0] };
    pushed.actuators.push(actuator("push", kind));
    let pushed = System::new(&pushed).unwrap();
    let x = random_state(&system, 2);
    let expected = rates(&pushed, &x, &[0.0, 0.0, 6.0 * x[6]]);
    for (found, expected) in rates(&system, &x, &[0.0; 2]).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15);
    }
}

#[test]
fn mass_added_by_a_law_is_mass_at_the_centre_of_mass_of_its_body() {
    let mut plant = arm(Space::Spatial);
    plant.environment.gravity_m_s2 = three([0.1, -0.3, 0.2]);
    plant.bodies[1].com_m = three([0.4, 0.2, 0.3]);
    let jet = |name: &str, size: f64| {
        let kind = ActuatorKind::Thruster {
            body: "link1".to_owned(),
            position_m: three([0.3; 3]),
            direction: [0.0, 0.6, 0.8].map(|d| d * size),
        };
        actuator(name, kind)
    };
    plant.actuators.extend([jet("one", 1.0), jet("two", -1.0)]);
    let mut heavy = plant.clone();
    heavy.bodies[1].mass_kg.value += 0.5 * (2.0 + 3.0);
    let (system, heavy) = (system_with(plant, &[("growing", "body:link1", 0.5)]), System::new(&heavy).unwrap());
    let x = random_state(&system, 3);
    let u = [4.0, 1.0, 2.0, 3.0];
    for (found, expected) in rates(&system, &x, &u).iter().zip(rates(&heavy, &x, &u)) {
        assert!((found - expected).abs() < 1e-13, "{found} {expected}"); // rounding
    }
}

#[test]
fn a_law_on_an_actuator_changes_what_acts_and_pushes_its_body() {
    let plain = System::new(&arm(Space::Spatial)).unwrap();
    let system = system_with(arm(Space::Spatial), &[("amplified", "actuator:joint1.torque", 0.5)]);
    let mut pushed = arm(Space::Spatial);
    let kind = ActuatorKind::BodyForce { body: "link1".to_owned(), position_m: three([0.0; 3]), direction: Z };
    pushed.actuators.push(actuator("push", kind));
    let pushed = System::new(&pushed).unwrap();
    let x = random_state(&plain, 3);
    let expected = rates(&pushed, &x, &[6.0, 1.0, 2.0]);
    for (found, expected) in rates(&system, &x, &[4.0, 1.0]).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-15);
    }
}

#[test]
fn a_law_on_a_sensor_sees_the_accelerations_of_its_body() {
    let system = system_with(arm_with_sensor(), &[("shifted", "sensor:encoder", 2.0)]);
    let mut measured = arm_with_sensor();
    let origin = SensorKind::Accelerometer {
        body: "link2".to_owned(),
        position_m: three([0.0; 3]),
        axis: [0.0, 1.0, 0.0],
        point: None,
    };
    measured.sensors.push(sensor("a", origin));
    let measured = System::new(&measured).unwrap();
    let x = random_state(&system, 4);
    let expected = readings(&measured, &x, &[4.0, 1.0])[2];
    assert!((readings(&system, &x, &[4.0, 1.0])[0] - (x[4] + 2.0 * expected)).abs() < 1e-15);
}

#[test]
fn hidden_states_have_names_and_move_as_their_laws_say() {
    // in the order of the catalogue, not of the plant
    let uses = [("sensor_memory", "sensor:encoder", 0.1), ("memory", "joint:joint2", 0.3)];
    let system = system_with(arm_with_sensor(), &uses);
    let names: Vec<&str> = system.states()[10..].iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["memory@joint:joint2.1", "memory@joint:joint2.2", "sensor_memory@sensor:encoder.1"]);
    let x = random_state(&system, 5);
    let x_dot = rates(&system, &x, &[0.0; 2]);
    assert_eq!(x_dot[10], x[9] - x[10]);
    assert_eq!(x_dot[11], 2.0 * x[10]);
    assert_eq!(x_dot[12], x[4]);
    assert_eq!(readings(&system, &x, &[0.0; 2])[0], x[4] + 0.1 * x[12]);
    let plain = System::new(&arm_with_sensor()).unwrap();
    let expected = rates(&plain, &x[..10], &[0.0, 0.3 * x[11]]);
    assert!((x_dot[9] - expected[9]).abs() < 1e-15);
    // and the fused call gives the same
    let (mut both, mut y) = (vec![0.0; 13], [0.0; 2]);
    system.derivative_and_read(&mut Workspace::new(&system), 0.0, &x, &[0.0; 2], &mut both, &mut y);
    assert_eq!(both, x_dot);
}

#[test]
fn at_zero_amplitude_nothing_changes() {
    let plain = System::new(&arm_with_sensor()).unwrap();
    let x = random_state(&plain, 6);
    for (kind, site) in [
        ("spring", "joint:joint1"),
        ("sail", "body:link2"),
        ("growing", "body:base"),
        ("amplified", "actuator:joint2.torque"),
        ("shifted", "sensor:torque"),
        ("heavier", "body:link1"),
    ] {
        let system = system_with(arm_with_sensor(), &[(kind, site, 0.0)]);
        assert_eq!(rates(&system, &x, &[4.0, 1.0]), rates(&plain, &x, &[4.0, 1.0]), "{kind}");
        assert_eq!(readings(&system, &x, &[4.0, 1.0]), readings(&plain, &x, &[4.0, 1.0]), "{kind}");
    }
}

#[test]
fn structure_is_changed_before_anything_is_compiled_and_filters_are_listed() {
    let mut heavy = arm_with_sensor();
    heavy.bodies[1].mass_kg.value += 3.0;
    let uses = [("heavier", "body:link1", 3.0), ("lag", "actuator:joint2.torque", 0.02)];
    let system = system_with(arm_with_sensor(), &uses);
    let x = random_state(&system, 7);
    assert_eq!(rates(&system, &x, &[4.0, 1.0]), rates(&System::new(&heavy).unwrap(), &x, &[4.0, 1.0]));
    let [filter] = system.filters() else { panic!("one filter") };
    assert_eq!(filter.place, FilterPlace::Input(1));
    assert_eq!(filter.kind, FilterKind::FirstOrder { time_constant_s: 0.02 });
}

#[test]
fn an_effect_in_the_wrong_place_is_refused_by_name() {
    for (uses, complaint) in [
        (("spring", "body:base", 1.0), "nothing moves there"),
        (("spring", "joint:elbow", 1.0), "cannot sit at joint:elbow"),
        (("shifted", "joint:joint1", 1.0), "this is no sensor"),
        (("unheard", "joint:joint1", 1.0), "there is no effect 'unheard'"),
        (("heavier", "body:elbow", 1.0), "cannot sit at body:elbow"),
    ] {
        let Err(error) = System::new(&with(arm_with_sensor(), &[uses])) else { panic!("{uses:?} must be refused") };
        let text = error.to_string();
        assert!(text.contains(complaint) && text.contains(uses.0), "{text}");
    }
}

#[test]
fn jacobians_run_through_the_laws() {
    let uses = [("spring", "joint:joint1", 0.7), ("memory", "joint:joint2", 0.3), ("shifted", "sensor:encoder", 2.0)];
    let system = system_with(arm_with_sensor(), &uses);
    let (x, u) = (random_state(&system, 8), [4.0, -2.0]);
    let space = system.linearise(&mut Workspace::new(&system), 0.0, &x, &u);
    for column in 0..x.len() {
        let moved = |h: f64| {
            let mut x = x.clone();
            x[column] += h;
            (rates(&system, &x, &u), readings(&system, &x, &u))
        };
        let (ahead, behind) = (moved(1e-6), moved(-1e-6));
        for row in 0..x.len() {
            let difference = (ahead.0[row] - behind.0[row]) / 2e-6;
            // ε/h = 2e-10 on values of order ten
            assert!((difference - space.a[(row, column)]).abs() < 1e-7, "{row} {column}");
        }
        let difference = (ahead.1[0] - behind.1[0]) / 2e-6;
        assert!((difference - space.c[(0, column)]).abs() < 1e-7, "{column}");
    }
}
