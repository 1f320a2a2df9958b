//! Equations of motion `M(q) q'' = f(q, q', u)` in the closed form of each plant, and its
//! parameters by name.

use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;

/// Most degrees of freedom of a machine, hidden ones included.
pub const DOF_MAX: usize = 5;

/// Coordinates, rates or forces; zero beyond `dof`.
pub type Vector = SVector<f64, DOF_MAX>;
/// A matrix over coordinates; the identity beyond `dof`.
pub type Matrix = SMatrix<f64, DOF_MAX, DOF_MAX>;

/// Lagrange's equations of one plant, derived by hand. Units: SI; coordinates and sensors in the
/// order of the plant file.
pub trait Equations: Send + Sync {
    fn dof(&self) -> usize;

    /// Mass matrix; the identity beyond `dof`.
    fn mass(&self, q: &Vector) -> Matrix;

    /// Generalised forces: gravity, springs, viscous friction, gyroscopic terms, inputs `u`.
    fn force(&self, q: &Vector, v: &Vector, u: &[f64]) -> Vector;

    /// True readings of an instant, one per sensor; `a` is q''.
    fn read(&self, q: &Vector, v: &Vector, a: &Vector, y: &mut [f64]);

    /// Readings averaged over an interval, from (q, v) at both ends; `None`: the sensors read
    /// instants.
    fn read_mean(&self, _begin: (&Vector, &Vector), _end: (&Vector, &Vector), _dt_s: f64) -> Option<Vec<f64>> {
        None
    }
}

/// Values of the parameters of a plant file by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers(pub BTreeMap<String, f64>);

impl Numbers {
    /// Every parameter of `plant` at its value.
    #[must_use]
    pub fn of(plant: &dynamics::description::Plant) -> Self {
        Self(plant.parameters().into_iter().map(|parameter| (parameter.name, parameter.value)).collect())
    }

    /// # Panics
    /// The plant file has no such name: the machine belongs to another file.
    #[must_use]
    pub fn get(&self, name: &str) -> f64 {
        *self.0.get(name).unwrap_or_else(|| panic!("the plant file has no number '{name}'"))
    }

    /// As [`Numbers::get`], and zero for a name that the file does not have.
    #[must_use]
    pub fn or_zero(&self, name: &str) -> f64 {
        self.0.get(name).copied().unwrap_or(0.0)
    }
}

/// Hidden structure: parts that the plant file does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extra {
    /// A further slosh mass or bending mode: ratio to the first one, frequency \[Hz\], damping
    /// ratio.
    pub second: Option<[f64; 3]>,
    /// A compliant gear: compliance [rad/(N m)], damping ratio.
    pub gear: Option<[f64; 2]>,
}
