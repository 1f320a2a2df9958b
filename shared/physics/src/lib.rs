//! Closed-form models that fly: what the on-board estimators believe about the spacecraft.
//!
//! May import: estimation, nalgebra, libm, serde. No std, no alloc. Must never know: a file, a clock, a random number,
//! or `plant`, which makes the truth these models are tested against in another formulation.
//!
//! | file | subject |
//! |---|---|
//! | `momentum` | regressor of the angular momentum of base and two links, eight or nine parameters |
//! | `free_floating` | the eight parameters before capture, from the physical ones, and their equations of motion |
//! | `dynamic_equation` | regressor of their dynamic equation |
//! | `free_flying` | base with thrusters: eight linear parameters, their regressor, its momentum form, equations of motion |
//! | `mated` | the nine parameters after capture of a rigid target |
//! | `inertial_estimator` | momentum samples in, parameters with covariance and verdicts out |
//! | `excitation` | Fourier trajectories of the joints and the bound they promise |
//! | `slosh` | propellant as spring, mass and damper on one axis |
//! | `slosh_arc` | any record length in 2048 blocks |
//! | `slosh_scan`, `slosh_likelihood`, `slosh_estimator` | global start and maximum likelihood over the arc |
//! | `appendage` | modes of a flexible appendage on a free hub, bound and held-out check of a free decay |

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod appendage;
pub mod dynamic_equation;
pub mod excitation;
pub mod free_floating;
pub mod free_flying;
pub mod inertial_estimator;
pub mod mated;
pub mod momentum;
#[cfg(test)]
mod seeded_noise;
pub mod slosh;
pub mod slosh_arc;
pub mod slosh_estimator;
pub mod slosh_likelihood;
pub mod slosh_scan;
