use super::*;
use dynamics::description::{Noise, Quantity, Scope, SensorKind, SignalKind, Site, TankModel};

mod cures;
mod faults;
mod header;
mod limits;
mod round_trip;

/// Line 1 of a plant that has one of nearly everything; each fault test breaks it in one place.
const PLANT: &str = r#"format = 1
name = "test"
space = "planar"
gravity = [0, "-1 m/s^2"]

[[body]]
name = "hub"
mass = "400 kg"
inertia = "66.7 kg*m^2"
joint = { kind = "free" }

[[body]]
name = "link_1"
parent = "hub"
mass = { value = "12 kg", sigma = "1 %" }
com = ["1.9 m", 0]
inertia = "17 kg*m^2"
joint = { kind = "revolute", name = "shoulder", position = ["0.99 m", "0.99 m"], friction = "0.1 N*m*s/rad" }

[[body]]
name = "slider"
parent = "link_1"
mass = "3 kg"
inertia = "0.1 kg*m^2"
joint = { kind = "prismatic", name = "rail", axis = [3, 4], stiffness = "10 N/m" }

[[tank]]
name = "fuel"
body = "hub"
kind = "spring"
axis = "y"
mass = "28.7 kg"
position = ["-0.45 m", "0.2 m"]
stiffness = "0.16 N/m"

[[appendage]]
name = "panel"
body = "hub"
points = { root = ["1 m", 0], tip = ["5 m", 0] }

[[appendage.mode]]
name = "bending"
frequency = "1 Hz"
damping_ratio = 0.005
rotation = "5 sqrt(kg)*m"
shape = { root = [0, 0], tip = [0, "0.6 1/sqrt(kg)"] }

[[actuator]]
name = "motor"
kind = "joint_torque"
joint = "shoulder"
command = { kind = "sine", amplitude = "2 N*m", frequency = "0.1 Hz" }

[[actuator]]
name = "pusher"
kind = "prescribed_joint"
joint = "rail"
what = "position"
command = { kind = "slew", size = "0.1 m", width = "5 s" }

[[controller]]
name = "loop"
actuator = "motor"
position_sensor = "angle"
kp = "600 N*m/rad"
reference = { kind = "constant", value = "0.5 rad" }

[[source]]
name = "imu"
clock_skew = "20 ppm"

[[sensor]]
name = "angle"
kind = "encoder"
joint = "shoulder"
noise = "12 urad"
period = "20 ms"

[[sensor]]
name = "gyro"
kind = "gyro"
body = "hub"
noise = "0.09 deg/sqrt(h)"
source = "imu"

[[sensor]]
name = "tip"
kind = "accelerometer"
point = "panel:tip"
axis = "xy"
noise = "100 ug/sqrt(Hz)"

[initial]
"joint:shoulder" = { position = "10 deg", rate = "1 deg/s" }

[[effect]]
kind = "joint_coulomb"
site = "joint:shoulder"
force = "0.2 N*m"

[simulation]
duration = "5 s"
period = "10 ms"
"#;

fn plant(text: &str) -> Plant {
    parse("test.toml", text).unwrap_or_else(|errors| panic!("{}", shown(&errors))).plant
}

fn shown(errors: &[FileError]) -> String {
    errors.iter().map(|error| format!("{error}\n")).collect()
}

/// What is reported when `from` is replaced by `to`.
fn errors_with(from: &str, to: &str) -> Vec<FileError> {
    assert!(PLANT.contains(from), "'{from}' is not in the plant");
    parse("test.toml", &PLANT.replacen(from, to, 1)).expect_err("the broken plant was accepted")
}

fn line_of(text: &str, word: &str) -> usize {
    let at = text.find(word).unwrap_or_else(|| panic!("'{word}' is not in the text"));
    text[..at].matches('\n').count() + 1
}

#[test]
fn the_example_says_what_it_should() {
    let plant = plant(PLANT);
    assert_eq!(plant.bodies[1].mass_kg, Quantity::with_prior(12.0, 0.12));
    assert_eq!(plant.bodies[0].joint.name, "hub", "a joint without a name has its body's");
    assert!(
        matches!(plant.bodies[2].joint.kind, dynamics::description::JointKind::Prismatic { axis } if axis == [0.6, 0.8, 0.0])
    );
    let SignalKind::Sine { amplitude, frequency_hz, .. } = &plant.actuators[0].command[0].kind else { panic!() };
    assert_eq!((amplitude.value, frequency_hz.value), (2.0, 0.1));
    let names: Vec<&str> = plant.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!(names, ["angle", "gyro", "tip_x", "tip_y"]);
    let SensorKind::Accelerometer { body, position_m, axis, point } = &plant.sensors[3].kind else { panic!() };
    assert_eq!((body.as_str(), position_m[0].value, *axis), ("hub", 5.0, [0.0, 1.0, 0.0]));
    assert_eq!(*point, Some(("panel".to_owned(), "tip".to_owned())));
    assert!(matches!(&plant.tanks[0].model, TankModel::Spring { stiffness_n_m, .. } if stiffness_n_m[0].value == 0.16));
    assert_eq!(plant.simulation.step_s, 0.01, "the step is the period where it is not stated");
    assert_eq!(plant.effects[0].values, [("force".to_owned(), Quantity::known(0.2))]);
}

#[test]
fn a_noise_is_a_density_or_a_standard_deviation_by_its_dimension() {
    let plant = plant(PLANT);
    assert!(matches!(plant.sensors[0].noise, Noise::PerSample(q) if q.value == 1.2e-5));
    let arw = 0.09 / 60.0 * core::f64::consts::PI / 180.0;
    // four roundings on either side
    assert!(matches!(plant.sensors[1].noise, Noise::Density(q) if (q.value / arw - 1.0).abs() < 1e-15));
    assert!(matches!(plant.sensors[2].noise, Noise::Density(q) if q.value == 980.665e-6));
}

#[test]
fn bodies_may_stand_in_any_order_and_are_sorted() {
    let (hub, rest) = (PLANT.find("[[body]]").unwrap(), PLANT.find("[[body]]\nname = \"link_1\"").unwrap());
    let moved = format!("{}{}\n{}", &PLANT[..hub], &PLANT[rest..], &PLANT[hub..rest]);
    assert_eq!(plant(&moved).bodies, plant(PLANT).bodies);
    // and a fault is still reported at its own table
    let broken = moved.replace("mass = \"400 kg\"", "mass = \"-400 kg\"");
    let errors = parse("test.toml", &broken).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (1, line_of(&broken, "-400 kg")), "{}", shown(&errors));
}

#[test]
fn priors_have_scopes_and_relative_sigmas() {
    let text = PLANT.replace(
        "clock_skew = \"20 ppm\"",
        "clock_skew = { value = 0, sigma = \"20 ppm\", scope = \"per recording\" }",
    );
    let skew = plant(&text).sources[0].clock_skew;
    assert_eq!(skew, Quantity { value: 0.0, sigma: Some(2e-5), scope: Scope::PerRecording });
    let text = PLANT.replace("com = [\"1.9 m\", 0]", "com = { value = [\"1.9 m\", 0], sigma = \"5 mm\" }");
    assert_eq!(plant(&text).bodies[1].com_m[..2], [Quantity::with_prior(1.9, 0.005), Quantity::with_prior(0.0, 0.005)]);
}

#[test]
fn a_frequency_may_be_given_as_a_rate_but_a_rate_not_in_hertz() {
    let text = PLANT.replace("frequency = \"1 Hz\"", "frequency = \"60 rpm\"");
    let frequency = plant(&text).appendages[0].modes[0].frequency_hz.value;
    assert!((frequency - 1.0).abs() < 1e-15, "{frequency}"); // three roundings
    let errors = errors_with("rate = \"1 deg/s\"", "rate = \"1 Hz\"");
    assert!(errors[0].message.contains("counts cycles"), "{}", shown(&errors));
}

#[test]
fn g_is_a_gram_where_only_that_makes_sense() {
    let text = PLANT.replace("mass = \"28.7 kg\"", "mass = \"28.7 g\"").replace("\"-1 m/s^2\"", "\"-1 g\"");
    let plant = plant(&text);
    assert_eq!((plant.tanks[0].mass_kg.value, plant.environment.gravity_m_s2[1].value), (0.0287, -9.80665));
}

#[test]
fn nineteen_bits_are_one_turn_in_so_many_steps() {
    let text = PLANT.replace("noise = \"12 urad\"", "resolution = \"19 bit\"");
    assert_eq!(plant(&text).sensors[0].resolution.value, core::f64::consts::TAU / f64::from(1 << 19));
}

#[test]
fn an_effect_on_one_line_reads_as_in_a_file() {
    let plant = plant(PLANT);
    let read = parse_effect(&plant, "joint_coulomb@joint:shoulder force=\"0.2 N*m\"").unwrap();
    assert_eq!(read, plant.effects[0]);
    assert_eq!(parse_effect(&plant, "joint_coulomb@joint:shoulder force=0.2").unwrap(), read, "without unit: SI");
    for (text, words) in [
        ("joint_columb@joint:shoulder", ["joint_columb", "did you mean 'joint_coulomb'"]),
        ("joint_coulomb@joint:sholder", ["joint:sholder", "joint:shoulder"]),
        ("joint_coulomb@body:hub", ["body:hub", "joint"]),
        ("joint_coulomb@joint:shoulder forse=1", ["forse", "did you mean 'force'"]),
        ("joint_coulomb@joint:shoulder force=\"1 kg\"", ["'1 kg' is a mass", "N*m"]),
        ("joint_coulomb@joint:shoulder force=much", ["much", "not a number"]),
        ("joint_coulomb joint:shoulder", ["joint_coulomb", "KIND@SITE"]),
    ] {
        let message = parse_effect(&plant, text).unwrap_err();
        assert!(words.iter().all(|word| message.contains(word)), "{text}: {message}");
    }
}

#[test]
fn effects_are_added_by_name_and_taken_away() {
    let mut plant = plant(PLANT);
    let site: Site = "joint:rail".parse().unwrap();
    plant.add_effect("joint_coulomb", &site, &[("force", 3.0)]).unwrap();
    assert_eq!(plant.effects[1].values, [("force".to_owned(), Quantity::known(3.0))]);
    assert!(plant.add_effect("joint_coulomb", &site, &[("force", f64::NAN)]).is_err());
    assert!(plant.add_effect("nothing", &site, &[]).unwrap_err().contains("nothing"));
    assert!(plant.without_effects().effects.is_empty());
}

#[test]
fn every_unit_of_the_catalogue_is_readable_at_every_site() {
    let plants = ["study_case", "study_case_spatial", "oscillator", "drive_rig", "tank_pendulum", "damper_rig"];
    for name in plants {
        let path = format!("{}/../../deploy/plants/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let plant = plant(&std::fs::read_to_string(path).unwrap());
        for effect in catalogue::EFFECTS {
            for site in dynamics::effect::sites(effect, &plant) {
                for parameter in effect.parameters {
                    let unit = dynamics::description::unit_at(&plant, &site, parameter.unit);
                    let read = units::parse(&unit);
                    assert!(read.is_ok(), "{} of {} at {site}: '{unit}': {read:?}", parameter.name, effect.kind);
                }
            }
        }
    }
}
