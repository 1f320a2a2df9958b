//! What was simulated: the numbers that estimates are compared with.

use plant::appendage::AppendageParameters;
use plant::arm_parameters::{ArmParameters, Target};
use runtime::RunConfig;
use runtime::scenario::AppendageTruth;
use telemetry::{Domain, Phase};

/// True parameters of a domain in a phase; empty when nothing was simulated (a recording).
#[must_use]
pub fn parameters(run: &RunConfig, domain: Domain, phase: Phase) -> Vec<f64> {
    let scenario = &run.scenario;
    match (domain, phase) {
        (_, Phase::Replay) => Vec::new(),
        (Domain::Inertial, Phase::PreCapture) => ArmParameters::paper_table_ii().inertial_parameters_truth().to_vec(),
        (Domain::Inertial, Phase::Mated) => {
            scenario.mated.as_ref().and_then(|mated| mated.target.as_ref()).map_or(Vec::new(), |target| {
                let target = Target {
                    mass_kg: target.mass_kg,
                    com_from_grasp_m: target.com_from_grasp_m,
                    inertia_com_kg_m2: target.inertia_com_kg_m2,
                };
                ArmParameters::paper_table_ii().with_target(target).mated_inertial_parameters_truth().to_vec()
            })
        }
        (Domain::Slosh, _) => {
            let truth = scenario.slosh.as_ref().and_then(|slosh| slosh.truth.as_ref());
            truth.map_or(Vec::new(), |truth| vec![truth.m_s_kg, truth.k_s_n_m, truth.c_s_n_s_m])
        }
        (Domain::Modal, _) => match scenario.modal.as_ref().and_then(|modal| modal.truth.as_ref()) {
            Some(AppendageTruth::DesignBp3) => AppendageParameters::design()
                .modes()
                .iter()
                .flat_map(|mode| [mode.frequency_hz, mode.damping_ratio])
                .collect(),
            None => Vec::new(),
        },
    }
}
