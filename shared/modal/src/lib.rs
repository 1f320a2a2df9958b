//! Modal parameters of vibrating structures from measured motion: frequency, damping ratio, shape,
//! uncertainty.
//!
//! What it is: an [`identifier`] that flies (samples one by one, fixed memory, [`Mode`]s on
//! request), and [`methods`] for whole [`record`]s on the ground, of which [`maximum_likelihood`]
//! with known inputs is the reference.
//!
//! May import: faer (single-threaded), libm, serde.
//!
//! Must never know: telemetry, partitions, clocks, files, spacecraft.
//!
//! ```
//! use modal::{Config, ModalIdentifier};
//!
//! let (rate_hz, omega_rad_s, zeta) = (50.0, std::f64::consts::TAU * 3.0, 0.02);
//! let mut identifier = ModalIdentifier::new(Config { halvings: 0, ..Config::new(1, rate_hz) });
//! let mut random = 1_u32; // a linear congruential generator
//! for k in 0..1000 {
//!     random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
//!     let (t_s, uniform) = (f64::from(k) / rate_hz, f64::from(random) / f64::from(u32::MAX));
//!     let noise = 1e-3 * (uniform - 0.5);
//!     identifier.push(&[(-zeta * omega_rad_s * t_s).exp() * (omega_rad_s * t_s).sin() + noise]);
//! }
//! let modes = identifier.identify().expect("a mode of a free decay");
//! let mode = modes.iter().find(|mode| (mode.frequency_hz - 3.0).abs() < 0.01).expect("3 Hz");
//! assert!((mode.damping_ratio - zeta).abs() < 0.002);
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `identifier` | the identifier in flight: samples in, modes out |
//! | `best_rate` | of modes seen at several rates, the one that is reported |
//! | `streaming`, `gram` | exact block-Hankel Gram matrix of a stream or of a record |
//! | `stretch` | products of the Gram matrix of a part of a record, without the matrix |
//! | `operational` | a whole record without inputs, as it is: gaps, tones, late channels |
//! | `tones` | tones of machines: found, distinguished from modes, taken out |
//! | `pairs`, `short_gaps` | a stationary record with samples missing: covariances of pairs; short gaps filled |
//! | `decimation` | half the sample rate behind an anti-alias filter |
//! | `onset` | a jump in the motion ends a segment |
//! | `ssi_cov`, `weighting` | covariance-driven subspace identification, all orders at once |
//! | `stabilisation`, `selection` | poles that persist over orders; poles that are modes |
//! | `uncertainty`, `shape_uncertainty` | standard deviations of frequency, damping and shape |
//! | `mac`, `mode_sets` | assurance criteria and collinearity of shapes; two sets of modes compared |
//! | `tracking` | the identity of modes over successive answers |
//! | `methods`, `record` | every method by name, over whole records |
//! | `maximum_likelihood`, `model_order` | variable projection, known inputs; number of modes by BIC |
//! | `known_input` | search, direct term and verdict of a record with known input, in a loop or not |
//! | `adequacy`, `innovations` | tests of the residuals; known input with a disturbance |
//! | `era`, `lsce`, `po_moesp`, `rational_fraction` | methods of the literature |
//! | `frequency_responses` | modes of measured frequency responses |
//! | `separable`, `residual_correlation`, `lag_window` | least squares with weights, their residuals; windows |
//! | `hand_selection` | poles of the sweep that a person points at |
//! | `setups` | several setups with common reference sensors: merged after or before identification |
//! | `low_rate` | a record at a lower rate behind an anti-alias filter; trends taken out |
//! | `singular_values` | singular values of spectral densities and of response matrices |
//! | `advice`, `drift` | whether a record can determine its modes; changes of modes within a record |
#![forbid(unsafe_code)]

pub mod adequacy;
pub mod advice;
mod best_rate;
pub mod decimation;
pub mod drift;
pub mod era;
pub mod frequency_responses;
pub mod gram;
pub mod hand_selection;
mod history;
pub mod identifier;
mod innovations;
pub mod known_input;
mod lag_window;
mod leading;
pub mod low_rate;
pub mod lsce;
pub mod mac;
pub mod maximum_likelihood;
pub mod methods;
pub mod mode_sets;
pub mod model_order;
pub mod onset;
pub mod operational;
pub mod pairs;
mod participation;
pub mod po_moesp;
mod projection;
pub mod rational_fraction;
pub mod record;
mod residual_correlation;
mod seeded;
pub mod selection;
mod separable;
pub mod setups;
pub mod shape_uncertainty;
mod short_gaps;
pub mod singular_values;
pub mod ssi_cov;
pub mod stabilisation;
pub mod streaming;
pub mod stretch;
#[cfg(test)]
#[path = "../tests/laws/cases/noise.rs"]
mod test_noise;
pub mod tones;
pub mod tracking;
pub mod uncertainty;
pub mod weighting;

pub use faer::c64;
pub use identifier::{Config, ModalError, ModalIdentifier};
pub use onset::OnsetGate;
pub use selection::{Mode, Selection, SelectionSettings};
pub use shape_uncertainty::ShapeScale;
pub use stabilisation::{RejectedPole, Rejection, StabilityCriteria};
