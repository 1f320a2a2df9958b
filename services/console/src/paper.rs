//! Relative errors of the seed paper [%], for the column beside ours.

use telemetry::{Domain, Phase};

/// Table III, TLS (IV gives the same), momentum approach: a1 to a8.
const INERTIAL: [f64; 8] = [0.09, 0.28, 0.25, 0.57, 0.18, 0.10, 0.38, 0.02];
/// Table IV, UKF on the dynamic equation: a1 to a8.
const INERTIAL_TORQUE: [f64; 8] = [0.28, 0.74, 3.66, 10.05, 13.77, 0.00, 8.22, 8.19];
/// Table VI, the better of TLS and IV: m_s, k_s, c_s.
const SLOSH: [f64; 3] = [1.86, 1.08, 324.87];
/// Table IX, SSI-COV: f1, zeta1, f2, zeta2.
const MODAL: [f64; 4] = [0.02, 0.02, 0.00, 0.03];

/// The paper's error of an inertial parameter from torques.
#[must_use]
pub fn torque_error_percent(phase: Phase, parameter: usize) -> Option<f64> {
    INERTIAL_TORQUE.get(parameter).copied().filter(|_| phase == Phase::PreCapture)
}

/// The paper's error of a parameter of the pre-capture benchmarks.
#[must_use]
pub fn error_percent(domain: Domain, phase: Phase, parameter: usize) -> Option<f64> {
    if phase != Phase::PreCapture {
        return None;
    }
    let table: &[f64] = match domain {
        Domain::Inertial => &INERTIAL,
        Domain::Slosh => &SLOSH,
        Domain::Modal => &MODAL,
    };
    table.get(parameter).copied()
}
