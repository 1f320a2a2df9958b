//! `--json` is one object on standard output, for every command that has it.

use crate::desk::{Folder, ask, scenario};
use std::collections::BTreeSet;

/// A command line for every command, as short as it can be; `SHORT` is a scenario.
const COMMANDS: &[&str] = &[
    "run SHORT --link lockstep --record run.mcap",
    "digest run.mcap",
    "simulate pendulum --duration 4 --out swing.csv",
    "simulate pendulum --inputs swing.csv --out predicted.csv",
    "effects",
    "effects joint_coulomb",
    "effects --plant pendulum",
    "icd",
    "events run.mcap",
    "events --list",
    "tables list",
    "tables validate guards.toml",
    "command check sequence.toml",
    "plant check pendulum tank_1d",
    "plant describe pendulum",
    "plant parameters pendulum --duration 2",
    "plant new swing.csv --out new.toml",
    "plant new swing.csv --list",
    "doctor swing.csv predicted.csv --plant pendulum",
    "doctor swing.csv predicted.csv --list",
    "compare swing.csv predicted.csv",
    "compare swing.csv --list predicted.csv",
    "modal SHORT_MODES",
    "modal swing.csv --list",
    "replay SHORT_MODES",
    "replay SHORT_MODES --list",
    "diagnose swing.csv --plant pendulum --effort quick",
    "diagnose swing.csv --plant pendulum --list",
    "identify swing.csv --plant pendulum",
    "identify swing.csv --list --plant pendulum",
    "challenge --case 1 --out case",
    "challenge --cases 1",
    "bench bp2-stroke --trials 1",
    "bench bp2-suspension --trials 1",
    "bench bp3b --trials 1",
    "bench dynamics",
    "drill --kills 1 --faults kill --speed 40",
    "latency --seconds 1",
    "budget --seconds 3",
];

/// Commands that need a run that flies or drivers that feed it: `fault_injection` and `deployment`
/// test what they print.
const TESTED_ELSEWHERE: [&str; 11] = [
    "top",
    "gateway",
    "command ping",
    "command safe",
    "command resume",
    "command allow-capture",
    "command clear-counters",
    "command sequence",
    "tables load",
    "tables activate",
    "tables dump",
];
const GUARDS: &str = "format = 1\npartition = \"supervisor\"\ntable = \"guards\"\nversion = 4\n\
    [values]\nsafe_dwell_frames = 800\n";
const SEQUENCE: &str = "format = 1\n[[command]]\nframe = 300\norder = \"ping\"\nto = \"all\"\n";

/// A free decay of two channels.
fn decay() -> String {
    let row = |k: u32| {
        let t = f64::from(k) * 0.005;
        let tone = |hertz: f64, damping: f64| (-damping * t).exp() * (std::f64::consts::TAU * hertz * t).sin();
        let noise = |seed: u32| f64::from((k * 7919 + seed) % 997) * 1e-6;
        let (one, other) = (tone(5.0, 0.1), tone(11.0, 0.2));
        format!("{t:.3},{:.9},{:.9}\n", one + other + noise(3), 0.5 * one - other + noise(71))
    };
    "time [s],acceleration_1 [m/s^2],acceleration_2 [m/s^2]\n".to_owned() + &(0..2000).map(row).collect::<String>()
}

#[test]
fn every_command_with_json_prints_one_object_and_nothing_else() {
    let folder = Folder::new("objects");
    folder.file("decay.csv", decay());
    folder.file("guards.toml", GUARDS);
    folder.file("sequence.toml", SEQUENCE);
    let short = scenario("short.toml");
    for line in COMMANDS {
        let words = line.split(' ').map(|word| match word {
            "SHORT" => short.as_str(),
            "SHORT_MODES" => "decay.csv",
            word => word,
        });
        let answer = folder.ask(&words.chain(["--json"]).collect::<Vec<_>>());
        // a busy computer exceeds a budget or a time, which is the command's answer
        let measures = line.starts_with("budget") || line.starts_with("drill");
        let answer = if measures && answer.code == Some(1) { answer } else { answer.ends_with(0) };
        answer.object();
        assert!(answer.stdout.ends_with("}\n") && answer.stdout.starts_with('{'), "{answer}");
    }
}

/// Subcommands that `--help` of `words` lists.
fn listed(words: &[&str]) -> Vec<String> {
    let help = ask(&[words, &["--help"]].concat()).ends_with(0).stdout;
    let block = help.split("Commands:\n").nth(1).unwrap_or("");
    let lines = block.lines().take_while(|line| !line.is_empty()).filter(|line| line.starts_with("  "));
    let names = lines.filter_map(|line| line.split_whitespace().next().map(String::from));
    names.filter(|name| name != "help").collect()
}

#[test]
fn no_command_with_json_is_left_out_of_the_test() {
    let mut with_json = BTreeSet::new();
    for name in listed(&[]) {
        let inner = listed(&[&name]);
        let lines = if inner.is_empty() {
            vec![vec![name]]
        } else {
            inner.into_iter().map(|of| vec![name.clone(), of]).collect()
        };
        for words in lines {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            if ask(&[&words[..], &["--help"]].concat()).stdout.contains("--json") {
                with_json.insert(words.join(" "));
            }
        }
    }
    assert!(with_json.len() > 12, "{with_json:?}");
    let tested = |name: &String| COMMANDS.iter().any(|line| line == name || line.starts_with(&format!("{name} ")));
    let missing: Vec<_> =
        with_json.iter().filter(|name| !tested(name) && !TESTED_ELSEWHERE.contains(&name.as_str())).collect();
    assert!(missing.is_empty(), "not tested: {missing:?}");
}
