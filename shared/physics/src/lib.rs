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
//! | `consider` | the second sigma: what the sensor sheet's systematic errors may do; identified or prior kept |
//! | `weak_form` | the dynamic equation against test functions: no accelerations, no momentum |
//! | `arm_filter` | unscented filter of motion and parameters |
//! | `arm_live` | momentum and filter together, sample by sample, as they fly |
//! | `free_flying` | base with thrusters: eight linear parameters, their regressor, its momentum form, equations of motion |
//! | `mated` | the nine parameters after capture of a rigid target |
//! | `target` | the target's mass, centre and inertia from before and after capture |
//! | `target_statement` | what a cooperative target states of itself: tested, fused |
//! | `inertial_estimator` | momentum samples in, parameters with covariance and verdicts out |
//! | `excitation` | Fourier trajectories of the joints and the bound they promise |
//! | `slosh` | propellant as spring, mass and damper on one axis |
//! | `slosh_arc` | any record length in 2048 blocks |
//! | `slosh_scan`, `slosh_likelihood`, `slosh_estimator` | global start and maximum likelihood over the arc |
//! | `slosh_prior` | a tank believed before the record, and what the record did to it |
//! | `slosh_plan` | bound and stroke of an experiment before it is flown |
//! | `appendage` | modes of a flexible appendage on a free hub, bound and held-out check of a free decay |

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod appendage;
pub mod arm_filter;
pub mod arm_live;
pub mod consider;
pub mod dynamic_equation;
pub mod excitation;
pub mod free_floating;
pub mod free_flying;
pub mod inertial_estimator;
pub mod mated;
pub mod momentum;
#[cfg(test)]
#[path = "../../estimation/src/seeded_noise.rs"]
mod seeded_noise;
pub mod slosh;
pub mod slosh_arc;
pub mod slosh_estimator;
pub mod slosh_likelihood;
pub mod slosh_plan;
pub mod slosh_prior;
pub mod slosh_scan;
pub mod target;
pub mod target_statement;
pub mod weak_form;
