//! Exact solution of `x' = A x + B u + c` with u held: what a linear plant does, whatever the step.

use crate::SimulationError;
use dynamics::dual::Dual;
use dynamics::system::{StateSpace, System, Workspace};
use dynamics::zero_order_hold::discretise;
use nalgebra::{DMatrix, DVector};

/// Largest relative difference of two linearisations that is still rounding.
const LINEAR_MAX: f64 = 1e-9;

/// A linear plant with its transitions over the intervals known beforehand.
pub(super) struct ExactHold {
    a: DMatrix<f64>,
    /// `[B c]`.
    b: DMatrix<f64>,
    transitions: Vec<Transition>,
    /// `[u; 1]`.
    input: DVector<f64>,
    next: DVector<f64>,
    term: DVector<f64>,
    product: DVector<f64>,
}

struct Transition {
    length_s: f64,
    phi: DMatrix<f64>,
    gamma: DMatrix<f64>,
}

impl ExactHold {
    /// About (`x`, `u`), after making sure that the equations are the same about another state,
    /// input and time.
    pub fn new(system: &System, t_s: f64, x: &[f64], u: &[f64], lengths_s: &[f64]) -> Result<Self, SimulationError> {
        let n = x.len();
        if system.tangent_len() != n {
            return Err(SimulationError::NotLinear { what: "the attitude", difference: 1.0 });
        }
        let here = affine(system, t_s, x, u);
        // another point: every number moved by its own amount
        let moved = |value: &f64, i: usize| value + 0.1 * (1.0 + value.abs()) * (1.0 + 0.37 * (i % 5) as f64);
        let x_2: Vec<f64> = x.iter().enumerate().map(|(i, value)| moved(value, i)).collect();
        let u_2: Vec<f64> = u.iter().enumerate().map(|(i, value)| moved(value, i + 2)).collect();
        let there = affine(system, t_s + 1.7, &x_2, &u_2);
        for (what, one, other) in [
            ("the state matrix", &here.0, &there.0),
            ("the input matrix", &here.1, &there.1),
            ("the constant", &here.2, &there.2),
        ] {
            let scale = one.norm().max(other.norm()).max(1e-300);
            // the constant is a difference of what the state and the inputs do
            let scale = if what == "the constant" { scale.max(here.0.norm()).max(here.1.norm()) } else { scale };
            let difference = (one - other).norm() / scale;
            if difference.is_nan() || difference > LINEAR_MAX {
                return Err(SimulationError::NotLinear { what, difference });
            }
        }
        let (a, inputs, constant) = here;
        let mut b = DMatrix::zeros(n, u.len() + 1);
        b.columns_mut(0, u.len()).copy_from(&inputs);
        b.column_mut(u.len()).copy_from(&constant);
        let transition = |length_s: &f64| {
            let (phi, gamma) = discretise(&a, &b, *length_s);
            Transition { length_s: *length_s, phi, gamma }
        };
        let transitions = lengths_s.iter().map(transition).collect();
        let zeros = || DVector::zeros(n);
        let input = DVector::from_element(u.len() + 1, 1.0);
        Ok(Self { transitions, input, next: zeros(), term: zeros(), product: zeros(), a, b })
    }

    /// Moves `x` on by `length_s` [s] under constant inputs `u`.
    pub fn advance(&mut self, u: &[f64], length_s: f64, x: &mut [f64]) {
        self.input.as_mut_slice()[..u.len()].copy_from_slice(u);
        let Some(known) = self.transitions.iter().find(|transition| transition.length_s == length_s) else {
            return self.advance_by_series(length_s, x);
        };
        self.term.copy_from_slice(x);
        self.next.gemv(1.0, &known.phi, &self.term, 0.0);
        self.next.gemv(1.0, &known.gamma, &self.input, 1.0);
        x.copy_from_slice(self.next.as_slice());
    }

    /// Any interval: `x(h) = x + Σ h^k/k! A^{k−1} (A x + b)`, in pieces over which `‖A‖ h ≤ ½`,
    /// where 18 terms leave 2e-23.
    fn advance_by_series(&mut self, length_s: f64, x: &mut [f64]) {
        const TERMS: u32 = 18;
        const PIECES_MAX: f64 = 1e6;
        let pieces = libm::ceil(2.0 * self.a.norm() * length_s).max(1.0);
        assert!(pieces <= PIECES_MAX, "the interval is not short beside any time constant");
        let h = length_s / pieces;
        for _ in 0..pieces as u32 {
            self.next.copy_from_slice(x);
            self.term.gemv(h, &self.a, &self.next, 0.0);
            self.term.gemv(h, &self.b, &self.input, 1.0);
            for k in 2..=TERMS + 1 {
                self.next += &self.term;
                self.product.gemv(h / f64::from(k), &self.a, &self.term, 0.0);
                core::mem::swap(&mut self.term, &mut self.product);
            }
            x.copy_from_slice(self.next.as_slice());
        }
    }
}

/// A, B and c of `x' = A x + B u + c` about a point.
fn affine(system: &System, t_s: f64, x: &[f64], u: &[f64]) -> (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>) {
    let StateSpace { a, b, .. } = system.linearise(&mut Workspace::<Dual>::new(system), t_s, x, u);
    let mut slope = DVector::zeros(x.len());
    system.derivative(&mut Workspace::<f64>::new(system), t_s, x, u, slope.as_mut_slice());
    let constant = slope - &a * DVector::from_column_slice(x) - &b * DVector::from_column_slice(u);
    let constant = DMatrix::from_column_slice(x.len(), 1, constant.as_slice());
    (a, b, constant)
}
