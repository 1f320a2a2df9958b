//! What it is: every sample that partitions exchange, as code; the interface control document is
//! printed from it.
//!
//! A sample is a padding-free `#[repr(C)]` struct that begins with a [`Header`] (data: the same
//! bytes for the same seed and command) and travels beside [`Stamps`] (epoch, CRC, wall time of
//! send: never part of an identity). `samples!` in `topics.rs` is the one list: topic, type, depth,
//! producer, consumers. It determines the layout hashes, the size checks, the services of the
//! transport, the recording's schemas and `obsid icd`.
//!
//! ```
//! use telemetry::{IMU, Imu, Record, Sample, TOPICS, topic_named};
//!
//! let omega_bi_b_rad_s = [0.0, 0.0, 0.02];
//! let sample = Imu { interval_s: 0.01, omega_bi_b_rad_s, ..Imu::zeroed_at(30_000_000) };
//! assert_eq!(sample.header().t_meas_ns, 30_000_000);
//!
//! let topic = &TOPICS[IMU.id];
//! assert_eq!(topic_named(topic.name), Some(IMU.id));
//! assert_eq!((topic.record, topic.size), (Imu::NAME, size_of::<Imu>()));
//! let mut fields = topic.fields.iter();
//! let rate = fields.find(|field| field.name == "omega_bi_b_rad_s").expect("a field of `Imu`");
//! assert_eq!((rate.unit, rate.frame), ("rad/s", "body"));
//! ```
//!
//! May import: `zerocopy` (layout checks), `serde` (names in files), `crc32fast` and, behind the
//! feature `iceoryx2`, that crate's marker trait.
//!
//! Must never know: links, clocks, files, equations.
#![no_std]
#![forbid(unsafe_code)]

mod codes;
mod commands;
mod diagnosis;
mod events;
mod header;
mod health;
mod icd;
mod joint;
mod layout;
mod names;
mod records;
mod seal;
mod tables;
mod topics;

pub use codes::CODE_LISTS;
pub use commands::*;
pub use diagnosis::*;
pub use events::*;
pub use header::{Header, Stamps, crc32};
pub use health::*;
pub use icd::FieldInfo;
pub use joint::*;
pub use layout::{Layout, Record, layout_hash};
pub use names::{
    CodeList, DiagnosisVerdict, Domain, DoubtBasis, Experiment, Identifiability, InertiaAgreement, InertialStatus,
    JointVerdict, ModalStatus, ModeState, Parameter, ParameterBlock, PartitionId, Phase, Reason, SloshStatus,
    TARGET_CONTRADICTED, TARGET_CRC_WRONG, TARGET_NOT_SOLVED, TARGET_REJECTED, parameters, status_text,
    target_status_text,
};
pub use records::*;
pub use tables::*;
pub use topics::*;
