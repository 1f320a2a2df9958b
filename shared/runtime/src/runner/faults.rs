//! Faults of a drill, where they strike a partition.

use super::{RunError, Runner};
use crate::config::{Fault, KillPoint};
use crate::link::Link;
use telemetry::{EventCode, Header, IMU, Stamps, TopicId};

impl<L: Link> Runner<L> {
    /// The fault of this run that strikes this partition here, in its first life.
    pub(super) fn fault_at(&self, point: KillPoint, frame: u64, within: u64) -> Option<Fault> {
        let (id, is_first) = (self.id, self.epoch == 0);
        self.faults.iter().copied().find(|fault| match *fault {
            Fault::Kill { partition, frame: at, point: p } => {
                is_first && partition == id && p == point && at <= frame && frame < at + within
            }
            Fault::Tear { partition, frame: at, .. } => {
                is_first && partition == id && point == KillPoint::Checkpoint && at <= frame && frame < at + within
            }
            Fault::Hang { partition, frame: at } | Fault::Crash { partition, frame: at } => {
                is_first && partition == id && at == frame && point == KillPoint::Frame
            }
            Fault::KillAlways { partition, frame: at } => partition == id && frame >= at && point == KillPoint::Frame,
            Fault::Corrupt { .. } | Fault::Flood { .. } | Fault::Probe { .. } => false,
        })
    }

    pub(super) fn strike(&self, point: KillPoint, frame: u64) {
        if let (Some(hook), Some(fault)) = (self.fault_hook, self.fault_at(point, frame, 1)) {
            hook(&fault);
        }
    }

    /// Reports the events of a drill.
    pub(super) fn flood(&mut self) -> Result<(), RunError> {
        for index in 0..self.faults.len() {
            let Fault::Flood { partition, events } = self.faults[index] else { continue };
            let own = if partition == self.id { events } else { 0 };
            for number in 0..own {
                self.event(EventCode::SamplesLost, &[0.0, number.into()])?;
            }
        }
        Ok(())
    }

    /// Whether a damaged copy of the sample goes out before the good one.
    fn is_corrupted(&self, topic: TopicId, frame: Option<u64>) -> bool {
        let is_due = self.epoch == 0 && !self.corrupted[topic];
        self.faults.iter().any(|fault| match *fault {
            Fault::Corrupt { frame: at, topic: None } => topic == IMU.id && frame == Some(at),
            Fault::Corrupt { frame: at, topic: Some(of) } => is_due && topic == of && self.frames_done >= at,
            _ => false,
        })
    }

    /// Sends a damaged copy of a sample that is about to be sent, with the stamps of the good one.
    pub(super) fn corrupt_first(
        &mut self,
        topic: TopicId,
        frame: Option<u64>,
        stamps: &Stamps,
        payload: &[u8],
    ) -> Result<(), RunError> {
        if self.faults.is_empty() || !self.is_corrupted(topic, frame) {
            return Ok(());
        }
        self.corrupted[topic] = true;
        let mut damaged = payload.to_vec();
        // A bit of the mantissa in every number behind the header: plausible values that only the
        // CRC gives away.
        let numbers = size_of::<Header>()..damaged.len() - size_of::<u64>();
        damaged[numbers].iter_mut().skip(5).step_by(8).for_each(|byte| *byte ^= 0x10);
        Ok(self.link.publish(topic, stamps, &damaged)?)
    }
}
