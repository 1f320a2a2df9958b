//! Laws of effects in the equations of a plant, and in its simulation.

use super::super::trial::{defaults, plant};
use super::super::*;
use super::used;
use dynamics::description::{Controller, EffectUse, JointKind, Plant, Quantity, Signal, SignalKind, Site};
use dynamics::effect::*;
use dynamics::noise::Stream;
use dynamics::system::{System, Workspace};
use simulation::{SimulationError, Simulator, record};

/// Rates and readings of the plant with one effect, in the states that it has without, at a random
/// state; hidden states at zero.
fn answer(effect: &Effect, site: &Site, parameters: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut plant = plant();
    let names = effect.parameters.iter().map(|parameter| parameter.name);
    let values = names.zip(parameters).map(|(name, value)| (name.to_owned(), Quantity::known(*value))).collect();
    plant.effects.push(EffectUse { kind: effect.kind.to_owned(), site: site.clone(), values });
    rates_and_readings(&plant)
}

fn rates_and_readings(plant: &Plant) -> (Vec<f64>, Vec<f64>) {
    let system = System::new(plant).expect("the effect can act there");
    let stream = Stream::new(7, "state of the plant");
    let number = |k: usize| stream.uniform_pair(k as u64)[0] - 0.5;
    let mut x: Vec<f64> = (0..system.states().len()).map(number).collect();
    let hidden = system.states().iter().position(|state| state.name.contains('@'));
    x[hidden.unwrap_or(system.states().len())..].fill(0.0);
    let u: Vec<f64> = (0..system.inputs().len()).map(|k| number(1000 + k)).collect();
    let (mut x_dot, mut y) = (vec![0.0; x.len()], vec![0.0; system.outputs().len()]);
    system.derivative_and_read(&mut Workspace::new(&system), 20.0, &x, &u, &mut x_dot, &mut y);
    x_dot.truncate(hidden.unwrap_or(x.len()));
    (x_dot, y)
}

#[test]
fn in_the_equations_of_a_plant_no_effect_changes_anything_at_zero_amplitude_and_every_one_runs_at_its_default() {
    let untouched = rates_and_readings(&plant());
    for effect in EFFECTS {
        for site in sites(effect, &plant()) {
            let mut parameters = defaults(effect);
            let (x_dot, y) = answer(effect, &site, &parameters);
            assert!(x_dot.iter().chain(&y).all(|number| number.is_finite()), "{} at {site}", effect.kind);
            parameters[..effect.amplitudes()].fill(0.0);
            assert_eq!(answer(effect, &site, &parameters), untouched, "{} at {site}", effect.kind);
        }
    }
}

/// What the equations say of a plant with two effects.
fn together(first: &EffectUse, second: &EffectUse) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut plant = plant();
    plant.effects = vec![first.clone(), second.clone()];
    let system = System::new(&plant).ok()?;
    let x: Vec<f64> = (0..system.states().len()).map(|k| 0.3 * libm::sin(1.0 + 0.7 * k as f64)).collect();
    let u: Vec<f64> = (0..system.inputs().len()).map(|k| 0.4 + 0.3 * k as f64).collect();
    let (mut x_dot, mut y) = (vec![0.0; x.len()], vec![0.0; system.outputs().len()]);
    system.derivative_and_read(&mut Workspace::new(&system), 20.0, &x, &u, &mut x_dot, &mut y);
    Some((x_dot, y))
}

#[test]
fn the_order_of_effects_in_a_file_changes_nothing() {
    let place =
        |effect: &&Effect| sites(effect, &plant()).into_iter().map(|site| used(effect.kind, &site.to_string(), &[]));
    let all: Vec<EffectUse> = EFFECTS.iter().flat_map(place).collect();
    for (i, first) in all.iter().enumerate() {
        // those of one site meet in one chain, those of bodies and joints in one structure
        for second in all[..i].iter().filter(|other| other.site == first.site || i % 7 == 0) {
            let (one, other) = (together(first, second), together(second, first));
            assert_eq!(one, other, "{} and {} at {}", first.kind, second.kind, first.site);
        }
    }
}

#[test]
fn friction_behind_a_dead_zone_still_brakes() {
    let mut plant = plant();
    plant.effects = vec![
        used("wheel_coulomb", "actuator:rw", &[("torque", 0.02)]),
        used("actuator_dead_zone", "actuator:rw", &[("half_width", 1.0)]),
    ];
    let system = System::new(&plant).unwrap();
    let mut x = vec![0.0; system.states().len()];
    let wheel = system.states().iter().position(|state| state.name == "wheel:rw").unwrap();
    x[wheel] = 100.0;
    let mut x_dot = x.clone();
    let u = vec![0.0; system.inputs().len()];
    system.derivative(&mut Workspace::new(&system), 0.0, &x, &u, &mut x_dot);
    assert!(x_dot[wheel] < -0.9, "{}", x_dot[wheel]); // 0.02 N m on 0.02 kg m^2
}

#[test]
fn slosh_laws_know_no_axes() {
    use dynamics::description::{Space, TankModel};
    // force along the displacement, whatever axes the tank is written in
    for (kind, values) in
        [("slosh_cubic", [3.0, 0.0]), ("slosh_quadratic_damping", [3.0, 0.0]), ("slosh_contact_line", [3.0, 0.5])]
    {
        let force = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            let mut plant = plant();
            plant.space = Space::Spatial;
            plant.tanks[0].model = TankModel::Spring {
                axes: vec![[cos, sin, 0.0], [-sin, cos, 0.0]],
                stiffness_n_m: vec![Quantity::known(0.0); 2],
                damping_n_s_m: vec![Quantity::known(0.0); 2],
            };
            let entry = CATALOGUE.effect(kind).unwrap();
            let named: Vec<(&str, f64)> = entry.parameters.iter().map(|p| p.name).zip(values).collect();
            plant.effects = vec![used(kind, "tank:oxidiser", &named)];
            let system = System::new(&plant).unwrap();
            let at = |name: &str| system.states().iter().position(|state| state.name == name).unwrap();
            let mut x = vec![0.0; system.states().len()];
            x[at("body:hub.qw")] = 1.0;
            // the same displacement and rate of the mass
            let (s, v) = ([0.3, 0.1], [-0.2, 0.4]);
            x[at("tank:oxidiser")] = cos * s[0] + sin * s[1];
            x[at("tank:oxidiser.2")] = -sin * s[0] + cos * s[1];
            x[at("tank:oxidiser.rate")] = cos * v[0] + sin * v[1];
            x[at("tank:oxidiser.2.rate")] = -sin * v[0] + cos * v[1];
            let mut x_dot = vec![0.0; x.len()];
            system.derivative(&mut Workspace::new(&system), 0.0, &x, &vec![0.0; system.inputs().len()], &mut x_dot);
            let a = [x_dot[at("tank:oxidiser.rate")], x_dot[at("tank:oxidiser.2.rate")]];
            [cos * a[0] - sin * a[1], sin * a[0] + cos * a[1]]
        };
        let (one, other) = (force(0.0), force(0.7));
        for i in 0..2 {
            assert!((one[i] - other[i]).abs() < 1e-12, "{kind}: {one:?} {other:?}"); // rounding
        }
    }
}

#[test]
fn a_controller_knows_nothing_of_what_the_file_leaves_out() {
    let zero = Quantity::known(0.0);
    let mut plant = plant();
    plant.controllers.push(Controller {
        name: "loop".to_owned(),
        actuator: "drive".to_owned(),
        position_sensor: None,
        rate_sensor: None,
        kp: zero,
        ki: zero,
        kd: zero,
        reference: vec![Signal {
            kind: SignalKind::Sine {
                amplitude: Quantity::known(0.3),
                frequency_hz: Quantity::known(0.2),
                phase_rad: zero,
            },
            begin_s: zero,
            end_s: None,
        }],
        feed_forward: Quantity::known(1.0),
        reference_rate: false,
    });
    let commands = |plant: &Plant| -> Vec<f64> {
        let mut simulator = Simulator::new(plant, 1, "test").unwrap();
        (0..50).map(|_| simulator.step().commands[2]).collect()
    };
    let nominal = commands(&plant);
    assert!(nominal.iter().any(|command| command.abs() > 1e-3));
    for (kind, site) in [("mass_error", "body:arm"), ("joint_flexibility", "joint:elbow"), ("com_shift", "body:arm")] {
        plant.effects = vec![used(kind, site, &[])];
        assert_eq!(commands(&plant), nominal, "{kind}");
    }
}

#[test]
fn the_environment_pushes_a_body_that_has_mass() {
    let mut plant = plant();
    plant.bodies.remove(0);
    plant.bodies[0].parent = None;
    plant.bodies[0].joint.kind = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    plant.bodies[0].joint.rotor_inertia = Quantity::known(2.0);
    (plant.tanks, plant.appendages) = (Vec::new(), Vec::new());
    plant.actuators.retain(|actuator| actuator.name == "drive");
    plant.sensors.retain(|sensor| sensor.name == "enc");
    plant.environment.constant_force_n[0] = Quantity::known(5.0);
    plant.effects = vec![used("joint_flexibility", "joint:elbow", &[])];
    let (x_dot, _) = rates_at_rest(&plant);
    let system = System::new(&plant).unwrap();
    let at = |name: &str| system.states().iter().position(|state| state.name == name).unwrap();
    assert!(x_dot[at("joint:elbow.rate")].abs() < 1e-12, "the motor is not pushed");
    assert!((x_dot[at("joint:elbow_gear.rate")] - 0.5).abs() < 1e-12, "5 N on the 10 kg of the link");
}

fn rates_at_rest(plant: &Plant) -> (Vec<f64>, Vec<f64>) {
    let system = System::new(plant).unwrap();
    let (mut x_dot, mut y) = (vec![0.0; system.states().len()], vec![0.0; system.outputs().len()]);
    let (x, u) = (x_dot.clone(), vec![0.0; system.inputs().len()]);
    system.derivative_and_read(&mut Workspace::new(&system), 0.0, &x, &u, &mut x_dot, &mut y);
    (x_dot, y)
}

#[test]
fn propellant_that_is_gone_is_gone_in_the_next_segment_and_noise_is_not_firing() {
    let mut plant = plant();
    plant.effects = vec![used("mass_depletion", "body:hub", &[])];
    let burn = SignalKind::Constant { value: Quantity::known(10.0) };
    plant.actuators[0].command =
        vec![Signal { kind: burn, begin_s: Quantity::known(0.0), end_s: Some(Quantity::known(1.0)) }];
    let impulse = |simulator: &mut Simulator, periods: usize| {
        (0..periods).for_each(|_| {
            simulator.step();
        });
        *simulator.truth().state.last().unwrap()
    };
    let mut simulator = Simulator::new(&plant, 1, "test").unwrap();
    let burnt = impulse(&mut simulator, 100);
    assert!((burnt - 10.0).abs() < 1e-9, "{burnt}"); // 10 N for 1 s
    simulator.restart(5.0, &plant.initial.clone()).unwrap();
    assert_eq!(*simulator.truth().state.last().unwrap(), burnt);
    // coasting with a noisy actuator: the sum of 2000 samples of 1 N over 10 ms has 0.45 N s;
    // rectified it would be 16 N s
    plant.actuators[0].command.clear();
    plant.actuators[0].noise = Quantity::known(1.0);
    let coasted = impulse(&mut Simulator::new(&plant, 1, "test").unwrap(), 2000);
    assert!(coasted.abs() < 4.0 * 0.45, "{coasted}");
}

#[test]
fn a_body_keeps_some_mass_and_a_motion_without_bound_ends_by_name() {
    let mut empty = plant();
    empty.effects = vec![used("payload_drift", "body:arm", &[("rate", -0.1)])];
    empty.segments.clear();
    let mut simulator = Simulator::new(&empty, 1, "test").unwrap();
    simulator.restart(1000.0, &empty.initial.clone()).unwrap(); // 100 kg less than 10 kg
    (0..10).for_each(|_| {
        simulator.step();
    });
    assert_eq!(simulator.check_finite(), Ok(()));
    let mut unstable = plant();
    unstable.effects = vec![used("joint_viscous", "joint:elbow", &[("damping", 1e9)])];
    unstable.initial.values.push(dynamics::description::InitialValue {
        coordinate: "joint:elbow".to_owned(),
        position: Quantity::known(0.0),
        rate: Quantity::known(1.0),
    });
    let error = record(&unstable, 1, 10.0, &mut |_| {}).unwrap_err();
    assert!(matches!(error, SimulationError::NotFinite { .. }), "{error}");
}

#[test]
fn clocks_ranges_and_resolutions_of_effects_reach_the_record() {
    let mut plant = plant();
    plant.effects = vec![
        used("clock_offset", "sensor:gyro_z", &[("offset", 0.25)]),
        used("sensor_bias", "sensor:enc", &[("bias", 0.7)]),
        used("sensor_quantisation", "sensor:enc", &[("step", 0.5)]),
        used("sensor_lag", "sensor:enc", &[("time_constant", 0.1)]),
    ];
    let mut simulator = Simulator::new(&plant, 1, "test").unwrap();
    for _ in 0..20 {
        let row = simulator.step();
        assert_eq!(row.sample(0).unwrap().time_s, row.time_s + 0.25);
        assert_eq!(row.value(2), 0.5);
    }
}

/// A joint driven through `0.5 sin(2π t/4)` with bristles; (time, bend) at the end of every control
/// period.
fn bends(kind: &str, values: &[(&str, f64)]) -> Vec<(f64, f64)> {
    use dynamics::description::{ActuatorKind, Prescribed};
    let mut plant = plant();
    plant.actuators[2].kind = ActuatorKind::PrescribedJoint { joint: "elbow".to_owned(), what: Prescribed::Position };
    let kind_of_signal = SignalKind::Sine {
        amplitude: Quantity::known(0.5),
        frequency_hz: Quantity::known(0.25),
        phase_rad: Quantity::known(0.0),
    };
    plant.actuators[2].command = vec![Signal { kind: kind_of_signal, begin_s: Quantity::known(0.0), end_s: None }];
    plant.effects = vec![used(kind, "joint:elbow", values)];
    let mut simulator = Simulator::new(&plant, 1, "test").unwrap();
    (0..1200)
        .map(|_| {
            simulator.step();
            let truth = simulator.truth();
            (truth.time_s, *truth.state.last().unwrap())
        })
        .collect()
}

/// Under an imposed displacement a Dahl bristle approaches its sign as `e^(-way/d)` since the last
/// turning point (Dahl 1968).
#[test]
fn a_bristle_under_imposed_displacement_runs_the_loop_of_dahl() {
    let d = 0.05;
    let found = bends("joint_lugre", &[("break_away_ratio", 1.0), ("presliding", d), ("bristle_damping", 0.0)]);
    let position = |t: f64| 0.5 * libm::sin(core::f64::consts::FRAC_PI_2 * t);
    let (mut from, mut sign, mut turn_s) = ((0.0, 0.0), 1.0, 1.0);
    for (t, bend) in found {
        let at = |t: f64, (q, z): (f64, f64), sign: f64| sign - (sign - z) * libm::exp(-(position(t) - q).abs() / d);
        if t > turn_s + 1e-9 {
            from = (position(turn_s), at(turn_s, from, sign));
            (sign, turn_s) = (-sign, turn_s + 2.0);
        }
        // RK4: (|v| h / d)^5 / 120 a step is 7e-7, over a way of d = 6 steps
        assert!((bend - at(t, from, sign)).abs() < 2e-5, "{t}: {bend}");
    }
}

/// Bristles much shorter than the way of one step do not blow up: what is left of them is dry
/// friction.
#[test]
fn bristles_shorter_than_a_step_are_dry_friction() {
    for (kind, values) in [
        ("joint_lugre", vec![("break_away_ratio", 1.0), ("presliding", 1e-6), ("bristle_damping", 0.0)]),
        ("joint_bouc_wen", vec![("yield", 1e-4), ("exponent", 3.0), ("share", 0.7)]),
    ] {
        for (t, bend) in bends(kind, &values) {
            assert!(bend.abs() < 1.0 + 1e-3, "{kind} {t}: {bend}");
            // a fifth of a second behind a reversal: 20 steps, each of which leaves e^-1 of the
            // rest or less
            let phase = (t + 1.0) % 2.0;
            if t > 0.2 && (0.2..1.99).contains(&phase) {
                let sign = if (t + 1.0) % 4.0 < 2.0 { 1.0 } else { -1.0 };
                assert!((bend - sign).abs() < 1e-2, "{kind} {t}: {bend}");
            }
        }
    }
}

#[test]
fn planar_plants_list_what_they_feel_and_only_that() {
    let untouched = rates_and_readings(&plant());
    for effect in EFFECTS {
        let amplitudes = &effect.parameters[..effect.amplitudes()];
        let size = amplitudes.iter().map(|part| part.default).fold(0.0, f64::max);
        for site in sites(effect, &plant()) {
            for (k, part) in amplitudes.iter().enumerate() {
                let mut parameters = defaults(effect);
                parameters[..effect.amplitudes()].fill(0.0);
                parameters[k] = size.min(part.high);
                if part.out_of_plane {
                    assert_eq!(
                        answer(effect, &site, &parameters),
                        untouched,
                        "{} {} at {site}",
                        effect.kind,
                        part.name
                    );
                } else if amplitudes.len() > 1 && !gated_in_time(effect) {
                    assert_ne!(
                        answer(effect, &site, &parameters),
                        untouched,
                        "{} {} at {site}",
                        effect.kind,
                        part.name
                    );
                }
            }
        }
        for (k, part) in effect.parameters.iter().enumerate().filter(|(_, part)| part.out_of_plane) {
            for site in sites(effect, &plant()) {
                let (mut one, mut other) = (defaults(effect), defaults(effect));
                (one[k], other[k]) = (part.low, part.high);
                assert_eq!(answer(effect, &site, &one), answer(effect, &site, &other), "{} {}", effect.kind, part.name);
            }
        }
    }
    let mut carrying = plant();
    carrying.add_effect("constant_force", &"body:hub".parse().unwrap(), &[]).unwrap();
    let names: Vec<String> = carrying.parameters().into_iter().map(|parameter| parameter.name).collect();
    assert!(names.contains(&"effect.constant_force@body:hub.force_y".to_owned()));
    assert!(!names.contains(&"effect.constant_force@body:hub.force_z".to_owned()));
}

/// Acts later than the instant at which [`rates_and_readings`] looks.
fn gated_in_time(effect: &Effect) -> bool {
    effect.parameters.iter().any(|parameter| parameter.name == "begin" && parameter.default > 20.0)
}
