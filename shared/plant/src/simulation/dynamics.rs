//! The equations with their scratch, their integrator and their inputs: everything that moves a state.

use super::excitation::ExcitedClock;
use super::inputs::Inputs;
use super::integrator::{Drive, Stepper};
use crate::system::{System, Workspace};

/// Where the prescribed motions were at the beginning of a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin<'a> {
    pub begin_s: f64,
    pub clock: &'a ExcitedClock,
    pub motions: &'a [[f64; 2]],
}

/// A plant that can be moved and read.
pub(crate) struct Dynamics {
    pub system: System,
    pub workspace: Workspace<f64>,
    pub stepper: Stepper,
    pub inputs: Inputs,
}

impl Dynamics {
    /// Writes the prescribed entries of `u` at `t_s`.
    pub fn prescribe(&self, origin: &Origin<'_>, t_s: f64, u: &mut [f64]) {
        self.inputs.prescribe(origin.motions, origin.clock, origin.begin_s, t_s, u);
    }

    /// Moves `x` from `t_s` over `length_s`; leaves the prescribed entries of `u` at the end.
    pub fn advance(&mut self, origin: &Origin<'_>, t_s: f64, length_s: f64, x: &mut [f64], u: &mut [f64]) {
        let Self { system, workspace, stepper, inputs } = self;
        let prescribe = |t: f64, u: &mut [f64]| inputs.prescribe(origin.motions, origin.clock, origin.begin_s, t, u);
        stepper.advance(&mut Drive { system, workspace, u, prescribe }, t_s, length_s, x);
        inputs.prescribe(origin.motions, origin.clock, origin.begin_s, t_s + length_s, u);
    }

    pub fn read(&mut self, t_s: f64, x: &[f64], u: &[f64], y: &mut [f64]) {
        self.system.read(&mut self.workspace, t_s, x, u, y);
    }
}
