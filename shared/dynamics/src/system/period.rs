//! One control period of a motion.

use super::System;

/// State and inputs at the beginning of a control period, over which inputs are held.
#[derive(Clone, Copy)]
pub struct Period<'a> {
    pub system: &'a System,
    /// The motion begins anew: it does not follow from the period before.
    pub restarts: bool,
    /// Nothing follows it.
    pub last: bool,
    pub begin_s: f64,
    pub end_s: f64,
    /// As [`System::states`].
    pub state: &'a [f64],
    /// As [`System::inputs`].
    pub inputs: &'a [f64],
}
