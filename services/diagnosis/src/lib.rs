//! What it is: the partition of lowest priority, which says what physics a refused model lacks. It
//! keeps the rows of every arc; where the supervisor rejects a model, it diagnoses the arc that
//! does so, as `obsid diagnose` does, and publishes one answer.
//!
//! The diagnosis is work that a frame leaves. It is bounded by a count, not by time: its answer is
//! the same at any speed, and after any restart.
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

use craft::message::received;
use craft::missing::{Answer, sample};
use craft::parameters::{Parameters, ParametersError};
use craft::store::Store;
use plant_file::scenario::{CraftPlan, Scenario};
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use telemetry::{
    CRAFT, DIAGNOSIS, ESTIMATE_JOINT, INFORMATION, INFORMATION_INERTIAL, INFORMATION_MODAL, INFORMATION_SLOSH,
    JointEstimate, PartitionId, TopicId,
};

/// The partition.
struct Diagnoser {
    parameters: Parameters,
    store: Store,
    /// Per arc, where its first message ended: the shared parameters at which it is explained best.
    ended: Vec<Vec<f64>>,
    due: Option<Due>,
}

/// A question that a frame leaves.
struct Due {
    frame: u64,
    t_ns: u64,
    arc: usize,
    generation: u16,
    /// Shared parameters about which the refused messages are.
    theta: Vec<f64>,
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
        Ok(Self { parameters: Parameters::of(plan)?, store, ended, due: None })
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

    fn asked(&self, frame: &Frame<'_>) -> Option<Due> {
        let asks = |one: &&JointEstimate| {
            one.asks == JointEstimate::ASKS_WHAT_IS_MISSING && one.parameter_hash == self.parameters.hash
        };
        let asking = frame.samples(ESTIMATE_JOINT).iter().rfind(asks)?;
        let (arc, generation) = (usize::from(asking.verdict_arc), asking.generation);
        let theta = asking.theta[..self.parameters.len()].to_vec();
        (arc < self.store.arcs.len()).then_some(Due { frame: frame.number, t_ns: frame.t_ns, arc, generation, theta })
    }
}

impl Partition for Diagnoser {
    fn id(&self) -> PartitionId {
        PartitionId::Diagnosis
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[CRAFT.id, INFORMATION_INERTIAL.id, INFORMATION_SLOSH.id, INFORMATION_MODAL.id, ESTIMATE_JOINT.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        self.hear(frame);
        self.store.take(frame);
        self.due = self.asked(frame);
    }

    fn has_work(&self) -> bool {
        self.due.is_some()
    }

    /// One diagnosis: see [`examination::WORK_MAX`].
    fn work(&mut self, out: &mut Outputs) {
        let Some(due) = self.due.take() else { return };
        let own = &self.store.arcs[due.arc];
        let recording = self.store.recording(due.arc).filter(|_| self.store.is_whole(due.arc));
        // what was held out has no message of its own
        let ended = Some(&self.ended[due.arc]).filter(|ended| !ended.is_empty()).unwrap_or(&due.theta);
        let start = (&self.parameters, &ended[..]);
        let (verdict, effects, theta) = examination::examined(&own.plant, recording, start);
        let answer = Answer { arc: own.number, generation: due.generation, verdict, theta, effects };
        let mut said = sample(&answer, &own.plant, &self.parameters);
        (said.header.t_meas_ns, said.frame) = (due.t_ns, due.frame);
        out.publish(DIAGNOSIS, &said);
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&(&self.store.state, &self.ended), state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        (self.store.state, self.ended) = runtime::restore_state(state)?;
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
