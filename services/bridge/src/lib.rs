//! What it is: results, events and commands between two runs on two computers, over zenoh.
//!
//! One process on each computer. It sends the samples of the run that flies here, and shows those
//! of the other computer's run as a *mirror*: a folder and services in shared memory like a run's,
//! with the original headers, in which it alone publishes. Whatever reads a run reads the mirror;
//! the run here and its digest are not touched. A command given to the mirror's port is carried to
//! the other computer and handed to its run's port, which checks it as any other.
//!
//! `delivery` decides what is sent again, put in order and declared lost; this crate hands it
//! samples, time and zenoh's messages. zenoh repeats nothing and keeps nothing here.
//!
//! ```no_run
//! use bridge::{Arguments, End};
//!
//! let arguments = Arguments {
//!     end: End::Connect("tcp/10.0.0.1:7447".into()),
//!     run: None,
//!     mirror: Some("/run/obsid/obsid-far".into()),
//!     topics: bridge::default_topics(),
//!     room: 256,
//! };
//! let report = bridge::run(&arguments)?; // until SIGTERM
//! println!("{} samples came, {} are declared lost", report.arrived, report.lost);
//! # Ok::<(), bridge::BridgeError>(())
//! ```
//!
//! May import: delivery, runtime, telemetry, zenoh.
//!
//! Must never know: equations, estimators, the meaning of a sample.
#![forbid(unsafe_code)]

mod arguments;
mod line;
mod mirror;
mod near;
mod wire;

pub use arguments::{Arguments, End, parse};
pub use delivery::Counts;
pub use wire::default_topics;

use delivery::{Arrival, Identity, Origin, Peer, Refusal};
use line::Line;
use mirror::Mirror;
use near::Near;
use runtime::sys::tell;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use telemetry::TOPICS;

/// Between two looks at shared memory and line: an estimate comes once a second.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Arrivals handed on in one look: half of the smallest buffer, so that a reader of the mirror that
/// looks as often misses none behind a cut.
const AT_ONCE: usize = 8;
/// The far end is said to be silent after so long: three greetings \[ms\].
const SILENT_MS: u64 = 3000;
/// A run that is over is held for so long, so that its last samples come over.
const LINGER: Duration = Duration::from_secs(60);

/// Why a bridge ends without success.
#[derive(Debug, thiserror::Error)]
pub enum BridgeError {
    /// The command line.
    #[error("{0}")]
    Usage(String),
    /// The run or the mirror, its place and cure.
    #[error("{0}")]
    Place(String),
    /// zenoh.
    #[error("{endpoint}: {reason}; give tcp/ADDRESS:PORT or udp/ADDRESS:PORT of this computer to listen on")]
    Line { endpoint: String, reason: String },
    /// Shared memory.
    #[error(transparent)]
    Link(#[from] runtime::link::LinkError),
    /// A file.
    #[error(transparent)]
    File(#[from] std::io::Error),
    /// Another build at the far end.
    #[error("{0}; build obsid and obsid-bridge of both computers from one revision")]
    Refused(String),
}

/// Carries samples until SIGTERM, or until the run here is over and its last samples are
/// acknowledged.
///
/// # Errors
/// See [`BridgeError`].
pub fn run(arguments: &Arguments) -> Result<Counts, BridgeError> {
    let stop = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGTERM, Arc::clone(&stop))?;
    signal_hook::flag::register(SIGINT, Arc::clone(&stop))?;
    let life = runtime::sys::unix_ns() ^ (u64::from(std::process::id()) << 48);
    let near = arguments.run.as_deref().map(|folder| Near::attach(folder, &arguments.topics)).transpose()?;
    let origin = near.as_ref().map_or(Origin::default(), Near::origin);
    let layouts = TOPICS.iter().map(|topic| topic.layout).collect();
    let identity = Identity { generation: telemetry::generation(), layouts };
    let mut bridge = Bridge {
        peer: Peer::new(life, origin, identity, arguments.room),
        line: Line::open(&arguments.end)?,
        mirror: arguments.mirror.clone().map(Mirror::at),
        near,
        began: Instant::now(),
        over: None,
        is_silent: true,
    };
    while !stop.load(Ordering::Relaxed) && !bridge.is_done() {
        bridge.turn()?;
        std::thread::sleep(LOOK_EVERY);
    }
    Ok(bridge.peer.counts())
}

struct Bridge {
    peer: Peer,
    line: Line,
    near: Option<Near>,
    mirror: Option<Mirror>,
    began: Instant,
    /// When the run here was seen to be over.
    over: Option<Instant>,
    is_silent: bool,
}

impl Bridge {
    fn now_ms(&self) -> u64 {
        self.began.elapsed().as_millis() as u64
    }

    fn turn(&mut self) -> Result<(), BridgeError> {
        let now_ms = self.now_ms();
        if let Some(near) = &mut self.near {
            if self.over.is_none() && !near.is_alive() {
                self.over = Some(Instant::now());
                tell("bridge: the run here is over; its last samples are brought over\n");
            }
            let collected = near.collect(&mut self.peer);
            // Of a run that is over what shared memory still has is taken.
            collected.or_else(|error| if self.over.is_some() { Ok(()) } else { Err(error) })?;
        }
        while let Some(message) = self.line.received() {
            self.peer.hear(&message, now_ms);
        }
        if let Some(refusal) = self.peer.refusal() {
            return Err(BridgeError::Refused(in_words(refusal)));
        }
        for _ in 0..AT_ONCE {
            let Some(arrival) = self.peer.next_arrival() else { break };
            self.hand_on(arrival)?;
        }
        if let Some(mirror) = &mut self.mirror {
            mirror.turn(&mut self.peer)?;
        }
        let has_samples = self.near.is_some() && !(self.over.is_some() && self.peer.is_idle());
        self.peer.set_finished(!has_samples);
        let line = &self.line;
        self.peer.tick(now_ms, |message| line.send(message));
        self.watch_silence(now_ms);
        Ok(())
    }

    fn hand_on(&mut self, arrival: Arrival) -> Result<(), BridgeError> {
        if let Arrival::Sample { stream: wire::COMMANDS, payload, .. } = &arrival {
            if let Some(near) = &mut self.near {
                near.command(payload.clone());
            }
            return Ok(());
        }
        self.mirror.as_mut().map_or(Ok(()), |mirror| mirror.arrive(arrival))
    }

    fn watch_silence(&mut self, now_ms: u64) {
        let is_silent = self.peer.silent_ms(now_ms).is_none_or(|silent_ms| silent_ms >= SILENT_MS);
        if is_silent != self.is_silent {
            self.is_silent = is_silent;
            let word = if is_silent { "is silent: samples wait" } else { "is there" };
            tell(&format!("bridge: the other computer {word}\n"));
        }
    }

    /// The run here is over and brought over, and so is the one that is mirrored.
    fn is_done(&self) -> bool {
        let is_done = || self.peer.is_idle() && (self.mirror.is_none() || self.peer.far_is_finished());
        self.over.is_some_and(|since| is_done() || since.elapsed() > LINGER)
    }
}

fn in_words(refusal: &Refusal) -> String {
    match *refusal {
        Refusal::Protocol { ours, theirs } => {
            format!("this bridge speaks version {ours} of the protocol, the other computer's version {theirs}")
        }
        Refusal::Layout { ours, theirs, kind } => {
            let what = kind.and_then(|kind| TOPICS.get(kind)).map_or_else(
                || "the lists of topics or codes differ".to_string(),
                |topic| format!("topic {} is laid out otherwise", topic.name),
            );
            format!("telemetry {ours:08x} here, {theirs:08x} on the other computer: {what}")
        }
    }
}
