//! Each class of fault: the offending word, its line, and what is suggested.

use super::{FileError, PLANT, errors_with, line_of, parse, shown};

/// Exactly one report, at the line of `to`'s last line, with all words.
fn one(from: &str, to: &str, words: &[&str]) {
    let errors = errors_with(from, to);
    let text = PLANT.replacen(from, to, 1);
    let last = to.lines().last().unwrap_or("");
    check_one(&errors, line_of(&text, last), words);
}

fn check_one(errors: &[FileError], line: usize, words: &[&str]) {
    assert_eq!(errors.len(), 1, "{}", shown(errors));
    let text = errors[0].to_string();
    assert_eq!(errors[0].line, line, "{text}");
    assert!(text.starts_with(&format!("test.toml:{line}:")), "{text}");
    for word in words {
        assert!(text.contains(word), "'{word}' is not in: {text}");
    }
}

#[test]
fn unknown_keys_are_named_with_the_nearest() {
    one(
        "mass = \"28.7 kg\"",
        "mass = \"28.7 kg\"\nstifness = 1",
        &["stifness", "tank 'fuel'", "did you mean 'stiffness'?"],
    );
    one("friction = ", "frction = ", &["frction", "joint of body 'link_1'", "did you mean 'friction'?"]);
    one("sigma = \"1 %\"", "sigm = \"1 %\"", &["sigm", "mass of body 'link_1'", "did you mean 'sigma'?"]);
    one("gravity = ", "gravitiy = ", &["gravitiy", "did you mean 'gravity'?"]);
    one("[[tank]]", "[[tnak]]", &["tnak", "did you mean 'tank'?"]);
}

#[test]
fn a_misspelt_required_key_is_reported_once() {
    one("mass = \"400 kg\"", "maas = \"400 kg\"", &["maas", "body 'hub'", "did you mean 'mass'?"]);
}

#[test]
fn missing_keys_are_reported_at_their_table_with_an_example() {
    let errors = errors_with("mass = \"400 kg\"\n", "");
    check_one(&errors, 6, &["body 'hub'", "lacks 'mass'", "1 kg"]);
    let errors = errors_with("joint = { kind = \"free\" }", "");
    check_one(&errors, 6, &["body 'hub'", "lacks 'joint'", "kind ="]);
    let errors = errors_with("format = 1\n", "");
    check_one(&errors, 1, &["lacks 'format'", "format = 1"]);
}

#[test]
fn wrong_types_are_named() {
    one("name = \"fuel\"", "name = 3", &["name of tank", "a number", "not a text"]);
    one("joint = { kind = \"free\" }", "joint = \"free\"", &["joint of body 'hub'", "a text", "a table"]);
    one("axis = \"y\"", "axis = true", &["axis of tank 'fuel'", "no direction"]);
    one("mass = \"400 kg\"", "mass = true", &["mass of body 'hub'", "not a number with unit"]);
}

#[test]
fn wrong_dimensions_are_named_as_quantities() {
    one(
        "stiffness = \"0.16 N/m\"",
        "stiffness = \"3 kg\"",
        &["'3 kg' is a mass", "stiffness of tank 'fuel' is in N/m"],
    );
    one(
        "kp = \"600 N*m/rad\"",
        "kp = \"600 N/m\"",
        &["'600 N/m' is a stiffness", "kp of controller 'loop'", "N*m/rad"],
    );
    one(
        "amplitude = \"2 N*m\"",
        "amplitude = \"2 N\"",
        &["'2 N' is a force", "amplitude of command of actuator 'motor'"],
    );
    one("noise = \"12 urad\"", "noise = \"12 um\"", &["'12 um' is a length", "noise of sensor 'angle'", "rad"]);
    one("force = \"0.2 N*m\"", "force = \"0.2 V\"", &["'0.2 V' is a voltage", "force of effect 'joint_coulomb'"]);
    one("mass = \"28.7 kg\"", "mass = \"28.7 kgg\"", &["unknown unit 'kgg'", "did you mean 'kg'?"]);
    one("mass = \"28.7 kg\"", "mass = 28.7", &["mass of tank 'fuel' has no unit", "28.7 kg"]);
    one("position = \"10 deg\"", "position = 10", &["position of joint:shoulder", "has no unit", "rad"]);
}

#[test]
fn impossible_numbers_are_named() {
    one("mass = \"400 kg\"", "mass = \"-400 kg\"", &["mass of body 'hub' is negative: -400"]);
    one("mass = \"400 kg\"", "mass = nan", &["mass of body 'hub' is not a finite number"]);
    one("mass = \"400 kg\"", "mass = \"1e999 kg\"", &["mass of body 'hub' is not a finite number"]);
    one("inertia = \"66.7 kg*m^2\"", "inertia = \"-1 kg*m^2\"", &["inertia of body 'hub' is negative"]);
    one("sigma = \"1 %\"", "sigma = \"-1 %\"", &["standard deviation of mass of body 'link_1'", "-0.12"]);
    one(
        "frequency = \"1 Hz\"",
        "frequency = \"-1 Hz\"",
        &["frequency of mode 'bending' of appendage 'panel' is negative: -1"],
    );
    one("frequency = \"0.1 Hz\"", "frequency = 0", &["frequency of command of actuator 'motor' is zero"]);
    one("period = \"20 ms\"", "period = \"-20 ms\"", &["period of sensor 'angle' is negative: -0.02"]);
    one("duration = \"5 s\"", "duration = 0", &["duration of the simulation is not above zero"]);
}

const SPATIAL: &str = "format = 1\nname = \"s\"\nspace = \"spatial\"\n[[body]]\nname = \"hub\"\nmass = \"1 kg\"\njoint = { kind = \"free\" }\n";

#[test]
fn impossible_inertias_are_named_with_axis_and_the_three_numbers() {
    for (inertia, words) in [
        ("[\"10 kg*m^2\", \"20 kg*m^2\", \"50 kg*m^2\"]", ["about z violates the triangle inequality", "50 > 10 + 20"]),
        ("[\"-1 kg*m^2\", \"2 kg*m^2\", \"3 kg*m^2\"]", ["negative about x", "-1, 2, 3"]),
        // xy = 3 with xx = yy = 1: one principal moment is −2
        ("[\"1 kg*m^2\", \"1 kg*m^2\", \"3 kg*m^2\", \"3 kg*m^2\", 0, 0]", ["negative about principal axis 1", "-2"]),
        ("[\"1 kg*m^2\", \"2 kg*m^2\"]", ["has 2 numbers, not 3", "or 6"]),
    ] {
        let text = format!("{SPATIAL}inertia = {inertia}\n");
        let errors = parse("test.toml", &text).unwrap_err();
        check_one(&errors, 8, &[&["body 'hub'"], &words[..]].concat());
    }
    let possible = format!("{SPATIAL}inertia = [\"10 kg*m^2\", \"20 kg*m^2\", \"30 kg*m^2\"]\n");
    assert!(parse("test.toml", &possible).is_ok(), "a flat plate is at the limit, not beyond");
}

#[test]
fn unknown_names_are_named_with_the_nearest() {
    one("parent = \"hub\"", "parent = \"hubb\"", &["body 'link_1'", "'hubb'", "did you mean 'hub'?"]);
    one(
        "body = \"hub\"\nkind = \"spring\"",
        "kind = \"spring\"\nbody = \"hup\"",
        &["tank 'fuel'", "'hup'", "did you mean 'hub'?"],
    );
    let motor = "kind = \"joint_torque\"\njoint = \"shoulder\"";
    one(motor, &motor.replace("shoulder", "sholder"), &["actuator 'motor'", "'sholder'", "did you mean 'shoulder'?"]);
}

#[test]
fn unknown_kinds_and_words_are_named_with_the_nearest() {
    one("kind = \"spring\"", "kind = \"sping\"", &["kind of tank 'fuel' is 'sping'", "did you mean 'spring'?"]);
    one(
        "kind = \"encoder\"",
        "kind = \"enkoder\"",
        &["kind of sensor 'angle' is 'enkoder'", "did you mean 'encoder'?"],
    );
    one(
        "kind = \"joint_torque\"",
        "kind = \"joint_torq\"",
        &["kind of actuator 'motor'", "did you mean 'joint_torque'?"],
    );
    one("kind = \"revolute\"", "kind = \"revolut\"", &["kind of joint of body 'link_1'", "did you mean 'revolute'?"]);
    one("kind = \"sine\"", "kind = \"sin\"", &["kind of command of actuator 'motor'", "did you mean 'sine'?"]);
    one("space = \"planar\"", "space = \"plane\"", &["'plane'", "did you mean 'planar'?"]);
    one("kind = \"joint_coulomb\"", "kind = \"joint_colomb\"", &["joint_colomb", "did you mean 'joint_coulomb'?"]);
    one(
        "site = \"joint:shoulder\"",
        "site = \"joint:shuolder\"",
        &["joint:shuolder", "did you mean 'joint:shoulder'?"],
    );
    one("site = \"joint:shoulder\"", "site = \"jiont:shoulder\"", &["jiont:shoulder", "none of joint, body"]);
    one("force = \"0.2 N*m\"", "forse = \"0.2 N*m\"", &["forse", "effect 'joint_coulomb'", "did you mean 'force'?"]);
    one("\"joint:shoulder\" = {", "\"joint:sholder\" = {", &["joint:sholder", "did you mean 'joint:shoulder'?"]);
}

#[test]
fn references_among_inputs_and_outputs_are_checked() {
    one("actuator = \"motor\"", "actuator = \"moter\"", &["controller 'loop'", "'moter'", "did you mean 'motor'?"]);
    one("position_sensor = \"angle\"", "position_sensor = \"angel\"", &["'angel'", "did you mean 'angle'?"]);
    one("position_sensor = \"angle\"", "position_sensor = \"gyro\"", &["'gyro'", "reads rad/s"]);
    one("source = \"imu\"", "source = \"ium\"", &["source 'ium'", "imu"]);
    one("point = \"panel:tip\"", "point = \"panel:tup\"", &["'tup'", "did you mean 'tip'?"]);
    one("point = \"panel:tip\"", "point = \"pannel:tip\"", &["'pannel'", "did you mean 'panel'?"]);
    one("joint = \"rail\"", "joint = \"hub\"", &["actuator 'pusher'", "'hub' is neither"]);
}

#[test]
fn a_circle_of_bodies_is_printed() {
    let from = "joint = { kind = \"free\" }";
    let to = "joint = { kind = \"fixed\" }\nparent = \"slider\"";
    one(from, to, &["hub → slider → link_1 → hub"]);
}

#[test]
fn names_stand_once() {
    let errors = errors_with("name = \"loop\"", "name = \"motor\"");
    let line = line_of(PLANT, "name = \"loop\"");
    check_one(&errors, line, &["'motor' is given twice", "actuator 'motor'", "controller 'motor'"]);
    // a joint's name counts; the later of the two is reported
    let errors = errors_with("name = \"imu\"\nclock", "name = \"rail\"\nclock");
    let error = errors
        .iter()
        .find(|error| error.message.contains("'rail' is given twice"))
        .unwrap_or_else(|| panic!("{}", shown(&errors)));
    assert!(
        error.message.contains("the joint of body 'slider'") && error.line == line_of(PLANT, "name = \"imu\""),
        "{error}"
    );
}

#[test]
fn vectors_have_their_length_and_directions_are_not_zero() {
    one("com = [\"1.9 m\", 0]", "com = [\"1.9 m\", 0, 0, 0]", &["com of body 'link_1' has 4 numbers, not 2"]);
    one("com = [\"1.9 m\", 0]", "com = [\"1.9 m\", 0, \"1 m\"]", &["com of body 'link_1' has z = 1 in a planar plant"]);
    one("axis = [3, 4]", "axis = [0, 0]", &["axis of joint of body 'slider'", "zero"]);
    one("axis = [3, 4]", "axis = [3, 4, 5, 6]", &["axis of joint of body 'slider'", "has 4 numbers"]);
    one("axis = [3, 4]", "axis = \"z\"", &["axis", "points out of the plane"]);
    one(
        "stiffness = \"0.16 N/m\"",
        "stiffness = [\"1 N/m\", \"2 N/m\"]",
        &["stiffness of tank 'fuel' has 2 numbers", "one for each axis"],
    );
}

#[test]
fn every_point_moves_in_every_mode() {
    one("shape = { root = [0, 0], tip", "shape = { tip", &["shape of mode 'bending'", "lacks 'root'"]);
}

#[test]
fn a_joint_whose_motion_is_imposed_has_one_driver() {
    let errors =
        errors_with("kind = \"joint_torque\"\njoint = \"shoulder\"", "kind = \"joint_torque\"\njoint = \"rail\"");
    let error =
        errors.iter().find(|error| error.message.contains("imposed")).unwrap_or_else(|| panic!("{}", shown(&errors)));
    assert_eq!(error.line, line_of(PLANT, "joint = \"rail\""));
    assert!(["'rail'", "'motor'", "'pusher'"].iter().all(|word| error.message.contains(word)), "{error}");
}

#[test]
fn only_a_body_without_parent_is_free() {
    let errors = errors_with("kind = \"revolute\"", "kind = \"free\"");
    let error = errors.iter().find(|error| error.message.contains("carried by another and free"));
    let error = error.unwrap_or_else(|| panic!("{}", shown(&errors)));
    assert_eq!(error.line, line_of(PLANT, "kind = \"revolute\""));
    assert!(error.message.contains("'link_1'") && error.cure.contains("revolute"), "{error}");
}

#[test]
fn a_value_beyond_what_is_plausible_is_a_warning() {
    let text = PLANT.replace("force = \"0.2 N*m\"", "force = \"200000 N*m\"");
    let warnings = parse("test.toml", &text).unwrap().warnings;
    check_one(&warnings, line_of(&text, "200000 N*m"), &["force = 200000", "joint_coulomb", "plausible"]);
    assert_eq!(parse("test.toml", PLANT).unwrap().warnings, []);
}

#[test]
fn what_is_no_toml_is_said_with_its_line() {
    let errors = errors_with("mass = \"28.7 kg\"", "mass = 28.7 kg");
    assert_eq!(errors[0].line, line_of(PLANT, "28.7 kg"), "{}", shown(&errors));
    assert!(errors[0].cure.contains("TOML"));
}

#[test]
fn six_different_faults_are_six_reports_in_the_order_of_the_text() {
    let mut text = PLANT.to_owned();
    let faults = [
        ("mass = \"400 kg\"", "mass = \"-400 kg\""),
        ("parent = \"link_1\"", "parent = \"link_2\""),
        ("stiffness = \"0.16 N/m\"", "stiffness = \"3 kg\""),
        ("damping_ratio = 0.005", "damping = 0.005"),
        ("kind = \"encoder\"", "kind = \"encodr\""),
        ("site = \"joint:shoulder\"", "site = \"joint:elbow\""),
    ];
    for (from, to) in faults {
        text = text.replacen(from, to, 1);
    }
    let errors = parse("test.toml", &text).unwrap_err();
    assert_eq!(errors.len(), 6, "{}", shown(&errors));
    for (error, (_, to)) in errors.iter().zip(faults) {
        assert_eq!(error.line, line_of(&text, to), "{error}");
    }
}

/// No text may bring the reader down: every prefix of a plant, and every plant with one line left
/// out.
#[test]
fn no_text_makes_the_reader_panic() {
    for end in (0..PLANT.len()).step_by(7) {
        let _ = parse("test.toml", &PLANT[..end]);
    }
    let lines: Vec<&str> = PLANT.lines().collect();
    for left_out in 0..lines.len() {
        let text: Vec<&str> = lines.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, line)| *line).collect();
        let _ = parse("test.toml", &text.join("\n"));
        for other in ["= 0", "= -1", "= \"\"", "= []", "= {}", "= true", "= \"1 1 1\"", "= [[[]]]", "= 1979-05-27"] {
            let broken: Vec<String> = lines
                .iter()
                .enumerate()
                .map(|(i, line)| {
                    if i == left_out && line.contains(" = ") {
                        format!("{} {other}", line.split(" = ").next().unwrap())
                    } else {
                        (*line).to_owned()
                    }
                })
                .collect();
            if let Err(errors) = parse("test.toml", &broken.join("\n")) {
                assert!(!errors.is_empty());
            }
        }
    }
}
