//! What it is: the source of a run with real sensors: drivers write samples to a socket, the
//! gateway forms frames of them (architecture D10).
//!
//! It stands where the simulated source stands. A frame that it has sent is in its journal first,
//! so that a restarted gateway sends the same frame again; what drivers wrote while it was down is
//! lost, and its frames are counted as empty.
//!
//! ```no_run
//! use runtime::rundir::RunDir;
//! use telemetry::PartitionId;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The folder of a run, as `obsid gateway` makes it.
//! let folder = std::env::args_os().nth(1).ok_or("no folder of a run")?;
//! let run = RunDir::at(folder.as_ref()).load()?;
//! let mut source = gateway::connect(&run)?;
//! assert_eq!(source.id(), PartitionId::SensorSim);
//! assert!(source.is_ready(0), "frames before the experiment wait for no sensor");
//! # Ok(())
//! # }
//! ```
//!
//! May import: runtime, telemetry.
//!
//! Must never know: plants, estimators, what a sample means.
#![forbid(unsafe_code)]

mod assembly;

use assembly::{Assembly, Held, Timing};
use runtime::experiment::ExperimentWindow;
use runtime::feed::{FeedConfig, FeedSocket, Journal};
use runtime::{ConnectError, Frame, Outputs, Partition, RunConfig, StateError};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACTUATORS, Experiment, Header, IMU, JOINTS, PartitionId, Sample, TOPICS, Topic, TopicId,
};

/// Pacing windows that the journal holds: a restart goes back to a checkpoint, at most one window.
const JOURNAL_WINDOWS: u64 = 2;
/// Pacing windows of one topic at its full rate that are held before drivers have to wait.
const HELD_WINDOWS: u64 = 2;

/// State of a checkpoint.
#[derive(Default, Serialize, Deserialize)]
struct State {
    window: ExperimentWindow,
    /// First frame behind the run.
    last_frame: Option<u64>,
    assembly: Assembly,
}

/// The source partition of a run with real sensors.
pub struct Gateway {
    state: State,
    socket: FeedSocket,
    journal: Journal,
    timing: Timing,
    window_frames: u64,
    held_max: usize,
    /// Frames of the feed that an earlier life has sent.
    journaled: u64,
    formed: Vec<Held>,
}

/// Builds the gateway of `run`.
///
/// # Errors
/// When the run has no feed, or its socket or journal cannot be made.
pub fn connect(run: &RunConfig) -> Result<Box<dyn Partition>, ConnectError> {
    let fail = |reason: String| ConnectError { partition: PartitionId::SensorSim, reason };
    let feed = run.feed.as_ref().ok_or_else(|| fail("the run has no feed".into()))?;
    let FeedConfig { lateness_ns, silence_ns, .. } = *feed;
    let in_file = |path: &std::path::Path, error: std::io::Error| fail(format!("{}: {error}", path.display()));
    let journal = Journal::open(&feed.journal, JOURNAL_WINDOWS * run.window_frames);
    let mut gateway = Gateway {
        state: State::default(),
        socket: FeedSocket::bind(&feed.socket).map_err(|error| in_file(&feed.socket, error))?,
        journal: journal.map_err(|error| in_file(&feed.journal, error))?,
        timing: Timing {
            period_ns: run.period_ns,
            lateness_ns,
            silence_ns,
            ahead_ns: run.window_frames * run.period_ns,
        },
        window_frames: run.window_frames,
        held_max: usize::try_from(HELD_WINDOWS * run.window_frames).unwrap_or(usize::MAX) * TOPICS[IMU.id].per_frame,
        journaled: 0,
        formed: Vec::new(),
    };
    gateway.find_journaled();
    Ok(Box::new(gateway))
}

impl Gateway {
    /// Which frame of the feed a frame of the run carries. The experiment begins with the frame in
    /// which its mode takes effect; that one is open before it can wait for a sensor.
    fn fed_frame(&self, number: u64) -> Option<u64> {
        let window = &self.state.window;
        let inside = window.experiment == Experiment::Replay && number < window.end_frame;
        number.checked_sub(window.begin_frame + 1).filter(|_| inside)
    }

    fn find_journaled(&mut self) {
        self.journaled = self.state.assembly.closed();
        while self.journal.read(self.journaled, &mut |_, _| ()).is_some() {
            self.journaled += 1;
        }
    }

    /// Takes what has come, unless so much waits that drivers have to wait, too.
    fn listen(&mut self) -> u64 {
        let quiet_ns = self.socket.quiet().as_nanos() as u64;
        let (assembly, timing) = (&mut self.state.assembly, &self.timing);
        if assembly.held() < self.held_max || !assembly.is_complete(timing, quiet_ns) {
            self.socket.drain(&mut |topic, bytes| assembly.offer(topic, bytes, timing, quiet_ns));
        }
        quiet_ns
    }

    /// The samples of frame `fed` of the feed, in `formed`.
    fn form(&mut self, fed: u64) -> Result<(), std::io::Error> {
        let assembly = &mut self.state.assembly;
        if fed < self.journaled {
            let formed = &mut self.formed;
            formed.clear();
            let mut keep = |topic: TopicId, bytes: &[u8]| {
                let t_ns = telemetry_time(bytes);
                formed.push(Held { t_ns, topic, bytes: bytes.to_vec() });
            };
            if let Some((origin_ns, counts)) = self.journal.read(fed, &mut keep) {
                assembly.resume(fed + 1, origin_ns, counts, &self.timing);
                return Ok(());
            }
        }
        assembly.close(&self.timing, &mut self.formed);
        assembly.counts_mut().strangers = self.socket.strangers();
        let (origin_ns, counts) = (assembly.origin_ns(), *assembly.counts_mut());
        let samples = self.formed.iter().map(|held| (held.topic, &held.bytes[..]));
        self.journal.write(fed, origin_ns, &counts, samples)
    }
}

fn telemetry_time(bytes: &[u8]) -> u64 {
    use zerocopy::FromBytes;
    Header::read_from_prefix(bytes).map_or(0, |(header, _)| header.t_meas_ns)
}

impl Partition for Gateway {
    fn id(&self) -> PartitionId {
        PartitionId::SensorSim
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[]
    }

    fn is_ready(&mut self, number: u64) -> bool {
        let quiet_ns = self.listen();
        let complete = |fed| fed < self.journaled || self.state.assembly.is_complete(&self.timing, quiet_ns);
        self.fed_frame(number).is_none_or(complete)
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        if let Some(mode) = frame.new_mode() {
            self.state.window.step(frame, &[]);
            if mode.ended == 1 {
                // Results of the last frames are on their way for one more window.
                self.state.last_frame = Some(frame.number + self.window_frames);
            }
        }
        if let Some(fed) = self.fed_frame(frame.number) {
            // Without a journal a restart could not send the frame again: it is not sent at all.
            if let Err(error) = self.form(fed) {
                runtime::sys::tell(&format!("gateway: frame {fed} is lost, its journal: {error}\n"));
                self.formed.clear();
            }
            let begin_ns = self.state.assembly.origin_ns() + fed * frame.period_ns;
            for held in &self.formed {
                let t_ns = frame.t_ns + held.t_ns.saturating_sub(begin_ns);
                publish(held.topic, &held.bytes, t_ns, out);
            }
        }
        if self.state.last_frame.is_some_and(|last| frame.number >= last) {
            out.end();
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&self.state, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.state = runtime::restore_state(state)?;
        self.find_journaled();
        Ok(())
    }
}

/// Sends a sample on the run's clock.
fn publish(topic: TopicId, bytes: &[u8], t_ns: u64, out: &mut Outputs) {
    match topic {
        topic if topic == IMU.id => publish_as(IMU, bytes, t_ns, out),
        topic if topic == JOINTS.id => publish_as(JOINTS, bytes, t_ns, out),
        topic if topic == ACTUATORS.id => publish_as(ACTUATORS, bytes, t_ns, out),
        topic if topic == ACCELEROMETERS.id => publish_as(ACCELEROMETERS, bytes, t_ns, out),
        _ => {}
    }
}

fn publish_as<T: Sample>(topic: Topic<T>, bytes: &[u8], t_ns: u64, out: &mut Outputs) {
    if let Ok(mut sample) = T::read_from_bytes(bytes) {
        *sample.header_mut() = Header::at(t_ns);
        out.publish(topic, &sample);
    }
}
