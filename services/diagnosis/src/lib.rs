//! What it is: the partition of lowest priority, which says what physics a refused model lacks. It
//! keeps the rows of every arc; where the supervisor rejects a model, it diagnoses the arc that
//! does so, as `obsid diagnose` does, and publishes one answer.
//!
//! The diagnosis is computed on a thread of its own while frames go on, and answers in the frame
//! that its count pays for ([`craft::pace`]), not when it is ready: the answer and its frame are
//! the same at any speed. A restart begins it anew and waits until it is where it was.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let partition = diagnosis::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::Diagnosis);
//! for topic in partition.inputs() {
//!     println!("{}: {}", TOPICS[*topic].name, TOPICS[*topic].rate);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! May import: channels, craft, discovery, dynamics, identification, plant_file, runtime,
//! telemetry.
//!
//! Must never know: how a plant is simulated, recordings of other programs.
#![forbid(unsafe_code)]

pub mod examination;
mod thread;

use channels::Recording;
use craft::message::received;
use craft::missing::{Answer, sample};
use craft::pace;
use craft::parameters::{Parameters, ParametersError};
use craft::store::Store;
use dynamics::description::Plant;
use identification::work::Watch;
use plant_file::scenario::{CraftPlan, Scenario};
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    CRAFT, DIAGNOSIS, ESTIMATE_JOINT, INFORMATION, INFORMATION_INERTIAL, INFORMATION_MODAL, INFORMATION_SLOSH,
    JointEstimate, PartitionId, TopicId,
};
use thread::{Computation, Thread};

/// The partition.
struct Diagnoser {
    parameters: Parameters,
    store: Store,
    /// Per arc, where its first message ended: the shared parameters at which it is explained best.
    ended: Vec<Vec<f64>>,
    question: Option<Question>,
    /// The frame that is done: its number and time.
    now: (u64, u64),
    period_ns: u64,
    /// Where a process has started it; else with the first question.
    thread: Option<Thread>,
    computation: Option<Computation<Answer>>,
}

/// A question of the supervisor, until it is answered.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Question {
    frame: u64,
    arc: usize,
    generation: u16,
    /// Shared parameters to begin from: where the arc's first message ended, else those about which
    /// the refused messages are.
    start: Vec<f64>,
}

/// What an answer takes.
struct Evidence {
    number: usize,
    generation: u16,
    plant: Plant,
    recording: Option<Recording>,
    parameters: Parameters,
    start: Vec<f64>,
}

/// A run without a craft: there are no questions.
struct Idle;

/// Builds the partition of `run`.
///
/// # Errors
/// When the scenario cannot be read, or its craft states nothing to identify.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let scenario = Scenario::read(&run.scenario, &run.files, run.replay.is_some())
        .map_err(ConnectError::of(PartitionId::Diagnosis))?;
    let Some(plan) = &scenario.craft else { return Ok(Box::new(Idle)) };
    let diagnoser = Diagnoser::new(plan).map_err(ConnectError::of(PartitionId::Diagnosis))?;
    Ok(Box::new(diagnoser))
}

impl Diagnoser {
    fn new(plan: &CraftPlan) -> Result<Self, ParametersError> {
        let store = Store::new(plan, |_| true)?;
        let ended = vec![Vec::new(); store.arcs.len()];
        let parameters = Parameters::of(plan)?;
        Ok(Self {
            parameters,
            store,
            ended,
            question: None,
            now: (0, 0),
            period_ns: 0,
            thread: None,
            computation: None,
        })
    }

    /// Every arc is kept, so that its number is its place.
    fn hear(&mut self, frame: &Frame<'_>) {
        for message in INFORMATION.iter().flat_map(|topic| frame.samples(*topic)) {
            if message.generation == 0
                && let Ok(heard) = received(message, &self.parameters)
                && let Some(ended) = self.ended.get_mut(heard.arc)
            {
                *ended = heard.theta;
            }
        }
    }

    fn question_of(&self, frame: &Frame<'_>) -> Option<Question> {
        let asks = |one: &&JointEstimate| {
            one.asks == JointEstimate::ASKS_WHAT_IS_MISSING && one.parameter_hash == self.parameters.hash
        };
        let asking = frame.samples(ESTIMATE_JOINT).iter().rfind(asks)?;
        let (arc, generation) = (usize::from(asking.verdict_arc), asking.generation);
        // what was held out has no message of its own
        let ended = self.ended.get(arc)?;
        let start = if ended.is_empty() { asking.theta[..self.parameters.len()].to_vec() } else { ended.clone() };
        Some(Question { frame: frame.number, arc, generation, start })
    }

    fn evidence(&self, question: &Question) -> Evidence {
        let own = &self.store.arcs[question.arc];
        Evidence {
            number: own.number,
            generation: question.generation,
            plant: own.plant.clone(),
            recording: self.store.recording(question.arc).filter(|_| self.store.is_whole(question.arc)),
            parameters: self.parameters.clone(),
            start: question.start.clone(),
        }
    }
}

impl Evidence {
    fn answer(self, watch: &Watch) -> Answer {
        let start = (&self.parameters, &self.start[..]);
        let (verdict, effects, theta) = examination::examined(&self.plant, self.recording, start, watch);
        Answer { arc: self.number, generation: self.generation, verdict, theta, effects }
    }
}

impl Partition for Diagnoser {
    fn id(&self) -> PartitionId {
        PartitionId::Diagnosis
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[CRAFT.id, INFORMATION_INERTIAL.id, INFORMATION_SLOSH.id, INFORMATION_MODAL.id, ESTIMATE_JOINT.id]
    }

    fn start_threads(&mut self) {
        self.thread = Some(Thread::start());
    }

    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        self.hear(frame);
        self.store.take(frame);
        (self.now, self.period_ns) = ((frame.number, frame.t_ns), frame.period_ns);
        if let Some(question) = self.question_of(frame) {
            (self.question, self.computation) = (Some(question), None);
        }
    }

    fn has_work(&self) -> bool {
        self.question.is_some()
    }

    /// A frame's share of a diagnosis: see [`craft::pace`].
    fn work(&mut self, out: &mut Outputs) {
        let Some(question) = &self.question else { return };
        let granted = pace::granted(self.now.0 - question.frame, self.period_ns);
        if self.computation.is_none() {
            let evidence = self.evidence(question);
            let thread = self.thread.get_or_insert_with(Thread::start);
            self.computation = Some(Computation::start(thread, move |watch| evidence.answer(watch)));
        }
        let Some(answer) = self.computation.as_mut().and_then(|one| one.within(granted)) else { return };
        let mut said = sample(&answer, &self.store.arcs[question.arc].plant, &self.parameters);
        (said.frame, said.header.t_meas_ns) = self.now;
        out.publish(DIAGNOSIS, &said);
        (self.question, self.computation) = (None, None);
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&(&self.store.state, &self.ended, &self.question), state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        (self.store.state, self.ended, self.question) = runtime::restore_state(state)?;
        Ok(())
    }

    fn journal(&self) -> &[u8] {
        self.store.journal()
    }

    fn take_journal(&mut self, journal: &[u8]) {
        self.store.take_journal(journal);
    }
}

impl Partition for Idle {
    fn id(&self) -> PartitionId {
        PartitionId::Diagnosis
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[]
    }

    fn frame(&mut self, _frame: &Frame<'_>, _out: &mut Outputs) {}

    fn save(&mut self, _state: &mut Vec<u8>) -> Result<(), StateError> {
        Ok(())
    }

    fn restore(&mut self, _state: &[u8]) -> Result<(), StateError> {
        Ok(())
    }
}
