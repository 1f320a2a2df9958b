//! The warden of a run as a child of this process: started, listened to, watched, ended.
//!
//! Somebody has to watch the watcher: a warden that is stopped (SIGSTOP) says nothing, and says so
//! twice a second while it lives.

use crate::scratch::Scratch;
use runtime::RunConfig;
use runtime::deaths::DeathRow;
use runtime::rundir::purge_debris;
use runtime::statistics::PartitionRow;
use runtime::usage;
use runtime::warden::Report;
use rustix::process::{Pid, Signal, kill_process};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The warden gives a sign of life every 0.5 s; three missed ones are silence.
pub const SILENCE: Duration = Duration::from_millis(1500);
/// A silent warden that does not want for a processor is ended after this time.
const SILENT_MAX: Duration = Duration::from_secs(4);
/// Time for a dead warden's children, which the kernel kills with it, to be gone.
const ORPHANS_GRACE: Duration = Duration::from_millis(200);

/// How a run ended.
pub struct End {
    pub rows: Vec<PartitionRow>,
    pub deaths: Vec<DeathRow>,
    /// Why it did not get to its end.
    pub failure: Option<String>,
}

/// What a look at the warden's pipe found.
pub enum Heard {
    Report(Report),
    /// Nothing within the time that was allowed.
    Nothing,
    /// The warden is gone.
    Closed,
}

/// A warden that runs.
pub struct WardenProcess {
    child: Child,
    reports: Receiver<Report>,
    heard: Instant,
    end: Option<End>,
    hung: bool,
}

impl WardenProcess {
    /// Starts the warden of `run`; `wrapped_in` is a command that becomes it, empty for none.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(
        run: &RunConfig,
        images: Option<&Path>,
        scratch: &Scratch,
        wrapped_in: &[OsString],
    ) -> Result<Self, String> {
        let io = |error: std::io::Error| format!("warden: {error}");
        let config = scratch.leave_config(run).map_err(io)?;
        let program = std::env::current_exe().map_err(io)?;
        let mut words = wrapped_in.iter().cloned().chain([program.into_os_string()]);
        let mut command = Command::new(words.next().expect("the program at least"));
        command.args(words).args(["partition", "warden", "--config"]).arg(config).arg("--root").arg(scratch.root());
        if let Some(images) = images {
            command.arg("--images").arg(images);
        }
        // A group of its own: the terminal's Ctrl-C reaches the console, which asks the warden to
        // end in order.
        command.process_group(0).stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(io)?;
        let pipe = child.stdout.take().ok_or("warden: no pipe")?;
        let (sender, reports) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(pipe).lines().map_while(Result::ok) {
                let Ok(report) = serde_json::from_str(&line) else { continue };
                if sender.send(report).is_err() {
                    break;
                }
            }
        });
        Ok(WardenProcess { child, reports, heard: Instant::now(), end: None, hung: false })
    }

    /// Process id.
    pub fn pid(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    /// Asks for the end in order.
    pub fn terminate(&self) {
        let _ = kill_process(self.pid(), Signal::TERM);
    }

    /// Ends it at once, and its children with it.
    pub fn kill(&self) {
        let _ = kill_process(self.pid(), Signal::KILL);
    }

    /// The next report, or what else there is to be known after `patience`.
    pub fn next(&mut self, patience: Duration) -> Heard {
        match self.reports.recv_timeout(patience) {
            Ok(Report::End { ok, reason, partitions, deaths }) => {
                self.end = Some(End { rows: partitions, deaths, failure: (!ok).then_some(reason) });
                self.next(patience)
            }
            Ok(report) => {
                self.heard = Instant::now();
                Heard::Report(report)
            }
            Err(RecvTimeoutError::Timeout) => Heard::Nothing,
            Err(RecvTimeoutError::Disconnected) => Heard::Closed,
        }
    }

    /// Since it last said something, when that is too long; ends it when it is much too long.
    pub fn silence(&mut self) -> Option<Duration> {
        let silent = Some(self.heard.elapsed()).filter(|silent| *silent >= SILENCE)?;
        // Ready to run and not running: the computer is busy.
        if silent >= SILENT_MAX && usage::state(self.child.id()) != Some('R') {
            self.hung = true;
            self.kill();
        }
        Some(silent)
    }

    /// Waits for its end, after [`Heard::Closed`].
    pub fn end(mut self, scratch: &Scratch) -> End {
        let status = self.child.wait();
        if let Some(end) = self.end.take() {
            return end;
        }
        std::thread::sleep(ORPHANS_GRACE);
        purge_debris(scratch.root());
        let failure = match status {
            _ if self.hung => format!("the warden hung: no sign of life for {} s", SILENT_MAX.as_secs()),
            Ok(status) => format!("the warden ended without a result ({status})"),
            Err(error) => format!("warden: {error}"),
        };
        End { rows: Vec::new(), deaths: Vec::new(), failure: Some(failure) }
    }
}
