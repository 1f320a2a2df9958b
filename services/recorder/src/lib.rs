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
use runtime::table_store;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
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

/// A recording that a full disk has stopped is tried again after so many frames.
const RETRY_FRAMES: u64 = 500;

/// One file, and how much of it a checkpoint counts on.
struct Sink {
    path: PathBuf,
    file: Option<McapRecorder>,
    /// Sensor samples too, not only what partitions publish.
    takes_all: bool,
    written: u64,
}

impl Sink {
    fn new(path: &Path, takes_all: bool) -> Self {
        Sink { path: path.into(), file: None, takes_all, written: 0 }
    }

    fn flush(&mut self) -> Result<(), String> {
        self.file.as_mut().map_or(Ok(()), McapRecorder::flush).map_err(|error| error.to_string())
    }

    fn write(&mut self, frame: &Frame<'_>) -> Result<(), String> {
        let file = self.file.as_mut().ok_or("no file")?;
        for topic in INPUTS {
            if TOPICS[topic].delivery == Delivery::Source && !self.takes_all {
                continue;
            }
            for (stamps, payload) in frame.raw(topic) {
                file.write(topic, stamps, payload).map_err(|error| error.to_string())?;
                self.written += 1;
            }
        }
        Ok(())
    }

    /// Takes up what a killed process or a full disk has left, as far as `written` counts.
    fn recover(&mut self, written: u64) -> Result<(), String> {
        let mut kept = 0;
        let recovered = McapRecorder::recover(&self.path, |_, _, _| {
            kept += 1;
            kept <= written
        });
        let (file, _found) = recovered.map_err(|error| error.to_string())?;
        (self.file, self.written) = (Some(file), written);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), String> {
        let Some(file) = self.file.take() else { return Ok(()) };
        file.finish().map_err(|error| error.to_string())
    }
}

/// What a checkpoint holds: samples written to the results, to the recording of everything, and
/// since which frame that one stands still.
type State = (u64, u64, Option<u64>);

/// The partition: writes every topic, publishes none.
pub struct Recorder {
    /// Without these there is no result.
    results: Sink,
    /// Everything, where the user wants it and results have a file of their own: its disk may be
    /// full.
    everything: Option<Sink>,
    /// Frame since which `everything` stands still.
    stopped: Option<u64>,
    metadata: BTreeMap<String, String>,
    /// Name and text of the scenario and of the files that it names.
    attachments: Vec<(String, String)>,
    failure: Option<String>,
    frames: u64,
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
    let tables = (!run.tables.is_empty()).then(|| (table_store::ATTACHMENT.into(), table_store::to_json(&run.tables)));
    let (results, everything) = match &run.results {
        Some(results) => (Sink::new(results, false), Some(Sink::new(&run.record, run.record_all))),
        None => (Sink::new(&run.record, run.record_all), None),
    };
    Ok(Box::new(Recorder {
        results,
        everything,
        stopped: None,
        metadata,
        attachments: [(SCENARIO.to_string(), run.scenario.clone())].into_iter().chain(files).chain(tables).collect(),
        failure: None,
        frames: 0,
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
        self.frames = frame.number;
        if let Err(error) = self.record_results(frame) {
            // Reported with the checkpoint, which must not claim what the file does not hold.
            self.failure.get_or_insert(error);
        }
        self.retry();
        if let Err(error) = self.record_everything(frame) {
            self.stop(&error);
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        if let Some(failure) = &self.failure {
            return Err(StateError::Other(failure.clone()));
        }
        self.results.flush().map_err(StateError::Other)?;
        if let Err(error) = self.everything.as_mut().map_or(Ok(()), Sink::flush) {
            self.stop(&error);
        }
        let everything = self.everything.as_ref().map_or(0, |sink| sink.written);
        let whole: State = (self.results.written, everything, self.stopped);
        runtime::save_state(&whole, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let (results, everything, stopped): State = runtime::restore_state(state)?;
        self.results.recover(results).map_err(StateError::Other)?;
        self.stopped = stopped;
        if let Some(sink) = self.everything.as_mut().filter(|_| stopped.is_none()) {
            let recovered = if sink.path.is_file() { sink.recover(everything) } else { Err("no file".into()) };
            sink.written = everything;
            if let Err(error) = recovered {
                self.stop(&error);
            }
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), StateError> {
        if let Err(error) = self.everything.as_mut().map_or(Ok(()), Sink::finish) {
            self.stop(&error);
        }
        self.results.finish().map_err(StateError::Other)
    }
}

impl Recorder {
    fn record_results(&mut self, frame: &Frame<'_>) -> Result<(), String> {
        if self.results.file.is_none() {
            self.results.file = Some(self.begin(&self.results.path)?);
        }
        self.results.write(frame)
    }

    fn record_everything(&mut self, frame: &Frame<'_>) -> Result<(), String> {
        if self.stopped.is_some() || self.everything.is_none() {
            return Ok(());
        }
        if let Some(path) = self.everything.as_ref().filter(|sink| sink.file.is_none()).map(|sink| sink.path.clone()) {
            let file = self.begin(&path)?;
            self.everything.iter_mut().for_each(|sink| sink.file = None);
            self.everything.as_mut().ok_or("no recording")?.file = Some(file);
        }
        self.everything.as_mut().ok_or("no recording")?.write(frame)
    }

    /// A new file with what the run is.
    fn begin(&self, path: &Path) -> Result<McapRecorder, String> {
        let mut file = McapRecorder::create(path).map_err(|error| error.to_string())?;
        file.metadata("run", &self.metadata).map_err(|error| error.to_string())?;
        for (name, text) in &self.attachments {
            let kind = if name == table_store::ATTACHMENT { "application/json" } else { "application/toml" };
            file.attach(name, kind, text.as_bytes()).map_err(|error| error.to_string())?;
        }
        Ok(file)
    }

    /// The recording stops, the run goes on: said once, and left beside the results for whoever
    /// reads them.
    fn stop(&mut self, error: &str) {
        let Some(sink) = &mut self.everything else { return };
        sink.file = None;
        if self.stopped.is_none() {
            self.stopped = Some(self.frames);
            let text = format!("the recording stopped at frame {}: {error}", self.frames);
            runtime::sys::tell(&format!("recorder: {text}; the run goes on\n"));
            // Where the results have no room either, the run has failed for a better reason.
            let _ = std::fs::write(self.results.path.with_extension("stopped"), text);
        }
    }

    /// A stopped recording goes on behind what its file holds, once there is room.
    fn retry(&mut self) {
        let Some(since) = self.stopped.filter(|since| (self.frames - since) % RETRY_FRAMES == RETRY_FRAMES - 1) else {
            return;
        };
        let Some(sink) = self.everything.as_mut().filter(|sink| sink.path.is_file()) else { return };
        if sink.recover(sink.written).is_ok() {
            self.stopped = None;
            let frames = self.frames;
            runtime::sys::tell(&format!("recorder: the recording goes on, frames {since} to {frames} are missing\n"));
        }
    }
}
