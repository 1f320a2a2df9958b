//! Benchmark problems and experiment design: what they are to find, every method against its bound.
//!
//! May import: everything but services.
//!
//! | file | subject |
//! |---|---|
//! | `momentum_methods` | batch estimators on the momentum: LS, TLS, GTLS, IV, weighted with noise compensation |
//! | `momentum_extended` | the same with gyro latency and external torque, or with an unknown momentum and a modulated wheel |
//! | `rank_one` | the constraint of the eight parameters, imposed |
//! | `dynamic_equation_methods` | the same row by row: LS, TLS, IV, raw or filtered |
//! | `arm_smoother` | maximum likelihood over motion and parameters, and its bound |
//! | `flying_bound` | the bound of the flying arm, by another recursion than its filter |
//! | `flying_filter` | unscented filter of the flying arm, and its weak form |
//! | `experiment_design` | what a trajectory promises and what it asks of joints and base |
//! | `slosh_filter` | the same parameters by a square-root unscented filter, one pass or two |
//! | `slosh_observability` | what a formulation leaves without a trace |
//! | `slosh_calibration` | scale and delay of the thrust from a fast square wave |
//! | `slosh_planar` | propellant in the plane: springs, rail or pendulum on a free hub |
//! | `slosh_planar_record` | what is told of a flight in the plane: samples, noise, thrusters |
//! | `slosh_planar_scan`, `slosh_planar_id`, `slosh_planar_fit` | modes from the gyro, global search, maximum likelihood |
//! | `slosh_planar_second` | a second slosh mass: posterior over its frequency, damping and axis |
//! | `slosh_planar_thrust` | the planar tank and its calibrated thrusters, jointly |
//! | `slosh_suspension` | spring or pendulum, from levels of thrust |
//! | `slosh_srivc` | refined instrumental variables: the literature's estimator with the right prefilter |

#![forbid(unsafe_code)]

pub mod arm_parameters;
pub mod arm_smoother;
pub mod campaign;
pub mod consider_batch;
pub mod design;
pub mod dynamic_equation_methods;
pub mod evaluation;
pub mod experiment_design;
pub mod flying_bound;
pub mod flying_filter;
pub mod inertial;
pub mod modes;
pub mod momentum_extended;
pub mod momentum_methods;
pub mod plants;
pub mod rank_one;
pub mod report;
mod simulated;
pub mod slosh;
pub mod slosh_calibration;
pub mod slosh_filter;
pub mod slosh_observability;
pub mod slosh_planar;
pub mod slosh_planar_fit;
pub mod slosh_planar_id;
pub mod slosh_planar_record;
pub mod slosh_planar_scan;
pub mod slosh_planar_second;
pub mod slosh_planar_thrust;
pub mod slosh_srivc;
pub mod slosh_suspension;
pub mod truth;

#[cfg(test)]
mod benchmark_tank;
#[cfg(test)]
mod flown_arm;
#[cfg(test)]
#[path = "../../estimation/src/seeded_noise.rs"]
mod seeded_noise;
#[cfg(test)]
mod simulated_arm;
