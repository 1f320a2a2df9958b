//! Equations of motion of any system of bodies, joints, tanks, appendages, actuators and sensors.
//!
//! What it is: a description in SI (`description`), what may act on it besides (`effect`), and both compiled to equations in state space
//! with readings and Jacobians (`system` over `multibody`); commands over time (`signal`), exact lags and delays (`lags`), noise by
//! (seed, stream, sample) (`noise`).
//!
//! May import: `nalgebra`, `libm`, `num-traits`, `serde`, `strsim`, `thiserror`. Nothing of this workspace.
//!
//! Must never know: which effects exist, files, clocks, threads, estimates.

#![forbid(unsafe_code)]

pub mod beam;
pub mod description;
pub mod dual;
pub mod effect;
pub mod lags;
pub mod multibody;
pub mod noise;
pub mod real;
pub mod signal;
pub mod system;
pub mod zero_order_hold;
