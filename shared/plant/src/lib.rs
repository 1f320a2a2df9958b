//! The truth: simulated spacecraft that the identification is tested against.
//!
//! What it is: a free-floating arm in closed loop (BP1, before and after capture), sloshing propellant on
//! one axis (BP2), a flexible appendage on a rotating hub (BP3), and the noise of their sensors.
//!
//! May import: `nalgebra`, `libm`, `serde`. Nothing of this workspace.
//!
//! Must never know: `physics` and `estimation`. The flight estimators use minimal-parameter closed forms;
//! everything here is written from bodies, Jacobians and matrix exponentials instead, so that an error
//! in one formulation cannot hide in the other. Never: a clock, a thread, a random generator with a running
//! state. Noise is a function of (seed, stream name, sample number).
//!
//! Every simulator is rebuilt from its configuration and carries its changing part in a small serialisable
//! state (`state()`, `restore()`); equal configuration, state and commands give equal bits.

#![forbid(unsafe_code)]

pub mod appendage;
pub mod arm;
pub mod arm_parameters;
pub mod beam;
pub mod chain;
pub mod description;
pub mod dual;
pub mod effects;
pub mod file;
pub mod filter;
pub mod fourier_reference;
pub mod hub_controller;
pub mod information;
pub mod multibody;
pub mod noise;
pub mod real;
pub mod sensor;
pub mod simulation;
pub mod slosh;
pub mod system;
mod zero_order_hold;
