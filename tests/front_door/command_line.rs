//! Arguments, help, pipes and exit codes.

use crate::desk::{Folder, ask, command, scenario};
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;

/// Verbs as the program lists them.
fn verbs() -> Vec<String> {
    let help = ask(&["--help"]).ends_with(0).stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").map(String::from).collect()
}

#[test]
fn the_help_of_every_verb_shows_an_example() {
    let verbs = verbs();
    for name in [
        "run",
        "replay",
        "digest",
        "icd",
        "partition",
        "bench",
        "simulate",
        "effects",
        "plant",
        "doctor",
        "compare",
        "diagnose",
    ] {
        assert!(verbs.iter().any(|verb| verb == name), "{name} is not among {verbs:?}");
    }
    for verb in &verbs {
        let help = ask(&[verb, "--help"]).ends_with(0);
        assert!(help.stdout.contains("Examples:\n") && help.stdout.contains(&format!("  obsid {verb} ")), "{help}");
        assert!(help.stderr.is_empty(), "{help}");
    }
    let help = ask(&["--help"]).ends_with(0).stdout;
    assert!(help.contains("Examples:\n") && help.contains("obsid run"), "{help}");
}

#[test]
fn what_the_examples_set_and_hide_can_be_set_and_hidden() {
    let folder = Folder::new("examples");
    let help = ask(&["simulate", "--help"]).ends_with(0).stdout;
    let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  obsid simulate deploy/plants/")).collect();
    assert!(examples.len() >= 3, "{help}");
    for example in examples {
        let plant = example.split_whitespace().nth(2).unwrap();
        let name = plant.rsplit('/').next().unwrap().trim_end_matches(".toml");
        let mut arguments = vec!["simulate", name, "--duration", "0.5", "--out", "x.csv"];
        for flag in ["--set", "--hide"] {
            let given = example.split_once(&format!("{flag} '")).and_then(|(_, rest)| rest.split_once('\''));
            arguments.extend(given.iter().flat_map(|(value, _)| [flag, value]));
        }
        folder.ask(&arguments).ends_with(0);
    }
}

#[test]
fn wrong_arguments_end_with_two_and_name_what_was_wrong() {
    let wrong: &[(&[&str], &str)] = &[
        (&[], "Usage"),
        (&["frobnicate"], "frobnicate"),
        (&["run", "--speed", "0"], "above 0"),
        (&["run", "--speed", "nan"], "above 0"),
        (&["run", "--seed", "x"], "'x'"),
        (&["run", "--seed", "-1"], "-1"),
        (&["run", "--link", "tcp"], "shm, lockstep"),
        (&["run", "a.toml", "b.toml"], "b.toml"),
        (&["replay"], "<RECORDING>"),
        (&["digest"], "<FILE>"),
        (&["bench", "bp9"], "bp2-planar, bp2-tank-model, bp3a, bp3b"),
        (&["bench", "bp2", "--trials", "0"], "0"),
        (&["simulate", "pendulum"], "--out"),
        (&["doctor"], "<RECORDING>"),
        (&["compare", "a.csv"], "<SIMULATED>"),
        (&["diagnose", "a.csv"], "--plant"),
        (&["diagnose", "--plant", "pendulum"], "<RECORDING[=PLANT]>"),
        (&["diagnose", "a.csv", "--plant", "pendulum", "--threads", "0"], "--threads"),
        (&["modal"], "<FILE>"),
        (&["design", "bp9"], "bp9"),
        (&["icd", "--json", "--md"], "--md"),
        (&["budget", "--json", "--md"], "--md"),
        (&["drill", "--faults", "flood"], "one of kill, young"),
        (&["drill", "--kills", "0"], "0"),
        (&["top", "--json"], "--once"),
        (&["partition", "nobody"], "inertial-id"),
        (&["partition", "inertial-id"], "--run"),
        (&["partition", "warden"], "--config"),
    ];
    for (arguments, says) in wrong {
        let answer = ask(arguments).ends_with(2).says(&[says]);
        assert!(answer.stdout.is_empty(), "{answer}");
    }
}

#[test]
fn a_partition_without_its_run_folder_fails_and_says_so() {
    let folder = Folder::new("partition");
    let answer = folder.ask(&["partition", "inertial-id", "--run", "nowhere"]).ends_with(1);
    answer.says(&["inertial-id", "run folder", "No such file"]);
}

#[test]
fn a_record_file_that_cannot_be_written_is_found_out_before_the_run() {
    let folder = Folder::new("record");
    for link in ["shm", "lockstep"] {
        for file in ["nowhere/flight.mcap", "."] {
            let answer = folder.ask(&["run", &scenario("short.toml"), "--link", link, "--record", file, "--json"]);
            answer.refuses(&[file, "cannot be written", "--record"]);
        }
    }
}

#[test]
fn json_is_one_object_on_standard_output_and_nothing_else() {
    let folder = Folder::new("json");
    let run = folder.ask(&["run", &scenario("short.toml"), "--link", "lockstep", "--record", "r.mcap", "--json"]);
    let digest = folder.ask(&["digest", "r.mcap", "--json"]);
    let icd = folder.ask(&["icd", "--json"]);
    let bench = folder.ask(&["bench", "bp2", "--trials", "1", "--json"]);
    for answer in [run, digest, icd, bench] {
        let answer = answer.ends_with(0);
        answer.object();
        assert!(answer.stdout.ends_with("}\n") && answer.stdout.starts_with('{'), "{answer}");
        assert!(answer.stderr.is_empty(), "{answer}");
    }
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let mut child = command(&["icd", "--json"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::with_capacity(1, child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "{\n");
    ends_quietly(child);
}

#[test]
fn a_closed_standard_output_ends_the_program_quietly() {
    let short = scenario("short.toml");
    for arguments in [&["icd"][..], &["icd", "--md"], &["--help"], &["run", &short, "--link", "lockstep", "--json"]] {
        let mut child = command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        ends_quietly(child);
    }
}

fn ends_quietly(mut child: std::process::Child) {
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    let status = child.wait().unwrap();
    assert!(status.success() && stderr.is_empty(), "{status}: {stderr}");
}

#[test]
fn completions_of_every_shell_name_every_subcommand() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = ask(&["completions", shell]).ends_with(0);
        assert!(script.stderr.is_empty(), "{}", script.stderr);
        for verb in verbs() {
            assert!(script.stdout.contains(&verb), "{verb} is not in the script of {shell}");
        }
        assert!(script.stdout.contains("held-out"), "{shell}");
    }
    ask(&["completions", "tcl"]).ends_with(2).says(&["bash", "zsh", "fish"]);
}

#[test]
fn every_subcommand_has_a_manual_page_with_its_examples() {
    let page = ask(&["man"]).ends_with(0).stdout;
    assert!(page.contains(".TH obsid 1") && page.contains("obsid\\-diagnose(1)"), "{page}");
    let folder = Folder::new("man");
    folder.ask(&["man", "--out", "man1"]).ends_with(0);
    let read = |name: String| std::fs::read_to_string(folder.path().join("man1").join(&name)).expect(&name);
    for verb in verbs() {
        let page = read(format!("obsid-{verb}.1"));
        assert!(page.contains(".TH") && page.contains("Examples:"), "{verb}: {page}");
    }
    assert!(read("obsid-plant-check.1".into()).contains("plant check") && !read("obsid.1".into()).contains("sabotage"));
    folder.file("taken", "");
    folder.ask(&["man", "--out", "taken/man1"]).ends_with(1).says(&["taken/man1", "cannot be written"]);
}

#[test]
fn the_format_of_plant_files_is_printed_and_written_as_a_page() {
    let folder = Folder::new("format");
    let text = folder.ask(&["plant", "format"]).ends_with(0).stdout;
    assert!(
        text.starts_with("# Format 1\n") && text.contains("[[sensor]]") && text.contains("| `thruster` |"),
        "{text}"
    );
    folder.ask(&["plant", "format", "--html", "format.html"]).ends_with(0);
    let page = String::from_utf8(folder.bytes("format.html")).unwrap();
    assert!(page.contains("<h2>Sensors</h2>") && page.contains("<pre>[[body]]"), "{page}");
    folder.ask(&["plant", "format", "--html", "nowhere/format.html"]).ends_with(1).says(&["nowhere", "written"]);
}

#[test]
fn one_case_of_a_challenge_is_written_with_its_truth() {
    let folder = Folder::new("one-case");
    let of = |out: &str| folder.ask(&["challenge", "--seed", "1", "--case", "1", "--out", out, "--json"]).result();
    let told = of("a");
    assert_eq!(of("b"), told);
    for file in told["files"].as_array().unwrap() {
        let file = file.as_str().unwrap();
        assert_eq!(folder.bytes(&format!("a/{file}")), folder.bytes(&format!("b/{file}")), "{file}");
    }
    let truth: serde_json::Value = serde_json::from_slice(&folder.bytes("a/truth.json")).unwrap();
    assert_eq!(truth["truth"]["plant"], told["plant"]);
    folder.ask(&["plant", "check", "a/plant.toml"]).ends_with(0);
    folder.ask(&["challenge", "--case", "1"]).ends_with(2).says(&["--out"]);
    folder.ask(&["challenge", "--case", "1", "--out", "a", "--cases", "3"]).ends_with(2);
}

#[test]
fn a_run_flies_under_a_mask_that_takes_its_owners_rights() {
    let line = format!("umask 0177; exec {} run {} --json", env!("CARGO_BIN_EXE_obsid"), scenario("short.toml"));
    let output = std::process::Command::new("sh").args(["-c", &line]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
