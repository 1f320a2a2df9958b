//! Modal parameters of vibrating structures from streams of measured motion: frequencies, damping ratios, shapes, and their uncertainty.
//!
//! May import: faer (single-threaded), libm, serde. Must never know: telemetry, partitions, clocks, files, spacecraft.
//!
//! Read [`identifier`] first: [`ModalIdentifier`] takes samples one by one in fixed memory and gives [`Mode`]s when asked.
//! Below it: [`streaming`] (exact block-Hankel Gram matrix), [`decimation`], [`ssi_cov`] (all orders from one factorisation),
//! [`stabilisation`] and [`selection`] (which poles are modes), [`uncertainty`], [`mac`]. Before it: [`onset`] (a jump ends a segment).
#![forbid(unsafe_code)]

pub mod decimation;
mod history;
pub mod identifier;
pub mod mac;
pub mod onset;
pub mod selection;
pub mod ssi_cov;
pub mod stabilisation;
pub mod streaming;
#[cfg(test)]
#[path = "../tests/cases/noise.rs"]
mod test_noise;
pub mod uncertainty;
pub mod weighting;

pub use faer::c64;
pub use identifier::{Config, ModalError, ModalIdentifier};
pub use onset::OnsetGate;
pub use selection::{Mode, Selection, SelectionSettings};
pub use stabilisation::{RejectedPole, Rejection, StabilityCriteria};
