//! Every sample that exists: the interface control document of obsid, as code.
//!
//! A sample is a padding-free `#[repr(C)]` struct that begins with a [`Header`] (data: the same bytes for the same
//! seed and command) and travels beside [`Stamps`] (epoch, CRC, wall time of send: never part of an identity).
//! `samples!` in [`topics`] is the one list: topic, type, depth, producer, consumers. From it follow the layout
//! hashes, the size checks, the services of the transport, the recording's schemas and `obsid icd`.
//!
//! May import: nothing but `zerocopy` (layout checks), `serde` (names in files), a CRC and, behind the feature `iceoryx2`, that crate's
//! marker trait. Must never know: links, clocks, files, equations.
#![no_std]
#![forbid(unsafe_code)]

mod header;
mod icd;
mod layout;
mod names;
mod records;
mod topics;

pub use header::{Header, Stamps, crc32};
pub use icd::FieldInfo;
pub use layout::{Layout, Record, layout_hash};
pub use names::{
    CODE_LISTS, CodeList, Domain, DoubtBasis, EventCode, Experiment, Identifiability, InertiaAgreement, InertialStatus,
    ModalStatus, ModeState, Parameter, PartitionId, Phase, Reason, SloshStatus, TARGET_CONTRADICTED, TARGET_CRC_WRONG,
    TARGET_NOT_SOLVED, TARGET_REFUSED, parameters, status_text, target_status_text,
};
pub use records::*;
pub use topics::*;
