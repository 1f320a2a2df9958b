//! What it is: one craft that several partitions identify together. Each keeps the arc of its own
//! experiment and says what it knows of *all* parameters in one message; whoever folds the messages
//! of a generation in the order of the arcs has the same posterior, bit for bit.
//!
//! | file | subject |
//! |---|---|
//! | `parameters` | the list that all messages share, its hash, its blocks |
//! | `rows` | rows of a craft as bytes, and as a recording |
//! | `message` | a message as a telemetry sample, and back |
//! | `fold` | the posterior of messages, and how each tests the others |
//! | `places` | shared unknowns and those of one arc alone |
//! | `refusal` | an arc that no parameters explain, whatever steps are to come |
//! | `missing` | physics that an arc misses, as a sample and as part of a plant |
//! | `pace` | how many frames a diagnosis takes |
//! | `store` | the rows of arcs, kept from frame to frame |
//! | `keeper` | the partition that keeps an arc |
//!
//! An arc that is lost is a message that is missing: the posterior is wider and as honest.
//!
//! ```
//! use craft::fold::fold;
//! use craft::message::{Tag, received, sample};
//! use craft::parameters::Parameters;
//! use identification::joint::Message;
//! use nalgebra::{DMatrix, DVector};
//!
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants/oscillator.toml");
//! # let plant = plant_file::parse(file, &std::fs::read_to_string(file).unwrap()).unwrap().plant;
//! let parameters = Parameters::of_plant(&plant).unwrap();
//! let n = parameters.len();
//! // an arc that knows every parameter to half a prior's sigma, and found them off by as much
//! let (information, gradient) = (4.0 * DMatrix::identity(n, n), DVector::from_element(n, 2.0));
//! let message = Message { information, gradient, chi2: 98.0, log_determinant: 0.0, rows: 100 };
//! let priors: Vec<f64> = parameters.unknowns.iter().map(|unknown| unknown.prior).collect();
//! let travels = sample(Some(&message), &parameters, &priors, Tag { arc: 0, generation: 1, held_out: false });
//!
//! let heard = received(&travels, &parameters).unwrap();
//! let posterior = fold(&parameters, &[heard]).unwrap();
//! assert!((posterior.mean[0] - 2.0 / (1.0 + 4.0)).abs() < 1e-12); // the prior counts once
//! ```
//!
//! May import: telemetry, estimation, dynamics, channels, identification, plant_file, runtime.
//! Flies.
//!
//! Must never know: how a craft is simulated, a clock, a file.

#![forbid(unsafe_code)]

pub mod fold;
pub mod keeper;
pub mod message;
pub mod missing;
pub mod pace;
pub mod parameters;
mod places;
pub mod point;
pub mod refusal;
pub mod rows;
pub mod store;
#[cfg(test)]
mod trial;
