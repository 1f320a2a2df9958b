//! Modal parameters of vibrating structures from streams of measured motion: frequencies, damping ratios, shapes, and their uncertainty.
//!
//! May import: faer (single-threaded), libm, serde. Must never know: telemetry, partitions, clocks, files, spacecraft.
//!
//! Two halves. What flies: [`identifier`], samples one by one in fixed memory, [`Mode`]s when asked. On the ground: [`methods`], one
//! list over whole [`record`]s, [`maximum_likelihood`] with known inputs the estimator of record; [`frequency_responses`]; [`advice`] and [`drift`].
//!
//! Below the first: [`streaming`] (exact block-Hankel Gram matrix), [`decimation`], [`ssi_cov`] (all orders from one factorisation),
//! [`stabilisation`] and [`selection`] (which poles are modes), [`uncertainty`], [`mac`]; [`tracking`] (which mode is which). Before it: [`onset`] (a jump ends a segment).
#![forbid(unsafe_code)]

pub mod advice;
pub mod decimation;
pub mod drift;
pub mod era;
pub mod frequency_responses;
pub mod gram;
mod history;
pub mod identifier;
mod leading;
pub mod lsce;
pub mod mac;
pub mod maximum_likelihood;
pub mod methods;
pub mod model_order;
pub mod onset;
mod participation;
pub mod po_moesp;
mod projection;
pub mod rational_fraction;
pub mod record;
pub mod selection;
pub mod ssi_cov;
pub mod stabilisation;
pub mod streaming;
#[cfg(test)]
#[path = "../tests/cases/noise.rs"]
mod test_noise;
pub mod tracking;
pub mod uncertainty;
pub mod weighting;

pub use faer::c64;
pub use identifier::{Config, ModalError, ModalIdentifier};
pub use onset::OnsetGate;
pub use selection::{Mode, Selection, SelectionSettings};
pub use stabilisation::{RejectedPole, Rejection, StabilityCriteria};
