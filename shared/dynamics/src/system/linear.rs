//! State-space form by dual numbers.

use super::System;
use super::workspace::Workspace;
use crate::dual::Dual;
use nalgebra::DMatrix;

/// `x' ≈ f₀ + A δx + B δu`, `y ≈ h₀ + C δx + D δu`. Quaternions count as four states.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    pub a: DMatrix<f64>,
    pub b: DMatrix<f64>,
    pub c: DMatrix<f64>,
    pub d: DMatrix<f64>,
}

impl StateSpace {
    /// Room for the matrices of `system`.
    pub fn zeros(system: &System) -> Self {
        let (n, m, p) = (system.states().len(), system.inputs().len(), system.outputs().len());
        Self { a: DMatrix::zeros(n, n), b: DMatrix::zeros(n, m), c: DMatrix::zeros(p, n), d: DMatrix::zeros(p, m) }
    }
}

impl System {
    /// State-space form about (`x`, `u`).
    pub fn linearise(&self, ws: &mut Workspace<Dual>, t_s: f64, x: &[f64], u: &[f64]) -> StateSpace {
        let mut space = StateSpace::zeros(self);
        self.linearise_into(ws, t_s, x, u, &mut space);
        space
    }

    /// [`linearise`](Self::linearise) into matrices of the right size.
    ///
    /// One evaluation in dual numbers per state and input, exact to rounding. No allocation.
    pub fn linearise_into(&self, ws: &mut Workspace<Dual>, t_s: f64, x: &[f64], u: &[f64], space: &mut StateSpace) {
        let mut line = core::mem::take(&mut ws.line);
        for (at, value) in line.x.iter_mut().zip(x) {
            *at = Dual::new(*value, 0.0);
        }
        for (at, value) in line.u.iter_mut().zip(u) {
            *at = Dual::new(*value, 0.0);
        }
        for column in 0..x.len() + u.len() {
            let state = column < x.len();
            let variable = if state { &mut line.x[column] } else { &mut line.u[column - x.len()] };
            variable.derivative = 1.0;
            self.derivative_and_read(ws, t_s, &line.x, &line.u, &mut line.x_dot, &mut line.y);
            let variable = if state { &mut line.x[column] } else { &mut line.u[column - x.len()] };
            variable.derivative = 0.0;
            let (rates, readings, column) = if state {
                (&mut space.a, &mut space.c, column)
            } else {
                (&mut space.b, &mut space.d, column - x.len())
            };
            for (row, found) in line.x_dot.iter().enumerate() {
                rates[(row, column)] = found.derivative;
            }
            for (row, found) in line.y.iter().enumerate() {
                readings[(row, column)] = found.derivative;
            }
        }
        ws.line = line;
    }
}
