//! Header (data) and stamps (transport): what every sample carries.

use crate::layout::record;
#[cfg(feature = "iceoryx2")]
use iceoryx2::prelude::ZeroCopySend;

record! {
    /// First field of every sample. The same for the same seed and command, whichever partitions
    /// were killed and restarted.
    Header {
        layout: u32, "-", "-", "layout hash of the sample's type";
        source: u16, "-", "-", "producing partition";
        flags: u16, "-", "-", "reserved, 0";
        seq: u64, "-", "-", "sequence number, contiguous from 1 over all epochs of the source";
        t_meas_ns: u64, "ns", "-", "time of measurement: start of the interval the sample speaks of";
    }
}

impl Header {
    /// A header for time `t_meas_ns`. Layout, source and sequence number stay 0 until the runtime
    /// sends the sample.
    #[must_use]
    pub const fn at(t_meas_ns: u64) -> Self {
        Header { layout: 0, source: 0, flags: 0, seq: 0, t_meas_ns }
    }
}

record! {
    /// User header of the transport: changes from run to run, never enters an estimate or a digest.
    #[derive(Default)]
    Stamps {
        epoch: u32, "-", "-", "how often the source was started before";
        crc32: u32, "-", "-", "CRC-32 (IEEE) over the payload";
        sent_ns: u64, "ns", "-", "CLOCK_MONOTONIC at send";
    }
}

/// CRC-32 (IEEE 802.3, reflected, polynomial 0xEDB88320) of a payload, as [`Stamps`] carry it.
#[must_use]
pub fn crc32(payload: &[u8]) -> u32 {
    crc32fast::hash(payload)
}
