//! The mode table: per state its timeout, its abort path and one block of rows (event, guard,
//! action, next state).
//!
//! Rows are tried from top to bottom; the first whose event and guard match is taken. Every block
//! covers every event and ends it with [`Guard::Always`], so that each (state, event) pair is
//! defined. Events of one frame are offered in the order of their codes, and a frame changes the
//! state at most once.

use Action::{Abandon, Arm, Captured, End, Excite, Ignore, Override};
use Event::{
    Check, ContactSeen, Elapsed, InputsLost, ModelAccepted, ModelRejected, OperatorOverride, OperatorResume,
    PartitionLost, SafeCommand, Start, Timeout,
};
use Guard::{
    Always, CaptureAllowed, Enter, Judged, NotInForce, NothingLeft, OwnInputs, OwnPartition, Resumable, Running,
    SourceLost,
};
use telemetry::ModeState::{
    self, ApproachHold, Capture, MatedInertial, MatedSettle, PreCaptureInertial, PreCaptureModal, PreCaptureSlosh,
    Safe, Standby,
};

/// What can happen, most urgent first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u16)]
pub enum Event {
    /// Operator or warden: make safe.
    SafeCommand = 1,
    /// A partition was given up (derived from the situation in every frame, so it cannot be
    /// missed).
    PartitionLost = 2,
    /// A sensor that the running experiment needs is silent (derived).
    InputsLost = 3,
    /// Operator: capture without accepted models.
    OperatorOverride = 4,
    /// Operator: leave SAFE, go on with the plan.
    OperatorResume = 5,
    /// The plan begins.
    Start = 6,
    /// The validation accepted the model of an experiment.
    ModelAccepted = 7,
    /// The validation rejected it, or had no model to judge.
    ModelRejected = 8,
    /// Contact recognised from the data (derived).
    ContactSeen = 9,
    /// The intended duration of the state is over (derived).
    Elapsed = 10,
    /// The longest duration of the state is over (derived).
    Timeout = 11,
    /// The frame itself: guards are looked at (derived).
    Check = 12,
}

impl Event {
    /// In the order of their codes, which is that of urgency.
    pub const ALL: [Event; 12] = [
        SafeCommand,
        PartitionLost,
        InputsLost,
        OperatorOverride,
        OperatorResume,
        Start,
        ModelAccepted,
        ModelRejected,
        ContactSeen,
        Elapsed,
        Timeout,
        Check,
    ];

    /// As `Mode::event` carries it.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// `None` for a code that this build does not know.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|event| event.code() == code)
    }

    /// Meaning of `Mode::measured` and `Mode::limit` in a change that this event caused.
    pub const fn figures(self) -> &'static str {
        match self {
            Elapsed | Timeout => "frames waited and the duration [frames]",
            ContactSeen => "statistic of the jump and its limit [sigma]",
            _ => {
                "base rate and its limit [rad/s] where the next state demands one; to CAPTURE by accepted models the \
                 age of the older one and its limit [frames]; else 0"
            }
        }
    }

    /// As logs and the interface control document show it.
    pub const fn text(self) -> &'static str {
        match self {
            SafeCommand => "safe command",
            PartitionLost => "partition lost",
            InputsLost => "inputs lost",
            OperatorOverride => "operator override",
            OperatorResume => "operator resume",
            Start => "start",
            ModelAccepted => "model accepted",
            ModelRejected => "model rejected",
            ContactSeen => "contact seen",
            Elapsed => "duration elapsed",
            Timeout => "timeout",
            Check => "guard held",
        }
    }

    /// Acts even while an earlier decision has not taken effect yet: it does not rest on
    /// measurements of the old mode, or, contact, means the more for it.
    pub const fn is_urgent(self) -> bool {
        matches!(self, SafeCommand | PartitionLost | ContactSeen)
    }
}

/// Condition of a row, on measured quantities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    Always,
    /// The plan's next step leads to this state, every awaited model is judged, and what the state
    /// demands is measured: base rate below its limit, inputs alive.
    Enter(ModeState),
    /// Every model the running experiment is to give has been judged (or the timeout spares the
    /// wait).
    Judged,
    /// Every awaited model is judged and the plan holds nothing more.
    NothingLeft,
    /// Accepted inertial and slosh models younger than the limit, or an override; base rate low,
    /// inputs alive.
    CaptureAllowed,
    /// The state has been decided on and is not in force yet.
    NotInForce,
    /// A sample source was given up: nothing can be flown.
    SourceLost,
    /// The partition that the running experiment feeds was given up.
    OwnPartition,
    /// An input of the running experiment is silent.
    OwnInputs,
    /// The run has begun and not ended.
    Running,
    /// The run has not ended and the source lives.
    Resumable,
}

/// What a row does beside changing the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Ignore,
    /// The plan may begin.
    Arm,
    /// Remember the operator's override.
    Override,
    /// New experiment counter, excitation on, models awaited.
    Excite,
    /// Strike the step that waited too long off the plan.
    Abandon,
    /// From now on the plan is the mated one.
    Captured,
    /// Nothing follows.
    End,
}

/// Which limits of the plan run from the entry into a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timer {
    /// Timeout after the dwell in SAFE.
    SafeDwell,
    /// Timeout after the longest wait for a guard.
    Hold,
    /// Elapsed after the experiment's duration, timeout after its limit.
    Experiment,
    /// Timeout when no contact is seen.
    Capture,
    /// Elapsed after the settling time, timeout one hold later.
    Settle,
}

/// Where a row leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    Stay,
    To(ModeState),
    /// The block's abort path.
    Abort,
}

/// One line of the table; several events that are answered alike share it.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Causes of the change.
    pub events: &'static [Event],
    /// Condition; without it the next row of the event counts.
    pub guard: Guard,
    /// Effect on counters and steps.
    pub action: Action,
    /// State that follows.
    pub next: Next,
}

/// One state of the table.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// State of all rows.
    pub state: ModeState,
    /// Durations that raise `Elapsed` and `Timeout`.
    pub timer: Timer,
    /// State that an aborted experiment leads to.
    pub abort: ModeState,
    /// In the order in which they are evaluated.
    pub rows: &'static [Row],
}

const fn row(events: &'static [Event], guard: Guard, action: Action, next: Next) -> Row {
    Row { events, guard, action, next }
}

const fn to(state: ModeState) -> Next {
    Next::To(state)
}

const STAY: Next = Next::Stay;
const ABORT: Next = Next::Abort;
/// An experiment is over for the plan: its model is judged, or the wait for it is.
const OVER: &[Event] = &[ModelAccepted, ModelRejected, Timeout];

/// The three experiments before capture differ in nothing but what they excite.
const PRE_CAPTURE: &[Row] = &[
    row(&[SafeCommand], Always, Ignore, to(Safe)),
    row(&[PartitionLost], SourceLost, Ignore, to(Safe)),
    row(&[PartitionLost], OwnPartition, Ignore, ABORT),
    row(&[PartitionLost], Always, Ignore, STAY),
    row(&[InputsLost], OwnInputs, Ignore, ABORT),
    row(&[InputsLost], Always, Ignore, STAY),
    row(&[OperatorOverride], Always, Override, STAY),
    row(OVER, Enter(PreCaptureModal), Excite, to(PreCaptureModal)),
    row(OVER, Enter(PreCaptureSlosh), Excite, to(PreCaptureSlosh)),
    row(OVER, Enter(PreCaptureInertial), Excite, to(PreCaptureInertial)),
    row(OVER, Enter(ApproachHold), Ignore, to(ApproachHold)),
    row(OVER, NothingLeft, End, to(Standby)),
    row(OVER, Judged, Ignore, to(Standby)),
    row(OVER, Always, Ignore, STAY),
    row(&[OperatorResume, Start, ContactSeen, Elapsed, Check], Always, Ignore, STAY),
];

/// The table.
pub const TABLE: &[Block] = &[
    Block {
        state: Safe,
        timer: Timer::SafeDwell,
        abort: Safe,
        rows: &[
            row(&[OperatorResume], Resumable, Ignore, to(Standby)),
            row(&[OperatorResume], Always, Ignore, STAY),
            row(&[OperatorOverride], Always, Override, STAY),
            row(&[Start], Always, Arm, STAY),
            row(&[Timeout], Always, End, STAY),
            row(&[SafeCommand, PartitionLost, InputsLost, ModelAccepted, ModelRejected], Always, Ignore, STAY),
            row(&[ContactSeen, Elapsed, Check], Always, Ignore, STAY),
        ],
    },
    Block {
        state: Standby,
        timer: Timer::Hold,
        abort: Safe,
        rows: &[
            row(&[SafeCommand], Always, Ignore, to(Safe)),
            row(&[PartitionLost], SourceLost, Ignore, ABORT),
            row(&[PartitionLost], Always, Ignore, STAY),
            row(&[OperatorOverride], Always, Override, STAY),
            row(&[Start], Always, Arm, STAY),
            row(&[Check], Enter(PreCaptureModal), Excite, to(PreCaptureModal)),
            row(&[Check], Enter(PreCaptureSlosh), Excite, to(PreCaptureSlosh)),
            row(&[Check], Enter(PreCaptureInertial), Excite, to(PreCaptureInertial)),
            row(&[Check], Enter(ApproachHold), Ignore, to(ApproachHold)),
            row(&[Check], Enter(MatedSettle), Ignore, to(MatedSettle)),
            row(&[Check], NothingLeft, End, STAY),
            row(&[Check], Always, Ignore, STAY),
            row(&[Timeout], Running, Abandon, STAY),
            row(&[Timeout], Always, Ignore, STAY),
            row(&[InputsLost, OperatorResume, ModelAccepted, ModelRejected], Always, Ignore, STAY),
            row(&[ContactSeen, Elapsed], Always, Ignore, STAY),
        ],
    },
    Block { state: PreCaptureModal, timer: Timer::Experiment, abort: Standby, rows: PRE_CAPTURE },
    Block { state: PreCaptureSlosh, timer: Timer::Experiment, abort: Standby, rows: PRE_CAPTURE },
    Block { state: PreCaptureInertial, timer: Timer::Experiment, abort: Standby, rows: PRE_CAPTURE },
    Block {
        state: ApproachHold,
        timer: Timer::Hold,
        abort: Standby,
        rows: &[
            row(&[SafeCommand], Always, Ignore, to(Safe)),
            row(&[PartitionLost], SourceLost, Ignore, to(Safe)),
            row(&[PartitionLost], Always, Ignore, STAY),
            row(&[OperatorOverride], Always, Override, STAY),
            // Contact before it is commanded is a collision.
            row(&[ContactSeen], Always, Ignore, to(Safe)),
            row(&[Timeout], Always, End, ABORT),
            row(&[Check], CaptureAllowed, Ignore, to(Capture)),
            row(&[Check], Always, Ignore, STAY),
            row(&[InputsLost, OperatorResume, Start, ModelAccepted, ModelRejected, Elapsed], Always, Ignore, STAY),
        ],
    },
    Block {
        state: Capture,
        timer: Timer::Capture,
        abort: Safe,
        rows: &[
            row(&[SafeCommand], Always, Ignore, to(Safe)),
            row(&[PartitionLost], SourceLost, Ignore, ABORT),
            row(&[PartitionLost], OwnPartition, Ignore, ABORT),
            row(&[PartitionLost], Always, Ignore, STAY),
            row(&[InputsLost], OwnInputs, Ignore, ABORT),
            row(&[InputsLost], Always, Ignore, STAY),
            // Contact before the command is in force is a collision.
            row(&[ContactSeen], NotInForce, Ignore, ABORT),
            row(&[ContactSeen], Always, Captured, to(MatedSettle)),
            row(&[Timeout], Always, Ignore, ABORT),
            row(&[OperatorOverride, OperatorResume, Start], Always, Ignore, STAY),
            row(&[ModelAccepted, ModelRejected, Elapsed, Check], Always, Ignore, STAY),
        ],
    },
    Block {
        state: MatedSettle,
        timer: Timer::Settle,
        abort: Safe,
        rows: &[
            row(&[SafeCommand], Always, Ignore, to(Safe)),
            row(&[PartitionLost], SourceLost, Ignore, ABORT),
            row(&[PartitionLost], OwnPartition, Ignore, ABORT),
            row(&[PartitionLost], Always, Ignore, STAY),
            row(&[Elapsed], Enter(MatedInertial), Excite, to(MatedInertial)),
            row(&[Elapsed], NothingLeft, End, to(Standby)),
            row(&[Elapsed], Always, Ignore, STAY),
            row(&[Timeout], Always, End, to(Standby)),
            row(&[InputsLost, OperatorOverride, OperatorResume, Start], Always, Ignore, STAY),
            row(&[ModelAccepted, ModelRejected, ContactSeen, Check], Always, Ignore, STAY),
        ],
    },
    Block {
        state: MatedInertial,
        timer: Timer::Experiment,
        abort: Safe,
        rows: &[
            row(&[SafeCommand], Always, Ignore, to(Safe)),
            row(&[PartitionLost], SourceLost, Ignore, ABORT),
            row(&[PartitionLost], OwnPartition, Ignore, ABORT),
            row(&[PartitionLost], Always, Ignore, STAY),
            row(&[InputsLost], OwnInputs, Ignore, ABORT),
            row(&[InputsLost], Always, Ignore, STAY),
            row(OVER, Enter(MatedInertial), Excite, to(MatedInertial)),
            row(OVER, NothingLeft, End, to(Standby)),
            row(OVER, Judged, Ignore, to(Standby)),
            row(OVER, Always, Ignore, STAY),
            row(&[OperatorOverride, OperatorResume, Start, ContactSeen], Always, Ignore, STAY),
            row(&[Elapsed, Check], Always, Ignore, STAY),
        ],
    },
];

/// The block of a state.
pub fn block(state: ModeState) -> &'static Block {
    TABLE.iter().find(|block| block.state == state).expect("the table has a block for every state, which a test shows")
}

/// Whether the vehicle may be excited in `state`: the four experiments, nothing else.
pub const fn excitation_allowed(state: ModeState) -> bool {
    matches!(state, PreCaptureModal | PreCaptureSlosh | PreCaptureInertial | MatedInertial)
}
