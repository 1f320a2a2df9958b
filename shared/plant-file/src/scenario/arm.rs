//! Experiments with an arm, before and after capture, and what is known of arm and target.

use super::{Need, PlantUse};
use serde::Deserialize;

/// Joint trajectory of an arm experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trajectory {
    B,
    Mated,
}

/// Arm experiment: free-floating base, joints on a reference trajectory (BP1A, mated).
#[derive(Clone, Debug, PartialEq, Deserialize)]
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

/// Prior knowledge of the inertial estimator.
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
    /// Systematic errors that the data sheets of the sensors allow.
    #[serde(default)]
    pub sheet: SheetSigmas,
    /// After capture: what is known of the arm itself; with it the parameters of the target are
    /// identified.
    #[serde(default)]
    pub chaser: Option<ChaserSheet>,
    /// What a cooperative target states of itself.
    #[serde(default)]
    pub target: Option<TargetStatement>,
}

/// One sigma of each systematic error of gyro and joint sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
