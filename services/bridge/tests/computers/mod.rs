//! Two computers on one: namespaces, the line between them, and processes in them, all gone with
//! the test.

use runtime::link::Link;
use runtime::rundir::RunDir;
use runtime::shm::ShmLink;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};
use telemetry::{TOPICS, TopicId, is_result};

const PATIENCE: Duration = Duration::from_secs(60);

/// The built `obsid`, where everything is there that the test needs; else says what is missing.
pub fn program() -> Option<PathBuf> {
    let obsid = std::env::var_os("OBSID").map(PathBuf::from);
    let beside = Path::new(env!("CARGO_BIN_EXE_obsid-bridge")).with_file_name("obsid");
    let obsid = obsid.unwrap_or(beside);
    let works = |program: &str, arguments: &[&str]| {
        Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
    };
    let missing = if !obsid.is_file() {
        format!("{} (OBSID=PROGRAM, or the same --target-dir)", obsid.display())
    } else if !works("python3", &["--version"]) {
        "python3".to_string()
    } else if !Path::new("/dev/net/tun").exists() {
        "/dev/net/tun".to_string()
    } else if !works("ip", &["netns", "add", "obsid-probe"]) || !works("ip", &["netns", "del", "obsid-probe"]) {
        "ip netns, as root".to_string()
    } else {
        return Some(obsid);
    };
    let is_required = std::env::var("OBSID_REQUIRE").is_ok_and(|all| all.contains("namespaces"));
    assert!(!is_required, "missing: {missing}");
    eprintln!("SKIPPED: two computers: missing: {missing}");
    None
}

pub struct Run {
    pub folder: PathBuf,
    pub process: usize,
}

pub struct Computers {
    obsid: PathBuf,
    folder: PathBuf,
    namespaces: [String; 2],
    line: Child,
    line_input: Option<ChildStdin>,
    processes: Vec<(Child, Option<String>)>,
}

impl Computers {
    pub fn new(obsid: &Path, seed: u64) -> Self {
        let pid = std::process::id();
        let folder = PathBuf::from(format!("/dev/shm/bridge-{pid}"));
        let namespaces = ["a", "b"].map(|side| format!("obsid-{side}-{pid}"));
        for (side, namespace) in namespaces.iter().enumerate() {
            for part in ["root", "tmp", "far"] {
                std::fs::create_dir_all(folder.join(format!("{side}")).join(part)).unwrap();
            }
            assert!(Command::new("ip").args(["netns", "add", namespace]).status().unwrap().success());
            let up = ["-n", namespace, "link", "set", "dev", "lo", "up"];
            assert!(Command::new("ip").args(up).status().unwrap().success());
        }
        let [a, b] = namespaces.each_ref();
        // A tenth lost, 300 ms, cut from second 8 to 18.
        let mut line = Command::new("python3")
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/line.py"))
            .args([a, b, &seed.to_string(), "10", "300", "8", "18"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut ready = String::new();
        BufReader::new(line.stdout.as_mut().unwrap()).read_line(&mut ready).unwrap();
        let line_input = line.stdin.take();
        let world = Computers { obsid: obsid.into(), folder, namespaces, line, line_input, processes: Vec::new() };
        assert_eq!(ready, "ready\n");
        world
    }

    fn place(&self, side: usize, part: &str) -> PathBuf {
        self.folder.join(format!("{side}")).join(part)
    }

    /// Where `side` sees the run of the other computer.
    pub fn mirror(&self, side: usize) -> PathBuf {
        self.place(side, "far").join("m")
    }

    /// What the recorder of `side` has written.
    pub fn record(&self, side: usize) -> PathBuf {
        self.place(side, "tmp").join("record.mcap")
    }

    fn start(&mut self, side: usize, program: &Path, arguments: &[&str]) -> usize {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.namespaces[side]]).arg(program).args(arguments);
        command.env("OBSID_ROOT", self.place(side, "root")).env("TMPDIR", self.place(side, "tmp"));
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().unwrap();
        self.processes.push((child, None));
        self.processes.len() - 1
    }

    /// The short scenario in real time.
    pub fn start_run(&mut self, side: usize, seed: u64) -> Run {
        let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/scenarios/short.toml");
        let (seed, record) = (seed.to_string(), self.record(side).display().to_string());
        let arguments = ["run", scenario, "--speed", "1", "--seed", &seed, "--record", &record, "--json"];
        let process = self.start(side, &self.obsid.clone(), &arguments);
        let root = self.place(side, "root");
        let folder = wait_for(|| {
            let folder = runtime::rundir::living(&root)?;
            RunDir::at(&folder).ready().exists().then_some(folder)
        });
        Run { folder, process }
    }

    pub fn start_bridge(&mut self, side: usize, end: &[&str], run: &Path) -> usize {
        let (run, mirror) = (run.display().to_string(), self.mirror(side).display().to_string());
        let arguments = [end, &["--run", &run, "--mirror", &mirror]].concat();
        self.start(side, Path::new(env!("CARGO_BIN_EXE_obsid-bridge")), &arguments)
    }

    /// A command of `obsid` to the mirror of `side`.
    pub fn start_command(&mut self, side: usize, arguments: &[&str]) -> usize {
        let mirror = self.mirror(side).display().to_string();
        self.start(side, &self.obsid.clone(), &[arguments, &["--run", &mirror]].concat())
    }

    pub fn cut_from_now(&mut self) {
        self.line_input.as_mut().unwrap().write_all(b"go\n").unwrap();
    }

    pub fn has_ended(&mut self, process: usize) -> bool {
        self.processes[process].0.try_wait().unwrap().is_some()
    }

    /// Standard output of a process that has ended or is about to.
    pub fn output(&mut self, process: usize) -> String {
        let (child, output) = &mut self.processes[process];
        if output.is_none() {
            let mut text = String::new();
            child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
            child.wait().unwrap();
            *output = Some(text);
        }
        output.clone().unwrap()
    }

    /// What the line did.
    pub fn end_line(&mut self) -> String {
        self.line_input = None;
        let mut text = String::new();
        self.line.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        text
    }
}

impl Drop for Computers {
    fn drop(&mut self) {
        for (child, _) in &mut self.processes {
            // Only what was started here and still runs.
            if child.try_wait().is_ok_and(|ended| ended.is_none()) {
                let _ = Command::new("kill").arg(child.id().to_string()).status();
                let _ = child.wait();
            }
        }
        self.line_input = None;
        let _ = self.line.wait();
        for namespace in &self.namespaces {
            let _ = Command::new("ip").args(["netns", "del", namespace]).status();
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn wait_for<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let since = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(since.elapsed() < PATIENCE, "waited {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A consumer of a mirror: keeps every result as it comes.
pub struct Reader {
    link: ShmLink,
    seen: Vec<Vec<Vec<u8>>>,
}

impl Reader {
    pub fn of(mirror: &Path) -> Self {
        let dir = RunDir::at(mirror);
        wait_for(|| dir.ready().exists().then_some(()));
        let topics: Vec<TopicId> = (0..TOPICS.len()).filter(|&topic| is_result(topic)).collect();
        let link = ShmLink::observe(&dir.prefix(), &dir.iceoryx_root(), &topics).unwrap();
        Reader { link, seen: vec![Vec::new(); TOPICS.len()] }
    }

    pub fn look(&mut self) {
        for topic in 0..TOPICS.len() {
            let seen = &mut self.seen[topic];
            let _ = self.link.drain(topic, &mut |_, payload| seen.push(payload.to_vec()));
        }
    }

    pub fn of_topic(&self, topic: TopicId) -> Vec<Vec<u8>> {
        self.seen[topic].clone()
    }
}
