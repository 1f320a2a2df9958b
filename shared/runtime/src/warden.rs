//! The warden is the process supervisor: parent of every partition. It starts, reaps and restarts
//! them, or gives them up; it maps no shared memory.
//!
//! One thread around one `poll`: pidfds of the children, the supervisor's pipe, a signal pipe. Its
//! death ends its children; the next start removes the files that it left.

use crate::config::{GivenUp, Limits, RunConfig};
use crate::process::Life;
use crate::rundir::OwnedRunDir;
use crate::statistics::PartitionRow;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use telemetry::PartitionId;

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
const TERM_GRACE: Duration = Duration::from_secs(2);

/// Reports of the warden to the process that started it, one line each.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Report {
    /// The run's folder exists; `purged` folders of dead runs were removed.
    Started { folder: PathBuf, purged: usize },
    /// Last frame of the supervisor and the state of the mode in effect.
    Status { frame: u64, mode: String },
    /// A process ended before its run was over; `cause` is its signal or exit code.
    Death { partition: String, pid: u32, cause: String },
    /// A partition runs again, for the `restarts`-th time.
    Restart { partition: String, restarts: u32 },
    /// A partition's execution counter stood still for its limit: it is killed.
    Hang { partition: String },
    /// A partition died too often: the run goes on without it or ends.
    GivenUp { partition: String },
    /// The run is over; `reason` says why where it is not `ok`.
    End { ok: bool, reason: String, partitions: Vec<PartitionRow> },
}

/// How partitions are started.
#[derive(Clone, Debug)]
pub struct Launcher {
    /// `program partition NAME --run FOLDER --epoch N --cause C` ...
    pub program: PathBuf,
    /// ... or, as in an on-board computer's image,
    /// `images/obsid-NAME --run FOLDER --epoch N --cause C`.
    pub images: Option<PathBuf>,
}

impl Launcher {
    fn command(&self, id: PartitionId, folder: &std::path::Path, life: Life) -> Command {
        let mut command = match &self.images {
            Some(images) => Command::new(images.join(format!("obsid-{id}"))),
            None => Command::new(&self.program),
        };
        if self.images.is_none() {
            command.args(["partition", id.text()]);
        }
        let (epoch, cause, parent) = (life.epoch.to_string(), life.cause.to_string(), std::process::id().to_string());
        command.arg("--run").arg(folder).args(["--epoch", &epoch, "--cause", &cause, "--parent", &parent]);
        command.process_group(0);
        match id {
            PartitionId::Supervisor => command.stdin(Stdio::piped()).stdout(Stdio::piped()),
            _ => command.stdin(Stdio::null()).stdout(Stdio::null()),
        };
        command
    }
}

enum State {
    Waiting { until: Instant },
    Running { child: Child, pidfd: OwnedFd, since: Instant },
    Done,
    GivenUp,
}

/// When a partition died, and how far the run was.
struct DeathMark {
    at: Instant,
    frame: u64,
}

struct Ward {
    id: PartitionId,
    state: State,
    deaths: Vec<DeathMark>,
    epoch: u32,
    /// Of the last death, as in [`Life`].
    cause: u32,
}

impl Ward {
    fn is_over(&self) -> bool {
        matches!(self.state, State::Done | State::GivenUp)
    }
}

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
    report(&Report::Started { folder: owned.dir().path().to_path_buf(), purged });
    let mut warden = Warden::new(run, owned, launcher.clone(), report);
    let verdict = warden.watch(&mut signals);
    warden.end_all();
    let (ok, reason) = match verdict {
        Ok(()) => (true, String::new()),
        Err(reason) => (false, reason),
    };
    let partitions = warden.rows();
    (warden.report)(&Report::End { ok, reason, partitions });
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
    last_sweep: Instant,
    /// When the supervisor last wrote to its pipe; it reports the others' hangs, the warden its
    /// own.
    supervisor_heard: Instant,
    first_end: Option<Instant>,
    /// The run is over: partitions that still run have been ordered to end.
    ending: bool,
    window_frames: u64,
    report: &'a mut dyn FnMut(&Report),
}

impl<'a> Warden<'a> {
    fn new(run: &'a RunConfig, owned: OwnedRunDir, launcher: Launcher, report: &'a mut dyn FnMut(&Report)) -> Self {
        let ward = |&id: &PartitionId| Ward {
            id,
            state: State::Waiting { until: Instant::now() },
            deaths: Vec::new(),
            epoch: 0,
            cause: 0,
        };
        Warden {
            limits: &run.limits,
            owned,
            launcher,
            wards: run.partitions.iter().map(ward).collect(),
            services_exist: false,
            pipe: LineBuffer::default(),
            last_frame: 0,
            last_advance: Instant::now(),
            last_sweep: Instant::now(),
            supervisor_heard: Instant::now(),
            first_end: None,
            ending: false,
            window_frames: run.window_frames,
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
            self.end_supervisor_hang();
            self.sweep();
            if self.wards.iter().all(Ward::is_over) {
                return Ok(());
            }
            if self.first_end.is_some_and(|first| first.elapsed() > END_GRACE) {
                // The run is over: partitions that have not received this are informed.
                self.ending = true;
                self.signal_running(Signal::TERM);
                self.first_end = Some(Instant::now());
            }
            if self.last_advance.elapsed() > Duration::from_secs(self.limits.stall_s) {
                return Err(format!(
                    "no frame was processed for {} s (last: {})",
                    self.limits.stall_s, self.last_frame
                ));
            }
        }
    }

    /// The supervisor first and alone, until it has made the services; then whoever is due.
    fn start_due(&mut self) -> Result<(), String> {
        let folder = self.owned.dir().path().to_path_buf();
        for index in 0..self.wards.len() {
            let ward = &mut self.wards[index];
            let due = matches!(ward.state, State::Waiting { until } if until <= Instant::now());
            if !due || (ward.id != PartitionId::Supervisor && !self.services_exist) {
                continue;
            }
            let fail = |error: std::io::Error| format!("{}: cannot start: {error}", ward.id);
            let child = self
                .launcher
                .command(ward.id, &folder, Life { epoch: ward.epoch, cause: ward.cause, parent: None })
                .spawn()
                .map_err(fail)?;
            let pid = Pid::from_child(&child);
            let pidfd = pidfd_open(pid, PidfdFlags::empty()).map_err(|error| fail(error.into()))?;
            if let Some(stdout) = &child.stdout {
                rustix::fs::fcntl_setfl(stdout, rustix::fs::OFlags::NONBLOCK).map_err(|error| fail(error.into()))?;
            }
            ward.state = State::Running { child, pidfd, since: Instant::now() };
            if ward.epoch > 0 {
                (self.report)(&Report::Restart { partition: ward.id.to_string(), restarts: ward.epoch });
            }
        }
        Ok(())
    }

    fn sleep(&self, signals: &UnixStream) -> Result<(), String> {
        let mut fds = vec![PollFd::new(signals, PollFlags::IN)];
        for ward in &self.wards {
            if let State::Running { child, pidfd, .. } = &ward.state {
                fds.push(PollFd::new(pidfd, PollFlags::IN));
                fds.extend(child.stdout.as_ref().map(|pipe| PollFd::new(pipe, PollFlags::IN)));
            }
        }
        let timeout = Timespec { tv_sec: 0, tv_nsec: TICK.as_nanos() as i64 };
        match poll(&mut fds, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(format!("poll: {error}")),
        }
    }

    fn bury(&mut self) -> Result<(), String> {
        for index in 0..self.wards.len() {
            let State::Running { child, .. } = &mut self.wards[index].state else { continue };
            let pid = child.id();
            let Some(status) =
                child.try_wait().map_err(|error| format!("waiting for {}: {error}", self.wards[index].id))?
            else {
                continue;
            };
            let mut services_lost = status.code() == Some(EXIT_VANISHED);
            if self.wards[index].id == PartitionId::Supervisor {
                self.listen_to_supervisor();
                self.pipe = LineBuffer::default();
                services_lost |= !self.services_exist;
            }
            self.after_death(index, pid, status)?;
            if services_lost {
                self.renew_services()?;
            }
        }
        Ok(())
    }

    /// Takes everybody down and has the supervisor make the services anew; checkpoints and outboxes
    /// carry the run over.
    ///
    /// Services vanish with the last process that holds them (who starts holds none yet), and one
    /// whose maker dies half-way bricks its name. Whoever had ended in order starts again too: its
    /// samples went with the services.
    fn renew_services(&mut self) -> Result<(), String> {
        for ward in &mut self.wards {
            match &mut ward.state {
                State::Waiting { .. } | State::GivenUp => continue,
                State::Done => {}
                State::Running { child, .. } => {
                    let _ = child.kill();
                    let _ = child.wait();
                    ward.cause = Signal::KILL.as_raw() as u32;
                    let cause = "taken down, services have vanished".into();
                    (self.report)(&Report::Death { partition: ward.id.to_string(), pid: child.id(), cause });
                }
            }
            // No death of its own: it does not count towards giving it up.
            ward.epoch += 1;
            ward.state = State::Waiting { until: Instant::now() };
        }
        (self.services_exist, self.first_end) = (false, None);
        self.pipe = LineBuffer::default();
        self.owned.clear_services().map_err(|error| format!("services cannot be removed: {error}"))
    }

    fn after_death(&mut self, index: usize, pid: u32, status: ExitStatus) -> Result<(), String> {
        let ward = &mut self.wards[index];
        let ends_on_order = self.ending && status.code() == Some(EXIT_STOPPED);
        if status.success() || ends_on_order {
            ward.state = State::Done;
            self.first_end.get_or_insert_with(Instant::now);
            return Ok(());
        }
        ward.cause = status.signal().or(status.code().map(|code| 256 + code)).unwrap_or(0) as u32;
        let cause = match (status.code(), status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, Some(signal)) => format!("signal {signal}"),
            (None, None) => "unknown".into(),
        };
        (self.report)(&Report::Death { partition: ward.id.to_string(), pid, cause: cause.clone() });
        if status.code() == Some(EXIT_FINAL) {
            return Err(format!("{} cannot run: see its message", ward.id));
        }
        let limits = self.limits.of(ward.id);
        let window = Duration::from_secs(limits.restarts_within_s);
        // Deaths count together while they are recent, or while nothing has moved on between them
        // (a slow loop).
        let (frame, reach) = (self.last_frame, 2 * self.window_frames);
        ward.deaths.retain(|death| death.at.elapsed() < window || death.frame + reach > frame);
        ward.deaths.push(DeathMark { at: Instant::now(), frame });
        if ward.deaths.len() as u32 > limits.restarts_max {
            return self.give_up(index);
        }
        let back_off = &limits.back_off_ms;
        let wait_ms = back_off.get(ward.deaths.len() - 1).or(back_off.last()).copied().unwrap_or(0);
        ward.epoch += 1;
        self.supervisor_heard = Instant::now();
        ward.state = State::Waiting { until: Instant::now() + Duration::from_millis(wait_ms) };
        Ok(())
    }

    fn give_up(&mut self, index: usize) -> Result<(), String> {
        let id = self.wards[index].id;
        self.wards[index].state = State::GivenUp;
        (self.report)(&Report::GivenUp { partition: id.to_string() });
        let limits = self.limits.of(id);
        if limits.given_up == GivenUp::EndRun {
            return Err(format!("{id} was given up after {} deaths", limits.restarts_max + 1));
        }
        self.tell_supervisor(&format!("LOST {id}"));
        Ok(())
    }

    fn tell_supervisor(&mut self, line: &str) {
        for ward in &mut self.wards {
            if let (PartitionId::Supervisor, State::Running { child, .. }) = (ward.id, &mut ward.state)
                && let Some(stdin) = &mut child.stdin
            {
                // A dying supervisor receives the order again after its restart.
                let _ = writeln!(stdin, "{line}");
            }
        }
    }

    fn listen_to_supervisor(&mut self) {
        let running = self.wards.iter_mut().find(|ward| ward.id == PartitionId::Supervisor);
        let Some(State::Running { child, .. }) = running.map(|ward| &mut ward.state) else { return };
        let Some(stdout) = &mut child.stdout else { return };
        for line in self.pipe.read(stdout) {
            self.supervisor_heard = Instant::now();
            self.obey(&line);
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

    fn end_supervisor_hang(&mut self) {
        if !self.services_exist
            || self.supervisor_heard.elapsed() < Duration::from_millis(self.limits.of(PartitionId::Supervisor).hang_ms)
        {
            return;
        }
        self.supervisor_heard = Instant::now();
        let epoch = self.wards.iter().find(|ward| ward.id == PartitionId::Supervisor).map_or(0, |ward| ward.epoch);
        self.end_hang(PartitionId::Supervisor.text(), &epoch.to_string());
    }

    fn obey(&mut self, line: &str) {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["READY"] => {
                self.services_exist = true;
                let lost: Vec<_> =
                    self.wards.iter().filter(|w| matches!(w.state, State::GivenUp)).map(|w| w.id).collect();
                for id in lost {
                    self.tell_supervisor(&format!("LOST {id}"));
                }
            }
            ["STATUS", frame, mode] => {
                let frame = frame.parse().unwrap_or(self.last_frame);
                if frame > self.last_frame {
                    self.last_frame = frame;
                    self.last_advance = Instant::now();
                }
                (self.report)(&Report::Status { frame, mode: mode.into() });
            }
            ["HANG", name, epoch] => self.end_hang(name, epoch),
            ["SILENT", name] => self.end_silence(name),
            _ => tracing::warn!(line, "the supervisor said something unknown"),
        }
    }

    /// A supervisor that has come back never hears who hung before: a hang, unless that one has
    /// just been started.
    fn end_silence(&mut self, name: &str) {
        let Some(ward) = self.wards.iter().find(|ward| ward.id.text() == name) else { return };
        let limit = Duration::from_millis(self.limits.of(ward.id).hang_ms);
        let epoch = ward.epoch.to_string();
        if matches!(ward.state, State::Running { since, .. } if since.elapsed() >= limit) {
            self.end_hang(name, &epoch);
        }
    }

    fn end_hang(&mut self, name: &str, epoch: &str) {
        let hung = self.wards.iter().find(|ward| ward.id.text() == name && ward.epoch.to_string() == epoch);
        if let Some(State::Running { child, .. }) = hung.map(|ward| &ward.state) {
            (self.report)(&Report::Hang { partition: name.into() });
            let _ = kill_process(Pid::from_child(child), Signal::KILL);
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
            let _ = child.wait();
            ward.state = State::Done;
        }
    }

    fn rows(&self) -> Vec<PartitionRow> {
        let read = |ward: &Ward| {
            let text = std::fs::read_to_string(self.owned.dir().statistics(ward.id)).ok();
            let row: Option<PartitionRow> = text.and_then(|text| serde_json::from_str(&text).ok());
            let given_up = matches!(ward.state, State::GivenUp);
            PartitionRow { name: ward.id.to_string(), restarts: ward.epoch, given_up, ..row.unwrap_or_default() }
        };
        self.wards.iter().map(read).collect()
    }
}

/// Whole lines from a pipe that does not block.
#[derive(Default)]
struct LineBuffer(Vec<u8>);

impl LineBuffer {
    fn read(&mut self, pipe: &mut impl Read) -> Vec<String> {
        let mut chunk = [0; 4096];
        while let Ok(count) = pipe.read(&mut chunk) {
            if count == 0 {
                break;
            }
            self.0.extend_from_slice(&chunk[..count]);
        }
        let mut lines = Vec::new();
        while let Some(end) = self.0.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.0.drain(..=end).collect();
            lines.push(String::from_utf8_lossy(&line[..end]).into_owned());
        }
        lines
    }
}
