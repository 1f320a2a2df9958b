//! The likelihood of a plant with unknown parameters: linearised filter, fit, information,
//! prediction of held-out data.
//!
//! What it is: recordings matched to a plant (`problem`), their innovations and gradients
//! (`filter`), maximum a posteriori fits of parameters and noise (`fit`), several recordings with
//! plants of their own as one estimate (`joint`), what an experiment would tell (`information`),
//! prediction of data that were not fitted (`held_out`), work counted alike on every machine
//! (`work`).
//!
//! May import: `channels`, `dynamics`, `catalogue`, `estimation`. Flight partitions may import it.
//! Inside, `problem` ← `filter` ← `fit` ← `held_out`, `joint`, never the other way.
//!
//! Must never know: `simulation`, files, clocks, threads' order, what is decided from it.
//!
//! ```
//! use identification::fit::{EstimationSession, fit};
//! use identification::problem::Problem;
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants/pendulum.toml");
//! # let text = std::fs::read_to_string(file).unwrap();
//! # let plant = plant_file::parse(file, &text).unwrap().plant;
//! # let recording = simulation::record(&plant, 5, 5.0, &mut |_| {}).unwrap();
//! // a plant with priors, and a recording of it
//! let problem = Problem::new(&plant, &[recording], &[]).unwrap();
//! let session = EstimationSession::new(&problem, 1).unwrap();
//! let fitted = fit(&session, &plant, &session.prior(), &session.noise, 4).unwrap();
//! assert!(fitted.converged);
//! assert!((fitted.chi2_per_sample - 1.0).abs() < 0.2); // the noise is all that is left
//! for (i, unknown) in problem.unknowns.iter().enumerate() {
//!     println!("{} = {} ± {}", unknown.name, fitted.theta[i], fitted.sigma[i]);
//! }
//! ```

#![forbid(unsafe_code)]

pub mod dot;
pub mod filter;
pub mod fit;
pub mod held_out;
pub mod information;
pub mod joint;
#[cfg(test)]
mod noise;
pub mod problem;
pub mod statistics;
#[cfg(test)]
mod synthetic;
pub mod work;
