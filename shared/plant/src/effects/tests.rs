//! Laws of the whole catalogue.

use super::trial::{Trial, both, defaults, plant};
use super::*;
use crate::description::{Controller, EffectUse, JointKind, Quantity, Signal, SignalKind};
use crate::dual::Dual;
use crate::noise::Stream;
use crate::simulation::{SimulationError, Simulator, record};
use crate::system::{System, Workspace};

fn is_snake_case(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}

#[test]
fn every_entry_is_named_once_and_says_what_it_is() {
    for (index, effect) in EFFECTS.iter().enumerate() {
        assert!(is_snake_case(effect.kind), "{}", effect.kind);
        assert!(EFFECTS[..index].iter().all(|other| other.kind != effect.kind), "{} twice", effect.kind);
        assert!(EFFECTS[..index].iter().all(|other| other.title != effect.title), "{} twice", effect.title);
        for text in [effect.title, effect.what, effect.signature, effect.confounders, effect.experiment] {
            assert!(text.len() > 10 && !text.contains("  ") && text.is_ascii(), "{}: {text}", effect.kind);
        }
        assert!(!effect.sites.is_empty(), "{}", effect.kind);
    }
}

#[test]
fn every_parameter_has_a_name_of_its_own_and_a_default_within_its_range() {
    for effect in EFFECTS {
        assert!(!effect.parameters.is_empty() && effect.parameters.len() <= PARAMETERS_MAX, "{}", effect.kind);
        assert!(effect.hidden_states <= HIDDEN_MAX, "{}", effect.kind);
        for (index, parameter) in effect.parameters.iter().enumerate() {
            let here = format!("{} {}", effect.kind, parameter.name);
            assert!(is_snake_case(parameter.name), "{here}");
            assert!(effect.parameters[..index].iter().all(|other| other.name != parameter.name), "{here}");
            assert!(parameter.low < parameter.high, "{here}");
            assert!(parameter.low <= parameter.default && parameter.default <= parameter.high, "{here}");
            assert!(!parameter.unit.is_empty() && !parameter.what.is_empty(), "{here}");
        }
        let amplitude = &effect.parameters[..effect.amplitudes];
        assert!(amplitude.iter().all(|part| part.low <= 0.0 && part.high > 0.0), "{}", effect.kind);
        assert!(amplitude.iter().any(|part| part.default > 0.0), "{}", effect.kind);
    }
}

#[test]
fn confounders_and_experiments_name_effects_that_exist() {
    for effect in EFFECTS {
        let words = effect.confounders.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        for word in words.filter(|word| word.contains('_')) {
            assert!(super::effect(word).is_some(), "{} names '{word}'", effect.kind);
            assert_ne!(word, effect.kind, "{} confounds itself", effect.kind);
        }
    }
}

/// Amplitude zero, all else at every combination of the ends of its range.
fn silent_corners(effect: &Effect) -> Vec<Vec<f64>> {
    let others = &effect.parameters[effect.amplitudes..];
    let corner = |bits: usize| {
        let ends = others.iter().enumerate().map(|(i, p)| if bits >> i & 1 == 1 { p.high } else { p.low });
        core::iter::repeat_n(0.0, effect.amplitudes).chain(ends).collect()
    };
    (0..1 << others.len()).map(corner).collect()
}

#[test]
fn at_zero_amplitude_nothing_changes_exactly() {
    for effect in EFFECTS {
        for parameters in silent_corners(effect) {
            match effect.law {
                Law::ActuatorFilter(filter) | Law::SensorFilter(filter) => {
                    assert_eq!(filter(&parameters), FilterKind::None, "{} {parameters:?}", effect.kind);
                }
                Law::Structure(build) => {
                    for site in sites(effect, &plant()) {
                        let mut built = plant();
                        build(&mut built, &site, &parameters).expect("zero amplitude needs nothing");
                        assert_eq!(built, plant(), "{} at {site}", effect.kind);
                    }
                }
                _ => {
                    for k in 0..20 {
                        let state = Trial::random(k);
                        let action = Action { hidden_rate: [0.0; HIDDEN_MAX], ..state.act(effect, &parameters) };
                        assert_eq!(action, state.untouched(effect), "{} {parameters:?}", effect.kind);
                    }
                }
            }
        }
    }
}

fn numbers(action: &Action<f64>) -> Vec<f64> {
    let mut all = vec![action.force, action.value, action.added_mass_kg];
    all.extend(action.wrench);
    all.extend(action.hidden_rate);
    all
}

fn derivatives(action: &Action<Dual>) -> Vec<f64> {
    let mut all = vec![action.force, action.value, action.added_mass_kg];
    all.extend(action.wrench);
    all.extend(action.hidden_rate);
    all.iter().map(|number| number.derivative).collect()
}

/// Every parameter at one and the other end of its range, the rest at their defaults.
fn ends(effect: &Effect) -> Vec<Vec<f64>> {
    let mut all = vec![defaults(effect)];
    for (index, parameter) in effect.parameters.iter().enumerate() {
        for end in [parameter.low, parameter.high] {
            let mut values = defaults(effect);
            values[index] = end;
            all.push(values);
        }
    }
    all
}

#[test]
fn laws_and_their_derivatives_are_finite_at_rest_in_motion_and_at_the_ends_of_every_range() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        for parameters in ends(effect) {
            let still = Trial::default();
            for state in core::iter::once(still).chain((0..50).map(Trial::random)) {
                let here = format!("{} {parameters:?} {state:?}", effect.kind);
                assert!(numbers(&state.act(effect, &parameters)).iter().all(|x| x.is_finite()), "{here}");
                let slope = state.act_dual(effect, &parameters, &Trial::random(1000));
                assert!(derivatives(&slope).iter().all(|x| x.is_finite()), "{here}");
            }
        }
    }
}

#[test]
fn the_law_over_dual_numbers_is_the_derivative_of_the_law() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        let parameters = defaults(effect);
        let mut compared = 0;
        for k in 0..100 {
            let (state, direction) = (Trial::random(k), Trial::random(k + 5000));
            let slope = derivatives(&state.act_dual(effect, &parameters, &direction));
            let difference = |step: f64| -> Vec<f64> {
                let after = numbers(&state.moved(&direction, step).act(effect, &parameters));
                let before = numbers(&state.moved(&direction, -step).act(effect, &parameters));
                after.iter().zip(before).map(|(a, b)| (a - b) / (2.0 * step)).collect()
            };
            let (coarse, fine) = (difference(2e-6), difference(1e-6));
            for ((slope, fine), coarse) in slope.iter().zip(&fine).zip(&coarse) {
                // Richardson's estimate of the truncation error; where it is large a kink or a jump lies between the two points
                let truncation = (fine - coarse).abs();
                let scale = 1.0 + slope.abs();
                if truncation > 1e-4 * scale {
                    continue;
                }
                compared += 1;
                // rounding of the difference: 1e-16 · (values up to 1e6) / 1e-6 relative to scale is below 1e-4
                assert!((slope - fine).abs() <= 2.0 * truncation + 1e-4 * scale, "{} {slope} {fine}", effect.kind);
            }
        }
        assert!(compared > 1000, "{}: {compared} comparisons of 1300", effect.kind);
    }
}

#[test]
fn every_entry_finds_a_site_in_a_plant_with_one_of_everything() {
    let planar = plant();
    let spatial = Plant { space: crate::description::Space::Spatial, ..plant() };
    for effect in EFFECTS {
        assert!(!sites(effect, &planar).is_empty() || !sites(effect, &spatial).is_empty(), "{}", effect.kind);
    }
}

#[test]
fn at_its_default_every_effect_does_something_at_every_site() {
    for effect in EFFECTS {
        let parameters = defaults(effect);
        match effect.law {
            Law::ActuatorFilter(filter) | Law::SensorFilter(filter) => {
                assert_ne!(filter(&parameters), FilterKind::None, "{}", effect.kind);
            }
            Law::Structure(build) => {
                for site in sites(effect, &plant()) {
                    let mut built = plant();
                    let done = build(&mut built, &site, &parameters);
                    assert!(done.is_ok(), "{} at {site}: {done:?}", effect.kind);
                    assert_ne!(built, plant(), "{} at {site}", effect.kind);
                }
            }
            _ => {
                let acts = |k| {
                    let state = Trial::random(k);
                    state.act(effect, &parameters) != state.untouched(effect)
                };
                assert!((0..200).any(acts), "{}", effect.kind);
            }
        }
    }
}

#[test]
fn a_law_fills_no_more_hidden_states_than_it_says() {
    for effect in EFFECTS.iter().filter(|effect| both(effect).is_some()) {
        for k in 0..20 {
            let rates = Trial::random(k).act(effect, &defaults(effect)).hidden_rate;
            assert!(rates[effect.hidden_states..].iter().all(|rate| *rate == 0.0), "{}", effect.kind);
        }
    }
}

fn used(kind: &str, site: &str, values: &[(&str, f64)]) -> EffectUse {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), Quantity::known(*value))).collect();
    EffectUse { kind: kind.to_owned(), site: site.parse().unwrap(), values }
}

#[test]
fn values_stand_in_the_order_of_the_catalogue_with_defaults_filled_in() {
    let effect = effect("joint_coulomb").unwrap();
    let values = values(effect, &used("joint_coulomb", "joint:elbow", &[("smooth_rate", 0.5)])).unwrap();
    assert_eq!(values, [effect.parameters[0].default, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_wrong_word_is_answered_with_the_nearest_right_one() {
    let said = |used: EffectUse| {
        let mut plant = plant();
        plant.effects.push(used);
        let before = plant.clone();
        let error = apply_structures(&mut plant).unwrap_err().to_string();
        assert_eq!(plant, before);
        error
    };
    let kind = said(used("joint_columb", "joint:elbow", &[]));
    assert_eq!(kind, "there is no effect 'joint_columb'; did you mean 'joint_coulomb'?");
    let site = said(used("joint_coulomb", "joint:elbw", &[]));
    assert_eq!(site, "joint_coulomb cannot sit at joint:elbw; did you mean 'joint:elbow'?");
    let parameter = said(used("joint_coulomb", "joint:elbow", &[("forze", 1.0)]));
    assert_eq!(parameter, "joint_coulomb has no parameter 'forze'; did you mean 'force'?");
    assert_eq!(said(used("zzz", "joint:elbow", &[])), "there is no effect 'zzz'");
}

#[test]
fn structures_are_built_and_taken_off_the_list_and_all_other_effects_stay_in_order() {
    let mut built = plant();
    built.effects = vec![
        used("joint_coulomb", "joint:elbow", &[]),
        used("slosh_second_mode", "tank:oxidiser", &[]),
        used("sensor_lag", "sensor:enc", &[]),
        used("slosh_cubic", "tank:oxidiser_second", &[]), // sits at a part that a structure has made
    ];
    apply_structures(&mut built).unwrap();
    let kinds: Vec<&str> = built.effects.iter().map(|used| used.kind.as_str()).collect();
    assert_eq!(kinds, ["joint_coulomb", "sensor_lag", "slosh_cubic"]);
    assert_eq!(built.tanks.len(), 2);
    let again = built.clone();
    apply_structures(&mut built).unwrap();
    assert_eq!(built, again);
}

#[test]
fn a_part_that_cannot_be_built_is_refused_with_its_reason_and_the_plant_stays() {
    let mut built = plant();
    built.effects = vec![used("com_shift", "body:hub", &[]), used("appendage_left_out", "body:hub", &[("lever", 1e3)])];
    let before = built.clone();
    let error = apply_structures(&mut built).unwrap_err();
    assert!(matches!(error, EffectError::Impossible { .. }), "{error}");
    assert_eq!(built, before);
}

/// Rates and readings of the plant with one effect, in the states that it has without, at a random state; hidden states at zero.
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
            parameters[..effect.amplitudes].fill(0.0);
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
    use crate::description::{Space, TankModel};
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
            let entry = effect(kind).unwrap();
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
    // coasting with a noisy actuator: the sum of 2000 samples of 1 N over 10 ms has 0.45 N s; rectified it would be 16 N s
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
    unstable.initial.values.push(crate::description::InitialValue {
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
