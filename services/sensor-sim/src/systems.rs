//! From a scenario's truths to `plant`'s simulators. Each experiment has its own system, as in the benchmark.

use plant::appendage::{AppendageParameters, AppendageTruth};
use plant::arm::{ArmNoise, FreeFloatingArm};
use plant::arm_parameters::{ArmParameters, Target};
use plant::fourier_reference::FourierReference;
use plant::slosh::{SloshParameters, SloshTruth};
use runtime::scenario::{ArmExperiment, ModalExperiment, SloshExperiment, Trajectory};

/// Seconds in an hour, square root: data sheets state random walks per √h.
const SQRT_HOUR_S: f64 = 60.0;

/// Sample rate of the simulated accelerometer array where the scenario states none.
pub const ARRAY_RATE_HZ: f64 = 200.0;

/// The arm of an experiment; `grasped` decides whether its target is on.
pub fn arm(experiment: &ArmExperiment, grasped: bool, period_s: f64, seed: u64, stream: &str) -> FreeFloatingArm {
    let mut parameters = ArmParameters::paper_table_ii();
    if let Some(target) = experiment.target.as_ref().filter(|_| grasped) {
        parameters = parameters.with_target(Target {
            mass_kg: target.mass_kg,
            com_from_grasp_m: target.com_from_grasp_m,
            inertia_com_kg_m2: target.inertia_com_kg_m2,
        });
    }
    let reference = match experiment.trajectory {
        Trajectory::B => FourierReference::trajectory_b(),
        Trajectory::Mated => FourierReference::mated(),
    };
    let known = &experiment.known;
    let noise = ArmNoise {
        gyro_arw_rad_sqrt_s: known.gyro_arw_deg_sqrt_h.to_radians() / SQRT_HOUR_S,
        joint_rate_sigma_rad_s: known.joint_rate_sigma_rad_s,
        ..ArmNoise::default()
    };
    FreeFloatingArm::new(&parameters, reference, &noise, known.h_cm_nms, period_s, seed, stream)
}

pub fn slosh(experiment: &SloshExperiment, seed: u64, stream: &str) -> Option<SloshTruth> {
    let truth = experiment.truth.as_ref()?;
    let known = &experiment.known;
    let parameters = SloshParameters {
        m_0_kg: known.m_0_kg,
        m_s_kg: truth.m_s_kg,
        k_s_n_m: truth.k_s_n_m,
        c_s_n_s_m: truth.c_s_n_s_m,
    };
    let vrw = known.accelerometer_vrw_m_s_sqrt_h / SQRT_HOUR_S;
    Some(SloshTruth::new(&parameters, known.interval_s, vrw, seed, stream))
}

pub fn appendage(experiment: &ModalExperiment, seed: u64, stream: &str) -> Option<AppendageTruth> {
    experiment.truth.as_ref()?;
    let rate_hz = array_rate_hz(experiment);
    Some(AppendageTruth::new(
        &AppendageParameters::design(),
        rate_hz,
        experiment.known.accelerometer_sigma_m_s2,
        seed,
        stream,
    ))
}

pub fn array_rate_hz(experiment: &ModalExperiment) -> f64 {
    if experiment.known.rate_hz > 0.0 { experiment.known.rate_hz } else { ARRAY_RATE_HZ }
}
