//! Every command refuses every kind of bad file: with a cure, at once, in bounded memory.

use crate::desk::{Folder, command};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Address space of a refusal \[KiB\]: the program itself with its threads takes a sixth of it.
const MEMORY_KIB: u64 = 1_500_000;
/// A command that has not ended by then waits for a pipe \[s\].
const HANGS_S: u32 = 60;

/// A refusal of more bytes fills the terminal: twenty errors of a plant file, each with three lines
/// of it.
const LONG: usize = 20 * 1500;

/// Every place of the command line that takes a file that is read; `FILE` is the bad one.
const COMMANDS: &[&str] = &[
    "doctor FILE",
    "doctor good.csv --plant FILE",
    "doctor good.csv --map FILE",
    "doctor --list FILE",
    "compare FILE good.csv",
    "compare good.csv FILE",
    "diagnose FILE --plant pendulum",
    "diagnose good.csv --plant FILE",
    "diagnose good.csv --plant pendulum --map FILE",
    "diagnose good.csv --plant pendulum --held-out FILE",
    "diagnose good.csv --plant pendulum --repeat FILE",
    "modal FILE",
    "modal good.csv --map FILE",
    "replay FILE",
    "replay good.csv --scenario FILE",
    "replay good.csv --map FILE",
    "simulate FILE --out out.csv",
    "simulate pendulum --inputs FILE --out out.csv",
    "plant check FILE",
    "plant describe FILE",
    "plant parameters FILE",
    "plant new FILE --out new.toml",
    "effects --plant FILE",
    "digest FILE",
    "run FILE",
    "run --partitions FILE",
    "drill FILE",
    "budget FILE",
    "budget --partitions FILE",
    "design bp1a --limits FILE --out design.toml",
];

/// Bad files of a folder, each called so that its ending leads no command elsewhere.
fn bad_files(folder: &Folder) -> Vec<String> {
    let gz = |name: &str, text: &dyn Fn(&mut dyn Write)| {
        let file = std::fs::File::create(folder.path().join(name)).unwrap();
        let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
        text(&mut packed);
        packed.finish().unwrap();
    };
    let block = vec![b'7'; 1 << 20];
    gz("line.csv.gz", &|out| (0..80).for_each(|_| out.write_all(&block).unwrap()));
    let rows = "1,1\n".repeat(1 << 18);
    gz("bomb.csv.gz", &|out| {
        out.write_all(b"time [s],x [m]\n0,1\n").unwrap();
        (0..80).for_each(|_| out.write_all(rows.as_bytes()).unwrap());
    });
    folder.file("empty", "");
    folder.file("zeros", vec![0; 1 << 20]);
    folder.file("bytes", (0..100_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect::<Vec<_>>());
    folder.file("deep", "a = ".to_owned() + &"[".repeat(100_000));
    folder.file("long", "x".repeat(20 << 20));
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap().success());
    let own = ["line.csv.gz", "bomb.csv.gz", "empty", "zeros", "bytes", "deep", "long", "folder", "pipe", "absent"];
    own.into_iter().chain(["/dev/zero"]).map(String::from).collect()
}

/// Runs a command within [`MEMORY_KIB`].
fn bounded(folder: &Path, arguments: &[&str]) -> std::process::Output {
    let program = command(&[]).get_program().to_owned();
    let limited = format!("ulimit -v {MEMORY_KIB}; exec timeout {HANGS_S} \"$0\" \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &limited]).arg(program).args(arguments).current_dir(folder).stdin(Stdio::null());
    shell.output().unwrap()
}

#[test]
fn every_command_refuses_every_bad_file_with_a_cure_and_within_its_memory() {
    let folder = Folder::new("inputs");
    let rows: String = (0..200).map(|k| format!("{},{}\n", f64::from(k) / 100.0, (f64::from(k) / 9.0).sin())).collect();
    folder.file("good.csv", format!("time [s],angle [rad]\n{rows}"));
    let mut wrong = Vec::new();
    for file in bad_files(&folder) {
        // limits that state nothing are limits: those of the trajectory
        for line in COMMANDS.iter().filter(|line| !(file == "empty" && line.starts_with("design"))) {
            let arguments: Vec<&str> = line.split(' ').map(|word| if word == "FILE" { &file } else { word }).collect();
            let output = bounded(folder.path(), &arguments);
            let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
            let is_cured = stderr.contains("help: ");
            if output.status.code() != Some(3) || !is_cured || !stdout.is_empty() || stderr.len() > LONG {
                let head: String = stderr.chars().take(300).collect();
                wrong.push(format!("obsid {}\n{:?}\n{stdout}{head}", arguments.join(" "), output.status));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of them:\n{}", wrong.len(), wrong.join("\n\n"));
}

#[test]
fn a_simulation_that_no_memory_holds_is_refused_with_its_need_and_a_cure() {
    let folder = Folder::new("inputs-long");
    for seconds in ["1e12", "1e9", "inf", "nan", "-1"] {
        let duration = format!("--duration={seconds}");
        let refused = bounded(folder.path(), &["simulate", "pendulum", &duration, "--out", "out.csv"]);
        let stderr = String::from_utf8_lossy(&refused.stderr);
        assert!(matches!(refused.status.code(), Some(2 | 3)), "{seconds}: {stderr}");
        assert!(stderr.contains("help: give"), "{seconds}: {stderr}");
        if seconds == "1e12" {
            assert!(stderr.contains("GiB of memory") && stderr.contains("give at most"), "{stderr}");
        }
    }
}
