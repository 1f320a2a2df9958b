//! Guards: the plan's next step, and whether what is measured allows it.

use telemetry::{Domain, ModeState};

use super::plan::Situation;
use super::table::{Event, Guard};
use super::{ModeMachine, SEQUENCE};

/// Predicted sigma over its need from which an experiment is not worth flying. The prediction takes
/// a prior for the truth that may be off by a factor of two, and is off by as much itself; three
/// leaves a margin.
pub const OUT_OF_REACH: f64 = 3.0;

/// Whether an experiment before capture is still to be flown, or why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepStatus {
    Open,
    NotPlanned,
    ModelAccepted,
    NeedMet,
    NeedOutOfReach,
    AttemptsUsed,
    /// Its guard did not hold within the longest wait.
    Abandoned,
    PartitionLost,
}

/// Next step of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Experiment(Domain, ModeState),
    Replay(ModeState),
    Approach,
    Mated,
    Nothing,
}

/// Guard figures: what was looked at, and its limit.
pub(super) type Measure = (f64, f64);
pub(super) const UNMEASURED: Measure = (0.0, 0.0);

impl ModeMachine {
    /// Whether the experiment of `domain` before capture is still to be flown, or why it is
    /// skipped.
    pub fn step_status(&self, domain: Domain, situation: &Situation) -> StepStatus {
        let (index, seen) = (usize::from(domain.code()), situation.of(domain));
        let Some(experiment) = self.plan.experiment(domain) else { return StepStatus::NotPlanned };
        if self.accepted[index] {
            StepStatus::ModelAccepted
        } else if seen.lost {
            StepStatus::PartitionLost
        } else if self.abandoned[index] {
            StepStatus::Abandoned
        } else if self.attempts[index] > experiment.retries {
            StepStatus::AttemptsUsed
        } else if seen.sigma_over_need.is_some_and(|ratio| ratio <= 1.0) {
            StepStatus::NeedMet
        } else if seen.predicted_sigma_over_need.is_some_and(|ratio| ratio >= OUT_OF_REACH) {
            StepStatus::NeedOutOfReach
        } else {
            StepStatus::Open
        }
    }

    /// `Some` with the figures looked at when the guard holds.
    pub(super) fn guard(&self, guard: Guard, event: Event, frame: u64, situation: &Situation) -> Option<Measure> {
        let judged = event == Event::Timeout || !self.awaited.contains(&true);
        let lost = |domain: Option<Domain>| domain.is_some_and(|domain| situation.of(domain).lost);
        let of_event = self.event_measure(event, frame, situation);
        match guard {
            Guard::Always => Some(of_event),
            Guard::NotInForce => (!self.ended && frame < self.effective_frame).then_some(of_event),
            Guard::SourceLost => (!self.ended && situation.source_lost).then_some(of_event),
            Guard::OwnPartition => (!self.ended && lost(self.own_domain())).then_some(of_event),
            Guard::OwnInputs => {
                let silent = self.own_domain().is_some_and(|domain| !situation.of(domain).inputs_alive);
                (!self.ended && silent).then_some(of_event)
            }
            Guard::Judged => (!self.ended && judged).then_some(of_event),
            Guard::Running => (self.running && !self.ended).then_some(of_event),
            Guard::Resumable => (!self.ended && !situation.source_lost).then_some(of_event),
            Guard::NothingLeft => {
                (self.may_begin() && judged && self.step(situation) == Step::Nothing).then_some(of_event)
            }
            Guard::Enter(state) => (self.may_begin() && judged).then(|| self.may_enter(state, situation)).flatten(),
            Guard::CaptureAllowed => (!self.ended).then(|| self.may_capture(situation)).flatten(),
        }
    }

    pub(super) fn may_begin(&self) -> bool {
        self.running && !self.ended
    }

    /// Next step of the plan as things stand.
    pub(super) fn step(&self, situation: &Situation) -> Step {
        if let Some(replay) = &self.plan.replay {
            return match (self.replayed, SEQUENCE.iter().find(|entry| replay.domains[usize::from(entry.0.code())])) {
                (false, Some((_, state))) => Step::Replay(*state),
                _ => Step::Nothing,
            };
        }
        if self.captured {
            let open = !self.given_up
                && self.plan.mated.is_some_and(|mated| self.mated_attempts <= mated.retries && !self.mated_accepted);
            return if open { Step::Mated } else { Step::Nothing };
        }
        let open = |entry: &&(Domain, ModeState)| self.step_status(entry.0, situation) == StepStatus::Open;
        match SEQUENCE.iter().find(open) {
            Some((domain, state)) => Step::Experiment(*domain, *state),
            None if self.plan.capture && !self.given_up => Step::Approach,
            None => Step::Nothing,
        }
    }

    /// The plan's next step leads to `state` and what it demands is measured.
    fn may_enter(&self, state: ModeState, situation: &Situation) -> Option<Measure> {
        let inputs = match (self.step(situation), state) {
            // A recording is not excited: neither its rate nor its channels can be waited for.
            (Step::Replay(next), _) if next == state => return Some(UNMEASURED),
            (Step::Experiment(domain, next), _) if next == state => Some(domain),
            (Step::Approach, ModeState::ApproachHold) => None,
            (Step::Mated, ModeState::MatedSettle | ModeState::MatedInertial) => Some(Domain::Inertial),
            _ => return None,
        };
        let alive = inputs.is_none_or(|domain| situation.of(domain).inputs_alive);
        let (rate, limit) = (situation.base_rate_rad_s, self.plan.base_rate_limit_rad_s);
        (alive && rate <= limit).then_some((rate, limit))
    }

    /// Accepted inertial and slosh models younger than the limit, or an override; the base calm,
    /// its sensors alive.
    fn may_capture(&self, situation: &Situation) -> Option<Measure> {
        let calm = situation.base_rate_rad_s <= self.plan.base_rate_limit_rad_s;
        if !(calm && situation.of(Domain::Inertial).inputs_alive) {
            return None;
        }
        if self.operator_override {
            return Some((situation.base_rate_rad_s, self.plan.base_rate_limit_rad_s));
        }
        let inertial = situation.of(Domain::Inertial).accepted_age_frames?;
        let age = inertial.max(situation.of(Domain::Slosh).accepted_age_frames?);
        (age <= self.plan.accepted_age_limit_frames).then_some((age as f64, self.plan.accepted_age_limit_frames as f64))
    }
}
