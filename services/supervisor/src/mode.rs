//! Mode logic: one table, evaluated once a frame, deterministic, without a clock.
//!
//! The plan is a sequence of steps: modal, slosh and inertial experiment, approach and capture,
//! settling and mated experiment, or the replay of a recording alone. A step that is not planned,
//! whose need is met, that cannot meet its need, that was tried as often as allowed or whose
//! partition was given up is skipped. `mode/table.rs` says what each event does in each state;
//! `mode/guards.rs` holds the guards, this file the counters and the timers.
//!
//! Decisions taken here, which the table does not show:
//! - A decision takes effect `window_frames` later. Until then only urgent events act, because
//!   everything measured still speaks of the old mode. Timers run from the effective frame.
//! - CAPTURE requires accepted inertial *and* slosh models, also when the plan flies no slosh
//!   experiment: a domain without an identified model is not accepted, and the override exists for
//!   a vehicle without a tank.
//! - APPROACH_HOLD without permission waits for an operator until its timeout, then the run ends in
//!   STANDBY.
//! - A verdict counts only with the experiment counter (generation) of the experiment that waits
//!   for it.
//! - After the end of the run nothing but the safe command acts.

mod decision;
mod guards;
mod plan;
mod table;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use telemetry::{Domain, Experiment, ModeState};

use decision::state_code;
use guards::{Measure, Step, UNMEASURED};

pub use decision::{Decision, Stimulus};
pub use guards::{OUT_OF_REACH, StepStatus};
pub use plan::{ContactMeasure, DomainSituation, ExperimentPlan, Plan, ReplayPlan, Situation};
pub use table::{Action, Block, Event, Guard, Next, Row, TABLE, Timer, block, excitation_allowed};

/// Order in which the domains are identified before capture.
const SEQUENCE: [(Domain, ModeState); 3] = [
    (Domain::Modal, ModeState::PreCaptureModal),
    (Domain::Slosh, ModeState::PreCaptureSlosh),
    (Domain::Inertial, ModeState::PreCaptureInertial),
];

/// The machine: the plan and how far it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeMachine {
    plan: Plan,
    window_frames: u64,
    #[serde(with = "state_code")]
    state: ModeState,
    /// First frame that belongs to the state.
    effective_frame: u64,
    /// Timers run from here: the effective frame, or later in STANDBY when a step was struck off.
    since_frame: u64,
    generation: u32,
    running: bool,
    ended: bool,
    captured: bool,
    operator_override: bool,
    /// Models the running experiment still owes, by `Domain::code`.
    awaited: [bool; 3],
    accepted: [bool; 3],
    abandoned: [bool; 3],
    attempts: [u32; 3],
    mated_attempts: u32,
    mated_accepted: bool,
    replayed: bool,
    /// Approach or mated experiment struck off after the longest wait.
    given_up: bool,
}

impl ModeMachine {
    /// A machine in STANDBY that waits for [`Stimulus::Start`]. `window_frames` is the pacing
    /// window.
    pub fn new(plan: Plan, window_frames: u64) -> Self {
        let planned = [plan.modal, plan.slosh, plan.inertial, plan.mated, plan.replay.map(|replay| replay.experiment)];
        for experiment in planned.iter().flatten() {
            assert!(experiment.duration_frames > 0);
            assert!(experiment.timeout_frames > experiment.duration_frames);
        }
        assert!(plan.base_rate_limit_rad_s > 0.0);
        Self {
            plan,
            window_frames,
            state: ModeState::Standby,
            effective_frame: 0,
            since_frame: 0,
            generation: 0,
            running: false,
            ended: false,
            captured: false,
            operator_override: plan.operator_override,
            awaited: [false; 3],
            accepted: [false; 3],
            abandoned: [false; 3],
            attempts: [0; 3],
            mated_attempts: 0,
            mated_accepted: false,
            replayed: false,
            given_up: false,
        }
    }

    /// Takes the limits and longest waits of `plan`; its experiments stay.
    pub fn set_limits(&mut self, plan: &Plan) {
        let own = &mut self.plan;
        own.base_rate_limit_rad_s = plan.base_rate_limit_rad_s;
        own.settle_frames = plan.settle_frames;
        own.hold_timeout_frames = plan.hold_timeout_frames;
        own.capture_timeout_frames = plan.capture_timeout_frames;
        own.safe_dwell_frames = plan.safe_dwell_frames;
        own.accepted_age_limit_frames = plan.accepted_age_limit_frames;
    }

    /// State last decided on; in force from [`Self::effective_frame`].
    pub fn state(&self) -> ModeState {
        self.state
    }

    /// First frame of [`Self::state`]; later than the present frame while a decision waits for the
    /// pacing window.
    pub fn effective_frame(&self) -> u64 {
        self.effective_frame
    }

    /// The plan is done or given up: no further decision follows but a safe command.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Counter of the newest experiment; 0 before the first.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Evaluates the table once. At most one change of state, `None` without one.
    pub fn evaluate(&mut self, frame: u64, stimuli: &[Stimulus], situation: &Situation) -> Option<Decision> {
        for stimulus in stimuli {
            self.note_verdict(stimulus);
        }
        let pending = frame < self.effective_frame;
        for event in Event::ALL {
            let happened = stimuli.iter().any(|stimulus| stimulus.event() == event);
            if !happened && !self.derived(event, frame, situation) {
                continue;
            }
            let (row, measure) = self.row(event, frame, situation);
            let harmless =
                row.next == Next::Stay && matches!(row.action, Action::Ignore | Action::Arm | Action::Override);
            if pending && !event.is_urgent() && !harmless {
                continue;
            }
            if let Some(decision) = self.take(row, event, measure, frame, situation) {
                return Some(decision);
            }
        }
        None
    }

    /// A verdict of the running experiment pays what it owed; any other is old and changes nothing.
    fn note_verdict(&mut self, stimulus: &Stimulus) {
        let Stimulus::Verdict { domain, generation, accepted } = *stimulus else { return };
        let index = usize::from(domain.code());
        if generation != self.generation || !self.awaited[index] {
            return;
        }
        self.awaited[index] = false;
        if self.state == ModeState::MatedInertial {
            self.mated_accepted |= accepted;
        } else {
            self.accepted[index] |= accepted;
        }
    }

    /// Events without a report: they follow from the situation and the frame.
    fn derived(&self, event: Event, frame: u64, situation: &Situation) -> bool {
        let waited = frame.saturating_sub(self.since_frame);
        let in_force = !self.ended && frame >= self.effective_frame;
        match event {
            Event::PartitionLost => situation.source_lost || situation.domains.iter().any(|domain| domain.lost),
            Event::InputsLost => in_force && self.own_domain().is_some_and(|domain| !situation.of(domain).inputs_alive),
            Event::ContactSeen => situation.contact.is_some(),
            Event::Elapsed => in_force && self.duration_frames().is_some_and(|limit| waited >= limit),
            Event::Timeout => in_force && self.timeout_frames(situation).is_some_and(|limit| waited >= limit),
            Event::Check => true,
            _ => false,
        }
    }

    /// First row of the state's block that answers `event`, with what its guard measured.
    fn row(&self, event: Event, frame: u64, situation: &Situation) -> (&'static Row, Measure) {
        block(self.state)
            .rows
            .iter()
            .filter(|row| row.events.contains(&event))
            .find_map(|row| Some((row, self.guard(row.guard, event, frame, situation)?)))
            .expect("every block ends every event with an unguarded row, which a test shows")
    }

    /// Domain whose sensors and partition the state depends on; none while a recording is played.
    fn own_domain(&self) -> Option<Domain> {
        match self.state {
            _ if self.plan.replay.is_some() => None,
            ModeState::Capture | ModeState::MatedSettle | ModeState::MatedInertial => Some(Domain::Inertial),
            state => SEQUENCE.iter().find(|entry| entry.1 == state).map(|entry| entry.0),
        }
    }

    /// Plan of the experiment that `state` flies.
    fn experiment_plan(&self, state: ModeState) -> Option<&ExperimentPlan> {
        match (&self.plan.replay, state) {
            (_, state) if !excitation_allowed(state) => None,
            (Some(replay), _) => Some(&replay.experiment),
            (None, ModeState::MatedInertial) => self.plan.mated.as_ref(),
            (None, state) => {
                SEQUENCE.iter().find(|entry| entry.1 == state).and_then(|entry| self.plan.experiment(entry.0))
            }
        }
    }

    fn experiment(&self, state: ModeState) -> Experiment {
        match state {
            state if !excitation_allowed(state) => Experiment::None,
            _ if self.plan.replay.is_some() => Experiment::Replay,
            ModeState::PreCaptureModal => Experiment::Modal,
            ModeState::PreCaptureSlosh => Experiment::Slosh,
            ModeState::PreCaptureInertial => Experiment::Inertial,
            _ => Experiment::MatedInertial,
        }
    }

    fn duration_frames(&self) -> Option<u64> {
        match block(self.state).timer {
            Timer::Experiment => self.experiment_plan(self.state).map(|plan| plan.duration_frames),
            Timer::Settle => Some(self.plan.settle_frames),
            Timer::SafeDwell | Timer::Hold | Timer::Capture => None,
        }
    }

    fn timeout_frames(&self, situation: &Situation) -> Option<u64> {
        match block(self.state).timer {
            Timer::Experiment => self.experiment_plan(self.state).map(|plan| plan.timeout_frames),
            Timer::Settle => Some(self.plan.settle_frames + self.plan.hold_timeout_frames),
            Timer::SafeDwell => Some(self.plan.safe_dwell_frames),
            Timer::Capture => Some(self.plan.capture_timeout_frames),
            Timer::Hold => {
                let waits = self.may_begin() && self.step(situation) != Step::Nothing;
                waits.then_some(self.plan.hold_timeout_frames)
            }
        }
    }

    /// Figures of an event that no guard looks at.
    fn event_measure(&self, event: Event, frame: u64, situation: &Situation) -> Measure {
        let waited = frame.saturating_sub(self.since_frame) as f64;
        match event {
            Event::Elapsed => (waited, self.duration_frames().unwrap_or(0) as f64),
            Event::Timeout => (waited, self.timeout_frames(situation).unwrap_or(0) as f64),
            Event::ContactSeen => situation.contact.map_or(UNMEASURED, |contact| (contact.statistic, contact.limit)),
            _ => UNMEASURED,
        }
    }

    /// Carries out a row; `Some` when it is worth a sample: a new state, a new experiment, or the
    /// end.
    fn take(
        &mut self,
        row: &Row,
        event: Event,
        measure: Measure,
        frame: u64,
        situation: &Situation,
    ) -> Option<Decision> {
        let from = self.state;
        let to = match row.next {
            Next::Stay => from,
            Next::To(state) => state,
            Next::Abort => block(from).abort,
        };
        let mut news = to != from;
        match row.action {
            Action::Ignore => {}
            Action::Arm => self.arm(frame),
            Action::Override => self.operator_override = true,
            Action::Abandon => self.abandon(frame, situation),
            Action::Captured => self.captured = true,
            Action::Excite => {
                self.excite(to);
                news = true;
            }
            Action::End => {
                news |= !self.ended;
                self.ended = true;
            }
        }
        if !news {
            return None;
        }
        self.state = to;
        self.effective_frame = frame + self.window_frames;
        self.since_frame = self.effective_frame;
        if !excitation_allowed(to) {
            self.awaited = [false; 3];
        }
        Some(Decision {
            frame,
            effective_frame: self.effective_frame,
            from,
            to,
            event,
            experiment: self.experiment(to),
            duration_frames: self.experiment_plan(to).map_or(0, |plan| plan.duration_frames),
            generation: self.generation,
            ended: self.ended,
            measured: measure.0,
            limit: measure.1,
        })
    }

    fn arm(&mut self, frame: u64) {
        if !self.running {
            self.running = true;
            self.since_frame = self.since_frame.max(frame);
        }
    }

    /// Strikes off the step whose guard did not hold within the longest wait, and gives the next
    /// one as long.
    fn abandon(&mut self, frame: u64, situation: &Situation) {
        match self.step(situation) {
            Step::Experiment(domain, _) => self.abandoned[usize::from(domain.code())] = true,
            Step::Replay(_) => self.replayed = true,
            Step::Approach | Step::Mated => self.given_up = true,
            Step::Nothing => {}
        }
        self.since_frame = frame;
    }

    /// Counts an attempt and opens the account of models the experiment owes.
    fn excite(&mut self, state: ModeState) {
        self.generation += 1;
        self.awaited = [false; 3];
        if let Some(replay) = &self.plan.replay {
            self.awaited = replay.domains;
            self.replayed = true;
        } else if state == ModeState::MatedInertial {
            self.awaited[usize::from(Domain::Inertial.code())] = true;
            self.mated_attempts += 1;
        } else if let Some((domain, _)) = SEQUENCE.iter().find(|entry| entry.1 == state) {
            let index = usize::from(domain.code());
            self.awaited[index] = true;
            self.attempts[index] += 1;
        }
    }
}
