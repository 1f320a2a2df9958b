//! A partition as a process: joins shared memory, turns until the run ends, reports how it does.

mod warden_words;

use crate::config::{Fault, KillPoint};
use crate::events::EventLog;
use crate::ground::GroundPort;
use crate::hardening::Hardening;
use crate::inbox::Counters;
use crate::life::Life;
use crate::link::{Link, LinkError};
use crate::partition::{Connect, ConnectError};
use crate::rules::Rules;
use crate::rundir::RunDir;
use crate::runner::{RunError, Runner, TablePlaces, Timetable, Turn};
use crate::shm::{Role, ShmLink};
use crate::statistics::Statistics;
use crate::table_store::TableStore;
use crate::trace::{Mark, Trace};
use crate::watch::HangWatch;
use crate::{RunConfig, resets, sys};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use telemetry::{COMMAND, EVENT, EventCode, HOUSEKEEPING, PROGRESS, PartitionId, Severity, TELECOMMAND, TICK};

/// Frames per turn: bounds the time between looks at signals and links.
const FRAMES_PER_TURN: u64 = 25;
const BEAT: Duration = Duration::from_millis(50);
/// Between two looks whether the work beside the loop is done.
const WORK_LOOK: Duration = Duration::from_millis(2);
/// Between two looks whether drivers of real sensors have written: half a frame of 10 ms.
const FEED_LOOK: Duration = Duration::from_millis(5);
/// A wait of 0 would not let others run.
const TIMER_MIN_NS: u64 = 10_000;
const HOUSEKEEPING_EVERY: Duration = Duration::from_secs(1);

/// Why a partition's process ends before its run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    #[error(transparent)]
    Connect(#[from] ConnectError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Its files are complete; whether the run is over is the warden's knowledge.
    #[error("told to end before the run was over")]
    Stopped,
    #[error("run folder: {0}")]
    Folder(#[from] std::io::Error),
}

impl ProcessError {
    /// Whether another start could succeed.
    #[must_use]
    pub fn is_final(&self) -> bool {
        matches!(self, ProcessError::Connect(_) | ProcessError::Link(LinkError::Layout { .. }))
    }

    /// What the warden does about it.
    fn exit_code(&self) -> i32 {
        match self {
            ProcessError::Link(LinkError::Vanished { .. }) => crate::warden::EXIT_VANISHED,
            ProcessError::Stopped => crate::warden::EXIT_STOPPED,
            error if error.is_final() => crate::warden::EXIT_FINAL,
            _ => 1,
        }
    }
}

/// Runs partition `id` of the run in `folder` until the run ends or SIGTERM comes.
///
/// # Errors
/// See [`ProcessError`]; the warden restarts after all but final ones.
pub fn run(id: PartitionId, connect: Connect, folder: &Path, life: Life) -> Result<(), ProcessError> {
    sys::die_with_parent(life.parent);
    let stop = Arc::new(AtomicBool::new(false));
    // The terminal's Ctrl-C reaches every process; order is the warden's business.
    let ignored = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGTERM, Arc::clone(&stop))?;
    signal_hook::flag::register(SIGINT, ignored)?;
    let dir = RunDir::at(folder);
    let run = dir.load()?;
    if !run.partitions.contains(&id) {
        // A service manager starts every unit that is installed.
        sys::tell(&format!("{id}: takes no part in this run\n"));
        if let Some(manager) = sys::Notifier::of_environment() {
            manager.say("READY=1");
        }
        return Ok(());
    }
    if run
        .faults
        .iter()
        .any(|f| matches!(f, Fault::Kill { partition, point: KillPoint::Connect, .. } if *partition == id))
        && life.epoch == 0
    {
        sys::kill_self();
    }
    let mut process = Process::start(id, connect, &run, &dir, life)?;
    while !stop.load(Ordering::Relaxed) && !process.is_over() {
        process.cycle()?;
    }
    let over = process.is_over();
    process.end()?;
    if over { Ok(()) } else { Err(ProcessError::Stopped) }
}

struct Process<'a> {
    runner: Runner<ShmLink>,
    run: &'a RunConfig,
    statistics: Statistics,
    /// Counters as last reported in an event.
    reported: Counters,
    watch: Option<HangWatch>,
    /// The supervisor's.
    ground: Option<GroundPort>,
    /// The supervisor's.
    rules: Rules,
    finished: bool,
    others_done: Vec<PartitionId>,
    is_back: bool,
    told_anew: bool,
    last_beat: Instant,
    last_housekeeping: Instant,
    /// Where a service manager, not a warden, watches this process.
    manager: Option<sys::Notifier>,
}

impl<'a> Process<'a> {
    fn start(
        id: PartitionId,
        connect: Connect,
        run: &'a RunConfig,
        dir: &RunDir,
        life: Life,
    ) -> Result<Self, ProcessError> {
        let is_supervisor = id == PartitionId::Supervisor;
        let role = match (is_supervisor, dir.ready().exists()) {
            (true, false) => {
                // What a supervisor that died on its way has left: nobody else has opened it.
                dir.clear_services()?;
                Role::Creates
            }
            (false, false) => return Err(LinkError::Vanished { topic: "wake" }.into()),
            (_, true) => Role::Opens,
        };
        let partition = connect(run)?;
        let mut inputs = partition.inputs().to_vec();
        inputs.extend([TICK.id, telemetry::MODE.id, PROGRESS.id, COMMAND.id, TELECOMMAND.id]);
        let rules = Rules::new(if is_supervisor { &run.limits.rules } else { &[] });
        if is_supervisor && !run.limits.rules.is_empty() {
            inputs.push(EVENT.id);
        }
        let link = ShmLink::join(&dir.prefix(), &dir.iceoryx_root(), id, &inputs, role)?;
        let store = crate::checkpoint::Store::new(&dir.own(id), id.text());
        let mut runner = Runner::start(partition, link, run, life.epoch, Some(store))?.with_fault_hook(strike);
        if let Some(folder) = &run.trace {
            let mut trace = Trace::create(&crate::trace::path(folder, id, life.epoch))?;
            let now_ns = sys::monotonic_ns();
            trace.mark(Mark::Start, life.epoch.into(), now_ns, now_ns);
            runner.trace_to(trace);
        }
        let ground = is_supervisor.then(|| GroundPort::open(&dir.ground())).transpose()?;
        keep_records(&mut runner, run, dir, life)?;
        if role == Role::Creates {
            std::fs::write(dir.ready(), "")?;
        }
        let hardening = Hardening::confine(dir, id, run);
        runner.work_beside();
        timetable(run, id).into_iter().for_each(|table| runner.keep_time(table));
        let mut process = Process {
            is_back: life.epoch == 0,
            told_anew: false,
            reported: runner.counters(),
            runner,
            run,
            statistics: Statistics::new(dir.statistics(id), life),
            watch: is_supervisor.then(|| HangWatch::new(run)),
            ground,
            rules,
            finished: false,
            others_done: Vec::with_capacity(PartitionId::COUNT),
            last_beat: Instant::now(),
            last_housekeeping: Instant::now(),
            manager: sys::Notifier::of_environment(),
        };
        process.harden(hardening, dir);
        if let Some(watch) = &mut process.watch {
            watch.say_ready();
        }
        let severity = if life.epoch == 0 { Severity::Information } else { Severity::Warning };
        process.runner.event_as(severity, EventCode::Started, &[life.epoch.into(), life.cause.into()])?;
        process.runner.beat()?;
        process.wake_everybody();
        process.report("READY=1");
        Ok(process)
    }

    /// All threads exist: the barriers are closed.
    fn harden(&mut self, mut hardening: Hardening, dir: &RunDir) {
        hardening.filter(self.run);
        self.statistics.hardened(hardening);
        let (id, is_first) = (self.runner.id(), self.runner.epoch() == 0);
        if is_first
            && self.run.faults.iter().any(|fault| matches!(fault, Fault::Probe { partition } if *partition == id))
        {
            crate::hardening::probe(dir, id);
        }
    }

    fn cycle(&mut self) -> Result<(), ProcessError> {
        if let Some(ground) = &mut self.ground {
            ground.receive(|command| self.runner.take_command(command))?;
        }
        let turn = self.runner.turn(self.frames_allowed())?;
        self.obey_rules()?;
        let ended_now = turn == Turn::Finished && !self.finished;
        self.finished = turn == Turn::Finished;
        self.note_finished();
        let (runner, watch) = (&self.runner, self.watch.as_mut());
        let told = watch.map(|watch| watch.turn(runner.heard(), runner.frames_done(), runner.mode_text()));
        self.runner.forget_heard();
        self.obey_warden(told)?;
        if (matches!(turn, Turn::Worked(_)) || ended_now) && self.runner.id() == PartitionId::SensorSim {
            self.wake_everybody();
        }
        if self.last_beat.elapsed() >= BEAT {
            self.last_beat = Instant::now();
            self.runner.beat()?;
        }
        if self.last_housekeeping.elapsed() >= HOUSEKEEPING_EVERY {
            self.last_housekeeping = Instant::now();
            self.housekeeping()?;
            self.report("WATCHDOG=1");
        }
        if self.runner.began_anew() && !self.told_anew {
            self.told_anew = true;
            self.runner.event(EventCode::BeganAnew, &[self.runner.frames_done() as f64])?;
            let (id, frame) = (self.runner.id(), self.runner.frames_done());
            sys::tell(&format!(
                "{id}: no checkpoint is whole: it begins anew at frame {frame}, what it knew is lost\n"
            ));
        }
        if !self.is_back && self.runner.fresh_ns().is_some() {
            // The warden reads from it how long a restart took.
            self.is_back = true;
            self.housekeeping()?;
        }
        // Who did fewer frames than a turn may do has no further one; word of samples that came
        // since is kept, and ends the wait at once.
        if !matches!(turn, Turn::Worked(FRAMES_PER_TURN)) {
            self.wait()?;
        }
        Ok(())
    }

    /// Events that become commands.
    fn obey_rules(&mut self) -> Result<(), ProcessError> {
        while let Some(event) = self.runner.take_heard_event() {
            let runner = &mut self.runner;
            self.rules.hear(&event, sys::monotonic_ns(), |opcode, to| runner.take_own_command(opcode, to))?;
        }
        Ok(())
    }

    fn wait(&mut self) -> Result<(), ProcessError> {
        let timeout = if self.runner.is_working() { WORK_LOOK } else { self.time_to_next_frame() };
        let begin_ns = sys::monotonic_ns();
        if let Some(trace) = self.runner.trace_mut() {
            trace.flush();
        }
        self.runner.link_mut().wait(timeout)?;
        if let Some(trace) = self.runner.trace_mut() {
            trace.mark(Mark::Wait, 0, begin_ns, sys::monotonic_ns());
        }
        Ok(())
    }

    /// Over: this partition has finished, and no partition can need its samples any more.
    fn is_over(&self) -> bool {
        let needs_us = |id: &&PartitionId| {
            **id != self.runner.id() && !self.others_done.contains(id) && !self.runner.given_up().contains(id)
        };
        self.finished && self.run.partitions.iter().find(needs_us).is_none()
    }

    fn report(&self, word: &str) {
        if let Some(manager) = &self.manager {
            manager.say(word);
        }
    }

    fn end(&mut self) -> Result<(), ProcessError> {
        self.statistics.end_loop();
        let told = self.watch.as_mut().map(HangWatch::told);
        self.obey_warden(told)?;
        self.runner.finish()?;
        self.runner.say_squelched(true)?;
        self.runner.event(EventCode::Ended, &[self.runner.frames_done() as f64])?;
        self.housekeeping()?;
        self.runner.beat()?;
        self.wake_everybody();
        if let Some(trace) = self.runner.trace_mut() {
            trace.flush();
        }
        Ok(())
    }

    fn note_finished(&mut self) {
        if !self.finished {
            // Frame counts of others can only be compared once our own last frame is known.
            self.others_done.clear();
        }
        for progress in self.runner.heard() {
            let id = u16::try_from(progress.partition).ok().and_then(PartitionId::from_code);
            let is_new = |id: &PartitionId| !self.others_done.contains(id);
            let is_done = self.finished && progress.frames_checkpointed >= self.runner.frames_done();
            if let Some(id) = id.filter(|_| is_done).filter(is_new) {
                self.others_done.push(id);
            }
        }
    }

    /// `--speed`: a simulated source does not run ahead of N times real time.
    fn frames_allowed(&self) -> u64 {
        let due = |table: Timetable| table.frames_due(self.runner.frames_done(), sys::monotonic_ns());
        self.runner.timetable().map_or(FRAMES_PER_TURN, due).min(FRAMES_PER_TURN)
    }

    fn time_to_next_frame(&self) -> Duration {
        let until_due = |table: Timetable| match table.due_ns(self.runner.frames_done()) {
            // The source is not ready to begin.
            0 => WORK_LOOK,
            due_ns => Duration::from_nanos(due_ns.saturating_sub(sys::monotonic_ns()).max(TIMER_MIN_NS)),
        };
        let is_fed = self.run.feed.is_some() && self.runner.id() == PartitionId::SensorSim;
        self.runner.timetable().map_or(BEAT, until_due).min(if is_fed { FEED_LOOK } else { BEAT })
    }

    fn wake_everybody(&mut self) {
        for &id in &self.run.partitions {
            if id != self.runner.id() {
                self.runner.link_mut().wake(id);
            }
        }
    }

    /// Reports drops and losses: one event of each per housekeeping period.
    fn report_losses(&mut self) -> Result<(), ProcessError> {
        let (now, reported) = (self.runner.counters(), self.reported);
        self.reported = now;
        let kinds = [(EventCode::BadSamples, now.bad, reported.bad), (EventCode::SamplesLost, now.lost, reported.lost)];
        for (code, now, reported) in kinds {
            if now > reported {
                self.runner.event(code, &[(now - reported) as f64, now as f64])?;
            }
        }
        Ok(self.runner.say_squelched(false)?)
    }

    fn housekeeping(&mut self) -> Result<(), ProcessError> {
        self.report_losses()?;
        let sample = self.statistics.sample(&self.runner);
        self.runner.publish_status(HOUSEKEEPING, &sample)?;
        Ok(self.statistics.write()?)
    }
}

/// Where events and tables of this life go, before the process loses its rights to open files.
fn keep_records(runner: &mut Runner<ShmLink>, run: &RunConfig, dir: &RunDir, life: Life) -> std::io::Result<()> {
    let id = runner.id();
    runner.log_events_to(EventLog::open(&dir.events(id))?);
    let slots = run.keep.clone().unwrap_or_else(|| dir.own(id));
    runner.keep_tables(TablePlaces { slots: TableStore::at(&slots), report: dir.tables(id) });
    if let Some(folder) = run.keep.as_deref().filter(|_| life.epoch > 0) {
        // A full disk costs a line of the log and not the partition.
        resets::append(&resets::file(folder), id, life).unwrap_or_default();
    }
    Ok(())
}

/// Of a source that follows the clock at `--speed`.
fn timetable(run: &RunConfig, id: PartitionId) -> Option<Timetable> {
    let speed = run.speed.filter(|_| id == PartitionId::SensorSim)?;
    Some(Timetable::new((run.period_ns as f64 / speed) as u64))
}

fn strike(fault: &Fault) {
    match fault {
        Fault::Kill { .. } | Fault::KillAlways { .. } | Fault::Tear { .. } => sys::kill_self(),
        Fault::Crash { .. } => sys::crash_self(),
        Fault::Hang { .. } => sys::stop_self(),
        Fault::Corrupt { .. } | Fault::Flood { .. } | Fault::Probe { .. } => {}
    }
}

/// `main` of a partition's own binary: `--run FOLDER [--epoch N] [--cause C]`, `--version`,
/// `--help`.
#[must_use]
pub fn main(id: PartitionId, connect: Connect, version: &str) -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|first| first == "--version") {
        println!("obsid-{id} {version}, telemetry layout {:08x}", telemetry::generation());
        return ExitCode::SUCCESS;
    }
    match parse(&arguments, id) {
        Ok((folder, life)) => exit_code(id, run(id, connect, &folder, life)),
        Err(wrong) => {
            sys::tell(&format!(
                "obsid-{id}: {wrong}\nusage: obsid-{id} --run FOLDER [--epoch N|next] [--cause C] [--parent PID] | --version\n\
                 Started by the warden of a run (`obsid run --images DIR`) or by a service manager (--epoch next).\n"
            ));
            ExitCode::from(2)
        }
    }
}

fn parse(arguments: &[String], id: PartitionId) -> Result<(PathBuf, Life), String> {
    let (mut folder, mut life, mut epoch) = (None, Life::default(), "0");
    for pair in arguments.chunks(2) {
        let [name, value] = pair else { return Err(format!("{}: a value is missing", pair[0])) };
        let number = || value.parse().map_err(|_| format!("{name} {value}: not a whole number"));
        match name.as_str() {
            "--run" => folder = Some(PathBuf::from(value)),
            "--epoch" => epoch = value,
            "--cause" => life.cause = number()?,
            "--parent" => life.parent = Some(number()?),
            _ => return Err(format!("{name}: unknown")),
        }
    }
    let folder = folder.ok_or("--run FOLDER is missing")?;
    life.epoch = epoch_of(epoch, &folder, id)?;
    Ok((folder, life))
}

/// How often a partition was started before: a number, or `next` to have its starts counted in its
/// own folder, where no warden counts them.
///
/// # Errors
/// When `text` is neither, or the count cannot be kept.
pub fn epoch_of(text: &str, folder: &Path, id: PartitionId) -> Result<u32, String> {
    if text != "next" {
        return text.parse().map_err(|_| format!("--epoch {text}: neither a whole number nor next"));
    }
    let file = RunDir::at(folder).own(id).join("starts");
    let before = std::fs::read_to_string(&file).ok().and_then(|text| text.parse().ok()).unwrap_or(0_u32);
    let kept = std::fs::write(&file, (before + 1).to_string());
    kept.map(|()| before).map_err(|error| format!("{}: {error}", file.display()))
}

/// Says what went wrong and whether a restart could help.
#[must_use]
pub fn exit_code(id: PartitionId, result: Result<(), ProcessError>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // The warden asked for it and says why.
        Err(error @ ProcessError::Stopped) => ExitCode::from(error.exit_code() as u8),
        Err(error) => {
            // One write: six processes share the console's standard error.
            sys::tell(&format!("{id}: {error}\n"));
            ExitCode::from(error.exit_code() as u8)
        }
    }
}
