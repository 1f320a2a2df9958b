//! What would hang, overflow or be ignored, and what only the equations show: a report at its line.

use super::{PLANT, errors_with, line_of, parse, shown};

fn one(from: &str, to: &str, words: &[&str]) {
    let errors = errors_with(from, to);
    let text = PLANT.replacen(from, to, 1);
    assert_eq!(errors.len(), 1, "{}", shown(&errors));
    let said = errors[0].to_string();
    assert_eq!(errors[0].line, line_of(&text, to.lines().last().unwrap()), "{said}");
    assert!(!errors[0].cure.is_empty(), "no cure: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} are not in: {said}");
}

fn warned(from: &str, to: &str, words: &[&str]) {
    assert!(PLANT.contains(from), "'{from}' is not in the plant");
    let text = PLANT.replacen(from, to, 1);
    let warnings = parse("test.toml", &text).unwrap_or_else(|errors| panic!("{}", shown(&errors))).warnings;
    assert_eq!(warnings.len(), 1, "{}", shown(&warnings));
    assert_eq!(warnings[0].line, line_of(&text, to.lines().last().unwrap()), "{}", warnings[0]);
    let said = warnings[0].to_string();
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} are not in: {said}");
}

const SINE: &str = "command = { kind = \"sine\", amplitude = \"2 N*m\", frequency = \"0.1 Hz\" }";

#[test]
fn sizes_that_end_in_no_time_or_memory_are_refused() {
    let multisine = |last: &str| {
        format!("command = {{ kind = \"multisine\", rms = \"1 N*m\", period = \"1e9 s\", first = 1, last = {last} }}")
    };
    one(SINE, &multisine("4000000000"), &["4000000000 harmonics"]);
    one(SINE, &multisine("9000000000"), &["9000000000", "whole number"]);
    one("noise = \"12 urad\"", "noise = \"12 urad\"\ndelay = \"1e9 s\"", &["delay of sensor 'angle'", "unit"]);
    one("period = \"20 ms\"", "period = \"20 ns\"", &["period of sensor 'angle'", "microsecond"]);
    one("period = \"20 ms\"", "reading = \"mean\"\nperiod = \"1e9 s\"", &["mean of sensor 'angle'"]);
    one("period = \"10 ms\"", "period = \"10 ms\"\nstep = \"1 ns\"", &["steps"]);
    one("duration = \"5 s\"", "duration = \"1e9 s\"", &["samples", "shorter"]);
    let delay = "[[effect]]\nkind = \"sensor_delay\"\ndelay = \"1e9 s\"\nsite = \"sensor:angle\"\n[simulation]";
    let errors = errors_with("[simulation]", delay);
    assert!(errors[0].message.contains("delay of sensor 'angle'"), "{}", shown(&errors));
}

#[test]
fn what_is_possible_but_hardly_meant_is_warned_of() {
    warned("period = \"10 ms\"", "period = \"10 ms\"\nstep = \"20 ms\"", &["longer than its period"]);
    warned(SINE, &SINE.replace("0.1 Hz", "60 Hz"), &["60 Hz", "50 Hz"]);
    let multisine = "command = { kind = \"multisine\", rms = \"1 N*m\", period = \"1 s\", first = 1, last = 70 }";
    warned(SINE, multisine, &["70 Hz", "50 Hz"]);
    let thruster = "kind = \"thruster\"\nbody = \"hub\"\nposition = [0, 0]\ndirection = \"x\"\n";
    let jet = |command: &str| format!("[[actuator]]\nname = \"jet\"\n{thruster}command = {command}");
    let after = |text: String| format!("[[source]]\nname = \"clock\"\n{text}\n[[source]]\nname = \"imu\"");
    for command in [
        "{ kind = \"sine\", amplitude = \"1 N\", frequency = \"1 Hz\" }",
        "[{ kind = \"constant\", value = \"2 N\", end = \"1 s\" }, { kind = \"step\", size = \"-1 N\", begin = \"1 s\" }]",
    ] {
        let text = PLANT.replace("[[source]]\nname = \"imu\"", &after(jet(command)));
        let warnings = parse("test.toml", &text).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].message.contains("falls to -1 N"), "{}", shown(&warnings));
    }
    let offset =
        "[{ kind = \"constant\", value = \"2 N\" }, { kind = \"sine\", amplitude = \"1 N\", frequency = \"1 Hz\" }]";
    let text = PLANT.replace("[[source]]\nname = \"imu\"", &after(jet(offset)));
    assert_eq!(parse("test.toml", &text).unwrap().warnings, []);
}

#[test]
fn an_atmosphere_or_field_that_nothing_feels_is_warned_of() {
    for (stated, says) in [
        ("atmosphere = { density = \"1 kg/m^3\" }", "atmosphere"),
        ("magnetic_field = [\"1 uT\", 0]", "magnetic field"),
    ] {
        let to = format!("[environment]\n{stated}\n\n[[body]]\nname = \"hub\"");
        let text = PLANT.replacen("[[body]]\nname = \"hub\"", &to, 1);
        let warnings = parse("test.toml", &text).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].message.contains(says), "{}", shown(&warnings));
        assert_eq!(warnings[0].line, line_of(&text, stated));
    }
}

#[test]
fn an_imposed_motion_has_no_noise_range_controller_or_beginning() {
    let slew = "command = { kind = \"slew\", size = \"0.1 m\", width = \"5 s\" }";
    one(slew, &format!("{slew}\nnoise = \"1 mm\""), &["noise of actuator 'pusher'", "leave it out"]);
    one(slew, &format!("{slew}\nrange = \"1 m\""), &["range of actuator 'pusher'", "leave it out"]);
    let errors =
        errors_with("actuator = \"motor\"\nposition_sensor = \"angle\"\nkp = \"600 N*m/rad\"", "actuator = \"pusher\"");
    assert!(errors[0].message.contains("'pusher', which imposes a motion"), "{}", shown(&errors));
    one(
        "[initial]",
        "[initial]\n\"joint:rail\" = { position = \"1 m\" }",
        &["joint:rail", "'pusher' imposes its motion"],
    );
    one(
        "period = \"10 ms\"",
        "period = \"10 ms\"\nintegrator = \"exact_zero_order_hold\"",
        &["'pusher'", "runge_kutta_4"],
    );
}

#[test]
fn what_has_no_sensitive_axis_has_no_misalignment() {
    let misaligned = "misalignment = { axis = \"z\", angle = \"1 deg\" }";
    for (from, name) in [("kind = \"encoder\"", "angle"), ("kind = \"gyro\"", "gyro")] {
        let errors = errors_with(from, &format!("{from}\n{misaligned}"));
        assert_eq!(errors.len(), 1, "{}", shown(&errors));
        assert!(errors[0].message.contains(&format!("sensor '{name}' has no sensitive axis")), "{}", shown(&errors));
    }
    let names: Vec<String> = super::plant(PLANT).parameters().into_iter().map(|parameter| parameter.name).collect();
    let misalignments: Vec<&String> = names.iter().filter(|name| name.ends_with(".misalignment")).collect();
    assert_eq!(misalignments, ["tip_x.misalignment", "tip_y.misalignment"]);
}

#[test]
fn a_slosh_mass_has_independent_axes() {
    for axes in ["[\"y\", \"-y\"]", "[[1, 1], [2, 2]]"] {
        one("axis = \"y\"", &format!("axes = {axes}"), &["tank 'fuel'", "same direction"]);
    }
}

#[test]
fn segments_are_in_order_and_apart() {
    let two = |first: &str, second: &str| {
        format!("[[segment]]\nname = \"a\"\n{first}\n[[segment]]\nname = \"b\"\n{second}\n\n[simulation]")
    };
    for (first, second, at, word) in [
        ("begin = \"1 s\"\nend = \"3 s\"", "begin = \"2 s\"", "end = \"3 s\"", "after segment 'b' begins"),
        ("begin = \"3 s\"", "begin = \"2 s\"", "begin = \"2 s\"", "not after segment 'a'"),
        ("begin = \"-1 s\"", "begin = \"2 s\"", "begin = \"-1 s\"", "negative"),
    ] {
        let text = PLANT.replace("[simulation]", &two(first, second));
        let errors = parse("test.toml", &text).unwrap_err();
        assert_eq!((errors.len(), errors[0].line), (1, line_of(&text, at)), "{}", shown(&errors));
        assert!(errors[0].message.contains(word), "{}", shown(&errors));
    }
    let apart = PLANT.replace("[simulation]", &two("begin = \"1 s\"\nend = \"2 s\"", "begin = \"2 s\""));
    assert!(parse("test.toml", &apart).is_ok_and(|parsed| parsed.warnings.is_empty()));
}

const FREE: &str = r#"format = 1
name = "free"
space = "spatial"
[[body]]
name = "hub"
mass = "10 kg"
inertia = ["5 kg*m^2", "5 kg*m^2", "5 kg*m^2"]
joint = { kind = "free" }
[[body]]
name = "arm"
parent = "hub"
mass = "1 kg"
com = ["1 m", 0, 0]
inertia = ["0.1 kg*m^2", "0.1 kg*m^2", "0.1 kg*m^2"]
joint = { kind = "revolute", axis = "z" }
[[appendage]]
name = "panel"
body = "hub"
[[appendage.mode]]
name = "bending"
frequency = "1 Hz"
damping_ratio = 0.01
translation = [0, 0, "2 sqrt(kg)"]
[[actuator]]
name = "wheel"
kind = "wheel"
body = "hub"
axis = "x"
inertia = "1 kg*m^2"
"#;

/// Errors and warnings of the changed plant.
fn free(from: &str, to: &str) -> (Vec<super::FileError>, bool) {
    assert!(FREE.contains(from));
    match parse("test.toml", &FREE.replacen(from, to, 1)) {
        Ok(parsed) => (parsed.warnings, true),
        Err(errors) => (errors, false),
    }
}

#[test]
fn a_mode_or_wheel_that_takes_more_than_its_body_has_is_refused_at_its_line() {
    assert_eq!(free("2 sqrt(kg)", "3 sqrt(kg)").0, []);
    for (from, to, word) in [
        ("2 sqrt(kg)", "4 sqrt(kg)", "16 kg along z of its 10"),
        ("2 sqrt(kg)", "3.162277660168380 sqrt(kg)", "along z"),
        ("translation = [0, 0, \"2 sqrt(kg)\"]", "rotation = [0, \"9 sqrt(kg)*m\", 0]", "about y"),
        ("inertia = \"1 kg*m^2\"", "inertia = \"9 kg*m^2\"", "9 kg*m^2 about x"),
    ] {
        let (found, _) = free(from, to);
        assert_eq!(found.len(), 1, "{to}: {}", shown(&found));
        let text = FREE.replacen(from, to, 1);
        assert_eq!(found[0].line, line_of(&text, to), "{}", found[0]);
        assert!(found[0].message.contains(word), "{}", found[0]);
    }
    // without the arm to hold it, no equations
    let alone = FREE.replacen("2 sqrt(kg)", "4 sqrt(kg)", 1);
    let (begin, end) = (alone.find("[[body]]\nname = \"arm\"").unwrap(), alone.find("[[appendage]]").unwrap());
    let alone = format!("{}{}", &alone[..begin], &alone[end..]);
    let errors = parse("test.toml", &alone).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (1, line_of(&alone, "4 sqrt(kg)")), "{}", shown(&errors));
    // and beside an error elsewhere
    let errors = parse("test.toml", &format!("{alone}[simulation]\nduration = 0\n")).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (2, line_of(&alone, "4 sqrt(kg)")), "{}", shown(&errors));
}

#[test]
fn thin_rods_and_point_masses_are_bodies_where_something_else_turns_with_them() {
    let arm = "inertia = [\"0.1 kg*m^2\", \"0.1 kg*m^2\", \"0.1 kg*m^2\"]";
    for rod in ["inertia = [0, \"0.1 kg*m^2\", \"0.1 kg*m^2\"]", "inertia = [0, 0, 0]"] {
        assert_eq!(free(arm, rod), (Vec::new(), true), "{rod}");
    }
    let about_itself = |rod: &str| FREE.replacen(arm, rod, 1).replace("axis = \"z\"", "axis = \"x\"");
    let text = about_itself("inertia = [0, 0, 0]");
    let errors = parse("test.toml", &text).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (1, line_of(&text, "inertia = [0, 0, 0]")), "{}", shown(&errors));
    assert!(errors[0].message.contains("turns in joint 'arm'") && errors[0].cure.contains("thin rod"), "{}", errors[0]);
}

#[test]
fn a_hub_without_mass_is_refused_at_its_mass() {
    let text = "format = 1\nname = \"a\"\nspace = \"planar\"\n[[body]]\nname = \"hub\"\nmass = 0\ninertia = 0\njoint = { kind = \"free\" }\n[[body]]\nname = \"arm\"\nparent = \"hub\"\nmass = \"1 kg\"\ninertia = \"1 kg*m^2\"\njoint = { kind = \"revolute\" }\n";
    let errors = parse("test.toml", text).unwrap_err();
    assert_eq!((errors.len(), errors[0].line), (1, line_of(text, "mass = 0")), "{}", shown(&errors));
    assert!(errors[0].message.contains("body 'hub'"), "{}", errors[0]);
}
