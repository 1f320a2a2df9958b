//! Random trees and states for the tests of the multibody algorithms.

mod conservation;
mod derivatives;
mod descriptions;
mod golden;
mod identities;
mod internal;
mod invariance;
mod planar;

use super::*;
use crate::dual::Dual;
use crate::noise::Stream;
use crate::real::Real;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

/// Numbers in (−1, 1), one after the other.
struct Draw {
    stream: Stream,
    sample: u64,
}

impl Draw {
    fn new(seed: u64) -> Self {
        Self { stream: Stream::new(seed, "random tree"), sample: 0 }
    }

    fn number(&mut self) -> f64 {
        self.sample += 1;
        2.0 * self.stream.uniform_pair(self.sample)[1] - 1.0
    }

    fn index(&mut self, below: usize) -> usize {
        (((self.number() + 1.0) / 2.0) * below as f64) as usize
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.number(), self.number(), self.number())
    }

    fn unit(&mut self) -> Vector3<f64> {
        self.vector().normalize()
    }

    fn rotation(&mut self) -> Matrix3<f64> {
        Rotation3::new(self.vector() * 2.0).into_inner()
    }

    fn numbers(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.number()).collect()
    }

    /// A body whose inertia is that of masses on its principal axes.
    fn link(&mut self, parent: Option<usize>, joint: JointKind) -> Link {
        let r = self.rotation();
        let (a, b, c) = (self.number().abs() + 0.1, self.number().abs() + 0.1, self.number().abs() + 0.1);
        let armature = match joint {
            JointKind::Revolute { .. } | JointKind::Prismatic { .. } => 0.2 * self.number().abs(),
            _ => 0.0,
        };
        Link {
            parent,
            joint,
            position_m: self.vector(),
            rotation: self.rotation(),
            mass_kg: 1.0 + 4.0 * self.number().abs(),
            com_m: self.vector() * 0.5,
            inertia_com_kg_m2: r * Matrix3::from_diagonal(&Vector3::new(a + b, b + c, c + a)) * r.transpose(),
            armature,
        }
    }

    fn joint(&mut self) -> JointKind {
        match self.index(8) {
            0 => JointKind::FreeSpatial,
            1 => JointKind::FreePlanar,
            2 => JointKind::Fixed,
            3 | 4 => JointKind::Prismatic { axis: self.unit() },
            _ => JointKind::Revolute { axis: self.unit() },
        }
    }

    fn internal(&mut self, link: usize) -> InternalCoordinate {
        let coupling: [f64; 6] = core::array::from_fn(|_| 0.3 * self.number());
        InternalCoordinate { link, mass: 1.0 + self.number().abs(), coupling }
    }

    /// A forest of up to eight links with joints of every kind, and up to three internal
    /// coordinates.
    fn tree(&mut self, root: JointKind, gravity: Vector3<f64>) -> Model {
        let mut links = vec![self.link(None, root)];
        for i in 1..3 + self.index(6) {
            let parent = if self.index(10) == 0 { None } else { Some(self.index(i)) };
            let joint = self.joint();
            let link = self.link(parent, joint);
            links.push(link);
        }
        let internals: Vec<_> = (0..self.index(4))
            .map(|_| {
                let link = self.index(links.len());
                self.internal(link)
            })
            .collect();
        Model::new(&links, &internals, gravity).expect("a random tree with mass everywhere is a mechanism")
    }

    /// Positions with unit quaternions.
    fn position(&mut self, model: &Model) -> Vec<f64> {
        let mut q = model.neutral_position();
        let step: Vec<f64> = self.numbers(model.v_len()).iter().map(|x| 2.0 * x).collect();
        let neutral = q.clone();
        integrate_position(model, &neutral, &step, 1.0, &mut q);
        q
    }

    fn state(&mut self, model: &Model) -> State {
        let q = self.position(model);
        let (v, a) = (self.numbers(model.v_len()), self.numbers(model.v_len()));
        let tau = self.numbers(model.v_len()).iter().map(|x| 5.0 * x).collect();
        let wrench = (0..model.links_len()).map(|_| core::array::from_fn(|_| 3.0 * self.number())).collect();
        State { q, v, a, tau, wrench }
    }
}

struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
    wrench: Vec<[f64; 6]>,
}

const GRAVITY: Vector3<f64> = Vector3::new(0.7, -2.0, -9.0);

fn roots() -> [JointKind; 5] {
    [
        JointKind::FreeSpatial,
        JointKind::FreePlanar,
        JointKind::Fixed,
        JointKind::Revolute { axis: Vector3::z() },
        JointKind::Prismatic { axis: Vector3::x() },
    ]
}

/// A hundred random trees with a random state each.
fn random_trees() -> impl Iterator<Item = (Model, State)> {
    (0..100).map(|seed| {
        let mut draw = Draw::new(seed);
        let model = draw.tree(roots()[seed as usize % 5], GRAVITY);
        let state = draw.state(&model);
        (model, state)
    })
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn accelerations(model: &Model, state: &State, wrench: &[[f64; 6]]) -> Vec<f64> {
    let mut acceleration = vec![0.0; model.v_len()];
    forward_dynamics(model, &mut Data::new(model), &state.q, &state.v, &state.tau, wrench, &mut acceleration);
    acceleration
}

fn efforts(model: &Model, q: &[f64], v: &[f64], a: &[f64], wrench: &[[f64; 6]]) -> Vec<f64> {
    let mut tau = vec![0.0; model.v_len()];
    inverse_dynamics(model, &mut Data::new(model), q, v, a, wrench, &mut tau);
    tau
}

fn mass(model: &Model, q: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(model.v_len(), model.v_len());
    mass_matrix(model, &mut Data::new(model), q, &mut matrix);
    matrix
}

/// Six joints with orthogonal wrist axes on a free base: the case of the speed figures.
fn six_joint_arm(base: JointKind, gravity: Vector3<f64>) -> Model {
    let (y, z) = (Vector3::y(), Vector3::z());
    let body = |parent, joint, x: f64, mass: f64| Link {
        parent,
        joint,
        position_m: Vector3::new(x, 0.1, 0.0),
        rotation: Matrix3::identity(),
        mass_kg: mass,
        com_m: Vector3::new(0.5 * x, 0.02, 0.01),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.1, 0.3, 0.35)) * mass * 0.2,
        armature: 0.0,
    };
    let mut links = vec![body(None, base, 0.8, 400.0)];
    for (i, axis) in [z, y, y, z, y, z].into_iter().enumerate() {
        links.push(body(Some(i), JointKind::Revolute { axis }, 0.7, 12.0 - i as f64));
    }
    Model::new(&links, &[], gravity).expect("an arm")
}
