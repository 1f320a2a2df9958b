//! What the on-board estimators believe of the spacecraft, in closed form.
//!
//! What it is: models and estimators that fly in `services`, in fixed memory. What flies nowhere
//! (the literature's baselines, bounds, the tank in the plane) is in `bench`, with the tests that
//! compare the one with the other.
//!
//! May import: `estimation`, nalgebra, libm, serde. No std, no alloc.
//!
//! Must never know: a file, a clock, a random number, `bench`, or `dynamics` and `simulation`,
//! which make the truth that these models are tested against in another formulation.
//!
//! ```
//! use physics::excitation::{FourierTrajectory, MomentumPlan, predicted_sigma};
//! use physics::{free_floating::PlanarArm, momentum::ChannelSigma};
//!
//! let arm = PlanarArm {
//!     mass_kg: [400.0, 12.1, 11.7], inertia_com_kg_m2: [66.67, 17.27, 14.10],
//!     base_to_joint_m: [0.99, 0.99], joint_to_com_m: [1.9, 1.73], com_to_next_m: 0.168,
//! };
//! let gyro_and_encoders = ChannelSigma {
//!     omega0_rad_s: 2.6e-4, joint_rate_rad_s: [1e-4; 2], joint_angle_rad: [1.3e-5; 2],
//! };
//! let plan = MomentumPlan { h_nms: 68.0, sigma_h_nms: 0.0, duration_s: 60.0, rate_hz: 100.0 };
//! let (alpha, motion) = (arm.minimal_parameters(), FourierTrajectory::trajectory_b());
//! let sigma = predicted_sigma(&alpha, &motion, &plan, &gyro_and_encoders).expect("exciting");
//! assert!(sigma[0] < 1e-4 * alpha[0]); // a1 to 0.005 % from a minute
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `momentum` | angular momentum of base and two links, linear in eight or nine parameters |
//! | `free_floating` | the eight parameters before capture, their equations of motion |
//! | `mated` | the nine parameters after capture of a rigid target |
//! | `free_flying` | base with thrusters: eight linear parameters, regressor, equations of motion |
//! | `dynamic_equation` | the dynamic equation, linear in the parameters |
//! | `weak_form` | the same against test functions: no accelerations, no momentum |
//! | `inertial_estimator` | momentum samples in, parameters with covariance and verdicts out |
//! | `arm_filter` | unscented filter of motion and parameters |
//! | `arm_live` | momentum and filter together, sample by sample |
//! | `consider` | the second sigma: systematic errors of the sensors; identified or prior kept |
//! | `excitation` | Fourier trajectories of the joints and the bound they promise |
//! | `target` | the target's mass, centre and inertia from before and after capture |
//! | `target_statement` | what a cooperative target states of itself: tested, fused |
//! | `slosh` | propellant as spring, mass and damper on one axis |
//! | `slosh_arc` | any record length in 2048 blocks |
//! | `slosh_likelihood`, `slosh_scan` | likelihood over the arc, and its global start |
//! | `slosh_prior` | a tank believed before the record, and what the record did to it |
//! | `slosh_estimator` | maximum likelihood as it flies |
//! | `slosh_plan` | bound and stroke of an experiment before it is flown |
//! | `appendage` | modes of a flexible appendage on a free hub, bound and held-out check |

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
