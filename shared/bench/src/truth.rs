//! True parameters read off a plant: what its tank and its modes are to be found as.

use dynamics::description::{Initial, Plant, TankModel};
use dynamics::system::{System, Workspace};

/// Mass, stiffness and damping of the only slosh mass; `None`: the plant has no such tank.
#[must_use]
pub fn tank(plant: &Plant) -> Option<[f64; 3]> {
    let [tank] = &plant.tanks[..] else { return None };
    match &tank.model {
        TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } => {
            Some([tank.mass_kg.value, stiffness_n_m.first()?.value, damping_n_s_m.first()?.value])
        }
        TankModel::Pendulum { .. } => None,
    }
}

/// Frequency \[Hz\] and damping ratio of every mode of hub and appendage together, lowest first.
#[must_use]
pub fn modes(plant: &Plant) -> Option<Vec<f64>> {
    let system = System::new(plant).ok()?;
    let x = system.initial_state(&Initial::default(), &|_| None).ok()?;
    let u = vec![0.0; system.inputs().len()];
    let found = system.modes(&mut Workspace::new(&system), 0.0, &x, &u);
    Some(found.modes.iter().flat_map(|mode| [mode.frequency_hz, mode.damping_ratio]).collect())
}
