//! What was simulated: the numbers that estimates are compared with, taken from the plants of the scenario.

use plant::arm_parameters::{ArmParameters, Target};
use plant::description::{Body, Initial, JointKind, Plant, TankModel};
use plant::system::{System, Workspace};
use runtime::RunConfig;
use runtime::scenario::PlantUse;
use sensor_sim::systems;
use telemetry::{Domain, Phase};

/// True parameters of a domain in a phase; empty when nothing was simulated (a recording), or a plant whose numbers have no
/// counterpart among the estimates.
#[must_use]
pub fn parameters(run: &RunConfig, domain: Domain, phase: Phase) -> Vec<f64> {
    let scenario = &run.scenario;
    let of = |used: Option<&PlantUse>| used.and_then(|used| systems::plant(used).ok());
    let found = match (domain, phase) {
        (_, Phase::Replay) => None,
        (Domain::Inertial, Phase::PreCapture) => {
            let plant = of(scenario.inertial.as_ref().and_then(|arm| arm.plant.as_ref()));
            plant.and_then(|plant| arm(&plant)).map(|arm| arm.inertial_parameters_truth().to_vec())
        }
        (Domain::Inertial, Phase::Mated) => {
            let plant = of(scenario.mated.as_ref().and_then(|arm| arm.plant.as_ref()));
            plant.and_then(|plant| arm(&plant)).map(|arm| arm.mated_inertial_parameters_truth().to_vec())
        }
        (Domain::Slosh, _) => {
            of(scenario.slosh.as_ref().and_then(|slosh| slosh.plant.as_ref())).and_then(|plant| tank(&plant))
        }
        (Domain::Modal, _) => {
            of(scenario.modal.as_ref().and_then(|modal| modal.plant.as_ref())).and_then(|plant| modes(&plant))
        }
    };
    found.unwrap_or_default()
}

/// A free base with two links in a row whose centres of mass lie on their axes, and perhaps a target on the second.
fn arm(plant: &Plant) -> Option<ArmParameters> {
    let [base, link_1, link_2, rest @ ..] = &plant.bodies[..] else { return None };
    let revolute = |link: &Body, parent: &Body| {
        let turns = matches!(link.joint.kind, JointKind::Revolute { axis: [0.0, 0.0, 1.0] });
        turns && link.parent.as_deref() == Some(parent.name.as_str()) && link.com_m[1].value == 0.0
    };
    if base.joint.kind != JointKind::Free || !revolute(link_1, base) || !revolute(link_2, link_1) {
        return None;
    }
    let target = match rest {
        [] => None,
        [target] if target.joint.kind == JointKind::Fixed && target.parent.as_deref() == Some(&link_2.name) => Some(target),
        _ => return None,
    };
    let planar = |numbers: [plant::description::Quantity; 3]| [numbers[0].value, numbers[1].value];
    let (root, elbow) = (planar(link_1.joint.position_m), planar(link_2.joint.position_m));
    let (base_com, l) = (planar(base.com_m), [link_1.com_m[0].value, link_2.com_m[0].value]);
    let grasp_m = target.map_or(l[1], |target| target.joint.position_m[0].value);
    let inertia = |body: &Body| body.inertia_com_kg_m2[2].value;
    Some(ArmParameters {
        base_mass_kg: base.mass_kg.value,
        base_inertia_com_kg_m2: inertia(base),
        r0_m: [root[0] - base_com[0], root[1] - base_com[1]],
        link_mass_kg: [link_1.mass_kg.value, link_2.mass_kg.value],
        link_inertia_com_kg_m2: [inertia(link_1), inertia(link_2)],
        l_m: l,
        r_m: [elbow[0] - l[0], grasp_m - l[1]],
        target: target.map(|target| Target {
            mass_kg: target.mass_kg.value,
            com_from_grasp_m: planar(target.com_m),
            inertia_com_kg_m2: inertia(target),
        }),
    })
}

fn tank(plant: &Plant) -> Option<Vec<f64>> {
    let [tank] = &plant.tanks[..] else { return None };
    match &tank.model {
        TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } => {
            Some(vec![tank.mass_kg.value, stiffness_n_m.first()?.value, damping_n_s_m.first()?.value])
        }
        TankModel::Pendulum { .. } => None,
    }
}

/// Modes of hub and appendage together, lowest first.
fn modes(plant: &Plant) -> Option<Vec<f64>> {
    let system = System::new(plant).ok()?;
    let x = system.initial_state(&Initial::default(), &|_| None).ok()?;
    let u = vec![0.0; system.inputs().len()];
    let found = system.modes(&mut Workspace::new(&system), 0.0, &x, &u);
    Some(found.modes.iter().flat_map(|mode| [mode.frequency_hz, mode.damping_ratio]).collect())
}
