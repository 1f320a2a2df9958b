//! The other computer's run as it appears here: a folder and services like a run's.

use crate::BridgeError;
use crate::wire::{self, About};
use delivery::{Arrival, Mark, Peer, StreamId};
use runtime::config::{Limits, Sabotage};
use runtime::events::EventLog;
use runtime::ground::GroundPort;
use runtime::link::Link;
use runtime::recordings::RemovedRecordings;
use runtime::rundir::OwnedRunDir;
use runtime::shm::ShmLink;
use runtime::{RunConfig, sys};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use telemetry::{EVENT, PartitionId, Stamps, TOPICS};

/// Between two looks for readers that have joined: they get what is in the history \[ns\].
const REFRESH_NS: u64 = 100_000_000;
/// Declared losses, one JSON object a line.
const LOSSES: &str = "losses.jsonl";

/// Makes the mirror when its run is known.
pub struct Mirror {
    folder: PathBuf,
    made: Option<Made>,
}

struct Made {
    link: ShmLink,
    ground: GroundPort,
    /// Rings that `obsid events` and `obsid command` read.
    logs: BTreeMap<u16, EventLog>,
    losses: File,
    refreshed_ns: u64,
    commands: u64,
    owned: OwnedRunDir,
}

impl Mirror {
    /// Of which `folder` will be made.
    pub fn at(folder: PathBuf) -> Self {
        Mirror { folder, made: None }
    }

    /// Publishes a sample; notes a loss.
    ///
    /// # Errors
    /// When the mirror's folder or services cannot be made or written.
    pub fn arrive(&mut self, arrival: Arrival) -> Result<(), BridgeError> {
        match (arrival, &mut self.made) {
            (Arrival::Begun(origin), _) => self.begin(&origin.about),
            (arrival, Some(made)) => made.take(&arrival),
            (_, None) => Ok(()),
        }
    }

    /// The far end sends of another run than before, or of none.
    fn begin(&mut self, about: &[u8]) -> Result<(), BridgeError> {
        self.made = None;
        if !about.is_empty() {
            let about = serde_json::from_slice(about).map_err(std::io::Error::from)?;
            self.made = Some(Made::new(&self.folder, about)?);
        }
        Ok(())
    }

    /// Takes commands, and serves readers that have joined.
    ///
    /// # Errors
    /// When shared memory cannot be written.
    pub fn turn(&mut self, peer: &mut Peer) -> Result<(), BridgeError> {
        let Some(made) = &mut self.made else { return Ok(()) };
        let commands = &mut made.commands;
        made.ground.receive(|datagram| {
            *commands += 1;
            peer.offer(wire::COMMANDS, Mark { epoch: 0, seq: *commands }, datagram.to_vec());
            Ok::<(), BridgeError>(())
        })?;
        let now_ns = sys::monotonic_ns();
        if now_ns - made.refreshed_ns >= REFRESH_NS {
            made.refreshed_ns = now_ns;
            made.link.refresh()?;
        }
        Ok(())
    }
}

impl Made {
    fn new(folder: &std::path::Path, about: About) -> Result<Self, BridgeError> {
        sys::tell(&format!("bridge: {} mirrors the run '{}'\n", folder.display(), about.name));
        let owned = OwnedRunDir::create_at(folder, &config(about)).map_err(|error| {
            let cure = "give the path of a folder that does not exist yet, in one that does";
            BridgeError::Place(format!("--mirror {}: {error}; {cure}", folder.display()))
        })?;
        let dir = owned.dir();
        let link = ShmLink::mirror(&dir.prefix(), &dir.iceoryx_root())?;
        let ground = GroundPort::open(&dir.ground())?;
        let losses = File::create(dir.path().join(LOSSES))?;
        std::fs::write(dir.ready(), "")?;
        let (logs, refreshed_ns, commands) = (BTreeMap::new(), 0, 0);
        Ok(Made { link, ground, logs, losses, refreshed_ns, commands, owned })
    }

    fn take(&mut self, arrival: &Arrival) -> Result<(), BridgeError> {
        match arrival {
            Arrival::Begun(_) => Ok(()),
            Arrival::Lost { stream, from, to } => self.declare(*stream, *from, *to, "lost"),
            Arrival::Sample { stream, mark, payload } => match wire::from_bytes(*stream, payload) {
                Some((sound, payload)) => self.publish(&sound, payload),
                None => self.declare(*stream, mark.seq, mark.seq, "damaged"),
            },
        }
    }

    fn publish(&mut self, sound: &wire::Sound, payload: &[u8]) -> Result<(), BridgeError> {
        // The clock of the other computer says nothing here.
        let stamps = Stamps { sent_ns: sys::monotonic_ns(), ..sound.stamps };
        self.link.publish(sound.topic, &stamps, payload)?;
        if let Some(id) = PartitionId::from_code(sound.source).filter(|_| sound.topic == EVENT.id) {
            let log = match self.logs.entry(sound.source) {
                std::collections::btree_map::Entry::Occupied(log) => log.into_mut(),
                std::collections::btree_map::Entry::Vacant(place) => {
                    place.insert(EventLog::open(&self.owned.dir().events(id))?)
                }
            };
            log.write(&stamps, payload);
        }
        Ok(())
    }

    /// A loss is never silent: a line of the file, and one to the operator.
    fn declare(&mut self, stream: StreamId, from: u64, to: u64, what: &str) -> Result<(), BridgeError> {
        let (topic, source) = wire::topic_and_source(stream);
        let topic = TOPICS.get(topic).map_or("?", |topic| topic.name);
        let source = PartitionId::from_code(source).map_or("?", PartitionId::text);
        let object = serde_json::json!({
            "unix_ns": sys::unix_ns(), "topic": topic, "partition": source, "from": from, "to": to, "what": what,
        });
        writeln!(self.losses, "{object}")?;
        sys::tell(&format!("bridge: {topic} of {source}: samples {from} to {to} are {what}\n"));
        Ok(())
    }
}

/// Of a run that is carried out elsewhere.
fn config(about: About) -> RunConfig {
    RunConfig {
        scenario: String::new(),
        files: BTreeMap::new(),
        name: about.name,
        period_ns: about.period_ns,
        seed: 0,
        replay: None,
        feed: None,
        record: PathBuf::new(),
        results: None,
        record_all: false,
        trace: None,
        windows: false,
        speed: None,
        window_frames: about.window_frames,
        checkpoint_frames: about.window_frames,
        partitions: about.partitions,
        limits: Limits::alike(u64::MAX),
        tables: Vec::new(),
        keep: None,
        removed: RemovedRecordings::default(),
        commands: Vec::new(),
        sabotage: Sabotage::None,
        faults: Vec::new(),
    }
}
