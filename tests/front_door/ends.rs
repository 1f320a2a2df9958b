//! Runs that fail or are interrupted: what is kept, what is said, and that nothing is left behind.

use crate::desk::{Answer, Folder, command, scenario};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// A place for runs of a test's own; short, because sockets lie in it, and not named like a run's
/// folder.
struct Root(PathBuf);

impl Root {
    fn new(name: &str) -> Self {
        let path = PathBuf::from(format!("/dev/shm/door-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Root(path)
    }

    fn command(&self, folder: &Folder, arguments: &[&str]) -> Command {
        let mut command = command(arguments);
        command.current_dir(folder.path()).env("OBSID_ROOT", &self.0).env("TMPDIR", &self.0);
        command
    }

    fn ask(&self, folder: &Folder, arguments: &[&str]) -> Answer {
        answer(self.command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
    }

    fn left(&self) -> Vec<PathBuf> {
        std::fs::read_dir(&self.0).unwrap().flatten().map(|entry| entry.path()).collect()
    }

    fn assert_empty(&self) {
        assert!(self.left().is_empty(), "left: {:?}", self.left());
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn answer(child: Child) -> Answer {
    let output = child.wait_with_output().unwrap();
    Answer {
        arguments: String::new(),
        code: output.status.code().or(output.status.signal().map(|signal| -signal)),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Waits until `file` holds something, which says that the run is on its way.
fn wait_for(folder: &Folder, file: &str) {
    let path = folder.path().join(file);
    // Ten seconds at a look a millisecond; a recorder starts within one.
    for _ in 0..10_000 {
        if std::fs::metadata(&path).is_ok_and(|file| file.len() > 0) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("{file} stays empty");
}

fn is_object_of_a_failed_run(answer: &Answer, says: &str) -> Value {
    let object = answer.object();
    assert_eq!(object["completed"], false, "{answer}");
    assert!(object["failure"].as_str().unwrap().contains(says), "{answer}");
    for key in ["modes", "partitions"] {
        assert!(object[key].is_array(), "{answer}");
    }
    object
}

#[test]
fn an_interrupted_run_ends_in_order_on_either_link_and_keeps_its_recording() {
    for (link, ended_by) in [("lockstep", Signal::INT), ("lockstep", Signal::TERM), ("shm", Signal::INT)] {
        let (root, folder) = (Root::new(link), Folder::new(&format!("interrupted-{link}")));
        // The default mission takes seconds, whatever the link.
        let arguments = ["run", "--link", link, "--record", "r.mcap", "--json"];
        let child = root.command(&folder, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(&folder, "r.mcap");
        signal(&child, ended_by);
        let answer = answer(child).ends_with(1).says(&["obsid: stopped by a signal"]);
        let object = is_object_of_a_failed_run(&answer, "stopped by a signal");
        root.assert_empty();
        let digest = folder.ask(&["digest", "r.mcap", "--json"]).result();
        assert_eq!(object["digest"], digest["digest"], "{answer}");
    }
}

#[test]
fn a_run_that_cannot_start_says_so_in_its_result_and_leaves_no_recording() {
    let (root, folder) = (Root::new("images"), Folder::new("failed"));
    let short = scenario("short.toml");
    let arguments = ["run", &short, "--images", "nowhere", "--record", "new.mcap"];
    let answer = root.ask(&folder, &[&arguments[..], &["--json"]].concat()).ends_with(1).says(&["obsid: "]);
    let object = is_object_of_a_failed_run(&answer, "cannot start");
    assert!(object["digest"].is_null(), "{answer}");
    assert!(!folder.path().join("new.mcap").exists(), "nothing was recorded");
    let table = root.ask(&folder, &arguments).ends_with(1);
    assert!(table.stdout.contains("NOT COMPLETED: "), "{table}");
    root.assert_empty();
}

#[test]
fn a_failed_run_does_not_show_the_results_of_an_earlier_one_in_the_same_file() {
    let (root, folder) = (Root::new("earlier"), Folder::new("earlier"));
    let short = scenario("short.toml");
    root.ask(&folder, &["run", &short, "--link", "lockstep", "--record", "r.mcap"]).ends_with(0);
    let before = folder.bytes("r.mcap");
    let answer = root.ask(&folder, &["run", &short, "--images", "nowhere", "--record", "r.mcap", "--json"]);
    assert!(is_object_of_a_failed_run(&answer, "cannot start")["digest"].is_null(), "{answer}");
    assert!(folder.bytes("r.mcap") == before);
}

#[test]
fn bad_input_leaves_no_empty_recording() {
    let folder = Folder::new("no-recording");
    let short = scenario("short.toml");
    folder.file("wrong.toml", "format = 1\ncolour = 3\n");
    for arguments in [&["run", &short, "--partitions", "wrong.toml"][..], &["run", "wrong.toml"]] {
        folder.ask(&[arguments, &["--record", "new.mcap"]].concat()).refuses(&["colour"]);
        assert!(!folder.path().join("new.mcap").exists(), "{arguments:?}");
    }
}

#[test]
fn a_root_that_runs_cannot_use_is_refused_before_anything_starts() {
    let folder = Folder::new("root");
    let file = folder.path().join(folder.file("file", "")).display().to_string();
    for root in ["/nonexistent", &file] {
        for link in ["shm", "lockstep"] {
            let arguments = ["run", &scenario("short.toml"), "--link", link, "--record", "new.mcap", "--json"];
            let mut command = command(&arguments);
            command.current_dir(folder.path()).env("OBSID_ROOT", root).stdout(Stdio::piped()).stderr(Stdio::piped());
            answer(command.spawn().unwrap()).refuses(&["OBSID_ROOT", root, "existing folder", "/dev/shm"]);
            assert!(!folder.path().join("new.mcap").exists());
        }
    }
}

#[test]
fn nothing_is_left_when_the_reader_of_the_result_has_gone() {
    let short = scenario("short.toml");
    for link in ["shm", "lockstep"] {
        let (root, folder) = (Root::new(&format!("gone-{link}")), Folder::new("gone"));
        let mut child = root
            .command(&folder, &["run", &short, "--link", link, "--json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let answer = answer(child).ends_with(0);
        assert!(answer.stderr.is_empty(), "{answer}");
        root.assert_empty();
    }
}

#[test]
fn messages_that_nobody_reads_do_not_cost_the_result() {
    let (root, folder) = (Root::new("deaf"), Folder::new("deaf"));
    // A death and a restart are told on standard error, whose reader has gone.
    let short = scenario("short.toml");
    let arguments = ["run", &short, "--kill", "slosh-id@500", "--json"];
    let mut child = root.command(&folder, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let object: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(object["completed"], true);
    let mut child = command(&["run", "nowhere.toml"]).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(3), "the exit code says it all the same");
}

#[test]
fn a_result_that_cannot_be_written_is_a_failure() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let child = command(&["icd", "--json"]).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
    answer(child).ends_with(1).says(&["standard output", "No space left"]);
}

#[test]
fn what_a_killed_console_leaves_is_gone_when_the_next_run_starts() {
    let (root, folder) = (Root::new("killed"), Folder::new("killed"));
    let mut child = root.command(&folder, &["run", "--link", "lockstep"]).stdout(Stdio::null()).spawn().unwrap();
    while root.left().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(root.left().len(), 1, "else the next run has nothing to remove");
    root.ask(&folder, &["run", &scenario("short.toml"), "--link", "lockstep", "--json"]).result();
    root.assert_empty();
}

#[test]
fn a_partition_that_is_given_up_is_named_in_the_table_with_what_was_lost() {
    let (root, folder) = (Root::new("given-up"), Folder::new("given-up"));
    let short = scenario("short.toml");
    let arguments = ["run", &short, "--kill-always", "slosh-id@500"];
    let table = root.ask(&folder, &arguments).ends_with(4).says(&["obsid: degraded: slosh-id was given up after "]);
    assert!(table.stdout.starts_with("DEGRADED: slosh-id was given up after "), "{table}");
    assert!(table.stdout.contains("no slosh results from then on"), "{table}");
    let result = root.ask(&folder, &[&arguments[..], &["--json"]].concat()).ends_with(4).object();
    assert_eq!((&result["completed"], &result["degraded"]), (&false.into(), &true.into()), "{result}");
    for row in result["partitions"].as_array().unwrap() {
        assert_eq!(row["given_up"], row["name"] == "slosh-id", "{row}");
    }
}

#[test]
fn the_reason_of_a_missing_estimate_holds_the_estimators_own_words_once() {
    let folder = Folder::new("status");
    // A tenth of a second after the pulse of one second: no mode rings for so short a time.
    let text = "format = 1\nname = \"brief\"\n[modal]\nduration_s = 1.1\nplant = { file = \"hub_appendage\" }\n";
    folder.file("brief.toml", text);
    let result = folder.ask(&["run", "brief.toml", "--link", "lockstep", "--json"]).result();
    let rows = result["estimates"]["modal"].as_array().unwrap();
    assert!(!rows.is_empty());
    for row in rows {
        assert!(row["value"].is_null(), "{row}");
        assert_eq!(row["reason"].as_str().unwrap().matches("no mode found").count(), 1, "{row}");
    }
}
