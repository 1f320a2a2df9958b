//! Sampled PID on the hub's attitude: the loop that BP3B closes around the appendage.
//!
//! `u = 600 e + 120 ∫e − 450 θ'`, `e = r − θ`; the reference climbs one step every second.
//! Modes identified from output alone are then those of the closed loop, not of the appendage.

use serde::{Deserialize, Serialize};

/// Gains of the hub's controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HubController {
    pub proportional_nm_rad: f64,
    pub integral_nm_rad_s: f64,
    pub derivative_nms_rad: f64,
}

/// The controller's memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HubControllerState {
    pub error_integral_rad_s: f64,
}

impl HubController {
    /// The benchmark's gains.
    pub const fn benchmark() -> Self {
        Self { proportional_nm_rad: 600.0, integral_nm_rad_s: 120.0, derivative_nms_rad: 450.0 }
    }

    /// Torque to be held over the next interval; the integral includes the present error (backward
    /// rectangle).
    pub fn torque_nm(
        &self,
        state: &mut HubControllerState,
        reference_rad: f64,
        hub_angle_rad: f64,
        hub_rate_rad_s: f64,
        interval_s: f64,
    ) -> f64 {
        let error = reference_rad - hub_angle_rad;
        state.error_integral_rad_s += error * interval_s;
        self.proportional_nm_rad * error + self.integral_nm_rad_s * state.error_integral_rad_s
            - self.derivative_nms_rad * hub_rate_rad_s
    }
}

/// Staircase reference: `step · (1 + ⌊t / 1 s⌋)`, from t = 0.
pub fn staircase_rad(t_s: f64, step_rad: f64) -> f64 {
    // a sample meant to lie on the edge must not fall before it by rounding
    step_rad * (1.0 + libm::floor(t_s + 1e-9))
}
