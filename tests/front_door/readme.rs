//! Every command of `README.md` and `deploy/examples/README.md`, run in order in a fresh folder
//! that has a copy of `deploy`.
//!
//! In a `console` block a line after `$ ` is a command and the lines below are its output. A lone
//! `…` stands for lines that are not shown, one inside a line for a part of it. In an `sh` block
//! every line is a command.

use crate::desk::{Folder, workspace};
use std::path::Path;
use std::process::{Command, Stdio};

/// Commands of the README that no test runs: they build, or run this test.
const EXCLUDED: [&str; 3] = ["sudo apt-get install gcc", "cargo install --path .", "cargo test --release"];
/// What a command may begin with.
const PROGRAMS: [&str; 2] = ["obsid", "cmp"];
const ELLIPSIS: &str = "…";

#[derive(Debug, PartialEq)]
struct Step {
    command: String,
    shown: Vec<String>,
}

/// The commands of a page with the output that it shows.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let (mut block, mut continues) = (None, false);
    for line in page.lines() {
        if let Some(info) = line.strip_prefix("```") {
            block = if block.is_some() { None } else { Some(info.to_owned()) };
            continue;
        }
        let command = match block.as_deref() {
            Some("sh") if line.starts_with('#') || line.is_empty() => continue,
            Some("sh") => Some(line),
            Some("console") => line.strip_prefix("$ "),
            _ => continue,
        };
        match command {
            Some(rest) if !continues => steps.push(Step { command: rest.to_owned(), shown: Vec::new() }),
            None if !continues => {
                steps.last_mut().expect("output follows a command").shown.push(line.trim_end().to_owned());
            }
            _ => steps.last_mut().unwrap().command.push_str(line.trim_start()),
        }
        let last = &mut steps.last_mut().unwrap().command;
        continues = last.ends_with('\\');
        last.truncate(last.trim_end_matches('\\').len());
    }
    steps.iter_mut().for_each(|step| step.command = as_typed(&step.command));
    steps
}

/// The command without its comment, with the program in place of cargo.
fn as_typed(command: &str) -> String {
    let command = command.split_once("  #").map_or(command, |(command, _)| command).trim();
    command.replace("cargo run --release --", "obsid")
}

/// The parts of a shown line are in one line of the output, in order.
fn is_in(shown: &str, line: &str) -> bool {
    let mut rest = line;
    shown.split(ELLIPSIS).map(str::trim).filter(|part| !part.is_empty()).all(|part| match rest.split_once(part) {
        Some((_, behind)) => {
            rest = behind;
            true
        }
        None => false,
    })
}

/// Shown lines that do not occur in the output in their order.
fn missing<'a>(shown: &'a [String], output: &str) -> Vec<&'a str> {
    let mut lines = output.lines();
    let is_text = |line: &&String| !line.is_empty() && line.trim() != ELLIPSIS;
    shown.iter().filter(is_text).filter(|line| !lines.any(|real| is_in(line, real))).map(String::as_str).collect()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let (path, target) = (entry.as_ref().unwrap().path(), to.join(entry.unwrap().file_name()));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

/// Runs every command of a page that is not excluded; how many there were.
fn follow(page: &str, name: &str) -> usize {
    let folder = Folder::new(name);
    copy(&workspace().join("deploy"), &folder.path().join("deploy"));
    let program = Path::new(env!("CARGO_BIN_EXE_obsid")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let steps: Vec<Step> = steps(page).into_iter().filter(|step| !EXCLUDED.contains(&step.command.as_str())).collect();
    for Step { command, shown } in &steps {
        let first = command.split_whitespace().next().unwrap_or_default();
        assert!(PROGRAMS.contains(&first), "`{command}` is neither run nor excluded");
        let output = Command::new("sh")
            .args(["-c", command])
            .current_dir(folder.path())
            .env("PATH", &path)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).join("\n");
        assert!(output.status.success(), "`{command}`: {}\n{text}", output.status);
        let missing = missing(shown, &text);
        assert!(missing.is_empty(), "`{command}` does not print\n{}\nbut\n{text}", missing.join("\n"));
    }
    steps.len()
}

fn page(path: &str) -> String {
    std::fs::read_to_string(workspace().join(path)).unwrap()
}

#[test]
fn every_command_of_the_readme_runs_and_prints_what_is_shown() {
    let readme = page("README.md");
    assert!(readme.lines().count() <= 150, "{} lines", readme.lines().count());
    for command in EXCLUDED {
        assert!(steps(&readme).iter().any(|step| step.command == command), "`{command}` is not in the README");
    }
    let run = follow(&readme, "readme");
    assert!(run > 10, "{run} commands");
}

#[test]
fn every_command_of_the_examples_runs_and_gives_the_files_again() {
    let run = follow(&page("deploy/examples/README.md"), "readme-examples");
    assert!(run >= 6, "{run} commands");
}

#[test]
fn commands_output_and_omissions_are_told_apart() {
    let page = "$ no\n```console\n$ obsid a \\\n    --b  # why\none … three\n…\nlast\n$ obsid c\n```\n```sh\n# remark\ncargo run --release -- run  # x\n```\n";
    let step = |command: &str, shown: &[&str]| Step {
        command: command.to_owned(),
        shown: shown.iter().map(|line| (*line).to_owned()).collect(),
    };
    let found = steps(page);
    assert_eq!(
        found,
        [step("obsid a --b", &["one … three", "…", "last"]), step("obsid c", &[]), step("obsid run", &[])]
    );
    assert!(missing(&found[0].shown, "zero\n one two three\nx\nlast\n").is_empty());
    assert_eq!(missing(&found[0].shown, "one three two\nfirst\n"), ["last"]);
    assert_eq!(missing(&found[0].shown, "three one\nlast\n"), ["one … three", "last"]);
}
