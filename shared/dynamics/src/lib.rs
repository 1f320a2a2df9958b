//! Equations of motion of any system of bodies, joints, tanks, appendages, actuators and sensors.
//!
//! What it is: a description in SI (`description`), what may act on it besides (`effect`), and both
//! compiled to equations in state space with readings and Jacobians (`system` over `multibody`);
//! commands over time (`signal`), exact lags and delays (`lags`), noise by (seed, stream, sample)
//! (`noise`).
//!
//! May import: `nalgebra`, `libm`, `num-traits`, `serde`, `strsim`, `thiserror`; of this workspace
//! `estimation` alone, for the exponential of a matrix.
//!
//! Must never know: which effects exist, files, clocks, threads, estimates.
//!
//! ```
//! use dynamics::multibody::{Data, JointKind, Link, Model, forward_dynamics};
//! use nalgebra::{Matrix3, Vector3};
//!
//! let length_m = 0.5; // a point mass on a light rod, turning about y
//! let joint = JointKind::Revolute { axis: Vector3::y() };
//! # let (parent, armature) = (None, 0.0);
//! # let (position_m, rotation) = (Vector3::zeros(), Matrix3::identity());
//! # let inertia_com_kg_m2 = Matrix3::zeros();
//! let com_m = Vector3::new(0.0, 0.0, -length_m);
//! let mass_kg = 2.0;
//! let bob =
//!     Link { parent, joint, position_m, rotation, mass_kg, com_m, inertia_com_kg_m2, armature };
//! let model = Model::new(&[bob], &[], Vector3::new(0.0, 0.0, -9.81)).unwrap();
//! let (mut data, mut acceleration) = (Data::new(&model), [0.0]);
//! forward_dynamics(&model, &mut data, &[0.1], &[0.0], &[0.0], &[], &mut acceleration);
//! assert!((acceleration[0] + 9.81 / length_m * 0.1_f64.sin()).abs() < 1e-12); // −g/l sin θ
//! ```

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
