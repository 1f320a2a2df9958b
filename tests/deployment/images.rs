//! Units, container images and package: complete for every partition of the table, and what the
//! units start is what is tested here.

use crate::{Place, object, scenario, workspace};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use serde_json::Value;
use std::collections::BTreeMap;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// `systemd-analyze security` of a unit at most; the figure.
const EXPOSURE_MAX: f64 = 1.5;
/// Exit code of a partition that came before the services.
const FOUND_NOTHING: i32 = 5;
const ORDERS: u64 = 12;

fn text(path: &str) -> String {
    let path = workspace().join("deploy").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Names of the table's partitions.
fn partitions() -> Vec<String> {
    let table: toml::Table = text("partitions.toml").parse().unwrap();
    table["partition"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap().to_string()).collect()
}

fn value<'a>(unit: &'a str, key: &str) -> &'a str {
    let line = unit.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    line.unwrap_or_else(|| panic!("no {key} in\n{unit}"))
}

#[test]
fn every_partition_of_the_table_has_a_unit_an_image_and_a_place_in_the_package() {
    let (target, images) = (text("systemd/obsid.target"), text("container/Containerfile"));
    let manifest = std::fs::read_to_string(workspace().join("Cargo.toml")).unwrap();
    for name in partitions() {
        let (unit, binary) = (format!("obsid-{name}.service"), format!("obsid-{name}"));
        let file = text(&format!("systemd/{unit}"));
        assert!(value(&file, "ExecStart").starts_with(&format!("/usr/bin/{binary} --run ")), "{file}");
        assert!(value(&target, "Wants").split(' ').any(|wanted| wanted == unit), "{unit} in\n{target}");
        let stage = images.split("FROM scratch AS ").find(|stage| stage.starts_with(&format!("{name}\n")));
        let stage = stage.unwrap_or_else(|| panic!("no stage of {name} in the Containerfile"));
        assert!(stage.contains(&format!("COPY {binary} /{binary}\n")) && stage.contains("USER 65532"), "{stage}");
        assert!(manifest.contains(&format!("[\"target/release/{binary}\", \"usr/bin/\", \"755\"]")), "{binary}");
    }
    // Its lines for a warden would fill the journal.
    assert_eq!(value(&text("systemd/obsid-supervisor.service"), "StandardOutput"), "null");
    assert_eq!(images.matches("\nFROM ").count(), images.matches("\nFROM scratch AS ").count());
}

#[test]
fn what_the_keeper_keeps_beyond_the_run_every_partition_may_write_and_no_more_of_that_folder() {
    let keeper = text("systemd/obsid-keeper.service");
    let kept = value(&keeper, "ExecStart").split_once(" --keep ").and_then(|(_, rest)| rest.split(' ').next()).unwrap();
    let state = value(&keeper, "StateDirectory").split(' ').any(|folder| format!("/var/lib/{folder}") == kept);
    assert!(state, "systemd makes {kept}: {keeper}");
    let hardening = text("systemd/obsid-.service.d/hardening.conf");
    let writable: Vec<&str> = value(&hardening, "ReadWritePaths").split(' ').collect();
    assert_eq!(writable, ["/run/obsid", "/dev/shm", &format!("-{kept}")]);
}

/// A root folder with the units and programs of their names.
fn installed(place: &Place) -> String {
    let root = place.file("root");
    let (units, programs) = (Path::new(&root).join("etc/systemd/system"), Path::new(&root).join("usr/bin"));
    let hardening = "obsid-.service.d";
    std::fs::create_dir_all(units.join(hardening)).unwrap();
    std::fs::create_dir_all(&programs).unwrap();
    let source = workspace().join("deploy/systemd");
    std::fs::copy(source.join(hardening).join("hardening.conf"), units.join(hardening).join("hardening.conf")).unwrap();
    for name in partitions().iter().map(String::as_str).chain(["keeper"]) {
        let unit = format!("obsid-{name}.service");
        std::fs::copy(source.join(&unit), units.join(&unit)).unwrap();
        std::os::unix::fs::symlink("/bin/true", programs.join(format!("obsid-{name}"))).unwrap();
    }
    std::os::unix::fs::symlink("/bin/true", programs.join("obsid")).unwrap();
    std::fs::copy(source.join("obsid.target"), units.join("obsid.target")).unwrap();
    root
}

#[test]
fn systemd_finds_nothing_wrong_with_the_units_and_little_that_they_could_do() {
    let place = Place::new();
    let root = format!("--root={}", installed(&place));
    let analyze = |arguments: &[&str]| Command::new("systemd-analyze").args(arguments).output();
    let Ok(verdict) = analyze(&["verify", &root, "obsid.target"]) else {
        eprintln!("deployment: skipped: no systemd-analyze here");
        return;
    };
    assert!(verdict.status.success(), "{}", String::from_utf8_lossy(&verdict.stderr));
    for name in partitions().iter().map(String::as_str).chain(["keeper"]) {
        let unit = format!("obsid-{name}.service");
        let output = analyze(&["security", "--offline=true", "--no-pager", &root, &unit]).unwrap();
        let report = String::from_utf8_lossy(&output.stdout).into_owned();
        let level = report.rsplit_once("exposure level for ").and_then(|(_, rest)| rest.split(' ').nth(1));
        let level: f64 = level.and_then(|level| level.parse().ok()).unwrap_or_else(|| panic!("{unit}: {report}"));
        assert!(level <= EXPOSURE_MAX, "{unit}: {level}");
    }
}

/// A service manager of our own: starts what the units say, and starts it again when it fails.
struct Manager {
    place: Place,
    folder: String,
    commands: BTreeMap<String, Vec<String>>,
    word: UnixDatagram,
}

impl Manager {
    fn new() -> Self {
        let place = Place::new();
        // The folder's name is the prefix of the run's files in /dev/shm: one a test.
        let name = place.0.file_name().unwrap().to_string_lossy().replace("deployed", "obsid-units");
        let folder = place.file(&name);
        let (record, scenario, keep) = (place.file("flight.mcap"), scenario("short.toml"), place.file("keep"));
        std::fs::create_dir(&keep).unwrap();
        let command = |name: &str| {
            let line = text(&format!("systemd/obsid-{name}.service"));
            let line = value(&line, "ExecStart").replace(" --speed 1", "");
            let line = line.replace("/run/obsid/obsid-flight", &folder).replace("/var/lib/obsid/flight.mcap", &record);
            let line = line.replace("/var/lib/obsid/keep", &keep).replace("/etc/obsid/scenario.toml", &scenario);
            let mut words: Vec<String> = line.split(' ').map(String::from).collect();
            let program = words.remove(0);
            if let Some(partition) = program.strip_prefix("/usr/bin/obsid-") {
                words.splice(0..0, ["partition".to_string(), partition.into()]);
            }
            (name.to_string(), words)
        };
        let commands = partitions().iter().map(String::as_str).chain(["keeper"]).map(command).collect();
        let word = UnixDatagram::bind(place.file("word")).unwrap();
        Manager { place, folder, commands, word }
    }

    fn spawn(&self, name: &str) -> Child {
        let words: Vec<&str> = self.commands[name].iter().map(String::as_str).collect();
        let mut command = self.place.command(&words);
        command.env("NOTIFY_SOCKET", self.place.file("word")).stdout(Stdio::null()).spawn().unwrap()
    }

    /// Until a process says `word`.
    fn hear(&self, word: &str) {
        let mut bytes = [0; 64];
        while self.word.recv(&mut bytes).is_ok_and(|count| &bytes[..count] != word.as_bytes()) {}
    }

    /// Runs the scenario with the partitions started in `order`; one of them may be killed once it
    /// is ready. The digest of the recording, and how often each was started again.
    fn fly(&self, order: &[String], killed: Option<&str>) -> (String, BTreeMap<String, u32>) {
        let mut keeper = self.spawn("keeper");
        self.hear("READY=1");
        let (mut running, mut restarts) = (Vec::new(), BTreeMap::new());
        for name in order {
            let child = self.spawn(name);
            if killed.is_some() {
                // One after the other: the word is that of the partition started last.
                self.hear("READY=1");
            }
            if killed == Some(name) {
                kill_process(Pid::from_child(&child), Signal::KILL).unwrap();
            }
            running.push((name.clone(), child));
        }
        while !running.is_empty() {
            let pidfds: Vec<_> = running
                .iter()
                .map(|(_, child)| pidfd_open(Pid::from_child(child), PidfdFlags::empty()).unwrap())
                .collect();
            let mut fds: Vec<_> = pidfds.iter().map(|pidfd| PollFd::new(pidfd, PollFlags::IN)).collect();
            poll(&mut fds, None).unwrap();
            let ended = fds.iter().position(|fd| !fd.revents().is_empty()).unwrap();
            let (name, child) = running.remove(ended);
            let output = child.wait_with_output().unwrap();
            if output.status.success() {
                continue;
            }
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code().is_none_or(|code| code == FOUND_NOTHING), "{name}: {said}");
            if output.status.code().is_none() {
                *restarts.entry(name.clone()).or_default() += 1;
            }
            running.push((name.clone(), self.spawn(&name)));
        }
        kill_process(Pid::from_child(&keeper), Signal::TERM).unwrap();
        assert!(keeper.wait().unwrap().success());
        assert!(!Path::new(&self.folder).exists(), "the keeper leaves nothing");
        let output = self.place.command(&["digest", &self.place.file("flight.mcap"), "--json"]).output().unwrap();
        (object(&output, 0)["digest"].as_str().unwrap().to_string(), restarts)
    }
}

fn lockstep() -> String {
    let output = Place::new().command(&["run", &scenario("short.toml"), "--json", "--link", "lockstep"]).output();
    object(&output.unwrap(), 0)["digest"].as_str().unwrap().to_string()
}

/// The partitions in an order that `seed` gives (Fisher-Yates).
fn shuffled(seed: u64) -> Vec<String> {
    let (mut order, mut state) = (partitions(), seed);
    for last in (1..order.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        order.swap(last, (state >> 33) as usize % (last + 1));
    }
    order
}

fn give_the_same_results(orders: impl Iterator<Item = u64>) {
    let expected = lockstep();
    for seed in orders {
        let order = shuffled(seed);
        let (digest, _) = Manager::new().fly(&order, None);
        assert_eq!(digest, expected, "{order:?}");
    }
}

#[test]
fn units_give_the_same_results_in_any_order_of_start() {
    give_the_same_results((0..ORDERS).step_by(2));
}

#[test]
fn units_give_the_same_results_in_other_orders_of_start() {
    give_the_same_results((1..ORDERS).step_by(2));
}

#[test]
fn a_partition_that_the_manager_starts_again_takes_up_its_work() {
    let order = ["supervisor", "sensor-sim", "slosh-id", "inertial-id", "modal-id", "recorder"].map(String::from);
    let manager = Manager::new();
    let (digest, restarts) = manager.fly(&order, Some("slosh-id"));
    assert_eq!((digest, restarts), (lockstep(), BTreeMap::from([("slosh-id".to_string(), 1)])));
    // What is kept beyond the run knows of it.
    let output =
        manager.place.command(&["events", "--resets", &manager.place.file("keep"), "--json"]).output().unwrap();
    let resets = object(&output, 0)["resets"].clone();
    let of_slosh = |reset: &&Value| reset["partition"] == "slosh-id" && reset["epoch"] == 1;
    assert_eq!(resets.as_array().unwrap().iter().filter(of_slosh).count(), 1, "{resets}");
}
