//! How the state moves: Runge–Kutta of fourth order, midpoint, or the exact solution of a linear
//! plant under held inputs.

mod exact;

use super::SimulationError;
use dynamics::description::{Integrator, Plant, SimulationSettings as Settings};
use dynamics::dual::Dual;
use dynamics::system::{InputRole, RungeKutta, System, Workspace};
use exact::ExactHold;

/// Steps of at most `step_s` that an interval takes.
pub(crate) fn substeps(length_s: f64, step_s: f64) -> u32 {
    // an interval that is a whole number of steps but for rounding takes that number
    libm::ceil(length_s / step_s - 1e-9).max(1.0) as u32
}

/// The plant and where its inputs come from, during an integration.
pub(crate) struct Drive<'a, F: FnMut(f64, &mut [f64])> {
    pub system: &'a System,
    pub workspace: &'a mut Workspace<f64>,
    /// Inputs; held entries stand, prescribed ones are written by `prescribe` at every stage.
    pub u: &'a mut [f64],
    pub prescribe: F,
    /// Where the readings of the first slope go; taken once.
    pub reading: Option<&'a mut [f64]>,
}

impl<F: FnMut(f64, &mut [f64])> Drive<'_, F> {
    fn slope(&mut self, t_s: f64, x: &[f64], x_dot: &mut [f64]) {
        (self.prescribe)(t_s, self.u);
        match self.reading.take() {
            None => self.system.derivative(self.workspace, t_s, x, self.u, x_dot),
            Some(y) => self.system.derivative_and_read(self.workspace, t_s, x, self.u, x_dot, y),
        }
    }
}

/// How a plant is moved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub integrator: Integrator,
    pub step_s: f64,
    /// Why it is another integrator than the plant states.
    pub instead: Option<String>,
}

/// Turn of the fastest part of the plant in one step of Runge–Kutta that stands for the exact hold
/// \[rad\]: `0.1⁴/120`, 1e-6 of a radian's error.
const STEP_TURN_RAD: f64 = 0.1;
/// Most steps of a period; a part that is stiffer still is seen as a state that is not finite.
const STEPS_MAX: f64 = 1000.0;

/// The integrator that `plant` states. The exact hold is for linear equations: where the plant is
/// linear but for its effects, Runge–Kutta takes its place, in steps that follow the fastest part.
///
/// # Errors
/// The plant itself is not linear.
pub(crate) fn choose(plant: &Plant, system: &System) -> Result<Choice, SimulationError> {
    let Settings { integrator, step_s, period_s, .. } = plant.simulation;
    let stated = Choice { integrator, step_s, instead: None };
    // prescribed motions are rejected by name
    let held = system.inputs().iter().all(|input| input.role == InputRole::Command);
    if integrator != Integrator::ExactZeroOrderHold || !held {
        return Ok(stated);
    }
    let linear = |system: &System| {
        ExactHold::new(system, 0.0, &vec![0.0; system.states().len()], &vec![0.0; system.inputs().len()], &[])
    };
    linear(&System::new(&plant.without_effects())?)?;
    // a law that is linear where it is tried (a stop not yet reached) need not be so elsewhere
    if !system.has_laws() && linear(system).is_ok() {
        return Ok(stated);
    }
    let (x, u) = (vec![0.0; system.states().len()], vec![0.0; system.inputs().len()]);
    let a = system.linearise(&mut Workspace::<Dual>::new(system), 0.0, &x, &u).a;
    let fastest = dynamics::system::spectral_radius(a);
    let fine_s = if fastest > 0.0 { STEP_TURN_RAD / fastest } else { f64::INFINITY };
    let step_s = step_s.min(fine_s).max(period_s / STEPS_MAX);
    let instead = format!(
        "exact_zero_order_hold needs linear equations, and the plant carries an effect: runge_kutta_4 in steps of {step_s:.1e} s instead"
    );
    Ok(Choice { integrator: Integrator::RungeKutta4, step_s, instead: Some(instead) })
}

/// An integrator with its scratch.
pub(crate) struct Stepper {
    integrator: Integrator,
    step_s: f64,
    scratch: RungeKutta,
    exact: Option<ExactHold>,
}

impl Stepper {
    /// Integrator for `system`. `lengths_s` are the intervals that will be asked for; the exact
    /// hold prepares them.
    ///
    /// # Errors
    /// The exact hold is requested for a plant that is not linear in its state about (`x`, `u`).
    pub fn new(
        system: &System,
        integrator: Integrator,
        step_s: f64,
        (t_s, x, u): (f64, &[f64], &[f64]),
        lengths_s: &[f64],
    ) -> Result<Self, SimulationError> {
        let n = system.states().len();
        let exact = match integrator {
            Integrator::ExactZeroOrderHold => Some(ExactHold::new(system, t_s, x, u, lengths_s)?),
            Integrator::RungeKutta4 | Integrator::Midpoint => None,
        };
        Ok(Self { integrator, step_s, scratch: RungeKutta::new(n), exact })
    }

    /// Moves `x` from `t_s` over `length_s`, in equal steps of at most the longest step.
    ///
    /// Cost: 4 (Runge–Kutta) or 2 (midpoint) derivatives a step, one product with a matrix (exact);
    /// no allocation.
    pub fn advance<F: FnMut(f64, &mut [f64])>(
        &mut self,
        drive: &mut Drive<'_, F>,
        t_s: f64,
        length_s: f64,
        x: &mut [f64],
    ) {
        if let Some(exact) = &mut self.exact {
            exact.advance(drive.u, length_s, x);
            return;
        }
        let steps = substeps(length_s, self.step_s);
        let h = length_s / f64::from(steps);
        for step in 0..steps {
            let t = t_s + f64::from(step) * h;
            let slope = |share: f64, x: &[f64], x_dot: &mut [f64]| drive.slope(t + share * h, x, x_dot);
            match self.integrator {
                Integrator::Midpoint => self.scratch.midpoint(h, x, slope),
                Integrator::RungeKutta4 | Integrator::ExactZeroOrderHold => self.scratch.step(h, x, slope),
            }
            drive.system.normalise(x);
        }
    }
}

#[cfg(test)]
mod tests;
