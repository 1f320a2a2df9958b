//! Which of two ways of deciding a diagnosis takes.

use crate::diagnose::{Diagnosis, Options, Phase};
use crate::{diagnose, evidence};
use identification::problem::Problem;

/// A way of deciding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// One comparison of hypotheses in nats ([`crate::evidence`]).
    #[default]
    Evidence,
    /// Tests one after another ([`crate::diagnose`]): the previous method, to compare with.
    Cascade,
}

impl Engine {
    /// Diagnoses `problem` in this way.
    pub fn diagnose(self, problem: &Problem, options: &Options, progress: &mut dyn FnMut(Phase, f64)) -> Diagnosis {
        match self {
            Self::Cascade => diagnose::diagnose(problem, options, progress),
            Self::Evidence => evidence::diagnose(problem, options, progress),
        }
    }
}
