//! The blind challenge: the value of a diagnosis on truth that it cannot know.
//!
//! What it is: benches (deployed plants) with equations of motion of this crate's own, by Lagrange
//! and by hand; an adaptive integrator that locates sticking and slipping; noise of its own; cases
//! drawn from a seed, hidden, hashed, diagnosed, opened and scored.
//!
//! May import: `plant-file`, `dynamics` (descriptions) and `catalogue` (names of effects) for the
//! plants that the tool receives; `identification` and `discovery` for the public call and its
//! verdict.
//!
//! Must never know: how the tool works; the equations of `dynamics` and `simulation`, but in the
//! one test that both describe the same nominal plant.
//!
//! ```
//! use challenge::{bench::BENCHES, campaign::open, case::{Class, case, digest}};
//!
//! let (seed, index) = (7, 0);
//! let sealed = case(seed, index); // drawn, simulated, hashed
//! assert_eq!(digest(&sealed.truth), sealed.digest);
//! assert_eq!(case(seed, index).digest, sealed.digest); // a case is a function of seed and index
//!
//! let truth = open(&sealed.truth).expect("the bytes of a truth");
//! assert_eq!(truth.class, Class::Null); // nothing is hidden in three of ten cases
//! assert!(truth.effects.is_empty() && BENCHES.iter().any(|bench| bench.plant == truth.plant));
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `bench`, `excite` | plants with the effects that they can hide; seeded experiments |
//! | `equations`, `machines` | equations of motion, one file per plant |
//! | `hidden`, `motion`, `simulate` | laws of effects; integration with dry friction; recordings |
//! | `disturb`, `random` | noise as stated or different from it; seeded streams |
//! | `realised`, `whiten` | detectability d, absorption by parameters, similarity to rivals |
//! | `case`, `campaign` | one case, drawn and sealed; all cases of a seed |
//! | `answer`, `score` | the verdict of the tool; the figures of the published table |
//!
//! Why not the simulator of obsid with effects? Truth and filter would share every law, every step
//! of integration and every mistake.

#![forbid(unsafe_code)]

pub mod answer;
pub mod bench;
pub mod campaign;
pub mod case;
pub mod disturb;
pub mod equations;
pub mod excite;
pub mod hidden;
pub mod machines;
pub mod motion;
pub mod random;
pub mod realised;
pub mod score;
pub mod simulate;
pub mod whiten;
