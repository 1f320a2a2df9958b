//! What happens between pre-capture and mated identification.

use serde::Deserialize;

/// What happens between pre-capture and mated identification.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CapturePlan {
    /// Capture is part of the plan.
    pub enabled: bool,
    /// Settling time after contact.
    pub settle_s: f64,
    /// Longest time to wait for contact.
    pub contact_timeout_s: f64,
    /// Oldest accepted model with which capture is allowed.
    pub model_age_limit_s: f64,
    /// Largest base rate with which an experiment may start.
    pub base_rate_limit_rad_s: f64,
    /// The operator takes responsibility for capture without accepted models.
    pub operator_override: bool,
}

impl Default for CapturePlan {
    fn default() -> Self {
        CapturePlan {
            enabled: false,
            settle_s: 5.0,
            contact_timeout_s: 20.0,
            model_age_limit_s: 7200.0,
            base_rate_limit_rad_s: 1.0,
            operator_override: false,
        }
    }
}
