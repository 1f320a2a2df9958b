//! A run that was started elsewhere: its folder, and commands to it.

use crate::Failure;
use runtime::events::read_log;
use runtime::ground;
use runtime::rundir::{self, RunDir};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use telemetry::{EVERY_PARTITION, Event, EventCode, KEY_MAX, PartitionId, Refusal, Telecommand};

const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Two ground programs at once: each takes the other's number for its own so often.
const SEQUENCE_TRIES: u32 = 4;

/// The run in the folder `asked`, or the newest one of this user.
///
/// # Errors
/// [`Failure::Input`] when no run flies there.
pub fn living(asked: Option<PathBuf>) -> Result<RunDir, Failure> {
    let root = std::env::var_os("OBSID_ROOT").filter(|value| !value.is_empty());
    let root = root.map_or_else(|| PathBuf::from("/dev/shm"), PathBuf::from);
    let found = match asked {
        Some(path) => Some(path).filter(|path| rundir::is_alive(path)),
        None => rundir::living(&root),
    };
    found.map(|path| RunDir::at(&path)).ok_or_else(|| {
        Failure::Input(miette::miette!(
            help = "start one with `obsid run`; of a run with its own OBSID_ROOT set the same here",
            "{}: no run flies there",
            root.display()
        ))
    })
}

/// How far a command has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// It waits for its frame.
    Accepted,
    /// Every addressee has carried it out; the frame of the first.
    Executed { frame: u64 },
}

/// A key that no command of this computer has had.
#[must_use]
pub fn fresh_key() -> u64 {
    runtime::sys::monotonic_ns() % (KEY_MAX / 2) + 1
}

/// Above every number that the port was seen to take.
#[must_use]
pub fn next_sequence(dir: &RunDir) -> u32 {
    let seen = |event: &Event| match event.known_code() {
        Some(EventCode::CommandAccepted) => event.argument[2] as u32,
        Some(EventCode::CommandRefused) => event.argument[3] as u32,
        _ => 0,
    };
    let events = read_log(&dir.events(PartitionId::Supervisor));
    events.iter().map(|(_, event)| seen(event)).max().unwrap_or(0).saturating_add(1)
}

/// Sends `command` and waits until it is accepted, and, if it is not delayed, carried out.
///
/// # Errors
/// [`Failure::Run`] with the reason when it is refused, or when nobody answers within `limit`.
pub fn order(dir: &RunDir, mut command: Telecommand, limit: Duration) -> Result<Progress, Failure> {
    for _ in 0..SEQUENCE_TRIES {
        command.sequence = next_sequence(dir);
        match carried_out(dir, &command, limit)? {
            Answer::Done(progress) => return Ok(progress),
            Answer::SequenceOld => {}
        }
    }
    Err(Failure::Run("another ground program sends at the same time: every sequence number was taken".into()))
}

enum Answer {
    Done(Progress),
    SequenceOld,
}

fn carried_out(dir: &RunDir, command: &Telecommand, limit: Duration) -> Result<Answer, Failure> {
    let run = dir.load().map_err(|error| Failure::Run(error.to_string()))?;
    let addressees: Vec<PartitionId> = run.partitions.iter().copied().filter(|&id| command.is_for(id)).collect();
    let since_ns = runtime::sys::monotonic_ns();
    let bytes = runtime::orders::datagram(*command);
    let began = Instant::now();
    // A supervisor that is being restarted has no port for a moment; a command that it took and
    // lost is sent again under the same key.
    let mut sent_at = None::<Instant>;
    while began.elapsed() < limit {
        let is_stale = sent_at.is_none_or(|at| at.elapsed() > limit / 4);
        if is_stale && ground::send(&dir.ground(), &bytes).is_ok() {
            sent_at = Some(Instant::now());
        }
        std::thread::sleep(LOOK_EVERY);
        let accepted = match answer_of(dir, PartitionId::Supervisor, command, since_ns) {
            Some(Said::Refused(Refusal::SequenceOld, _)) => return Ok(Answer::SequenceOld),
            Some(Said::Refused(refusal, fault)) => return Err(refused(command, refusal, fault)),
            Some(_) => true,
            None => false,
        };
        if accepted && command.delay_frames > 0 {
            return Ok(Answer::Done(Progress::Accepted));
        }
        let mut frames = Vec::new();
        for &id in &addressees {
            match answer_of(dir, id, command, since_ns) {
                Some(Said::Executed(frame)) => frames.push(frame),
                Some(Said::Refused(refusal, fault)) => return Err(refused(command, refusal, fault)),
                _ => {}
            }
        }
        // Of a partition that the run does not have, the port's refusal is awaited.
        if !addressees.is_empty() && frames.len() == addressees.len() {
            return Ok(Answer::Done(Progress::Executed { frame: frames.into_iter().min().unwrap_or(0) }));
        }
    }
    let who = if command.partition == EVERY_PARTITION { "not every partition".to_string() } else { "nobody".into() };
    let key = command.key;
    Err(Failure::Run(format!("{who} answered within {} s; send it again with --key {key}", limit.as_secs_f64())))
}

enum Said {
    Accepted,
    Executed(u64),
    Refused(Refusal, Option<Event>),
}

/// The newest word of `partition` on a command.
fn answer_of(dir: &RunDir, partition: PartitionId, command: &Telecommand, since_ns: u64) -> Option<Said> {
    let events = read_log(&dir.events(partition));
    let is_of_key = |event: &Event| event.argument[0] == command.key as f64;
    let at = events.iter().rposition(|(_, event)| {
        let code = event.known_code();
        let speaks = [EventCode::CommandAccepted, EventCode::CommandExecuted, EventCode::CommandRefused];
        code.is_some_and(|code| speaks.contains(&code)) && is_of_key(event)
    })?;
    let (stamps, event) = &events[at];
    match event.known_code()? {
        EventCode::CommandExecuted => Some(Said::Executed(event.argument[2] as u64)),
        EventCode::CommandAccepted => Some(Said::Accepted),
        // A refusal of an earlier try does not speak of this one.
        _ if stamps.sent_ns < since_ns => None,
        _ => {
            let before = at.checked_sub(1).map(|before| events[before].1);
            let fault = before.filter(|event| event.known_code() == Some(EventCode::TableRefused));
            Refusal::from_code(event.argument[2] as u16).map(|refusal| Said::Refused(refusal, fault))
        }
    }
}

fn refused(command: &Telecommand, refusal: Refusal, fault: Option<Event>) -> Failure {
    let fault = fault.map(|event| format!(": {event}")).unwrap_or_default();
    Failure::Run(format!("command with key {} refused: {refusal}{fault}", command.key))
}

/// A partition by its name.
///
/// # Errors
/// [`Failure::Usage`] with the names that there are.
pub fn partition(name: &str) -> Result<PartitionId, Failure> {
    let names = || PartitionId::ALL.iter().map(|id| id.text()).collect::<Vec<_>>().join(", ");
    PartitionId::named(name)
        .ok_or_else(|| Failure::Usage(format!("no partition is called '{name}'; there are {}", names())))
}
