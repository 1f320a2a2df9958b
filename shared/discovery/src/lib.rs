//! Which physics a plant does not model: hypotheses, screening, decision, prediction, next
//! experiment.
//!
//! What it is: every effect of the catalogue scored at every site (`score`), the decision as one
//! comparison of sets of hypotheses in nats (`evidence`), what is tested of it and answered
//! (`diagnose`), the same from modes instead of time series (`features`), laws outside the catalogue
//! (`unknown_law`), an omnibus test of the residuals (`omnibus`), wrong channel metadata
//! (`mislabelled`, `against_plant`), the experiment that separates two effects (`next_experiment`).
//!
//! May import: `channels`, `identification`, `examination`, `simulation`, `catalogue`, `dynamics`,
//! `plant_file`, `estimation`. Inside, `score` ← `unknown_law` ← `diagnose` ← `evidence`, and
//! `diagnose` ← `features`; `omnibus` and `mislabelled` import none of these.
//!
//! Must never know: files, processes, clocks, the command line. Channels come in as numbers with
//! names and SI units; findings go out as data.
//!
//! ```
//! use discovery::diagnose::{Options, Verdict};
//! use discovery::evidence::diagnose;
//! use identification::problem::Problem;
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants/pendulum.toml");
//! # let text = std::fs::read_to_string(file).unwrap();
//! let plant = plant_file::parse(file, &text).unwrap().plant;
//! // a pendulum with dry friction, which its plant file does not model
//! let mut truth = plant.clone();
//! truth.add_effect("joint_coulomb", &"joint:pivot".parse().unwrap(), &[("force", 0.05)]).unwrap();
//! let recording = simulation::record(&truth, 5, 2.0, &mut |_| {}).unwrap();
//! let problem = Problem::new(&plant, &[recording], &[]).unwrap();
//! let found = diagnose(&problem, &Options::default(), &mut |_, _| {});
//! assert_ne!(found.verdict, Verdict::None); // something is missing
//! println!("{:?}: {}", found.verdict, found.reason);
//! ```

#![forbid(unsafe_code)]

pub mod against_plant;
pub mod diagnose;
pub mod evidence;
pub mod features;
pub mod mislabelled;
pub mod next_experiment;
pub mod omnibus;
mod outline;
pub mod score;
pub mod unknown_law;

pub use outline::planned as planned_work;

#[cfg(test)]
#[path = "../../identification/src/noise.rs"]
mod noise;
#[cfg(test)]
mod noisier;
#[cfg(test)]
#[path = "../../identification/src/synthetic.rs"]
mod synthetic;
// for `synthetic`, which names it as of its own crate
#[cfg(test)]
use identification::problem;
