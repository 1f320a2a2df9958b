//! The first, special formulations of the benchmark problems, kept as an independent check of the
//! general plant. Tests only.
//!
//! Each was written for one vehicle and from other equations than `multibody` and `system`: the arm
//! from the Jacobians of its bodies in inertial coordinates, the tank as two point masses in
//! absolute coordinates, the appendage as the matrices of a clamped beam's assumed modes. The
//! published numbers of the problems (parameters, modes, peaks of signals) are checked here, on the
//! special formulation; the tests of `simulation`, `system` and `multibody` compare the general
//! plant with it sample by sample.
//!
//! Nothing outside tests may use this: the truth is made by [`crate`] alone.

pub mod appendage;
pub mod arm;
pub mod arm_parameters;
pub mod chain;
pub mod hub_controller;
pub mod sensor;
pub mod slosh;
