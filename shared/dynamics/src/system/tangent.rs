//! Small changes of state: quaternions are turned, everything else is added.

use super::System;
use super::geometry::{quaternion_of_vector, quaternion_product, rotation_vector_of_quaternion};
use crate::effect::Pick;

impl System {
    /// Numbers of a small change of state: a quaternion counts three.
    pub fn tangent_len(&self) -> usize {
        self.states().len() - self.layout.quaternions.len()
    }

    /// `x ⊕ delta`: a quaternion is turned by a rotation vector in body axes, everything else is
    /// added.
    pub fn retract(&self, x: &[f64], delta: &[f64], out: &mut [f64]) {
        assert!(x.len() == self.states().len() && out.len() == x.len());
        assert!(delta.len() == self.tangent_len());
        self.walk(|kind, state, tangent| match kind {
            Part::Number => out[state] = x[state] + delta[tangent],
            Part::Quaternion => {
                let step = quaternion_of_vector([delta[tangent], delta[tangent + 1], delta[tangent + 2]]);
                let turned = unit(quaternion_product(four(x, state), step));
                out[state..state + 4].copy_from_slice(&turned);
            }
        });
    }

    /// `b ⊖ a`, so that `a ⊕ (b ⊖ a) = b`.
    pub fn difference(&self, a: &[f64], b: &[f64], delta: &mut [f64]) {
        assert!(a.len() == self.states().len() && b.len() == a.len());
        assert!(delta.len() == self.tangent_len());
        self.walk(|kind, state, tangent| match kind {
            Part::Number => delta[tangent] = b[state] - a[state],
            Part::Quaternion => {
                let [w, x, y, z] = four(a, state);
                let turned = unit(quaternion_product([w, -x, -y, -z], four(b, state)));
                let shortest = if turned[0] < 0.0 { turned.map(|q| -q) } else { turned };
                delta[tangent..tangent + 3].copy_from_slice(&rotation_vector_of_quaternion(shortest));
            }
        });
    }

    /// Makes quaternions of unit length again: after integration steps, and for states from
    /// elsewhere.
    pub fn normalise<T: Pick>(&self, x: &mut [T]) {
        for first in &self.layout.quaternions {
            let quaternion = &mut x[*first..*first + 4];
            let square = quaternion.iter().fold(T::zero(), |sum, q| sum + *q * *q);
            let norm = square.sqrt();
            for q in quaternion {
                *q /= norm;
            }
        }
    }

    /// Calls `visit` with (part, first state, first component of the change), in the order of the
    /// states.
    fn walk(&self, mut visit: impl FnMut(Part, usize, usize)) {
        let (mut state, mut tangent) = (0, 0);
        while state < self.states().len() {
            if self.layout.quaternions.contains(&state) {
                visit(Part::Quaternion, state, tangent);
                (state, tangent) = (state + 4, tangent + 3);
            } else {
                visit(Part::Number, state, tangent);
                (state, tangent) = (state + 1, tangent + 1);
            }
        }
    }
}

enum Part {
    Number,
    Quaternion,
}

fn four(x: &[f64], at: usize) -> [f64; 4] {
    [x[at], x[at + 1], x[at + 2], x[at + 3]]
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}
