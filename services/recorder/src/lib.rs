//! What it is: recording of every sample in one MCAP file, in a process of its own: a stalled disk
//! may not delay an estimator.
//!
//! The file is the partition's memory: a checkpoint completes a chunk, and a restart goes on behind
//! the samples that the checkpoint counts.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::{PartitionId, TOPICS};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid run` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! println!("records to {}", run.record.display());
//! let partition = recorder::connect(&run)?;
//! assert_eq!(partition.id(), PartitionId::Recorder);
//! for topic in partition.inputs() {
//!     println!("{}: {}", TOPICS[*topic].name, TOPICS[*topic].rate);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! May import: recording, runtime, telemetry.
//!
//! Must never know: equations, estimators, the meaning of a sample.
#![forbid(unsafe_code)]

use recording::McapRecorder;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use std::collections::BTreeMap;
use std::path::PathBuf;
use telemetry::{Delivery, PartitionId, TOPIC_TABLE, TOPICS, TopicId};

/// Every topic.
const INPUTS: [TopicId; TOPIC_TABLE.len()] = {
    let mut all = [0; TOPIC_TABLE.len()];
    let mut topic = 0;
    while topic < all.len() {
        all[topic] = topic;
        topic += 1;
    }
    all
};

/// Name of the scenario's attachment in a recording.
const SCENARIO: &str = "scenario.toml";

/// The partition: writes every topic, publishes none.
pub struct Recorder {
    path: PathBuf,
    file: Option<McapRecorder>,
    metadata: BTreeMap<String, String>,
    /// Name and text of the scenario and of the files that it names.
    attachments: Vec<(String, String)>,
    record_all: bool,
    written: u64,
    failure: Option<String>,
}

/// Builds the partition of `run`; the file is made with its first frame or taken up after a
/// restart.
///
/// # Errors
/// None.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let metadata = BTreeMap::from([
        ("scenario".into(), run.name.clone()),
        ("seed".into(), run.seed.to_string()),
        ("window_frames".into(), run.window_frames.to_string()),
        ("period_ns".into(), run.period_ns.to_string()),
        ("version".into(), env!("CARGO_PKG_VERSION").into()),
    ]);
    let files = run.files.iter().map(|(name, text)| (name.clone(), text.clone()));
    Ok(Box::new(Recorder {
        path: run.record.clone(),
        file: None,
        metadata,
        attachments: [(SCENARIO.to_string(), run.scenario.clone())].into_iter().chain(files).collect(),
        record_all: run.record_all,
        written: 0,
        failure: None,
    }))
}

impl Partition for Recorder {
    fn id(&self) -> PartitionId {
        PartitionId::Recorder
    }

    fn inputs(&self) -> &'static [TopicId] {
        &INPUTS
    }

    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        if let Err(error) = self.record(frame) {
            // Reported with the checkpoint, which must not claim what the file does not hold.
            self.failure.get_or_insert(error);
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        if let Some(failure) = &self.failure {
            return Err(StateError::Other(failure.clone()));
        }
        if let Some(file) = &mut self.file {
            file.flush().map_err(|error| StateError::Other(error.to_string()))?;
        }
        runtime::save_state(&self.written, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.written = runtime::restore_state(state)?;
        let mut kept = 0;
        let written = self.written;
        let recovered = McapRecorder::recover(&self.path, |_, _, _| {
            kept += 1;
            kept <= written
        });
        let (file, _found) = recovered.map_err(|error| StateError::Other(error.to_string()))?;
        self.file = Some(file);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), StateError> {
        let Some(file) = self.file.take() else { return Ok(()) };
        file.finish().map_err(|error| StateError::Other(error.to_string()))
    }
}

impl Recorder {
    fn record(&mut self, frame: &Frame<'_>) -> Result<(), String> {
        if self.file.is_none() {
            let mut file = McapRecorder::create(&self.path).map_err(|error| error.to_string())?;
            file.metadata("run", &self.metadata).map_err(|error| error.to_string())?;
            for (name, text) in &self.attachments {
                file.attach(name, "application/toml", text.as_bytes()).map_err(|error| error.to_string())?;
            }
            self.file = Some(file);
        }
        let file = self.file.as_mut().ok_or("no file")?;
        for topic in INPUTS {
            if TOPICS[topic].delivery == Delivery::Source && !self.record_all {
                continue;
            }
            for (stamps, payload) in frame.raw(topic) {
                file.write(topic, stamps, payload).map_err(|error| error.to_string())?;
                self.written += 1;
            }
        }
        Ok(())
    }
}
