//! The benchmark problems, the experiment designs, and every method held against its bound.
//!
//! What it is: seeded Monte Carlo of problems whose truth is known, over the estimators that fly
//! (`physics`, `modal`) and those of the literature; and the models and methods that fly nowhere.
//!
//! May import: every crate of `shared`, and no `runtime`.
//!
//! Must never know: a service, a command line, a terminal, a file. No crate that flies imports it.
//!
//! ```
//! use bench::campaign::{Benchmark, Campaign};
//! use bench::inertial::Inertial;
//!
//! let benchmark = Inertial::bp1a().only(&["momentum-wls-bc"]);
//! let parameters = benchmark.parameters().expect("each parameter leaves a trace");
//! let campaign = Campaign::new(2, 1); // records, seed
//! let answers = campaign.run(&benchmark, &|| ());
//! let report = campaign.report(&benchmark, &parameters, &answers);
//! assert_eq!((report.methods.len(), report.methods[0].failed), (1, 0));
//! ```
//!
//! | file | problem or design |
//! |---|---|
//! | `campaign`, `report` | records from one seed on all cores; statistics beside bound and paper |
//! | `inertial` | BP1: the arm before and after capture, the target, each with what can go wrong |
//! | `slosh` | BP2: a tank on one axis and in the plane |
//! | `modes` | BP3: modes of a flexible appendage, free and in a control loop |
//! | `modal_records` | records of random structures with what real records have; loops with known input |
//! | `evaluation` | time and allocations of one evaluation of the equations of motion |
//! | `design` | joint motion and thrust with the least bound within limits |
//! | `experiment_design` | what a trajectory promises and what it requires of joints and base |
//! | `plants`, `simulated` | plants that come with the program; their records |
//! | `truth`, `arm_parameters` | the true parameters, read off a plant |
//!
//! | file | model or method that flies nowhere |
//! |---|---|
//! | `momentum_methods` | batch estimators on the momentum: LS, TLS, GTLS, IV, weighted |
//! | `momentum_extended` | the same with latency and external torque, or with an unknown momentum |
//! | `consider_batch` | the weighted fit with the covariance of the sensors' systematic errors |
//! | `rank_one` | the constraint of the eight parameters, imposed |
//! | `dynamic_equation_methods` | the dynamic equation row by row: LS, TLS, IV, raw or filtered |
//! | `arm_smoother` | maximum likelihood over motion and parameters, and its bound |
//! | `flying_filter` | unscented filter of the flying arm, and its weak form |
//! | `flying_bound` | the bound of the flying arm, by another recursion than its filter |
//! | `slosh_filter` | the tank by a square-root unscented filter, one pass or two |
//! | `slosh_srivc` | refined instrumental variables with the right prefilter |
//! | `slosh_observability` | what a formulation leaves without a trace |
//! | `slosh_calibration` | scale and delay of the thrust from a fast square wave |
//! | `slosh_planar` | propellant in the plane: springs, rail or pendulum on a free hub |
//! | `slosh_planar_record` | a flight in the plane: samples, noise, thrusters |
//! | `slosh_planar_scan`, `_id`, `_fit` | modes from the gyro, global search, maximum likelihood |
//! | `slosh_planar_second` | a second slosh mass: posterior of its frequency, damping and axis |
//! | `slosh_planar_thrust` | the planar tank and its calibrated thrusters, jointly |
//! | `slosh_suspension` | spring or pendulum, from levels of thrust |

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
pub mod modal_records;
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
