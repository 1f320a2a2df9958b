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
use runtime::recordings::{RecordingLimits, RemovedRecordings};
use runtime::table_store;
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use telemetry::{Delivery, EVENT, Event, EventCode, PartitionId, TOPIC_TABLE, TOPICS, TopicId};

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
    /// By topic: left out, because the file fills up.
    left_out: [bool; TOPIC_TABLE.len()],
    /// Samples left out.
    spared: u64,
}

impl Sink {
    fn new(path: &Path, takes_all: bool) -> Self {
        let left_out = [false; TOPIC_TABLE.len()];
        Sink { path: path.into(), file: None, takes_all, written: 0, left_out, spared: 0 }
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
            if self.left_out[topic] {
                self.spared += frame.raw(topic).count() as u64;
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
        (self.file, self.written) = (Some(file), written.min(kept));
        Ok(())
    }

    fn finish(&mut self) -> Result<(), String> {
        let Some(mut file) = self.file.take() else { return Ok(()) };
        if self.spared > 0 {
            let topics = INPUTS.iter().filter(|topic| self.left_out[**topic]).map(|topic| TOPICS[*topic].name);
            let topics = topics.collect::<Vec<_>>().join(" ");
            let facts = BTreeMap::from([("topics".into(), topics), ("samples".into(), self.spared.to_string())]);
            file.metadata("left out", &facts).map_err(|error| error.to_string())?;
        }
        file.finish().map_err(|error| error.to_string())
    }
}

/// What a checkpoint holds: samples written to the results, to the recording of everything, since
/// which frame that one stands still, how far it leaves topics out, and samples left out.
type State = (u64, u64, Option<u64>, u64, u64);

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
    limits: RecordingLimits,
    /// How far the recording leaves topics out ([`RecordingLimits::step`]), and how far that was
    /// said.
    step: usize,
    said: usize,
    /// Older recordings that had to go for this one.
    removed: RemovedRecordings,
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
        limits: run.limits.recording.clone(),
        step: 0,
        said: 0,
        removed: run.removed,
    }))
}

impl Partition for Recorder {
    fn id(&self) -> PartitionId {
        PartitionId::Recorder
    }

    fn inputs(&self) -> &'static [TopicId] {
        &INPUTS
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        self.frames = frame.number;
        self.say_what_is_missing(out);
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
        self.measure();
        let everything = self.everything.as_ref().map_or(0, |sink| sink.written);
        let spared = self.recording().spared;
        let whole: State = (self.results.written, everything, self.stopped, self.step as u64, spared);
        runtime::save_state(&whole, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let (results, everything, stopped, step, spared): State = runtime::restore_state(state)?;
        self.results.recover(results).map_err(StateError::Other)?;
        self.leave_out(step as usize);
        self.said = self.step;
        self.recording().spared = spared;
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
    /// The file of sensor samples, which may grow too large.
    fn recording(&mut self) -> &mut Sink {
        self.everything.as_mut().unwrap_or(&mut self.results)
    }

    /// Looks how large the recording is, and leaves out what its limits say.
    fn measure(&mut self) {
        let bytes = std::fs::metadata(&self.recording().path).map_or(0, |file| file.len());
        let step = self.limits.step(bytes);
        if step > self.step {
            self.leave_out(step);
        }
    }

    fn leave_out(&mut self, step: usize) {
        self.step = step;
        let topics: Vec<TopicId> = self.limits.left_out(step).collect();
        let sink = self.recording();
        topics.into_iter().for_each(|topic| sink.left_out[topic] = true);
    }

    fn say_what_is_missing(&mut self, out: &mut Outputs) {
        let frame = self.frames;
        let mut say = |code, arguments: &[f64]| {
            out.publish(EVENT, &Event::new(code, PartitionId::Recorder, frame, arguments));
        };
        let RemovedRecordings { files, bytes } = std::mem::take(&mut self.removed);
        if files > 0 && frame == 0 {
            say(EventCode::RecordingsRemoved, &[files as f64, bytes as f64]);
        }
        if self.said < self.step {
            self.said = self.step;
            let topics = self.limits.left_out(self.step).count();
            let sink = self.recording();
            let bytes = std::fs::metadata(&sink.path).map_or(0, |file| file.len());
            say(EventCode::RecordingReduced, &[topics as f64, bytes as f64, sink.spared as f64]);
        }
    }

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

#[cfg(test)]
mod tests;
