//! What the definition of the format says is so: its example reads, and its signs and frames are
//! those of the equations.

use super::{parse, plant, shown};
use crate::{FORMAT, effect_warnings, parse_effect};
use dynamics::description::{Plant, Space};
use dynamics::system::{System, Workspace};

/// The blocks of the definition that begin with "````kind`", put together.
fn blocks(kind: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for line in FORMAT.lines() {
        if line.starts_with("```") {
            inside = !inside && line.trim_end() == format!("```{kind}");
        } else if inside {
            text.push_str(line);
            text.push('\n');
        }
    }
    text
}

#[test]
fn the_blocks_of_the_definition_are_complete_plants_without_a_warning() {
    for (kind, space) in [("toml", Space::Planar), ("toml spatial", Space::Spatial)] {
        let text = blocks(kind);
        let parsed = parse("header", &text).unwrap_or_else(|errors| panic!("{}\n{text}", shown(&errors)));
        assert!(parsed.warnings.is_empty(), "{}", shown(&parsed.warnings));
        assert_eq!(parsed.plant.space, space);
        assert!(System::new(&parsed.plant).is_ok());
    }
    assert!(FORMAT.lines().filter(|line| line.starts_with("```toml")).count() >= 7, "blocks are not recognised");
}

#[test]
fn every_effect_in_the_documentation_of_the_reader_is_one() {
    let plant = plant(&blocks("toml"));
    let mut found = 0;
    let documented = |source: &str| -> String {
        source.lines().filter(|line| line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
    };
    let sources = [
        FORMAT.to_owned(),
        documented(include_str!("../effect_text.rs")),
        documented(include_str!("../../../dynamics/src/description/parameters.rs")),
    ];
    for source in sources {
        for example in source.split('`').filter(|text| text.contains("@joint:")) {
            found += 1;
            match example.strip_prefix("effect.") {
                Some(name) => {
                    let mut plant = plant.clone();
                    plant.set_parameter(&format!("effect.{name}"), 0.1).unwrap();
                }
                None => drop(parse_effect(&plant, example).unwrap_or_else(|error| panic!("{example}: {error}"))),
            }
        }
    }
    assert!(found >= 3, "{found} examples");
}

#[test]
fn an_effect_on_one_line_is_warned_of_as_in_a_file() {
    let plant = plant(&blocks("toml"));
    let effect = parse_effect(&plant, "joint_coulomb@joint:shoulder force=-0.2").unwrap();
    let warnings = effect_warnings(&plant, &effect);
    assert!(warnings.len() == 1 && warnings[0].contains("force = -0.2 N*m"), "{warnings:?}");
    let file = format!(
        "{}\n[[effect]]\nkind = \"joint_coulomb\"\nsite = \"joint:shoulder\"\nforce = \"-0.2 N*m\"\n",
        blocks("toml")
    );
    let from_file = parse("file", &file).unwrap().warnings;
    assert_eq!(from_file.len(), 1);
    assert!(warnings[0].starts_with(&from_file[0].message), "{warnings:?}, {from_file:?}");
    assert!(effect_warnings(&plant, &plant.effects[0]).is_empty());
}

/// All readings of a plant at its beginning, with `u` on all inputs.
fn readings(text: &str, u: f64) -> Vec<f64> {
    let (plant, system) = compiled(text);
    let x = system.initial_state(&plant.initial, &|_| None).unwrap();
    let mut y = vec![0.0; plant.sensors.len()];
    let u = vec![u; system.inputs().len()];
    system.read(&mut Workspace::new(&system), 0.0, &x, &u, &mut y);
    y
}

fn compiled(text: &str) -> (Plant, System) {
    let plant = plant(text);
    let system = System::new(&plant).unwrap();
    (plant, system)
}

fn close(got: &[f64], expected: &[f64]) {
    let near = got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12 * (1.0 + b.abs())); // rounding
    assert!(got.len() == expected.len() && near, "{got:?} is not {expected:?}");
}

const HUNG: &str = r#"format = 1
name = "hung"
space = "planar"
gravity = [0, "-9.81 m/s^2"]
[[body]]
name = "bob"
mass = "2 kg"
com = [0, "-1 m"]
inertia = "1 kg*m^2"
joint = { kind = "revolute", name = "pivot", friction = "3 N*m*s/rad" }
[[sensor]]
name = "a"
kind = "accelerometer"
body = "bob"
axis = "y"
[[sensor]]
name = "f"
kind = "force"
joint = "pivot"
axis = "y"
[[sensor]]
name = "t"
kind = "joint_torque"
joint = "pivot"
[[sensor]]
name = "m"
kind = "torque"
joint = "pivot"
"#;

#[test]
fn at_rest_an_accelerometer_reads_plus_g_and_a_joint_holds_the_weight() {
    close(&readings(HUNG, 0.0), &[9.81, 19.62, 0.0, 0.0]);
}

#[test]
fn the_joint_torque_is_the_actuators_share_and_the_torque_sensor_feels_friction_too() {
    let text = format!(
        "{HUNG}[[actuator]]\nname = \"u\"\nkind = \"joint_torque\"\njoint = \"pivot\"\n[initial]\n\"joint:pivot\" = {{ rate = \"1 rad/s\" }}\n"
    );
    let y = readings(&text, 0.5);
    close(&y[2..], &[0.5, 0.5 - 3.0]);
    // 3 kg m² about the pivot and 2 kg m² of the rotor: 1 rad/s² takes 3 N m through the joint
    let geared = text.replace("friction = \"3 N*m*s/rad\"", "rotor_inertia = \"2 kg*m^2\"");
    close(&readings(&geared, 5.0)[2..], &[5.0, 3.0]);
}

#[test]
fn a_wheel_turns_its_body_forward_and_its_rotor_back() {
    let text = "format = 1\nname = \"w\"\nspace = \"planar\"\n[[body]]\nname = \"hub\"\nmass = \"1 kg\"\ninertia = \"4 kg*m^2\"\njoint = { kind = \"free\" }\n[[actuator]]\nname = \"wheel\"\nkind = \"wheel\"\nbody = \"hub\"\ninertia = \"1 kg*m^2\"\n";
    let (plant, system) = compiled(text);
    let x = system.initial_state(&plant.initial, &|_| None).unwrap();
    let mut rates = vec![0.0; x.len()];
    system.derivative(&mut Workspace::new(&system), 0.0, &x, &[6.0], &mut rates);
    let rate = |name: &str| rates[system.states().iter().position(|state| state.name == name).unwrap()];
    // the body without its rotor has 3 kg m²; the rotor turns against inertial space with −6,
    // against the body with −8
    let names: Vec<String> = system.states().iter().map(|state| state.name.clone()).collect();
    let body = names.iter().find(|name| name.contains("hub") && name.contains("rate")).map_or(f64::NAN, |n| rate(n));
    assert!(
        rates.iter().any(|r| (r - 2.0).abs() < 1e-12) && rates.iter().any(|r| (r + 8.0).abs() < 1e-12),
        "{names:?} {rates:?} {body}"
    );
}

#[test]
fn an_attitude_counts_on_in_a_plane_and_jumps_at_half_a_turn_in_space() {
    let turned = |space: &str, inertia: &str, axis: &str, angle: &str| {
        let text = format!(
            "format = 1\nname = \"a\"\nspace = \"{space}\"\n[[body]]\nname = \"hub\"\nmass = \"1 kg\"\ninertia = {inertia}\njoint = {{ kind = \"free\" }}\n[[sensor]]\nname = \"s\"\nkind = \"attitude\"\nbody = \"hub\"\n{axis}[initial]\n\"body:hub.rz\" = {{ position = \"{angle}\" }}\n"
        );
        readings(&text, 0.0)[0].to_degrees()
    };
    let spatial = "[\"1 kg*m^2\", \"1 kg*m^2\", \"1 kg*m^2\"]";
    close(&[turned("planar", "\"1 kg*m^2\"", "", "200 deg")], &[200.0]);
    close(&[turned("spatial", spatial, "axis = \"z\"\n", "170 deg")], &[170.0]);
    close(&[turned("spatial", spatial, "axis = \"z\"\n", "200 deg")], &[-160.0]);
}

#[test]
fn a_joints_axis_is_in_the_body_after_its_orientation() {
    // turned by 90° about z the body's x is the parent's y
    let text = "format = 1\nname = \"a\"\nspace = \"spatial\"\n[[body]]\nname = \"slide\"\nmass = \"1 kg\"\ninertia = [\"1 kg*m^2\", \"1 kg*m^2\", \"1 kg*m^2\"]\njoint = { kind = \"prismatic\", axis = \"x\", orientation = { axis = \"z\", angle = \"90 deg\" } }\n[[sensor]]\nname = \"s\"\nkind = \"position\"\nbody = \"slide\"\naxis = \"xyz\"\n[initial]\n\"joint:slide\" = { position = \"1 m\" }\n";
    close(&readings(text, 0.0), &[0.0, 1.0, 0.0]);
}

#[test]
fn initial_rates_of_a_free_body_are_inertial_along_and_bodily_about() {
    let text = "format = 1\nname = \"a\"\nspace = \"spatial\"\n[[body]]\nname = \"hub\"\nmass = \"1 kg\"\ninertia = [\"1 kg*m^2\", \"1 kg*m^2\", \"1 kg*m^2\"]\njoint = { kind = \"free\" }\n[[sensor]]\nname = \"v\"\nkind = \"velocity\"\nbody = \"hub\"\naxis = \"xyz\"\n[[sensor]]\nname = \"g\"\nkind = \"gyro\"\nbody = \"hub\"\naxis = \"xyz\"\n[initial]\n\"body:hub.rz\" = { position = \"90 deg\" }\n\"body:hub.x\" = { rate = \"1 m/s\" }\n\"body:hub.rx\" = { rate = \"2 rad/s\" }\n";
    close(&readings(text, 0.0), &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
}

#[test]
fn a_constant_force_acts_at_the_centre_of_mass_in_inertial_axes() {
    let text = "format = 1\nname = \"a\"\nspace = \"planar\"\n[environment]\nconstant_force = [\"2 N\", 0]\n[[body]]\nname = \"hub\"\nmass = \"1 kg\"\ncom = [\"1 m\", 0]\ninertia = \"1 kg*m^2\"\njoint = { kind = \"free\" }\n[[sensor]]\nname = \"a\"\nkind = \"accelerometer\"\nbody = \"hub\"\nposition = [\"1 m\", 0]\naxis = \"xy\"\n[initial]\n\"body:hub.rz\" = { position = \"90 deg\" }\n";
    // inertial x is the body's −y
    close(&readings(text, 0.0), &[0.0, -2.0]);
}
