//! One parameter of a plant file: known, or to be estimated from a prior.

/// Scope of a parameter: over which recordings it has one value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// All recordings share it (a mass).
    #[default]
    Shared,
    /// Each recording has its own (a bias).
    PerRecording,
    /// Each segment has its own (an initial state).
    PerSegment,
}

/// A value in SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantity {
    pub value: f64,
    /// Prior standard deviation; `None` = known.
    pub sigma: Option<f64>,
    pub scope: Scope,
}

impl Quantity {
    /// A value without uncertainty, the same in all recordings.
    pub const fn known(value: f64) -> Self {
        Self { value, sigma: None, scope: Scope::Shared }
    }

    /// A value with a normal prior of standard deviation `sigma`, the same in all recordings.
    pub const fn with_prior(value: f64, sigma: f64) -> Self {
        Self { value, sigma: Some(sigma), scope: Scope::Shared }
    }
}
