//! The run that flies on this computer: its samples go out, commands for it come in.

use crate::BridgeError;
use crate::wire::{self, About};
use delivery::{Mark, Origin, Peer, StreamId};
use runtime::link::Link;
use runtime::rundir::{self, RunDir};
use runtime::shm::ShmLink;
use runtime::{RunConfig, ground, sys};
use std::collections::{BTreeMap, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use telemetry::{TOPICS, TopicId};

/// Commands that wait for a supervisor which is being restarted.
const COMMANDS_MAX: usize = 64;

/// Reader of a run.
pub struct Near {
    dir: RunDir,
    run: RunConfig,
    topics: Vec<TopicId>,
    link: ShmLink,
    /// Inode of the file that says that the services exist: they were made anew when it differs.
    services: Option<u64>,
    seen: BTreeMap<StreamId, Mark>,
    bad: u64,
    commands: VecDeque<Vec<u8>>,
}

impl Near {
    /// Joins the run in `folder` as a reader of `topics`.
    ///
    /// # Errors
    /// When no run flies there, or its build is another one.
    pub fn attach(folder: &Path, topics: &[TopicId]) -> Result<Self, BridgeError> {
        let dir = RunDir::at(folder);
        let services = inode(&dir);
        if !rundir::is_alive(folder) || services.is_none() {
            let cure = "start it with `obsid run`, or leave --run out";
            return Err(BridgeError::Place(format!("--run {}: no run flies there; {cure}", folder.display())));
        }
        let run = dir.load()?;
        let link = ShmLink::observe(&dir.prefix(), &dir.iceoryx_root(), topics)?;
        let seen = BTreeMap::new();
        Ok(Near { dir, run, topics: topics.to_vec(), link, services, seen, bad: 0, commands: VecDeque::new() })
    }

    /// This run, which another one in the same folder is not; what the far end makes its mirror of.
    pub fn origin(&self) -> Origin {
        let mut hash = DefaultHasher::new();
        let made = std::fs::metadata(self.dir.config()).map(|file| (file.ino(), file.mtime(), file.mtime_nsec()));
        (self.dir.path(), made.ok()).hash(&mut hash);
        let RunConfig { name, period_ns, window_frames, partitions, .. } = self.run.clone();
        let about = serde_json::to_vec(&About { name, period_ns, window_frames, partitions });
        Origin { number: hash.finish(), about: about.unwrap_or_default() }
    }

    /// Its warden or keeper lives.
    pub fn is_alive(&self) -> bool {
        rundir::is_alive(self.dir.path())
    }

    /// Offers what has been published since the last call, and hands commands over.
    ///
    /// # Errors
    /// When shared memory cannot be read.
    pub fn collect(&mut self, peer: &mut Peer) -> Result<(), BridgeError> {
        self.join_again_if_made_anew()?;
        let mut copies = Vec::new();
        for &topic in &self.topics {
            // Copied before it is looked at: a producer may write in between.
            self.link.drain(topic, &mut |stamps, payload| copies.push((topic, *stamps, payload.to_vec())))?;
        }
        for (topic, stamps, payload) in copies {
            let Some(sound) = wire::sound(topic, &stamps, &payload) else {
                self.bad += 1;
                sys::tell(&format!(
                    "bridge: {}: a damaged sample is not sent ({} so far)\n",
                    TOPICS[topic].name, self.bad
                ));
                continue;
            };
            let seen = self.seen.entry(sound.stream).or_default();
            if sound.mark > *seen {
                *seen = sound.mark;
                peer.offer(sound.stream, sound.mark, wire::to_bytes(&stamps, &payload));
            }
        }
        let port = self.dir.ground();
        while self.commands.front().is_some_and(|command| ground::send(&port, command).is_ok()) {
            self.commands.pop_front();
        }
        Ok(())
    }

    /// Takes a command of the other computer; the run's port checks it.
    pub fn command(&mut self, datagram: Vec<u8>) {
        if self.commands.len() == COMMANDS_MAX {
            sys::tell("bridge: no supervisor takes commands: the oldest of them is dropped\n");
            self.commands.pop_front();
        }
        self.commands.push_back(datagram);
    }

    fn join_again_if_made_anew(&mut self) -> Result<(), BridgeError> {
        let services = inode(&self.dir).filter(|&services| Some(services) != self.services);
        if services.is_some() {
            self.link = ShmLink::observe(&self.dir.prefix(), &self.dir.iceoryx_root(), &self.topics)?;
            self.services = services;
        }
        Ok(())
    }
}

fn inode(dir: &RunDir) -> Option<u64> {
    std::fs::metadata(dir.ready()).ok().map(|file| file.ino())
}
