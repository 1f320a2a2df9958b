//! What was simulated: the numbers that estimates are compared with, taken from the plants of the
//! scenario.

use crate::scenario_run::ScenarioRun;
use bench::arm_parameters::minimal_parameters;
use bench::truth::{modes, tank};
use plant_file::scenario::PlantUse;
use telemetry::{Domain, Phase};

/// True parameters of a domain in a phase; empty when nothing was simulated (a recording), or a
/// plant whose numbers have no counterpart among the estimates.
#[must_use]
pub fn parameters(run: &ScenarioRun, domain: Domain, phase: Phase) -> Vec<f64> {
    let scenario = &run.scenario;
    let of = |used: Option<&PlantUse>| used.and_then(|used| used.configure().ok()).map(|used| used.plant);
    let found = match (domain, phase) {
        (_, Phase::Replay) => None,
        (Domain::Inertial, Phase::PreCapture) => {
            let plant = of(scenario.inertial.as_ref().and_then(|arm| arm.plant.as_ref()));
            plant.and_then(|plant| minimal_parameters(&plant)).map(|nine| nine[..8].to_vec())
        }
        (Domain::Inertial, Phase::Mated) => {
            let plant = of(scenario.mated.as_ref().and_then(|arm| arm.plant.as_ref()));
            plant.and_then(|plant| minimal_parameters(&plant)).map(|nine| nine.to_vec())
        }
        (Domain::Slosh, _) => {
            let plant = of(scenario.slosh.as_ref().and_then(|slosh| slosh.plant.as_ref()));
            plant.and_then(|plant| tank(&plant)).map(|numbers| numbers.to_vec())
        }
        (Domain::Modal, _) => {
            of(scenario.modal.as_ref().and_then(|modal| modal.plant.as_ref())).and_then(|plant| modes(&plant))
        }
    };
    found.unwrap_or_default()
}

/// Mass, centre of mass and inertia of what is grasped, from its grasp point; `None`: nothing was
/// simulated, or nothing is grasped.
#[must_use]
pub fn target(run: &ScenarioRun) -> Option<[f64; 4]> {
    let mated = run.scenario.mated.as_ref()?;
    let (plant, name) = (mated.plant.as_ref()?.configure().ok()?.plant, mated.grasps.as_ref()?);
    let numbers = plant.parameters();
    let of = |number: &str| {
        let wanted = format!("{name}.{number}");
        numbers.iter().find(|parameter| parameter.name == wanted).map(|parameter| parameter.value)
    };
    Some([of("mass")?, of("com.x")?, of("com.y")?, of("inertia.zz")?])
}
