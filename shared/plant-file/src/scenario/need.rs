//! What the supervisor accepts a model for.

use serde::Deserialize;
use std::collections::BTreeMap;

/// What the supervisor accepts a model for.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Need {
    /// Per parameter: largest acceptable standard deviation [% of the estimate].
    pub sigma_percent: BTreeMap<String, f64>,
    /// Largest acceptable rms error of a simulation over held-out data (rad/s for inertial, else
    /// m/s^2).
    pub held_out_rms: Option<f64>,
}
