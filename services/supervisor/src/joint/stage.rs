//! How far a craft's identification is.

use serde::{Deserialize, Serialize};

/// What is waited for; until a frame after which it is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stage {
    /// The arc is to be flown next.
    Ready {
        arc: usize,
    },
    /// It is flown until `end_frame`, then heard.
    Flying {
        arc: usize,
        end_frame: u64,
        until_frame: u64,
    },
    /// Messages at a common point of linearisation.
    Folding {
        generation: u16,
        until_frame: u64,
    },
    /// The held-out arc at the posterior of so many messages.
    Predicting {
        generation: u16,
        until_frame: u64,
        fitted: usize,
    },
    /// What the refused model lacks.
    Diagnosing {
        until_frame: u64,
    },
    Ended,
}

impl Stage {
    /// Generation of the messages that are waited for, and whether they are of what is held out.
    pub fn awaited(self) -> (u16, bool) {
        match self {
            Self::Ready { .. } | Self::Flying { .. } => (0, false),
            Self::Folding { generation, .. } => (generation, false),
            Self::Predicting { generation, .. } => (generation, true),
            Self::Diagnosing { .. } | Self::Ended => (u16::MAX, false),
        }
    }
}
