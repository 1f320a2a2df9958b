//! The clock of commands and references, which can stand still while the plant's goes on.

use serde::{Deserialize, Serialize};

/// Excited time over one control period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ExcitedClock {
    /// Beginning of the period, plant time.
    pub begin_s: f64,
    /// The same instant in excited time.
    pub excited_begin_s: f64,
    pub running: bool,
}

impl ExcitedClock {
    /// Excited time at plant time `t_s` of this period.
    pub fn at(&self, t_s: f64) -> f64 {
        if self.running { self.excited_begin_s + (t_s - self.begin_s) } else { self.excited_begin_s }
    }
}
