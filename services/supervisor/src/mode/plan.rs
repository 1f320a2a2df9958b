//! The plan of the scenario and the measured situation: the two inputs of the mode table.

use serde::{Deserialize, Serialize};
use telemetry::Domain;

/// One experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExperimentPlan {
    /// Length of the excitation.
    pub duration_frames: u64,
    /// Latest frame after its beginning at which a verdict is waited for; longer than the duration.
    pub timeout_frames: u64,
    /// How often it is repeated when its model is rejected.
    pub retries: u32,
}

/// A recording played instead of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReplayPlan {
    /// As long as the recording.
    pub experiment: ExperimentPlan,
    /// Domains whose channels the recording carries, by `Domain::code`.
    pub domains: [bool; 3],
}

/// The scenario's mission, as data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Experiments before capture; `None` where the scenario plans none.
    pub modal: Option<ExperimentPlan>,
    /// As `modal`.
    pub slosh: Option<ExperimentPlan>,
    /// As `modal`.
    pub inertial: Option<ExperimentPlan>,
    /// Whether the approach and the capture are flown.
    pub capture: bool,
    /// Experiment after capture; `None` ends the run when the mated stack has settled.
    pub mated: Option<ExperimentPlan>,
    /// When present, the recording is all that happens.
    pub replay: Option<ReplayPlan>,
    /// From contact to the mated experiment.
    pub settle_frames: u64,
    /// Longest wait in STANDBY or APPROACH_HOLD for a guard to hold.
    pub hold_timeout_frames: u64,
    /// Longest wait for contact in CAPTURE.
    pub capture_timeout_frames: u64,
    /// Stay in SAFE before the run ends without an operator.
    pub safe_dwell_frames: u64,
    /// Oldest model with which CAPTURE is entered.
    pub accepted_age_limit_frames: u64,
    /// Above this base rate nothing new is begun.
    pub base_rate_limit_rad_s: f64,
    /// The scenario itself allows CAPTURE without accepted models.
    pub operator_override: bool,
}

impl Plan {
    /// The experiment before capture for one domain.
    pub fn experiment(&self, domain: Domain) -> Option<&ExperimentPlan> {
        match domain {
            Domain::Modal => self.modal.as_ref(),
            Domain::Slosh => self.slosh.as_ref(),
            Domain::Inertial => self.inertial.as_ref(),
        }
    }
}

/// Measured state of one domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DomainSituation {
    /// Every sensor its experiment needs has spoken recently.
    pub inputs_alive: bool,
    /// Age of the accepted model of the phase before capture; `None` without one.
    pub accepted_age_frames: Option<u64>,
    /// Largest standard deviation over its need, of an accepted model of this phase; at most one:
    /// nothing is left to learn, the experiment is skipped. `None` without a model or without a
    /// need.
    pub sigma_over_need: Option<f64>,
    /// The same, predicted for the end of the experiment (Cramér–Rao); from [`super::OUT_OF_REACH`]
    /// on it cannot meet the need and is skipped. `None` when nothing is predicted: then it is
    /// flown.
    pub predicted_sigma_over_need: Option<f64>,
    /// The partition was given up.
    pub lost: bool,
}

/// A statistic that recognised contact, and the limit it passed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactMeasure {
    /// Cumulative sum \[sigma\].
    pub statistic: f64,
    /// Limit that it passed \[sigma\].
    pub limit: f64,
}

/// Measured state in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Situation {
    /// Magnitude of the measured base rate; NaN when it is not known, which holds every guard on it
    /// closed.
    pub base_rate_rad_s: f64,
    /// By `Domain::code`.
    pub domains: [DomainSituation; 3],
    /// Contact recognised from the data.
    pub contact: Option<ContactMeasure>,
    /// The source of the samples was given up.
    pub source_lost: bool,
}

impl Situation {
    /// The part of one domain.
    pub fn of(&self, domain: Domain) -> &DomainSituation {
        &self.domains[usize::from(domain.code())]
    }

    /// As [`Situation::of`], to be filled in.
    pub fn of_mut(&mut self, domain: Domain) -> &mut DomainSituation {
        &mut self.domains[usize::from(domain.code())]
    }
}
