//! The warden is the process supervisor: parent of every partition. It starts, reaps and restarts
//! them, or gives them up; it maps no shared memory.
//!
//! One thread around one `poll`: pidfds of the children, the supervisor's pipe, a signal pipe. Its
//! death ends its children; the next start removes the files that it left.

mod pipe;
mod report;
mod ward;

pub use report::Report;

use crate::config::{GivenUp, Limits, RunConfig};
use crate::deaths::{Alertness, DeathLog, DeathRow};
use crate::process::Life;
use crate::rundir::OwnedRunDir;
use crate::statistics::PartitionRow;
use crate::sys::monotonic_ns;
use pipe::LineBuffer;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use telemetry::PartitionId;
use ward::{DeathMark, State, Ward};

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
/// Who was never heard may still be opening its services: up to 157 ms on a disk, more under load.
const START_LIMIT: Duration = Duration::from_secs(5);
const TERM_GRACE: Duration = Duration::from_secs(2);

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
    last_sweep: Instant,
    /// When the supervisor last wrote to its pipe; it reports the others' hangs, the warden its
    /// own.
    supervisor_heard: Instant,
    first_end: Option<Instant>,
    /// The run is over: partitions that still run have been ordered to end.
    ending: bool,
    window_frames: u64,
    started_ns: u64,
    deaths: DeathLog,
    alertness: Alertness,
    /// Who waits for whom, as the supervisor last said.
    waits: String,
    renew_after: Duration,
    last_look: Instant,
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
            last_sweep: Instant::now(),
            supervisor_heard: Instant::now(),
            first_end: None,
            ending: false,
            window_frames: run.window_frames,
            started_ns: monotonic_ns(),
            deaths: DeathLog::default(),
            alertness: Alertness::default(),
            waits: String::new(),
            renew_after: RENEW_AFTER,
            last_look: Instant::now(),
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
            self.end_supervisor_hang();
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
        }
        if self.last_look.elapsed() >= LOOK_EVERY {
            self.last_look = Instant::now();
            self.wards.iter_mut().for_each(Ward::look);
        }
    }

    /// Processes that live and do no frame: services that cannot be used any more. Renewed they are
    /// as good as new; a run that stands still all the same has failed.
    fn end_stall(&mut self) -> Result<(), String> {
        let still = self.last_advance.elapsed();
        if still > Duration::from_secs(self.limits.stall_s) {
            let waits = if self.waits.is_empty() { String::new() } else { format!("{}: ", self.waits) };
            return Err(format!(
                "{waits}no frame was processed for {} s (last: {})",
                self.limits.stall_s, self.last_frame
            ));
        }
        if still > self.renew_after && self.services_exist && self.first_end.is_none() {
            self.renew_after = still + self.renew_after * 2;
            self.tell(&Report::Stall { waits: self.waits.clone(), since_s: still.as_secs_f64() });
            self.renew_services()?;
        }
        Ok(())
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
            let (pid, t_ns) = (Pid::from_child(&child), monotonic_ns());
            let pidfd = pidfd_open(pid, PidfdFlags::empty()).map_err(|error| fail(error.into()))?;
            if let Some(stdout) = &child.stdout {
                rustix::fs::fcntl_setfl(stdout, rustix::fs::OFlags::NONBLOCK).map_err(|error| fail(error.into()))?;
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
        let timeout = Timespec { tv_sec: 0, tv_nsec: TICK.as_nanos() as i64 };
        self.alertness.sleeps();
        let woken = poll(&mut fds, Some(&timeout));
        self.alertness.wakes(monotonic_ns());
        match woken {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(format!("poll: {error}")),
        }
    }

    fn bury(&mut self) -> Result<(), String> {
        for index in 0..self.wards.len() {
            let State::Running { pidfd, .. } = &self.wards[index].state else { continue };
            let ready = poll(&mut [PollFd::new(pidfd, PollFlags::IN)], Some(&Timespec { tv_sec: 0, tv_nsec: 0 }));
            if !ready.is_ok_and(|count| count > 0) {
                continue;
            }
            let noticed_ns = monotonic_ns();
            self.wards[index].look();
            let State::Running { child, .. } = &mut self.wards[index].state else { continue };
            let pid = child.id();
            let Some(status) =
                child.try_wait().map_err(|error| format!("waiting for {}: {error}", self.wards[index].id))?
            else {
                continue;
            };
            let mut services_lost = status.code() == Some(EXIT_VANISHED) || self.wards[index].fails_again(status);
            if self.wards[index].id == PartitionId::Supervisor {
                self.listen_to_supervisor();
                self.pipe = LineBuffer::default();
                services_lost |= !self.services_exist;
            }
            self.after_death(index, pid, status, noticed_ns)?;
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
        for index in 0..self.wards.len() {
            let ward = &mut self.wards[index];
            match &mut ward.state {
                State::Waiting { .. } | State::GivenUp => continue,
                State::Done => {}
                State::Running { child, .. } => {
                    let _ = child.kill();
                    let (pid, noticed_ns) = (child.id(), monotonic_ns());
                    let _ = child.wait();
                    ward.cause = Signal::KILL.as_raw() as u32;
                    self.note_death(index, pid, "taken down, services have vanished", noticed_ns);
                }
            }
            // No death of its own: it does not count towards giving it up.
            let ward = &mut self.wards[index];
            ward.epoch += 1;
            ward.state = State::Waiting { until: Instant::now() };
        }
        (self.services_exist, self.first_end) = (false, None);
        self.pipe = LineBuffer::default();
        self.owned.clear_services().map_err(|error| format!("services cannot be removed: {error}"))
    }

    /// Into the log; the figures of the life that ended are kept.
    fn note_death(&mut self, index: usize, pid: u32, cause: &str, noticed_ns: u64) {
        let ward = &mut self.wards[index];
        let hung_ms = ward.hung_ms.take();
        ward.close_life(self.owned.dir(), &mut self.deaths);
        let (partition, epoch) = (ward.id.to_string(), ward.epoch);
        self.deaths.note(DeathRow {
            partition: partition.clone(),
            epoch,
            pid,
            cause: if hung_ms.is_some() { "hang".into() } else { cause.into() },
            t_s: noticed_ns.saturating_sub(self.started_ns) as f64 * 1e-9,
            noticed_ns,
            detect_ms: hung_ms.or(self.alertness.delay_ms(noticed_ns)),
            recover_ms: None,
        });
        self.tell(&Report::Death { partition, pid, cause: cause.into(), epoch, t_ns: noticed_ns });
    }

    fn after_death(&mut self, index: usize, pid: u32, status: ExitStatus, noticed_ns: u64) -> Result<(), String> {
        let ward = &mut self.wards[index];
        let told_to_end = self.ending && status.code() == Some(EXIT_STOPPED);
        if status.success() || told_to_end {
            ward.state = State::Done;
            ward.close_life(self.owned.dir(), &mut self.deaths);
            self.first_end.get_or_insert_with(Instant::now);
            return Ok(());
        }
        ward.cause = status.signal().or(status.code().map(|code| 256 + code)).unwrap_or(0) as u32;
        let cause = match (status.code(), status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, Some(signal)) => format!("signal {signal}"),
            (None, None) => "unknown".into(),
        };
        self.note_death(index, pid, &cause, noticed_ns);
        let ward = &mut self.wards[index];
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
        self.tell(&Report::GivenUp { partition: id.to_string() });
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
        let silent_ms = self.supervisor_heard.elapsed().as_secs_f64() * 1e3;
        self.supervisor_heard = Instant::now();
        let epoch = self.wards.iter().find(|ward| ward.id == PartitionId::Supervisor).map_or(0, |ward| ward.epoch);
        self.end_hang(PartitionId::Supervisor.text(), &epoch.to_string(), silent_ms);
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
                    self.renew_after = RENEW_AFTER;
                }
                let mode = mode.to_string();
                let _ = std::fs::write(
                    self.owned.dir().status(),
                    serde_json::json!({ "frame": frame, "mode": mode }).to_string(),
                );
                self.tell(&Report::Status { frame, mode });
            }
            ["WAITS", ..] => self.waits = line["WAITS".len()..].trim_start().to_string(),
            ["HANG", name, epoch, silent_ms] => self.end_hang(name, epoch, silent_ms.parse().unwrap_or(0.0)),
            ["SILENT", name] => self.end_silence(name),
            _ => tracing::warn!(line, "the supervisor said something unknown"),
        }
    }

    /// A supervisor that has come back never hears who hung before: a hang, unless that one has
    /// just been started.
    fn end_silence(&mut self, name: &str) {
        let Some(ward) = self.wards.iter().find(|ward| ward.id.text() == name) else { return };
        let limit = Duration::from_millis(self.limits.of(ward.id).hang_ms).max(START_LIMIT);
        let epoch = ward.epoch.to_string();
        if let State::Running { since, .. } = ward.state
            && since.elapsed() >= limit
        {
            self.end_hang(name, &epoch, since.elapsed().as_secs_f64() * 1e3);
        }
    }

    fn end_hang(&mut self, name: &str, epoch: &str, silent_ms: f64) {
        let hung = self.wards.iter().position(|ward| ward.id.text() == name && ward.epoch.to_string() == epoch);
        let Some((index, pid)) = hung.and_then(|index| Some((index, self.wards[index].pid()?))) else { return };
        let ward = &mut self.wards[index];
        if ward.is_starved(pid, silent_ms) {
            self.tell_supervisor(&format!("STARVED {name}"));
            return self.tell(&Report::Starved { partition: name.into() });
        }
        ward.hung_ms = Some(silent_ms);
        if let State::Running { child, .. } = &ward.state {
            let _ = kill_process(Pid::from_child(child), Signal::KILL);
        }
        self.tell(&Report::Hang { partition: name.into() });
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
