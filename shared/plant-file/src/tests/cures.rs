//! Habits of other programs and countries: the report says what to write.

use super::{PLANT, errors_with, line_of, parse, plant, shown};
use dynamics::description::Quantity;

fn one(from: &str, to: &str, words: &[&str]) {
    let errors = errors_with(from, to);
    assert_eq!(errors.len(), 1, "{}", shown(&errors));
    let text = errors[0].to_string();
    assert!(words.iter().all(|word| text.contains(word)), "{words:?} are not in: {text}");
}

#[test]
fn foreign_ways_of_writing_units_are_translated() {
    let mass = "mass = \"28.7 kg\"";
    for (written, cure) in
        [("10,5 kg", "\"10.5 kg\""), ("−3 kg", "\"-3 kg\""), ("10 t", "1000 kg"), ("3 kilogrammes", "'kilograms'")]
    {
        one(mass, &format!("mass = \"{written}\""), &["tank 'fuel'", cure]);
    }
}

#[test]
fn units_of_other_programs_mean_what_they_mean_in_a_recording() {
    for written in ["66.7 kg*m**2", "66.7 kg m2", "66.7 kgm2", "66.7 kg.m^2", "66.7 kg-m²"] {
        let inertia = PLANT.replace("66.7 kg*m^2", written);
        assert_eq!(plant(&inertia), plant(PLANT), "{written}");
    }
    assert_eq!(plant(&PLANT.replace("0.1 N*m*s/rad", "0.1 N.m.s/rad")), plant(PLANT));
    for (written, kg) in [("10 lb", 4.535_923_7), ("3 kilograms", 3.0), ("2 slugs", 29.187_805_874_412_8)] {
        let mass = plant(&PLANT.replace("mass = \"28.7 kg\"", &format!("mass = \"{written}\"")));
        let found = mass.parameters().into_iter().find(|parameter| parameter.name == "fuel.mass").unwrap().value;
        assert!((found - kg).abs() < 1e-12, "{written}: {found}");
    }
}

#[test]
fn a_gyro_noise_as_the_density_of_an_angle_is_explained() {
    one(
        "noise = \"0.09 deg/sqrt(h)\"",
        "noise = \"0.1 deg/sqrt(Hz)\"",
        &["sensor 'gyro'", "deg/s/sqrt(Hz)", "deg/sqrt(h)"],
    );
}

#[test]
fn a_share_of_zero_is_no_sigma() {
    let text = PLANT.replace("com = [\"1.9 m\", 0]", "com = { value = [\"1.9 m\", 0], sigma = \"10 %\" }");
    assert_eq!(plant(&text).bodies[1].com_m[..2], [Quantity::with_prior(1.9, 0.19), Quantity::known(0.0)]);
    one("com = [\"1.9 m\", 0]", "com = { value = [0, 0], sigma = \"1 %\" }", &["1 % of 0 is 0", "absolute sigma"]);
    one("com = [\"1.9 m\", 0]", "com = { value = [\"1 m\", 0], sigma = [\"1 %\", \"1 %\"] }", &["1 % of 0 is 0"]);
    one("mass = \"28.7 kg\"", "mass = { value = 0, sigma = \"1 %\" }", &["1 % of 0 is 0", "absolute sigma"]);
}

#[test]
fn tables_that_are_given_twice_are_called_so() {
    for (from, to, word) in [
        ("mass = \"28.7 kg\"", "mass = \"28.7 kg\"\nmass = \"2 kg\"", "mass"),
        ("[[tank]]", "[body]\nname = \"more\"\n[[tank]]", "body"),
    ] {
        let errors = errors_with(from, to);
        let text = errors[0].to_string();
        assert!(
            text.contains(&format!("'{word}'")) && text.contains("[[") && !text.contains("no TOML"),
            "{}",
            shown(&errors)
        );
    }
}

#[test]
fn reports_speak_of_the_sensor_of_the_text_not_of_its_channels() {
    let errors = errors_with("axis = \"xy\"", "axis = \"xy\"\ndelay = \"-1 s\"");
    assert_eq!(errors.len(), 1, "{}", shown(&errors));
    assert!(errors[0].message.contains("sensor 'tip' "), "{}", shown(&errors));
}

#[test]
fn two_things_of_one_kind_and_name_are_called_so() {
    one("name = \"gyro\"", "name = \"angle\"", &["more than one sensor is called 'angle'"]);
}

#[test]
fn names_that_exist_are_listed_once_and_in_the_plural() {
    let joint = "kind = \"joint_torque\"\njoint = \"shoulder\"";
    one(joint, &joint.replace("shoulder", "q"), &["known joints: shoulder, rail"]);
    one("body = \"hub\"\nkind = \"spring\"", "body = \"?\"\nkind = \"spring\"", &["known bodies: hub, link_1, slider"]);
}

#[test]
fn an_unknown_space_brings_no_other_report() {
    for to in ["space = \"cubic\"", ""] {
        one("space = \"planar\"", to, &["space"]);
    }
    let spatial = PLANT
        .replace("space = \"planar\"", "space = \"cubic\"")
        .replace("com = [\"1.9 m\", 0]", "com = [\"1.9 m\", 0, \"1 m\"]")
        .replace("inertia = \"66.7 kg*m^2\"", "inertia = [\"66.7 kg*m^2\", \"66.7 kg*m^2\", \"66.7 kg*m^2\"]");
    let errors = parse("test.toml", &spatial).unwrap_err();
    assert_eq!(errors.len(), 1, "{}", shown(&errors));
    let both = spatial.replace("mass = \"28.7 kg\"", "mass = \"-28.7 kg\"");
    let errors = parse("test.toml", &both).unwrap_err();
    assert!(errors.len() == 2 && errors[1].line == line_of(&both, "-28.7 kg"), "{}", shown(&errors));
}

#[test]
fn a_warning_has_the_unit_of_its_site() {
    let text = PLANT.replace("force = \"0.2 N*m\"", "force = \"200000 N*m\"");
    let warnings = parse("test.toml", &text).unwrap().warnings;
    assert!(warnings[0].message.contains("200000 N*m") && !warnings[0].message.contains("J/"), "{}", shown(&warnings));
}

#[test]
fn a_name_of_a_point_is_a_name() {
    let errors = errors_with("points = { root = [\"1 m\", 0]", "points = { \"ro.ot\" = [\"1 m\", 0]");
    assert!(errors.iter().any(|error| error.message.contains("'ro.ot' cannot name a point")), "{}", shown(&errors));
}

#[test]
fn an_axis_may_point_either_way_without_another_name() {
    let axes = |axes: &str| plant(&PLANT.replace("axis = \"y\"\nmass", &format!("axes = {axes}\nmass")));
    let names = |plant: dynamics::description::Plant| {
        let all = plant.parameters().into_iter().map(|parameter| parameter.name);
        all.filter(|name| name.starts_with("fuel.stiffness")).collect::<Vec<_>>()
    };
    assert_eq!(names(axes("[\"-x\", \"y\"]")), ["fuel.stiffness.x", "fuel.stiffness.y"]);
    assert_eq!(names(axes("[[1, 1], \"y\"]")), ["fuel.stiffness.1", "fuel.stiffness.2"]);
}

#[test]
fn defaults_of_an_effect_can_be_set_and_then_stand_in_it() {
    let mut plant = plant(PLANT);
    let name = "effect.joint_coulomb@joint:shoulder.smooth_rate";
    assert!(plant.parameters().iter().any(|parameter| parameter.name == name));
    plant.set_parameter(name, 0.25).unwrap();
    let force = ("force".to_owned(), Quantity::known(0.2));
    assert_eq!(plant.effects[0].values, [force, ("smooth_rate".to_owned(), Quantity::known(0.25))]);
}
