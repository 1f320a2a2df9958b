//! The experiment a partition is in: from the mode that takes effect to its last frame.

use crate::partition::Frame;
use serde::{Deserialize, Serialize};
use telemetry::{Experiment, Mode, ModeState, Phase};

/// Time between two estimates at first [frames].
const ESTIMATES_DENSE_EVERY: u64 = 100;
/// Longest time between two estimates of an experiment \[frames\].
pub const ESTIMATES_SPARSE_EVERY: u64 = 1000;
/// Time after which estimates are sparse [frames].
const ESTIMATES_SPARSE_AFTER: u64 = 1000;

/// What a frame means for a partition's experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// No experiment of this partition.
    Idle,
    /// First frame: begin with a fresh estimator.
    Begin,
    /// A frame of the experiment behind its first.
    Go,
    /// The frame after the last one: no more data, state the closing estimate.
    Close,
    /// The mode changed before the end: what was gathered is void.
    Abort,
}

/// The window of frames of the present experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExperimentWindow {
    /// Experiment of the mode in effect; it stays after the last frame.
    pub experiment: Experiment,
    /// State of the mode in effect.
    pub state: ModeState,
    /// Experiment counter of the mode, from 1; 0 before the first.
    pub generation: u32,
    /// First frame of the experiment.
    pub begin_frame: u64,
    /// First frame behind the experiment.
    pub end_frame: u64,
    closed: bool,
}

impl Default for ExperimentWindow {
    fn default() -> Self {
        ExperimentWindow {
            experiment: Experiment::None,
            state: ModeState::Standby,
            generation: 0,
            begin_frame: 0,
            end_frame: 0,
            closed: true,
        }
    }
}

impl ExperimentWindow {
    /// Takes the frame's mode and returns the meaning of the frame for a partition that works in
    /// the experiments `mine`.
    pub fn step(&mut self, frame: &Frame<'_>, mine: &[Experiment]) -> Step {
        if let Some(mode) = frame.new_mode() {
            return self.enter(mode, mine);
        }
        if self.closed || !mine.contains(&self.experiment) {
            return Step::Idle;
        }
        if frame.number < self.end_frame {
            return Step::Go;
        }
        self.closed = true;
        Step::Close
    }

    fn enter(&mut self, mode: &Mode, mine: &[Experiment]) -> Step {
        let was_open = !self.closed && mine.contains(&self.experiment);
        *self = ExperimentWindow {
            experiment: Experiment::from_code(mode.experiment).unwrap_or(Experiment::None),
            state: ModeState::from_code(mode.state).unwrap_or(ModeState::Safe),
            generation: mode.generation,
            begin_frame: mode.effective_frame,
            end_frame: mode.effective_frame + mode.duration_frames,
            closed: mode.duration_frames == 0,
        };
        if !self.closed && mine.contains(&self.experiment) {
            Step::Begin
        } else if was_open {
            Step::Abort
        } else {
            Step::Idle
        }
    }

    /// Whether an estimate that costs a factorisation goes out after this frame: every second at
    /// first (100 frames), then every ten, because estimates change ever more slowly.
    #[must_use]
    pub fn estimate_is_due(&self, frame: &Frame<'_>) -> bool {
        let done = self.elapsed(frame) + 1;
        done.is_multiple_of(if done < ESTIMATES_SPARSE_AFTER { ESTIMATES_DENSE_EVERY } else { ESTIMATES_SPARSE_EVERY })
    }

    /// Frames since the experiment began.
    #[must_use]
    pub fn elapsed(&self, frame: &Frame<'_>) -> u64 {
        frame.number.saturating_sub(self.begin_frame)
    }

    /// Phase in which an estimate of this experiment is made; pre-capture while there is no
    /// experiment.
    #[must_use]
    pub fn phase(&self) -> Phase {
        match self.experiment {
            Experiment::Replay => Phase::Replay,
            Experiment::MatedInertial => Phase::Mated,
            _ => Phase::PreCapture,
        }
    }
}
