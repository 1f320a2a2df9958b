//! What goes into the machine and what comes out of it: stimuli, decisions, the state in a
//! checkpoint.

use telemetry::{Domain, Experiment, Header, Mode, ModeState};

use super::table::Event;

/// Something the partition reports to the machine. Derived events (see [`Event`]) are formed by the
/// machine itself from the situation and the frame; reported ones are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stimulus {
    Start,
    SafeCommand,
    OperatorResume,
    OperatorOverride,
    /// Verdict on the model of the experiment that bore this counter.
    Verdict {
        domain: Domain,
        generation: u32,
        accepted: bool,
    },
}

impl Stimulus {
    pub(super) const fn event(&self) -> Event {
        match self {
            Stimulus::Start => Event::Start,
            Stimulus::SafeCommand => Event::SafeCommand,
            Stimulus::OperatorResume => Event::OperatorResume,
            Stimulus::OperatorOverride => Event::OperatorOverride,
            Stimulus::Verdict { accepted: true, .. } => Event::ModelAccepted,
            Stimulus::Verdict { accepted: false, .. } => Event::ModelRejected,
        }
    }
}

/// A change of mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Frame in which it is taken.
    pub frame: u64,
    /// First frame of the new state.
    pub effective_frame: u64,
    /// State that is left.
    pub from: ModeState,
    /// State that is entered.
    pub to: ModeState,
    /// Cause.
    pub event: Event,
    /// Experiment of the new state.
    pub experiment: Experiment,
    /// Length of the experiment, 0 for none.
    pub duration_frames: u64,
    /// Experiment counter, from 1.
    pub generation: u32,
    /// Nothing follows.
    pub ended: bool,
    /// Quantity that the guard (or, without one, the event) compared, and its limit; both 0 without
    /// a comparison.
    pub measured: f64,
    /// In the unit of `measured`, see `Event::figures`.
    pub limit: f64,
}

impl Decision {
    /// The sample that says so; `t_ns` is the time of the deciding frame.
    pub fn sample(&self, t_ns: u64) -> Mode {
        Mode {
            header: Header::at(t_ns),
            frame: self.frame,
            effective_frame: self.effective_frame,
            duration_frames: self.duration_frames,
            state: self.to.code(),
            previous: self.from.code(),
            experiment: self.experiment.code(),
            event: self.event.code(),
            generation: self.generation,
            ended: u32::from(self.ended),
            measured: self.measured,
            limit: self.limit,
        }
    }
}

/// A mode state in a checkpoint: its telemetry code.
pub(super) mod state_code {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};
    use telemetry::ModeState;

    /// For `#[serde(with)]`: the code as `u16`.
    pub fn serialize<S: Serializer>(state: &ModeState, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u16(state.code())
    }

    /// For `#[serde(with)]`.
    ///
    /// # Errors
    /// When the code is not one of `ModeState`.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ModeState, D::Error> {
        let code = u16::deserialize(deserializer)?;
        ModeState::from_code(code).ok_or_else(|| D::Error::custom(format!("unknown mode state {code}")))
    }
}
