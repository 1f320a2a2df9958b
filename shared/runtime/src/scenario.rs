//! A scenario: what is simulated or known, how it is excited, what the identified model is needed for.
//!
//! Files are TOML with `format = 1`; units are in the keys. Each experiment is simulated on a plant of its own (`plant`, read
//! by `sensor-sim` alone) and states what the estimators are told (`known`) and what they must reach (`need`).

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the supervisor accepts a model for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Need {
    /// Per parameter: largest acceptable standard deviation [% of the estimate].
    pub sigma_percent: BTreeMap<String, f64>,
    /// Largest acceptable rms error of a simulation over held-out data (rad/s for inertial, else m/s^2).
    pub held_out_rms: Option<f64>,
}

/// The plant that an experiment is simulated on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantUse {
    /// A plant file, relative to the scenario's folder, or the name of one that comes with the program.
    pub file: String,
    /// Numbers that differ from the file's: name and value with unit.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// Effects that the plant carries and no estimator is told of: `KIND@SITE name=value …`.
    #[serde(default)]
    pub hide: Vec<String>,
    /// The file's text, filled in where the scenario is read: a partition opens no files.
    #[serde(default)]
    pub text: String,
}

/// Joint trajectory of an arm experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trajectory {
    B,
    Mated,
}

/// Arm experiment: free-floating base, joints on a reference trajectory (BP1A, mated).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmExperiment {
    pub duration_s: f64,
    pub trajectory: Trajectory,
    #[serde(default)]
    pub plant: Option<PlantUse>,
    /// Body of the plant that is there only after the grasp.
    #[serde(default)]
    pub grasps: Option<String>,
    pub known: ArmKnown,
    #[serde(default)]
    pub need: Need,
}

/// What the inertial estimator is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmKnown {
    /// System angular momentum about the system's centre of mass.
    pub h_cm_nms: f64,
    #[serde(default)]
    pub h_cm_sigma_nms: f64,
    /// Prior of the inertial parameters; the estimator starts here.
    pub prior: Vec<f64>,
    #[serde(default = "default_gyro_arw")]
    pub gyro_arw_deg_sqrt_h: f64,
    #[serde(default = "default_joint_rate")]
    pub joint_rate_sigma_rad_s: f64,
    #[serde(default = "default_joint_angle")]
    pub joint_angle_sigma_rad: f64,
    /// Of one sample of a joint's torque; without it torques are not used.
    #[serde(default)]
    pub joint_torque_sigma_nm: Option<f64>,
    /// Of the torque sensors' common scale, relative.
    #[serde(default)]
    pub joint_torque_scale_sigma: f64,
    /// Sigma of the prior over its value; without it the prior is a number to start from.
    #[serde(default)]
    pub prior_relative_sd: Option<f64>,
    /// Systematic errors that the sensors' sheets allow.
    #[serde(default)]
    pub sheet: SheetSigmas,
    /// After capture: what is known of the arm itself; with it the target's own numbers are found.
    #[serde(default)]
    pub chaser: Option<ChaserSheet>,
    /// What a cooperative target states of itself.
    #[serde(default)]
    pub target: Option<TargetStatement>,
}

/// One sigma of each systematic error of gyro and joint sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SheetSigmas {
    pub gyro_bias_rad_s: f64,
    /// Misalignment included.
    pub gyro_scale: f64,
    pub joint_rate_scale: f64,
    pub joint_zero_rad: f64,
    /// Of the gyro behind the joints.
    pub latency_s: f64,
}

/// The arm's data sheet: base, link 1, link 2; masses and inertias with relative sigmas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChaserSheet {
    pub mass_kg: [f64; 3],
    pub mass_relative_sd: [f64; 3],
    pub inertia_kg_m2: [f64; 3],
    pub inertia_relative_sd: [f64; 3],
    /// Base's centre of mass to joint 1.
    pub shoulder_m: [f64; 2],
    /// Inboard joint to centre of mass.
    pub joint_to_com_m: [f64; 2],
    /// Sigma of the lengths above.
    pub length_sd_m: f64,
    /// Joint 1 to joint 2, from the drawing.
    pub link_1_length_m: f64,
    pub link_1_length_sd_m: f64,
    /// Joint 2 to the grasp point.
    pub grasp_m: f64,
    #[serde(default)]
    pub grasp_sd_m: f64,
}

/// Mass properties as a target states them, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetStatement {
    pub mass_kg: f64,
    pub com_m: [f64; 2],
    pub inertia_kg_m2: f64,
    /// Of mass, centre of mass x, y, inertia.
    pub sigma: [f64; 4],
    /// Where the grasp point lies in the target's frame, and how the grasp frame is turned in it.
    pub grasp_position_m: [f64; 2],
    pub grasp_angle_rad: f64,
    #[serde(default)]
    pub epoch_s: f64,
    /// CRC-32 of the statement as received; without it none is checked.
    #[serde(default)]
    pub crc32: Option<u32>,
}

const fn default_gyro_arw() -> f64 {
    0.09
}
const fn default_joint_rate() -> f64 {
    1e-4
}
const fn default_joint_angle() -> f64 {
    1.25e-5
}

/// Slosh experiment on one axis (BP2, 1-D).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SloshExperiment {
    pub duration_s: f64,
    #[serde(default)]
    pub force_amplitude_n: f64,
    #[serde(default)]
    pub force_frequency_hz: f64,
    #[serde(default)]
    pub plant: Option<PlantUse>,
    pub known: SloshKnown,
    #[serde(default)]
    pub need: Need,
}

/// What the slosh estimator is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SloshKnown {
    /// Mass of hub without slosh mass.
    pub m_0_kg: f64,
    /// Axis of force and acceleration.
    #[serde(default)]
    pub axis: Axis,
    #[serde(default = "default_vrw")]
    pub accelerometer_vrw_m_s_sqrt_h: f64,
    #[serde(default = "default_slosh_interval")]
    pub interval_s: f64,
    /// Tank expected before the experiment, `[m_s, k_s, c_s]`: its outcome is predicted from it.
    #[serde(default)]
    pub expected: Option<[f64; 3]>,
    /// Standard deviations of `expected`: it is then a prior, and the estimate says what the record did to each number.
    #[serde(default)]
    pub expected_sigma: Option<[f64; 3]>,
    /// The slosh mass is at rest when the experiment begins. Unless stated: yes in a simulation, which starts so; not
    /// known in a recording.
    #[serde(default)]
    pub starts_at_rest: Option<bool>,
}

/// Body axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    #[default]
    X,
    Y,
    Z,
}

impl Axis {
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

const fn default_vrw() -> f64 {
    0.008
}
const fn default_slosh_interval() -> f64 {
    0.1
}

/// Modal experiment: torque pulse, then free decay (BP3A); or an operational record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModalExperiment {
    pub duration_s: f64,
    #[serde(default)]
    pub torque_nm: f64,
    #[serde(default)]
    pub pulse_s: f64,
    #[serde(default)]
    pub plant: Option<PlantUse>,
    #[serde(default)]
    pub known: ModalKnown,
    #[serde(default)]
    pub need: Need,
}

/// What the modal estimator is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModalKnown {
    /// White noise of one accelerometer sample.
    pub accelerometer_sigma_m_s2: f64,
    /// Nominal sample rate; 0: taken from the data.
    pub rate_hz: f64,
    /// Modes expected before the experiment, from which its outcome is predicted: `[f_hz, zeta]`.
    pub expected: Vec<[f64; 2]>,
    /// Typical amplitude of the decay, for the same prediction.
    pub expected_amplitude_m_s2: f64,
    /// Band of interest.
    pub band_hz: Option<[f64; 2]>,
    /// Channels used, all when empty (numbered from 1).
    pub channels: Vec<usize>,
    /// Hub and appendage by analysis: with it the inertia about the hub's axis follows from the modes.
    pub appendage: Option<AppendageKnown>,
}

/// A hub with one flexible appendage, about its axis; of a body that floats, about its centre of mass with the translation free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AppendageKnown {
    /// Of the whole with the appendage undeformed, as the mass-property sheet says, and the sheet's relative sigma (0: none is stated).
    pub inertia_kg_m2: f64,
    #[serde(default)]
    pub inertia_relative_sd: f64,
    /// Momentum of each unit mode about the axis, and the relative sigma that they share.
    pub coupling_sqrt_kg_m: [f64; 2],
    #[serde(default)]
    pub coupling_relative_sd: f64,
    /// Modes with the rotation held fast, `[f_hz, zeta]`: their ratio is that of the geometry, the rest is found.
    pub locked: [[f64; 2]; 2],
    /// Joint angles of the arm during the modal experiment, if that is the body which the arm's experiment weighs: the two
    /// inertias are then compared. Without it they are of separate bodies.
    #[serde(default)]
    pub arm_angle_rad: Option<[f64; 2]>,
}

impl ModalKnown {
    /// Channels used of `available`, numbered from 0; empty when a stated one does not exist.
    #[must_use]
    pub fn channels_of(&self, available: usize) -> Vec<usize> {
        if self.channels.is_empty() {
            return (0..available).collect();
        }
        let exist = self.channels.iter().all(|channel| (1..=available).contains(channel));
        if exist { self.channels.iter().map(|channel| channel - 1).collect() } else { Vec::new() }
    }
}

impl Default for ModalKnown {
    fn default() -> Self {
        ModalKnown {
            accelerometer_sigma_m_s2: 3.10e-4,
            rate_hz: 0.0,
            expected: Vec::new(),
            expected_amplitude_m_s2: 0.0,
            band_hz: None,
            channels: Vec::new(),
            appendage: None,
        }
    }
}

/// What happens between pre-capture and mated identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CapturePlan {
    /// Capture is part of the plan.
    pub enabled: bool,
    /// Settling time after contact.
    pub settle_s: f64,
    /// Longest time to wait for contact.
    pub contact_timeout_s: f64,
    /// Oldest accepted model with which capture is allowed.
    pub model_age_limit_s: f64,
    /// Largest base rate with which an experiment may start.
    pub base_rate_limit_rad_s: f64,
    /// The operator takes responsibility for capture without accepted models.
    pub operator_override: bool,
}

impl Default for CapturePlan {
    fn default() -> Self {
        CapturePlan {
            enabled: false,
            settle_s: 5.0,
            contact_timeout_s: 20.0,
            model_age_limit_s: 7200.0,
            base_rate_limit_rad_s: 1.0,
            operator_override: false,
        }
    }
}

/// A scenario file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Version of this format.
    pub format: u32,
    pub name: String,
    #[serde(default = "default_frame_period")]
    pub frame_period_ms: u64,
    #[serde(default = "default_seed")]
    pub seed: u64,
    #[serde(default = "default_window")]
    pub window_frames: u64,
    #[serde(default)]
    pub modal: Option<ModalExperiment>,
    #[serde(default)]
    pub slosh: Option<SloshExperiment>,
    #[serde(default)]
    pub inertial: Option<ArmExperiment>,
    #[serde(default)]
    pub capture: CapturePlan,
    #[serde(default)]
    pub mated: Option<ArmExperiment>,
}

const fn default_frame_period() -> u64 {
    10
}
const fn default_seed() -> u64 {
    1
}
const fn default_window() -> u64 {
    100
}

impl Scenario {
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.frame_period_ms * 1_000_000
    }

    /// The plants of the experiments, by the experiment's name.
    pub fn plants_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut PlantUse)> {
        let modal = self.modal.as_mut().and_then(|modal| modal.plant.as_mut());
        let slosh = self.slosh.as_mut().and_then(|slosh| slosh.plant.as_mut());
        let inertial = self.inertial.as_mut().and_then(|arm| arm.plant.as_mut());
        let mated = self.mated.as_mut().and_then(|arm| arm.plant.as_mut());
        let all = [("modal", modal), ("slosh", slosh), ("inertial", inertial), ("mated", mated)];
        all.into_iter().filter_map(|(name, plant)| plant.map(|plant| (name, plant)))
    }

    /// Frames in `seconds`, rounded to the nearest.
    #[must_use]
    pub fn frames(&self, seconds: f64) -> u64 {
        (seconds * 1000.0 / self.frame_period_ms as f64).round() as u64
    }

    /// Numbers that no physical system can have, as `key: value: why`.
    #[must_use]
    pub fn impossible_numbers(&self) -> Vec<Impossible> {
        let mut found = Impossibles(Vec::new());
        found.integer("format", self.format.into(), self.format == 1, "this build reads format 1");
        found.integer(
            "frame_period_ms",
            self.frame_period_ms,
            (1..=1000).contains(&self.frame_period_ms),
            "must be 1 to 1000",
        );
        found.integer("window_frames", self.window_frames, self.window_frames > 0, "must be at least 1");
        if let Some(modal) = &self.modal {
            found.positive("modal.duration_s", modal.duration_s);
            found.positive("modal.known.accelerometer_sigma_m_s2", modal.known.accelerometer_sigma_m_s2);
            found.finite("modal.torque_nm", modal.torque_nm);
            found.finite("modal.pulse_s", modal.pulse_s);
            found.finite("modal.known.rate_hz", modal.known.rate_hz);
            found.finite("modal.known.expected_amplitude_m_s2", modal.known.expected_amplitude_m_s2);
            modal.known.band_hz.iter().flatten().for_each(|&edge| found.finite("modal.known.band_hz", edge));
            modal.known.expected.iter().flatten().for_each(|&number| found.finite("modal.known.expected", number));
            found.need("modal", &modal.need);
        }
        if let Some(slosh) = &self.slosh {
            found.positive("slosh.duration_s", slosh.duration_s);
            found.finite("slosh.force_amplitude_n", slosh.force_amplitude_n);
            found.finite("slosh.force_frequency_hz", slosh.force_frequency_hz);
            found.positive("slosh.known.m_0_kg", slosh.known.m_0_kg);
            found.positive("slosh.known.interval_s", slosh.known.interval_s);
            found.positive("slosh.known.accelerometer_vrw_m_s_sqrt_h", slosh.known.accelerometer_vrw_m_s_sqrt_h);
            found.need("slosh", &slosh.need);
        }
        for (name, arm, count) in [("inertial", &self.inertial, 8), ("mated", &self.mated, 9)] {
            let Some(arm) = arm else { continue };
            found.positive(&format!("{name}.duration_s"), arm.duration_s);
            found.positive(&format!("{name}.known.h_cm_nms"), arm.known.h_cm_nms.abs());
            found.positive(&format!("{name}.known.gyro_arw_deg_sqrt_h"), arm.known.gyro_arw_deg_sqrt_h);
            found.finite(&format!("{name}.known.h_cm_sigma_nms"), arm.known.h_cm_sigma_nms);
            found.finite(&format!("{name}.known.joint_rate_sigma_rad_s"), arm.known.joint_rate_sigma_rad_s);
            found.finite(&format!("{name}.known.joint_angle_sigma_rad"), arm.known.joint_angle_sigma_rad);
            arm.known.prior.iter().for_each(|&number| found.finite(&format!("{name}.known.prior"), number));
            let given = arm.known.prior.len();
            found.integer(
                &format!("{name}.known.prior"),
                given as u64,
                given == count,
                &format!("needs {count} numbers, a1 to a{count}"),
            );
            found.need(name, &arm.need);
        }
        let capture = &self.capture;
        found.finite("capture.settle_s", capture.settle_s);
        found.finite("capture.contact_timeout_s", capture.contact_timeout_s);
        found.finite("capture.model_age_limit_s", capture.model_age_limit_s);
        found.finite("capture.base_rate_limit_rad_s", capture.base_rate_limit_rad_s);
        found.0
    }
}

/// A number in a scenario that cannot be.
#[derive(Clone, Debug, PartialEq)]
pub struct Impossible {
    /// Dotted key.
    pub key: String,
    pub value: String,
    pub why: String,
}

struct Impossibles(Vec<Impossible>);

impl Impossibles {
    fn add(&mut self, key: &str, value: String, why: &str) {
        self.0.push(Impossible { key: key.into(), value, why: why.into() });
    }
    fn integer(&mut self, key: &str, value: u64, good: bool, why: &str) {
        if !good {
            self.add(key, value.to_string(), why);
        }
    }
    fn positive(&mut self, key: &str, value: f64) {
        if !(value.is_finite() && value > 0.0) {
            self.add(key, value.to_string(), "must be a finite number above 0");
        }
    }
    fn finite(&mut self, key: &str, value: f64) {
        if !value.is_finite() {
            self.add(key, value.to_string(), "must be finite");
        }
    }
    fn need(&mut self, experiment: &str, need: &Need) {
        for (name, &percent) in &need.sigma_percent {
            self.positive(&format!("{experiment}.need.sigma_percent.{name}"), percent);
        }
        if let Some(rms) = need.held_out_rms {
            self.positive(&format!("{experiment}.need.held_out_rms"), rms);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Scenario;

    const WHOLE: &str = r#"{
        "format": 1, "name": "toy", "frame_period_ms": 10,
        "modal": {"duration_s": 60, "torque_nm": 1, "pulse_s": 1, "need": {"sigma_percent": {"f1": 1}}},
        "slosh": {"duration_s": 60, "plant": {"file": "tank_1d"}, "known": {"m_0_kg": 300},
            "need": {"held_out_rms": 0.001}},
        "inertial": {"duration_s": 60, "trajectory": "b", "known": {"h_cm_nms": -0.5, "prior": [1,2,3,4,5,6,7,8]}},
        "mated": {"duration_s": 60, "trajectory": "mated", "known": {"h_cm_nms": 0.5, "prior": [1,2,3,4,5,6,7,8,9]},
            "plant": {"file": "mated"}, "grasps": "target"}
    }"#;

    fn whole() -> Scenario {
        serde_json::from_str(WHOLE).unwrap()
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

    /// TOML knows `nan` and `inf`; the run's configuration, which is JSON, does not: partitions could not read it.
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
        let plants: Vec<(&str, String)> =
            scenario.plants_mut().map(|(name, plant)| (name, plant.file.clone())).collect();
        assert_eq!(plants, [("slosh", "tank_1d".to_string()), ("mated", "mated".to_string())]);
    }

    #[test]
    fn seconds_become_the_nearest_number_of_frames() {
        let scenario = whole();
        assert_eq!(scenario.period_ns(), 10_000_000);
        assert_eq!([0.0, 0.004, 0.006, 1.0, 60.0].map(|seconds| scenario.frames(seconds)), [0, 0, 1, 100, 6000]);
    }
}
