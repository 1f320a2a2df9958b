//! One run of a drill: carried out, struck, and held against the undisturbed one.

use super::plan::{Kind, Random, RunPlan, Strike, When};
use crate::scratch::Scratch;
use crate::warden_process::{End, Heard, WardenProcess};
use runtime::RunConfig;
use runtime::checkpoint;
use runtime::rundir::RunDir;
use runtime::sys::{self, monotonic_ns};
use runtime::warden::Report;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::{
    Pid, PidfdFlags, Resource, Rlimit, Signal, getpriority_process, kill_process, pidfd_open, pidfd_send_signal,
    prlimit,
};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use telemetry::PartitionId;

/// A run that lasts longer is wedged. The warden's own stall limit is 180 s: it says first what is
/// wrong.
const WEDGED_AFTER: Duration = Duration::from_secs(200);
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Descriptors that a starved process may have: fewer than it has open.
const DESCRIPTORS_LEFT: u64 = 8;
/// Length of the stop of all processes together.
const CLOCK_JUMP: Duration = Duration::from_millis(400);
/// Words that a rogue process overwrites at a stroke.
const ROGUE_WORDS: usize = 64;

/// Below the warden's.
const PUNCTUAL_PRIORITY: u32 = 1;

/// A process that was killed by the drill.
#[derive(Clone, Debug)]
pub struct Killed {
    pub pid: u32,
    /// When the signal was sent (`CLOCK_MONOTONIC`) \[ns\].
    pub at_ns: u64,
}

/// What a run came to.
pub struct Flown {
    pub end: End,
    pub wedged: bool,
    pub interrupted: bool,
    pub killed: Vec<Killed>,
    /// Faults that struck, by kind.
    pub struck: Vec<Kind>,
    /// Cuts of real checkpoints that were read, and those that were taken for whole.
    pub cuts: u64,
    pub cuts_taken: u64,
    /// Files and processes that the run left.
    pub leaks: u64,
}

/// A process as the warden's reports name it.
struct Alive {
    pid: u32,
    epoch: u32,
    spawned_ns: u64,
    pidfd: OwnedFd,
}

impl Alive {
    fn is_dead(&self) -> bool {
        poll(&mut [PollFd::new(&self.pidfd, PollFlags::IN)], Some(&Timespec { tv_sec: 0, tv_nsec: 0 }))
            .is_ok_and(|count| count > 0)
    }
}

/// Carries `plan` out on `run`; `interrupted` ends it.
///
/// # Errors
/// When the run cannot be started.
pub fn fly(run: &RunConfig, plan: &RunPlan, scratch: &Scratch, interrupted: &AtomicBool) -> Result<Flown, String> {
    let hogs = (plan.kind == Kind::Hog).then(Hogs::start);
    let warden = WardenProcess::start(run, None, scratch, &wrapping(plan.kind))?;
    let mut injector = Injector {
        warden,
        folder: None,
        alive: BTreeMap::new(),
        all_up_ns: None,
        partitions: run.partitions.len(),
        due: plan.strikes.clone(),
        resumes: Vec::new(),
        flown: Flown {
            end: End { rows: Vec::new(), deaths: Vec::new(), failure: None },
            wedged: false,
            interrupted: false,
            killed: Vec::new(),
            struck: Vec::new(),
            cuts: 0,
            cuts_taken: 0,
            leaks: 0,
        },
    };
    injector.run_to_end(plan.kind, interrupted);
    let Injector { warden, folder, alive, mut flown, .. } = injector;
    flown.end = warden.end(scratch);
    drop(hogs);
    // Ctrl-C reaches the warden, too, which may end before this end of the pipe sees it.
    flown.interrupted |= interrupted.load(Ordering::Relaxed);
    flown.leaks += alive.values().filter(|process| !process.is_dead()).count() as u64;
    flown.leaks += folder.map_or(0, |folder| left_behind(&folder, plan.kind));
    Ok(flown)
}

/// `shm`: a file system of the run's own in place of `/dev/shm`, which somebody fills for a while.
fn wrapping(kind: Kind) -> Vec<OsString> {
    const SCRIPT: &str = "mount -t tmpfs -o size=64m,mode=1777 none /dev/shm || exit 1
        (sleep 0.5; cat /dev/zero > /dev/shm/fill; sleep 0.3; rm -f /dev/shm/fill) >/dev/null 2>&1 &
        exec \"$@\"";
    let words = ["unshare", "--mount", "--propagation", "private", "sh", "-c", SCRIPT, "sh"];
    words.iter().filter(|_| kind == Kind::Shm).map(OsString::from).collect()
}

fn left_behind(folder: &Path, kind: Kind) -> u64 {
    let prefix = RunDir::at(folder).prefix();
    let shared = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let ours = shared.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix)).count() as u64;
    u64::from(folder.exists()) + if kind == Kind::Shm { 0 } else { ours }
}

struct Injector {
    warden: WardenProcess,
    folder: Option<PathBuf>,
    alive: BTreeMap<String, Alive>,
    /// When every partition had been started.
    all_up_ns: Option<u64>,
    partitions: usize,
    due: Vec<Strike>,
    /// Stopped processes, and when they are to go on.
    resumes: Vec<(u64, Vec<Pid>)>,
    flown: Flown,
}

impl Injector {
    fn run_to_end(&mut self, kind: Kind, interrupted: &AtomicBool) {
        let _punctual = Punctual::begin();
        let started = Instant::now();
        let mut asked = false;
        loop {
            match self.warden.next(self.patience()) {
                Heard::Report(report) => self.take(&report, kind),
                Heard::Nothing => {}
                Heard::Closed => return,
            }
            self.strike_due();
            self.resume_due();
            if interrupted.load(Ordering::Relaxed) && !asked {
                (asked, self.flown.interrupted) = (true, true);
                self.warden.terminate();
            }
            if started.elapsed() > WEDGED_AFTER && !self.flown.wedged {
                self.flown.wedged = true;
                self.warden.kill();
            }
        }
    }

    /// Until the next strike.
    fn patience(&self) -> Duration {
        let now_ns = monotonic_ns();
        let strikes = self.due.iter().filter_map(|strike| self.due_ns(strike));
        let next = strikes.chain(self.resumes.iter().map(|(at_ns, _)| *at_ns)).min();
        next.map_or(LOOK_EVERY, |at_ns| Duration::from_nanos(at_ns.saturating_sub(now_ns)).min(LOOK_EVERY))
    }

    fn due_ns(&self, strike: &Strike) -> Option<u64> {
        match strike.when {
            When::Into { us } => Some(self.all_up_ns? + us * 1000),
            When::Young { epoch, us } => {
                let victim = self.alive.get(strike.victim.text()).filter(|victim| victim.epoch == epoch)?;
                Some(victim.spawned_ns + us * 1000)
            }
        }
    }

    fn take(&mut self, report: &Report, kind: Kind) {
        match report {
            Report::Started { folder, .. } => self.folder = Some(folder.clone()),
            Report::Spawn { partition, pid, epoch, t_ns } => {
                let number = i32::try_from(*pid).ok().and_then(Pid::from_raw);
                let Some(pidfd) = number.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok()) else { return };
                let process = Alive { pid: *pid, epoch: *epoch, spawned_ns: *t_ns, pidfd };
                self.alive.insert(partition.clone(), process);
                if self.alive.len() == self.partitions {
                    self.all_up_ns.get_or_insert(*t_ns);
                }
            }
            Report::Status { frame, .. } if kind == Kind::Checkpoint && *frame > 0 && self.flown.cuts == 0 => {
                // On a thread that takes turns with everybody else: it computes for long.
                let cut = || self.folder.as_deref().map_or((0, 0), cut_checkpoints);
                (self.flown.cuts, self.flown.cuts_taken) =
                    std::thread::scope(|scope| scope.spawn(cut).join()).unwrap_or_default();
            }
            _ => {}
        }
    }

    fn strike_due(&mut self) {
        let now_ns = monotonic_ns();
        let due: Vec<Strike> =
            self.due.iter().copied().filter(|strike| self.due_ns(strike).is_some_and(|at| at <= now_ns)).collect();
        self.due.retain(|strike| !due.contains(strike));
        due.iter().for_each(|strike| self.strike(strike));
    }

    fn strike(&mut self, strike: &Strike) {
        let Some(victim) = self.alive.get(strike.victim.text()).filter(|victim| !victim.is_dead()) else { return };
        let (pid, raw) = (victim.pid, i32::try_from(victim.pid).ok().and_then(Pid::from_raw));
        let Some(raw) = raw else { return };
        let signal = |signal| pidfd_send_signal(&victim.pidfd, signal).is_ok();
        let at_ns = monotonic_ns();
        let struck = match strike.kind {
            Kind::Kill | Kind::Young => {
                let sent = signal(Signal::KILL);
                if sent {
                    self.flown.killed.push(Killed { pid, at_ns });
                }
                sent
            }
            Kind::Stop => {
                self.resumes.push((at_ns + (5 + strike.number % 96) * 1_000_000, vec![raw]));
                signal(Signal::STOP)
            }
            Kind::Hang => signal(Signal::STOP),
            Kind::Memory => {
                let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
                let size = status.lines().find_map(|line| line.strip_prefix("VmSize:"));
                let kb: Option<u64> = size.and_then(|rest| rest.split_whitespace().next()?.parse().ok());
                kb.is_some_and(|kb| prlimit(Some(raw), Resource::As, limit(kb * 1024)).is_ok())
            }
            Kind::Descriptors => prlimit(Some(raw), Resource::Nofile, limit(DESCRIPTORS_LEFT)).is_ok(),
            Kind::Clock => self.stop_everybody(at_ns),
            Kind::Rogue => self.scribble(strike.number),
            _ => false,
        };
        if struck {
            self.flown.struck.push(strike.kind);
        }
    }

    /// The warden first, so that it finds nobody's hang; it goes on last.
    fn stop_everybody(&mut self, at_ns: u64) -> bool {
        let partitions = self.alive.values().filter(|process| !process.is_dead());
        let partitions = partitions.filter_map(|process| Pid::from_raw(process.pid.try_into().ok()?));
        let everybody: Vec<Pid> = [self.warden.pid()].into_iter().chain(partitions).collect();
        let stopped = everybody.iter().all(|pid| kill_process(*pid, Signal::STOP).is_ok());
        self.resumes.push((at_ns + CLOCK_JUMP.as_nanos() as u64, everybody.into_iter().rev().collect()));
        stopped
    }

    fn resume_due(&mut self) {
        let now_ns = monotonic_ns();
        for (_, stopped) in self.resumes.extract_if(.., |(at_ns, _)| *at_ns <= now_ns) {
            for pid in stopped {
                let _ = kill_process(pid, Signal::CONT);
            }
        }
    }

    /// Random words into one file of the transport that every process of this user can write.
    fn scribble(&self, number: u64) -> bool {
        use std::os::unix::fs::FileExt;
        let Some(folder) = &self.folder else { return false };
        let prefix = RunDir::at(folder).prefix();
        let mut files: Vec<PathBuf> =
            fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|e| e.path()).collect();
        files.retain(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with(&prefix) && (name.ends_with(".connection") || name.ends_with(".dynamic"))
        });
        files.sort();
        let mut random = Random(number);
        let Some(path) = files.get(random.below(files.len().max(1) as u64) as usize) else { return false };
        let Ok(file) = fs::OpenOptions::new().write(true).open(path) else { return false };
        let words = file.metadata().map_or(0, |of| of.len() / 8);
        (0..ROGUE_WORDS)
            .all(|_| file.write_all_at(&random.next().to_le_bytes(), 8 * random.below(words.max(1))).is_ok())
    }
}

/// Every cut of every partition's newest checkpoint is as if it were not there: how many were read,
/// and how many were taken for whole.
fn cut_checkpoints(folder: &Path) -> (u64, u64) {
    let (mut cuts, mut taken) = (0, 0);
    let folders = PartitionId::ALL.iter().map(|&id| RunDir::at(folder).own(id));
    for entry in folders.filter_map(|own| fs::read_dir(own).ok()).flatten().flatten() {
        let Ok(bytes) = fs::read(entry.path()) else { continue };
        if checkpoint::is_whole(&bytes) {
            cuts += bytes.len() as u64;
            taken += (0..bytes.len()).filter(|&cut| checkpoint::is_whole(&bytes[..cut])).count() as u64;
        }
    }
    (cuts, taken)
}

/// While it lives this thread runs before all ordinary ones, where the system allows it: a signal
/// is sent when it is stamped, not when the struck leave a processor free. What it starts meanwhile
/// is ordinary.
struct Punctual(bool);

impl Punctual {
    fn begin() -> Self {
        Punctual(sys::set_fifo(0, PUNCTUAL_PRIORITY).is_ok())
    }
}

impl Drop for Punctual {
    fn drop(&mut self) {
        if self.0 {
            let _ = sys::run_as_others(0, getpriority_process(None).unwrap_or(0));
        }
    }
}

fn limit(value: u64) -> Rlimit {
    Rlimit { current: Some(value), maximum: Some(value) }
}

/// A busy loop on every core, until dropped.
struct Hogs {
    over: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Hogs {
    fn start() -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let spin = |over: Arc<AtomicBool>| while !over.load(Ordering::Relaxed) {};
        let threads = (0..cores).map(|_| Arc::clone(&over)).map(|over| std::thread::spawn(move || spin(over)));
        Hogs { threads: threads.collect(), over }
    }
}

impl Drop for Hogs {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        self.threads.drain(..).for_each(|thread| drop(thread.join()));
    }
}
