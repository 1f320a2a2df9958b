//! The equations with their scratch, their integrator and their inputs: everything that moves a
//! state.

use super::excitation::ExcitedClock;
use super::inputs::Inputs;
use super::integrator::{Drive, Stepper};
use dynamics::system::{System, Workspace};

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
        self.advance_and_read(origin, (t_s, length_s), x, u, None);
    }

    /// [`advance`](Self::advance) that also takes the readings at the beginning, at the cost of the
    /// first slope. Returns whether they were taken: the exact hold has no slopes.
    pub fn advance_and_read(
        &mut self,
        origin: &Origin<'_>,
        (t_s, length_s): (f64, f64),
        x: &mut [f64],
        u: &mut [f64],
        reading: Option<&mut [f64]>,
    ) -> bool {
        let Self { system, workspace, stepper, inputs } = self;
        let prescribe = |t: f64, u: &mut [f64]| inputs.prescribe(origin.motions, origin.clock, origin.begin_s, t, u);
        let asked = reading.is_some();
        let mut drive = Drive { system, workspace, u, prescribe, reading };
        stepper.advance(&mut drive, t_s, length_s, x);
        let taken = asked && drive.reading.is_none();
        inputs.prescribe(origin.motions, origin.clock, origin.begin_s, t_s + length_s, u);
        taken
    }

    /// Writes the readings of `outputs` at state `x` and inputs `u` into `y`; the others are left
    /// as they are.
    pub fn read_some(&mut self, t_s: f64, x: &[f64], u: &[f64], outputs: &[usize], y: &mut [f64]) {
        self.system.read_some(&mut self.workspace, t_s, x, u, outputs, y);
    }

    /// Writes all readings at state `x` and inputs `u` into `y`.
    pub fn read(&mut self, t_s: f64, x: &[f64], u: &[f64], y: &mut [f64]) {
        self.system.read(&mut self.workspace, t_s, x, u, y);
    }
}
