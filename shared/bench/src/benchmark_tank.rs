//! The tank of the benchmark, for the tests of this crate.

use physics::slosh::SloshParameters;

pub const BASE_MASS_KG: f64 = 1004.5;

/// The benchmark's tank: 28.7 kg, 0.012052 Hz, ζ = 0.71 %.
pub const TANK: SloshParameters = SloshParameters { slosh_mass_kg: 28.7, stiffness_n_m: 0.16, damping_n_s_m: 0.03 };
