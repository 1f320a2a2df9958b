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
//! | `momentum_methods` | batch estimators on the momentum: LS, TLS, GTLS, IV, weighted with noise compensation |
//! | `momentum_extended` | the same with gyro latency and external torque, or with an unknown momentum and a modulated wheel |
//! | `consider` | the second sigma: what the sensor sheet's systematic errors may do; identified or prior kept |
//! | `rank_one` | the constraint of the eight parameters, imposed |
//! | `weak_form` | the dynamic equation against test functions: no accelerations, no momentum |
//! | `dynamic_equation_methods` | the same row by row: LS, TLS, IV, raw or filtered |
//! | `arm_filter` | unscented filter of motion and parameters |
//! | `arm_live` | momentum and filter together, sample by sample, as they fly |
//! | `arm_smoother` | maximum likelihood over motion and parameters, and its bound |
//! | `free_flying` | base with thrusters: eight linear parameters, their regressor, its momentum form, equations of motion |
//! | `flying_bound` | the bound of the flying arm, by another recursion than its filter |
//! | `flying_filter` | unscented filter of the flying arm, and its weak form |
//! | `mated` | the nine parameters after capture of a rigid target |
//! | `target` | the target's mass, centre and inertia from before and after capture |
//! | `target_statement` | what a cooperative target states of itself: tested, fused |
//! | `inertial_estimator` | momentum samples in, parameters with covariance and verdicts out |
//! | `excitation` | Fourier trajectories of the joints and the bound they promise |
//! | `experiment_design` | what a trajectory promises and what it asks of joints and base |
//! | `slosh` | propellant as spring, mass and damper on one axis |
//! | `slosh_arc` | any record length in 2048 blocks |
//! | `slosh_scan`, `slosh_likelihood`, `slosh_estimator` | global start and maximum likelihood over the arc |
//! | `slosh_prior` | a tank believed before the record, and what the record did to it |
//! | `slosh_filter` | the same parameters by a square-root unscented filter, one pass or two |
//! | `slosh_observability` | what a formulation leaves without a trace |
//! | `slosh_calibration` | scale and delay of the thrust from a fast square wave |
//! | `slosh_plan` | bound and stroke of an experiment before it is flown |
//! | `slosh_planar` | propellant in the plane: springs, rail or pendulum on a free hub |
//! | `slosh_planar_record` | what is told of a flight in the plane: samples, noise, thrusters |
//! | `slosh_planar_scan`, `slosh_planar_id`, `slosh_planar_fit` | modes from the gyro, global search, maximum likelihood |
//! | `slosh_planar_second` | a second slosh mass: posterior over its frequency, damping and axis |
//! | `slosh_planar_thrust` | the planar tank and its calibrated thrusters, jointly |
//! | `slosh_suspension` | spring or pendulum, from levels of thrust |
//! | `slosh_srivc` | refined instrumental variables: the literature's estimator with the right prefilter |
//! | `appendage` | modes of a flexible appendage on a free hub, bound and held-out check of a free decay |

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod appendage;
pub mod arm_filter;
pub mod arm_live;
pub mod arm_smoother;
pub mod consider;
pub mod dynamic_equation;
pub mod dynamic_equation_methods;
pub mod excitation;
pub mod experiment_design;
pub mod flying_bound;
pub mod flying_filter;
pub mod free_floating;
pub mod free_flying;
pub mod inertial_estimator;
pub mod mated;
pub mod momentum;
pub mod momentum_extended;
pub mod momentum_methods;
pub mod rank_one;
#[cfg(test)]
#[path = "../../estimation/src/seeded_noise.rs"]
mod seeded_noise;
#[cfg(test)]
mod simulated_arm;
pub mod slosh;
pub mod slosh_arc;
pub mod slosh_calibration;
pub mod slosh_estimator;
pub mod slosh_filter;
pub mod slosh_likelihood;
pub mod slosh_observability;
pub mod slosh_plan;
pub mod slosh_planar;
pub mod slosh_planar_fit;
pub mod slosh_planar_id;
pub mod slosh_planar_record;
pub mod slosh_planar_scan;
pub mod slosh_planar_second;
pub mod slosh_planar_thrust;
pub mod slosh_prior;
pub mod slosh_scan;
pub mod slosh_srivc;
pub mod slosh_suspension;
pub mod target;
pub mod target_statement;
pub mod weak_form;
