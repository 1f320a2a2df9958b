//! The warden is the process supervisor: parent of every partition. It starts, reaps and restarts
//! them, or gives them up; it maps no shared memory.
//!
//! One thread around one `poll`: pidfds of the children, the supervisor's pipe, a signal pipe. Its
//! death ends its children; the next start removes the files that it left.

mod deaths;
mod hangs;
mod health;
mod launcher;
mod looks;
mod pipe;
mod report;
mod ward;
mod window;

pub use launcher::Launcher;
pub use report::Report;

use crate::config::{Limits, RunConfig};
use crate::deaths::{Alertness, DeathLog};
use crate::life::Life;
use crate::rundir::OwnedRunDir;
use crate::statistics::PartitionRow;
use crate::sys::{Notifier, Precedence, monotonic_ns};
use health::HealthDesk;
use pipe::LineBuffer;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};
use telemetry::PartitionId;
use ward::{State, Ward};

/// Exit code of a partition that had to end before its run was over.
pub const EXIT_STOPPED: i32 = 6;
/// Exit code of a partition that no restart can help.
pub const EXIT_FINAL: i32 = 4;
/// Exit code of a partition that found no services to open.
pub const EXIT_VANISHED: i32 = 5;
const TICK: Duration = Duration::from_millis(50);
/// Time the others get to end once the first partition has ended.
const END_GRACE: Duration = Duration::from_secs(5);
/// A file that is empty for this long in shared memory has lost its maker.
const STILLBORN_AGE: Duration = Duration::from_secs(1);
/// A look at the processes' memory and processor times, and a sign of life to the console.
const LOOK_EVERY: Duration = Duration::from_secs(1);
const BEAT_EVERY: Duration = Duration::from_millis(500);
/// No frame for so long: the services are made anew; then again after twice the time, and so on
/// until the stall limit. The longest frame that is no fault takes half of it.
const RENEW_AFTER: Duration = Duration::from_secs(5);
/// Stall limits that work beside a loop may last: an arc was heard in a quarter of one, on a core
/// with four others at work.
const WORK_STALLS: u32 = 5;
/// Who was never heard may still be opening its services: up to 157 ms on a disk, more under load.
const START_LIMIT: Duration = Duration::from_secs(5);
const TERM_GRACE: Duration = Duration::from_secs(2);

/// Runs `run` to its end, reporting on the way.
///
/// # Errors
/// When the run's folder cannot be made or a process cannot be started.
pub fn run(
    run: &RunConfig,
    parent: &std::path::Path,
    launcher: &Launcher,
    report: &mut dyn FnMut(&Report),
) -> std::io::Result<bool> {
    // Before anything exists that a signal could leave behind.
    let (mut signals, write_end) = UnixStream::pair()?;
    signals.set_nonblocking(true)?;
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::low_level::pipe::register(signal, write_end.try_clone()?)?;
    }
    let purged = crate::rundir::purge_debris(parent);
    let owned = OwnedRunDir::create(parent, run)?;
    report(&Report::Started { folder: owned.dir().path().to_path_buf(), purged, t_ns: monotonic_ns() });
    let mut warden = Warden::new(run, owned, launcher.clone(), report);
    let verdict = warden.watch(&mut signals);
    warden.tell_acts();
    warden.end_all();
    let (ok, reason) = match verdict {
        Ok(()) => (true, String::new()),
        Err(reason) => (false, reason),
    };
    let (partitions, deaths) = (warden.rows(), warden.deaths.rows().to_vec());
    warden.tell(&Report::End { ok, reason, partitions, deaths });
    Ok(ok)
}

struct Warden<'a> {
    limits: &'a Limits,
    owned: OwnedRunDir,
    launcher: Launcher,
    wards: Vec<Ward>,
    services_exist: bool,
    pipe: LineBuffer,
    last_frame: u64,
    last_advance: Instant,
    /// When a partition was last said to do work that a frame left.
    last_work: Instant,
    last_sweep: Instant,
    /// Looked for processes that do nothing as they start.
    last_still: Instant,
    /// When the supervisor last wrote to its pipe; it reports the others' hangs, the warden its
    /// own.
    supervisor_heard: Instant,
    /// It has said something in its present life: before, it opens its services.
    supervisor_spoke: bool,
    first_end: Option<Instant>,
    /// The run is over: partitions that still run have been ordered to end.
    ending: bool,
    window_frames: u64,
    /// Partitions get CPU windows.
    windows: bool,
    started_ns: u64,
    deaths: DeathLog,
    health: HealthDesk,
    precedence: Precedence,
    /// A service manager that watches the warden, and whether it knows that the run is on its way.
    manager: Option<Notifier>,
    is_announced: bool,
    alertness: Alertness,
    /// Who waits for whom, as the supervisor last said.
    waits: String,
    renew_after: Duration,
    last_look: Instant,
    /// Index of the ward that was looked at then.
    looked_at: usize,
    last_beat: Instant,
    log: Option<File>,
    report: &'a mut dyn FnMut(&Report),
}

impl<'a> Warden<'a> {
    fn new(run: &'a RunConfig, owned: OwnedRunDir, launcher: Launcher, report: &'a mut dyn FnMut(&Report)) -> Self {
        Warden {
            limits: &run.limits,
            launcher,
            wards: run.partitions.iter().map(|&id| Ward::new(id)).collect(),
            log: File::create(owned.dir().log()).ok(),
            owned,
            services_exist: false,
            pipe: LineBuffer::default(),
            last_frame: 0,
            last_advance: Instant::now(),
            last_work: Instant::now(),
            last_sweep: Instant::now(),
            last_still: Instant::now(),
            supervisor_heard: Instant::now(),
            supervisor_spoke: false,
            first_end: None,
            ending: false,
            window_frames: run.window_frames,
            windows: run.windows,
            started_ns: monotonic_ns(),
            deaths: DeathLog::default(),
            health: HealthDesk::new(run),
            precedence: Precedence::take(),
            manager: Notifier::of_environment(),
            is_announced: false,
            alertness: Alertness::default(),
            waits: String::new(),
            renew_after: RENEW_AFTER,
            last_look: Instant::now(),
            looked_at: 0,
            last_beat: Instant::now(),
            report,
        }
    }

    /// Until every partition is over; `Err` says why the run failed.
    fn watch(&mut self, signals: &mut UnixStream) -> Result<(), String> {
        loop {
            self.start_due()?;
            self.sleep(signals)?;
            if signals.read(&mut [0; 16]).is_ok_and(|count| count > 0) {
                return Err("stopped by a signal".into());
            }
            self.bury()?;
            self.listen_to_supervisor();
            self.tell_acts();
            self.end_supervisor_hang();
            self.end_still();
            self.sweep();
            self.look();
            if self.wards.iter().all(Ward::is_over) {
                return Ok(());
            }
            if self.first_end.is_some_and(|first| first.elapsed() > END_GRACE) {
                // The run is over: partitions that have not received this are informed.
                self.ending = true;
                self.signal_running(Signal::TERM);
                self.first_end = Some(Instant::now());
            }
            self.end_stall()?;
        }
    }

    /// To the console and to the run's own log.
    fn tell(&mut self, report: &Report) {
        if let (Some(log), Ok(line)) = (&mut self.log, serde_json::to_string(report))
            && !matches!(report, Report::Status { .. } | Report::Beat { .. })
        {
            let _ = writeln!(log, "{line}");
        }
        (self.report)(report);
    }

    /// Figures of the processes, and a sign of life.
    fn look(&mut self) {
        if self.last_beat.elapsed() >= BEAT_EVERY {
            self.last_beat = Instant::now();
            self.tell(&Report::Beat { t_ns: monotonic_ns() });
            self.stroke();
        }
        // One after the other: a look reads a hundred files of the kernel, and a death that comes
        // meanwhile is noticed after it.
        if self.last_look.elapsed() >= LOOK_EVERY / self.wards.len() as u32 {
            self.last_look = Instant::now();
            self.looked_at = (self.looked_at + 1) % self.wards.len();
            self.wards[self.looked_at].look();
            self.give_windows();
        }
    }

    /// The watchdog of a service manager: from the first frame on, while the run goes on and nobody
    /// but who was given up is down.
    fn stroke(&mut self) {
        let Some(manager) = self.manager.as_ref().filter(|_| self.last_frame > 0) else { return };
        if !self.is_announced {
            self.is_announced = true;
            manager.say("READY=1");
        }
        let is_down = |ward: &Ward| matches!(ward.state, State::Waiting { .. });
        let idle = self.last_advance.elapsed().min(self.last_work.elapsed());
        if !self.wards.iter().any(is_down) && (idle < RENEW_AFTER || self.first_end.is_some()) {
            manager.say("WATCHDOG=1");
        }
    }

    fn give_windows(&mut self) {
        for index in 0..self.wards.len() {
            let ward = &mut self.wards[index];
            let given = if self.windows { ward.give_window(self.limits.of(ward.id)) } else { None };
            if let Some(window) = given.map(String::from) {
                let partition = self.wards[index].id.to_string();
                self.tell(&Report::Window { partition, window });
            }
        }
    }

    /// The supervisor first and alone, until it has made the services; then whoever is due, one at
    /// a time: a death while others are being started is noticed before the next start.
    fn start_due(&mut self) -> Result<(), String> {
        let is_due = |ward: &Ward| ward.due(self.services_exist).is_some_and(|due| due <= Instant::now());
        if let Some(index) = self.wards.iter().position(is_due) {
            let folder = self.owned.dir().path().to_path_buf();
            let ward = &mut self.wards[index];
            let fail = |error: std::io::Error| format!("{}: cannot start: {error}", ward.id);
            let child = self
                .launcher
                .command(ward.id, &folder, Life { epoch: ward.epoch, cause: ward.cause, parent: None })
                .spawn()
                .map_err(fail)?;
            let (pid, t_ns) = (Pid::from_child(&child), monotonic_ns());
            self.precedence.withhold_from(pid);
            let pidfd = pidfd_open(pid, PidfdFlags::empty()).map_err(|error| fail(error.into()))?;
            if let Some(stdout) = &child.stdout {
                rustix::fs::fcntl_setfl(stdout, rustix::fs::OFlags::NONBLOCK).map_err(|error| fail(error.into()))?;
            }
            if ward.id == PartitionId::Supervisor {
                (self.supervisor_heard, self.supervisor_spoke) = (Instant::now(), false);
                self.health.is_safe_said = false;
            }
            let (partition, epoch, number) = (ward.id.to_string(), ward.epoch, child.id());
            ward.state = State::Running { child, pidfd, since: Instant::now() };
            self.tell(&Report::Spawn { partition: partition.clone(), pid: number, epoch, t_ns });
            if epoch > 0 {
                self.tell(&Report::Restart { partition, restarts: epoch });
            }
        }
        Ok(())
    }

    fn sleep(&mut self, signals: &UnixStream) -> Result<(), String> {
        let mut fds = vec![PollFd::new(signals, PollFlags::IN)];
        for ward in &self.wards {
            if let State::Running { child, pidfd, .. } = &ward.state {
                fds.push(PollFd::new(pidfd, PollFlags::IN));
                fds.extend(child.stdout.as_ref().map(|pipe| PollFd::new(pipe, PollFlags::IN)));
            }
        }
        let due = self.wards.iter().filter_map(|ward| ward.due(self.services_exist)).min();
        let patience = due.map_or(TICK, |due| due.saturating_duration_since(Instant::now()).min(TICK));
        let timeout = Timespec { tv_sec: 0, tv_nsec: patience.as_nanos() as i64 };
        self.alertness.sleeps();
        let woken = poll(&mut fds, Some(&timeout));
        self.alertness.wakes(monotonic_ns());
        match woken {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(format!("poll: {error}")),
        }
    }

    /// After a death: what a young process left half-made in shared memory stands in everybody's
    /// way.
    fn sweep(&mut self) {
        let somebody_died = self.wards.iter().any(|ward| ward.epoch > 0);
        if somebody_died && self.last_sweep.elapsed() >= STILLBORN_AGE {
            self.last_sweep = Instant::now();
            self.owned.remove_stillborn(STILLBORN_AGE);
        }
    }

    fn signal_running(&self, signal: Signal) {
        for ward in &self.wards {
            if let State::Running { child, .. } = &ward.state {
                let _ = kill_process(Pid::from_child(child), signal);
            }
        }
    }

    /// Ends what still runs, in order: the source first, the recorder last, so that its file is
    /// complete.
    fn end_all(&mut self) {
        for ward in &mut self.wards {
            let State::Running { child, pidfd, .. } = &mut ward.state else { continue };
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
            let grace = Timespec { tv_sec: TERM_GRACE.as_secs() as i64, tv_nsec: 0 };
            let _ = poll(&mut [PollFd::new(&*pidfd, PollFlags::IN)], Some(&grace));
            let _ = child.kill();
            ward.look();
            if let State::Running { child, .. } = &mut ward.state {
                let _ = child.wait();
            }
            ward.close_life(self.owned.dir(), &mut self.deaths);
            if !matches!(ward.state, State::GivenUp) {
                ward.state = State::Done;
            }
        }
    }

    fn rows(&self) -> Vec<PartitionRow> {
        self.wards.iter().map(Ward::row).collect()
    }
}
