//! The inertia about the hub's axis that the modes found imply, by the geometry that the scenario
//! states.

use modal::Mode;
use physics::appendage::{self, Appendage};
use plant_file::scenario::AppendageKnown;

/// Inertia and standard deviation [kg m²]; `None` where the two modes of the geometry are not among
/// those found.
pub fn of_modes(known: &AppendageKnown, modes: &[Mode]) -> Option<(f64, f64)> {
    let nominal = Appendage {
        inertia_kg_m2: known.inertia_kg_m2,
        coupling: known.coupling_sqrt_kg_m,
        locked: known.locked.map(|[frequency_hz, damping_ratio]| appendage::Mode { frequency_hz, damping_ratio }),
    };
    let measured: Vec<_> = modes.iter().map(with_covariance).collect();
    nominal.inertia(&measured, known.coupling_relative_sd)
}

fn with_covariance(mode: &Mode) -> (appendage::Mode, [[f64; 2]; 2]) {
    let (f, zeta) = (mode.sigma_frequency_hz, mode.sigma_damping);
    let both = mode.correlation * f * zeta;
    let found = appendage::Mode { frequency_hz: mode.frequency_hz, damping_ratio: mode.damping_ratio };
    (found, [[f * f, both], [both, zeta * zeta]])
}
