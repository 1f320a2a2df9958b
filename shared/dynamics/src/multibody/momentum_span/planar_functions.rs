//! Functions of the state in which the momentum of a planar tree of revolute joints is linear.

use crate::multibody::Model;
use crate::multibody::model::Joint;

/// Functions of a planar tree of revolute joints: with `w_i` the absolute rate of body i and `φ_ij`
/// the angle between two bodies, `w_i`, `(w_i + w_j) cos φ_ij`, `(w_i + w_j) sin φ_ij` (the
/// quadratic form of the inertia in absolute rates).
///
/// `None` when link 0 is not a planar base or a joint slides. Bodies fixed to one another count
/// once.
pub fn planar_tree_functions(model: &Model) -> Option<PlanarFunctions> {
    if model.links[0].joint != Joint::FreePlanar {
        return None;
    }
    let mut bodies: Vec<Vec<usize>> = vec![Vec::new()]; // joints between base and body, as links
    let mut body_of = vec![0; model.links.len()];
    for (i, link) in model.links.iter().enumerate().skip(1) {
        let carrier = body_of[link.parent.checked_sub(1)?];
        match link.joint {
            Joint::Fixed => body_of[i] = carrier,
            Joint::Revolute { .. } => {
                let mut joints = bodies[carrier].clone();
                joints.push(i);
                bodies.push(joints);
                body_of[i] = bodies.len() - 1;
            }
            _ => return None,
        }
    }
    let coordinates = |joints: &Vec<usize>| joints.iter().map(|i| (model.links[*i].q, model.links[*i].v)).collect();
    Some(PlanarFunctions { bodies: bodies.iter().map(coordinates).collect() })
}

/// See [`planar_tree_functions`].
#[derive(Clone, Debug, PartialEq)]
pub struct PlanarFunctions {
    /// (q, v) indices of the joints between the base and each body.
    bodies: Vec<Vec<(usize, usize)>>,
}

impl PlanarFunctions {
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let n = self.bodies.len();
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// `"w1"`, `"(w0+w2) cos(phi2-phi0)"` …
    pub fn names(&self) -> Vec<String> {
        let single = (0..self.bodies.len()).map(|i| format!("w{i}"));
        let double = self
            .pairs()
            .flat_map(|(i, j)| ["cos", "sin"].map(|function| format!("(w{i}+w{j}) {function}(phi{j}-phi{i})")));
        single.chain(double).collect()
    }

    /// Values of the functions; the base's rate is `v[0]`.
    pub fn evaluate(&self, q: &[f64], v: &[f64], values: &mut [f64]) {
        let rate = |i: usize| v[0] + self.bodies[i].iter().map(|(_, v_index)| v[*v_index]).sum::<f64>();
        let angle = |i: usize| self.bodies[i].iter().map(|(q_index, _)| q[*q_index]).sum::<f64>();
        for (i, value) in values.iter_mut().take(self.bodies.len()).enumerate() {
            *value = rate(i);
        }
        for ((i, j), two) in self.pairs().zip(values[self.bodies.len()..].chunks_exact_mut(2)) {
            let (sin, cos) = libm::sincos(angle(j) - angle(i));
            two[0] = (rate(i) + rate(j)) * cos;
            two[1] = (rate(i) + rate(j)) * sin;
        }
    }
}
