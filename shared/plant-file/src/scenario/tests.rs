//! Numbers of a scenario, and what follows from them.

use super::Scenario;

mod reading;

const WHOLE: &str = r#"
format = 1
name = "toy"
[modal]
duration_s = 60
torque_nm = 1
pulse_s = 1
need.sigma_percent.f1 = 1
[slosh]
duration_s = 60
plant.file = "tank_1d"
known.m_0_kg = 300
need.held_out_rms = 0.001
[inertial]
duration_s = 60
trajectory = "b"
known = { h_cm_nms = -0.5, prior = [1, 2, 3, 4, 5, 6, 7, 8] }
[mated]
duration_s = 60
trajectory = "mated"
plant.file = "mated"
grasps = "target"
known = { h_cm_nms = 0.5, prior = [1, 2, 3, 4, 5, 6, 7, 8, 9] }
"#;

fn whole() -> Scenario {
    toml::from_str(WHOLE).unwrap()
}

fn keys(change: impl FnOnce(&mut Scenario)) -> Vec<String> {
    let mut scenario = whole();
    change(&mut scenario);
    scenario.impossible_numbers().into_iter().map(|impossible| impossible.key).collect()
}

#[test]
fn a_possible_scenario_has_no_impossible_number() {
    assert_eq!(whole().impossible_numbers(), []);
}

#[test]
fn every_impossible_number_is_listed_with_its_key_all_at_once() {
    let found = keys(|scenario| {
        scenario.format = 2;
        scenario.frame_period_ms = 0;
        scenario.window_frames = 0;
        let modal = scenario.modal.as_mut().unwrap();
        modal.duration_s = -1.0;
        modal.torque_nm = f64::NAN;
        modal.known.accelerometer_sigma_m_s2 = 0.0;
        modal.need.sigma_percent.insert("f1".into(), -1.0);
        let slosh = scenario.slosh.as_mut().unwrap();
        slosh.known.m_0_kg = 0.0;
        slosh.need.held_out_rms = Some(0.0);
        scenario.inertial.as_mut().unwrap().known.prior.pop();
        let mated = scenario.mated.as_mut().unwrap();
        mated.known.h_cm_nms = 0.0;
    });
    let expected = [
        "format",
        "frame_period_ms",
        "window_frames",
        "modal.duration_s",
        "modal.known.accelerometer_sigma_m_s2",
        "modal.torque_nm",
        "modal.need.sigma_percent.f1",
        "slosh.known.m_0_kg",
        "slosh.need.held_out_rms",
        "inertial.known.prior",
        "mated.known.h_cm_nms",
    ];
    assert_eq!(found, expected);
}

#[test]
fn an_impossible_number_says_its_value_and_why() {
    let mut scenario = whole();
    scenario.slosh.as_mut().unwrap().known.m_0_kg = -3.5;
    let found = scenario.impossible_numbers();
    assert_eq!((found[0].value.as_str(), found[0].why.as_str()), ("-3.5", "must be a finite number above 0"));
}

/// TOML knows `nan` and `inf`; an estimator with one of them gives no number at all.
#[test]
fn no_number_can_be_nan_unnoticed() {
    let mut unnoticed = Vec::new();
    let mut check = |key: &str, change: &dyn Fn(&mut Scenario)| {
        if keys(change).is_empty() {
            unnoticed.push(key.to_string());
        }
    };
    check("modal.pulse_s", &|s| s.modal.as_mut().unwrap().pulse_s = f64::NAN);
    check("modal.known.rate_hz", &|s| s.modal.as_mut().unwrap().known.rate_hz = f64::NAN);
    check("modal.known.band_hz", &|s| s.modal.as_mut().unwrap().known.band_hz = Some([f64::NAN, 1.0]));
    check("modal.known.expected", &|s| s.modal.as_mut().unwrap().known.expected = vec![[f64::NAN, 0.1]]);
    check("slosh.force_amplitude_n", &|s| s.slosh.as_mut().unwrap().force_amplitude_n = f64::NAN);
    check("slosh.force_frequency_hz", &|s| s.slosh.as_mut().unwrap().force_frequency_hz = f64::NAN);
    check("inertial.known.prior", &|s| s.inertial.as_mut().unwrap().known.prior[0] = f64::NAN);
    check("inertial.known.h_cm_sigma_nms", &|s| s.inertial.as_mut().unwrap().known.h_cm_sigma_nms = f64::NAN);
    check("inertial.known.joint_rate_sigma_rad_s", &|s| {
        s.inertial.as_mut().unwrap().known.joint_rate_sigma_rad_s = f64::NAN;
    });
    check("inertial.known.joint_angle_sigma_rad", &|s| {
        s.inertial.as_mut().unwrap().known.joint_angle_sigma_rad = f64::NAN;
    });
    check("capture.settle_s", &|s| s.capture.settle_s = f64::NAN);
    check("capture.contact_timeout_s", &|s| s.capture.contact_timeout_s = f64::NAN);
    check("capture.model_age_limit_s", &|s| s.capture.model_age_limit_s = f64::NAN);
    check("capture.base_rate_limit_rad_s", &|s| s.capture.base_rate_limit_rad_s = f64::NAN);
    assert_eq!(unnoticed, Vec::<String>::new());
}

#[test]
fn every_plant_is_listed_with_the_experiment_it_belongs_to() {
    let mut scenario = whole();
    let plants: Vec<(&str, String)> = scenario.plants_mut().map(|(name, plant)| (name, plant.file.clone())).collect();
    assert_eq!(plants, [("slosh", "tank_1d".to_string()), ("mated", "mated".to_string())]);
}

#[test]
fn seconds_become_the_nearest_number_of_frames() {
    let scenario = whole();
    assert_eq!(scenario.period_ns(), 10_000_000);
    assert_eq!([0.0, 0.004, 0.006, 1.0, 60.0].map(|seconds| scenario.frames(seconds)), [0, 0, 1, 100, 6000]);
}
