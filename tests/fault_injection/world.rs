//! A world: one test's own place for runs, in which nothing of another test can be seen, killed or
//! left behind.
//!
//! Its folder lies on tmpfs; runs make their folders in `r` (`OBSID_ROOT`), their scratch files in
//! `tmp` (`TMPDIR`). The console gets its own process group and ends in order when the test dies
//! (PDEATHSIG). A test waits for a file, a process or a line, never for a time; a run that outlives
//! [`DEADLINE`] is ended and examined. At most [`RUNS_AT_ONCE`] runs exist at a time: each has
//! seven processes beside the console.

use crate::ended::Ended;
use crate::process::Process;
use rustix::process::Signal;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longer than the warden's own stall limit (60 s), so that the warden says first what is wrong.
const DEADLINE: Duration = Duration::from_secs(150);
const RUNS_AT_ONCE: usize = 2;
const LOOK_EVERY: Duration = Duration::from_millis(1);
const SHARED_MEMORY: &str = "/dev/shm";
const SCENARIO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/scenarios/short.toml");

static RUNS: Mutex<usize> = Mutex::new(0);
static RUN_ENDED: Condvar = Condvar::new();

/// A test that fails while it holds a lock must not fail the others.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Permit;

impl Permit {
    fn wait() -> Self {
        let full = RUN_ENDED.wait_while(lock(&RUNS), |runs| *runs >= RUNS_AT_ONCE);
        *full.unwrap_or_else(PoisonError::into_inner) += 1;
        Permit
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        *lock(&RUNS) -= 1;
        RUN_ENDED.notify_one();
    }
}

pub struct World {
    folder: PathBuf,
    scenario: &'static str,
    /// Folders of all runs so far; their names are the prefixes of their files in shared memory.
    runs: Mutex<Vec<PathBuf>>,
}

impl World {
    pub fn new() -> Self {
        Self::flying(SCENARIO)
    }

    /// A world in which another scenario than the short one is flown.
    pub fn flying(scenario: &'static str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        // Short, because sockets lie in it (107 bytes at most); must not begin like a run's folder:
        // wardens purge those.
        let name = format!("faults-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let world = World { folder: Path::new(SHARED_MEMORY).join(name), scenario, runs: Mutex::default() };
        for folder in [world.folder.clone(), world.root(), world.scratch()] {
            std::fs::create_dir(folder).expect("the name is new");
        }
        std::fs::write(world.file("test"), std::thread::current().name().unwrap_or("?")).unwrap();
        world
    }

    /// A file of the test's own.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn root(&self) -> PathBuf {
        self.folder.join("r")
    }

    fn scratch(&self) -> PathBuf {
        self.folder.join("tmp")
    }

    pub fn processes(&self) -> Vec<Process> {
        Process::all_of_world(&self.root())
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("OBSID_ROOT", self.root()).env("TMPDIR", self.scratch());
        command.stdin(Stdio::null());
        command
    }

    /// A verb without processes of its own, to its end.
    pub fn obsid(&self, arguments: &[&str]) -> Output {
        self.command(env!("CARGO_BIN_EXE_obsid")).args(arguments).output().unwrap()
    }

    /// As [`World::obsid`] behind `ulimit LIMIT`.
    pub fn limited(&self, limit: &str, arguments: &[&str]) -> Output {
        let script = format!("ulimit {limit} && exec \"$@\"");
        let mut command = self.command("sh");
        command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_obsid")]).args(arguments).output().unwrap()
    }

    /// The scenario in one thread.
    pub fn lockstep(&self, arguments: &[&str]) -> Ended {
        let output = self.obsid(&[&["run", self.scenario, "--json", "--link", "lockstep"], arguments].concat());
        let log = String::from_utf8_lossy(&output.stderr).lines().map(String::from).collect();
        Ended { code: output.status.code(), json: serde_json::from_slice(&output.stdout).unwrap_or_default(), log }
    }

    /// The scenario as processes, to its end, after which nothing may be left.
    pub fn run(&self, arguments: &[&str]) -> Ended {
        let ended = self.start(arguments).end();
        self.assert_nothing_left();
        ended
    }

    /// Starts the scenario as processes.
    pub fn start(&self, arguments: &[&str]) -> Run<'_> {
        self.start_under(None, arguments)
    }

    /// As [`World::start`] under a service manager that listens to the socket `manager`.
    pub fn start_under(&self, manager: Option<&Path>, arguments: &[&str]) -> Run<'_> {
        let permit = Permit::wait();
        let mut command = self.command("setpriv"); // util-linux; becomes the console
        command.args(["--pdeathsig", "TERM", env!("CARGO_BIN_EXE_obsid"), "run", self.scenario, "--json"]);
        command.args(arguments).process_group(0).stdout(Stdio::piped()).stderr(Stdio::piped());
        manager.map(|socket| command.env("NOTIFY_SOCKET", socket));
        let mut child = command.spawn().expect("setpriv of util-linux can be started");
        let mut stdout = child.stdout.take().expect("piped");
        let stderr = child.stderr.take().expect("piped");
        let log = Arc::new(Mutex::new(Vec::new()));
        let lines = Arc::clone(&log);
        let readers = (
            std::thread::spawn(move || {
                let mut text = String::new();
                stdout.read_to_string(&mut text).map(|_| text).unwrap_or_default()
            }),
            std::thread::spawn(move || {
                BufReader::new(stderr).lines().map_while(Result::ok).for_each(|line| lock(&lines).push(line));
            }),
        );
        let console = Process::child(child.id(), "console");
        let known = lock(&self.runs).len();
        let mut run =
            Run { world: self, child, console, readers: Some(readers), log, started: Instant::now(), _permit: permit };
        let folder = run.wait_until("a run's folder", |run| run.world.folders().into_iter().nth(known));
        lock(&self.runs).push(folder);
        run
    }

    /// Folders of runs, those that were seen before first. (A console's scratch folder holds no
    /// `run.json`.)
    fn folders(&self) -> Vec<PathBuf> {
        let mut folders = lock(&self.runs).clone();
        let found = std::fs::read_dir(self.root()).unwrap().flatten().map(|entry| entry.path());
        let found = found.filter(|path| path.join("run.json").exists());
        folders.extend(found.filter(|path| !lock(&self.runs).contains(path)));
        folders
    }

    /// No process, no file of any run of this world.
    pub fn assert_nothing_left(&self) {
        let processes: Vec<_> = self.processes().into_iter().map(|process| (process.name, process.pid)).collect();
        assert!(processes.is_empty(), "still alive: {processes:?}");
        for folder in [self.root(), self.scratch()] {
            let left: Vec<_> = std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()).collect();
            assert!(left.is_empty(), "left: {left:?}");
        }
        assert!(self.shared_memory().is_empty(), "left: {:?}", self.shared_memory());
    }

    /// Files of this world's runs in shared memory.
    pub fn shared_memory(&self) -> Vec<PathBuf> {
        let prefixes: Vec<String> =
            lock(&self.runs).iter().map(|run| format!("{}_", run.file_name().unwrap().to_string_lossy())).collect();
        let entries = std::fs::read_dir(SHARED_MEMORY).unwrap().flatten();
        let ours = entries.filter(|entry| {
            let name = entry.file_name();
            prefixes.iter().any(|prefix| name.to_string_lossy().starts_with(prefix))
        });
        ours.map(|entry| entry.path()).collect()
    }
}

impl Drop for World {
    fn drop(&mut self) {
        for file in self.shared_memory() {
            let _ = std::fs::remove_file(file);
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A run on its way.
pub struct Run<'w> {
    world: &'w World,
    child: Child,
    pub console: Process,
    readers: Option<(JoinHandle<String>, JoinHandle<()>)>,
    log: Arc<Mutex<Vec<String>>>,
    started: Instant,
    _permit: Permit,
}

impl Run<'_> {
    /// Looks until `probe` finds what is waited for; fails when the console ends before, or at the
    /// deadline.
    pub fn wait_until<T>(&mut self, what: &str, mut probe: impl FnMut(&mut Self) -> Option<T>) -> T {
        loop {
            let over = self.console.ends_within(LOOK_EVERY);
            if let Some(found) = probe(self) {
                return found;
            }
            if over || self.started.elapsed() > DEADLINE {
                panic!("waited in vain for {what}: {}", self.autopsy());
            }
        }
    }

    /// The process called `name`, as soon as it lives.
    pub fn process(&mut self, name: &str) -> Process {
        let find = |run: &mut Self| run.world.processes().into_iter().find(|process| process.name == name);
        self.wait_until(&format!("a process called {name}"), find)
    }

    /// Whether the run's log has such a line.
    pub fn said(&self, line: &str) -> bool {
        lock(&self.log).iter().any(|said| said == line)
    }

    /// Until every partition has done frames and told so, once a second.
    pub fn wait_for_housekeeping(&mut self) {
        self.wait_until("housekeeping of all partitions", |run| (run.statistics().len() == 6).then_some(()));
    }

    /// Overwrites both checkpoints of `name`.
    pub fn spoil_checkpoints(&self, name: &str) {
        let folder = self.folder().expect("the run has begun").join(name);
        for slot in [0, 1] {
            std::fs::write(folder.join(format!("{name}.{slot}")), "spoilt").unwrap();
        }
    }

    fn folder(&self) -> Option<PathBuf> {
        lock(&self.world.runs).last().cloned()
    }

    fn statistics(&self) -> Vec<String> {
        let entries = self.folder().and_then(|folder| std::fs::read_dir(folder).ok());
        let files = entries.into_iter().flatten().flatten().map(|entry| entry.path().join("stats.json"));
        files.filter_map(|path| std::fs::read_to_string(path).ok()).collect()
    }

    /// Waits for the end of the console and of all it started.
    pub fn end(mut self) -> Ended {
        self.wait_for_end_of("console", |name| name == "console");
        self.wait_for_end_of("what the console started", |_| true);
        let status = self.child.wait().unwrap();
        let (stdout, stderr) = self.readers.take().expect("only here");
        let text = stdout.join().unwrap();
        stderr.join().unwrap();
        let log = core::mem::take(&mut *lock(&self.log));
        let code = status.code().or_else(|| status.signal().map(|signal| -signal));
        Ended { code, json: serde_json::from_str(&text).unwrap_or_default(), log }
    }

    /// Waits for the end of all processes of this world that are `concerned`.
    fn wait_for_end_of(&self, what: &str, concerned: impl Fn(&str) -> bool) {
        for process in self.world.processes().iter().filter(|process| concerned(&process.name)) {
            let left = DEADLINE.saturating_sub(self.started.elapsed());
            assert!(process.ends_within(left), "waited in vain for the end of {what}: {}", self.autopsy());
        }
    }

    /// What is known of a run that does not do what it should: processes, last figures, log.
    fn autopsy(&self) -> String {
        let processes: Vec<String> = self
            .world
            .processes()
            .iter()
            .map(|p| format!("{} (pid {}) in state {}", p.name, p.pid, p.state()))
            .collect();
        let log = lock(&self.log).join("\n  ");
        format!("\nalive: {processes:?}\nfigures:\n  {}\nlog:\n  {log}", self.statistics().join("\n  "))
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        // The warden before its partitions, or it would start them again.
        for concerned in ["console", "warden", ""] {
            for process in self.world.processes().iter().filter(|process| process.name.starts_with(concerned)) {
                process.signal(Signal::KILL);
                process.ends_within(Duration::from_secs(5));
            }
        }
        let _ = self.child.wait();
    }
}

/// The undisturbed run, in lockstep: what every drill is compared with.
pub struct Undisturbed {
    pub digest: String,
    pub frames: u64,
    pub ended: Ended,
    /// All its samples.
    pub recording: recording::RecordedRun,
}

/// Carried out once for all tests.
pub fn undisturbed() -> &'static Undisturbed {
    static ONCE: OnceLock<Undisturbed> = OnceLock::new();
    ONCE.get_or_init(|| {
        let world = World::new();
        let file = world.file("flight.mcap");
        let ended = world.lockstep(&["--record", file.to_str().unwrap()]);
        assert_eq!(ended.code, Some(0), "{ended}");
        let recording = recording::read_mcap(&file).unwrap();
        Undisturbed { digest: ended.digest().into(), frames: ended.count("sensor-sim", "frames"), recording, ended }
    })
}
