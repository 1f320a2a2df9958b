//! The plant as a predictor of its own recording: extended Kalman filter, frozen gains,
//! innovations.
//!
//! ```text
//! z = [δx | w | ℓ | x at the beginning of a mean | v]
//!     state, actuator noise held between switches, lags of sensors, AR(1) noise
//! ν_k = y_k − h(x̂_k, u_k + ŵ_k),   z ← z ⊕ K_k ν_k,   x ← flow(x, u + ŵ)
//! ```
//!
//! An accelerometer feels what its actuators do; with the held noise w among the states this
//! correlation needs no special form. The nonlinear pass uses gains K that are frozen for a fit.
//! [`Linear`] keeps what is linear about it: transitions and rows of measurement by differences of
//! the very functions of the pass. Noise of another size or colour then needs no nonlinear pass:
//! the [`Gains`] of any noise follow from a Riccati recursion on `Linear`, and [`whiten`] turns the
//! innovations of the frozen filter (and every column of sensitivities) into those of the new one,
//! exactly as far as the plant is linear.
//!
//! Process noise: what the plant states of its actuators, and a disturbance at every joint and free
//! body that nothing drives, at first far below what the sensors see.

mod attitude;
mod dense;
mod disturbances;
mod equations;
mod frozen;
pub(crate) mod gains;
mod gradient;
mod horizon;
mod initial;
mod initial_sigmas;
mod jacobian;
mod layout;
mod linear;
mod linearise;
mod noise_model;
mod propagator;
mod recursion;
mod rows;
mod sensitivity;
mod transition;
mod whiten;
mod wide;

pub use disturbances::{DISTURBANCE, equip};
pub use equations::{crossed, products};
pub use frozen::Frozen;
pub use gains::{Gains, gains, state_sigmas};
pub use gradient::{Gradient, Slope, gradient};
pub use horizon::{Ahead, ahead};
pub use initial::Start;
pub use initial_sigmas::initial_sigmas;
pub use layout::{Layout, tangent_names};
pub use linear::Linear;
pub use linearise::{linearise, linearise_along};
pub use noise_model::NoiseModel;
pub use propagator::Propagator;
pub(crate) use propagator::step_s;
pub use sensitivity::{Moved, sensitivities};
pub use whiten::whiten;

#[cfg(test)]
mod tests;
