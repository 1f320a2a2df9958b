//! From a scenario to the vehicles of its experiments. Each experiment has a plant of its own, as
//! in the benchmark; what the experiment itself decides (command, rate, trajectory) is the
//! scenario's.

use crate::craft;
use crate::vehicle::{Vehicle, VehicleError};
use dynamics::description::{Controller, Plant, Quantity, Signal, SignalKind};
use plant_file::scenario::{
    ArmExperiment, CraftPlan, ModalExperiment, PlantUse, Scenario, SloshExperiment, Trajectory,
};
use simulation::fourier_reference::FourierReference;

/// Why an experiment cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SystemsError {
    /// What is wrong with the plant file, a number set or an effect hidden.
    #[error("{file}: {reason}")]
    Plant { file: String, reason: String },
    #[error("{file}: {reason}")]
    Vehicle { file: String, reason: VehicleError },
}

/// Whose noise, and how long a frame is.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// Length of a frame \[s\].
    pub frame_s: f64,
    /// Of all noise streams.
    pub seed: u64,
    /// Prefix of the noise streams.
    pub stream: &'a str,
}

/// Every vehicle that `scenario` asks for can be built.
///
/// # Errors
/// The experiment whose vehicle cannot, and why.
pub fn check(scenario: &Scenario) -> Result<(), (&'static str, SystemsError)> {
    let setting = Setting { frame_s: scenario.period_ns() as f64 * 1e-9, seed: 0, stream: "" };
    let built = [
        ("modal", scenario.modal.as_ref().map(|modal| appendage(modal, setting))),
        ("slosh", scenario.slosh.as_ref().map(|slosh| tank(slosh, setting))),
        ("inertial", scenario.inertial.as_ref().map(|inertial| arm(inertial, true, setting))),
        ("mated", scenario.mated.as_ref().map(|mated| arm(mated, true, setting))),
        ("mated", scenario.mated.as_ref().map(|mated| arm(mated, false, setting))),
    ];
    let arcs = scenario.craft.iter().flat_map(|craft| (0..craft.arcs.len()).map(move |arc| (craft, arc)));
    let arcs = arcs.map(|(craft, arc)| ("craft", Some(of_arc(craft, arc, setting))));
    built
        .into_iter()
        .chain(arcs)
        .try_for_each(|(name, vehicle)| vehicle.transpose().map(|_| ()).map_err(|error| (name, error)))
}

/// The arm of an experiment; `grasped` decides whether its target is on.
///
/// # Errors
/// See [`SystemsError`].
pub fn arm(experiment: &ArmExperiment, grasped: bool, setting: Setting<'_>) -> Result<Option<Vehicle>, SystemsError> {
    let Some(used) = &experiment.plant else { return Ok(None) };
    let mut plant = configured(used)?;
    if let (Some(target), false) = (&experiment.grasps, grasped) {
        without_body(&mut plant, target).map_err(|reason| refused(used, reason))?;
    }
    let reference = match experiment.trajectory {
        Trajectory::B => FourierReference::trajectory_b(),
        Trajectory::Mated => FourierReference::mated(),
    };
    for (joint, controller) in plant.controllers.iter_mut().enumerate().take(reference.q0_rad.len()) {
        follow(controller, &reference, joint);
    }
    vehicle(used, &plant, setting)
}

/// The tank of an experiment under the experiment's thrust; under the plant's own where the
/// scenario states none.
///
/// # Errors
/// See [`SystemsError`].
pub fn tank(experiment: &SloshExperiment, setting: Setting<'_>) -> Result<Option<Vehicle>, SystemsError> {
    let Some(used) = &experiment.plant else { return Ok(None) };
    let mut plant = configured(used)?;
    plant.simulation.period_s = experiment.known.interval_s;
    if experiment.force_amplitude_n != 0.0 {
        command(
            &mut plant,
            SignalKind::Sine {
                amplitude: Quantity::known(experiment.force_amplitude_n),
                frequency_hz: Quantity::known(experiment.force_frequency_hz),
                phase_rad: Quantity::known(0.0),
            },
        )
        .map_err(|reason| refused(used, reason))?;
    }
    vehicle(used, &plant, setting)
}

/// The appendage of an experiment under the experiment's pulse.
///
/// # Errors
/// See [`SystemsError`].
pub fn appendage(experiment: &ModalExperiment, setting: Setting<'_>) -> Result<Option<Vehicle>, SystemsError> {
    let Some(used) = &experiment.plant else { return Ok(None) };
    let mut plant = configured(used)?;
    // Where the scenario states no rate, the sensors keep the plant's own.
    let own_s = plant.simulation.period_s;
    let stated_s = (experiment.known.rate_hz > 0.0).then(|| 1.0 / experiment.known.rate_hz);
    plant.simulation.period_s = setting.frame_s;
    for sensor in &mut plant.sensors {
        let own = sensor.period_s.unwrap_or(Quantity::known(own_s));
        sensor.period_s = Some(stated_s.map_or(own, Quantity::known));
    }
    let (size, width_s) = (Quantity::known(experiment.torque_nm), Quantity::known(experiment.pulse_s));
    command(&mut plant, SignalKind::Pulse { size, width_s, period_s: None }).map_err(|reason| refused(used, reason))?;
    vehicle(used, &plant, setting)
}

/// The craft of an arc, which also gives its rows; `setting.seed` decides which craft it is.
///
/// # Errors
/// See [`SystemsError`].
pub fn of_arc(plan: &CraftPlan, arc: usize, setting: Setting<'_>) -> Result<Option<Vehicle>, SystemsError> {
    let Some(arc) = plan.arcs.get(arc) else { return Ok(None) };
    let plant = craft::flown(plan, arc, setting.seed).map_err(|error| refused(&plan.plant, error.to_string()))?;
    let built = vehicle(&plan.plant, &plant, setting)?;
    Ok(built.map(|vehicle| vehicle.with_rows(plant)))
}

fn configured(used: &PlantUse) -> Result<Plant, SystemsError> {
    used.configure().map(|configured| configured.plant).map_err(|error| refused(used, error.to_string()))
}

fn refused(used: &PlantUse, reason: String) -> SystemsError {
    SystemsError::Plant { file: used.file.clone(), reason }
}

fn vehicle(used: &PlantUse, plant: &Plant, setting: Setting<'_>) -> Result<Option<Vehicle>, SystemsError> {
    let built = Vehicle::new(plant, setting.frame_s, setting.seed, setting.stream);
    built.map(Some).map_err(|reason| SystemsError::Vehicle { file: used.file.clone(), reason })
}

/// The first actuator follows `kind` from the experiment's begin.
fn command(plant: &mut Plant, kind: SignalKind) -> Result<(), String> {
    let actuator = plant.actuators.first_mut().ok_or("the plant has no actuator to be excited by")?;
    actuator.command = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
    Ok(())
}

fn follow(controller: &mut Controller, reference: &FourierReference, joint: usize) {
    let known = |numbers: [f64; 5]| numbers.map(Quantity::known).to_vec();
    let kind = SignalKind::Fourier {
        offset: Quantity::known(reference.q0_rad[joint]),
        period_s: Quantity::known(reference.period_s),
        sine: known(reference.a_rad_s[joint]),
        cosine: known(reference.b_rad_s[joint]),
    };
    controller.reference = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
}

/// Removes a body to which no other is attached.
fn without_body(plant: &mut Plant, name: &str) -> Result<(), String> {
    let before = plant.bodies.len();
    plant.bodies.retain(|body| body.name != name);
    if plant.bodies.len() == before {
        return Err(format!("grasps = '{name}': the plant has no such body"));
    }
    let faults = plant_file::validate::validate(plant);
    faults
        .into_iter()
        .find(|fault| !fault.warning)
        .map_or(Ok(()), |fault| Err(format!("without '{name}': {}", fault.message)))
}
