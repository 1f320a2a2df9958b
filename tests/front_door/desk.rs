//! The program at work, and the folder a test works in.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Root of the workspace.
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scenario of `deploy/scenarios`.
pub fn scenario(name: &str) -> String {
    workspace().join("deploy/scenarios").join(name).display().to_string()
}

/// A command of the program, without a terminal.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_obsid"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// What the program answered.
pub struct Answer {
    pub arguments: String,
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs the program in `folder`.
pub fn ask_in(folder: &Path, arguments: &[&str]) -> Answer {
    let output = command(arguments).current_dir(folder).output().unwrap();
    let answer = Answer {
        arguments: arguments.join(" "),
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    };
    assert!(!answer.stderr.contains("panicked"), "{answer}");
    answer
}

/// Runs the program.
pub fn ask(arguments: &[&str]) -> Answer {
    ask_in(workspace(), arguments)
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "obsid {}\nexit {:?}\n{}\n{}", self.arguments, self.code, self.stdout, self.stderr)
    }
}

impl Answer {
    /// The exit code is the one expected.
    pub fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self}");
        self
    }

    /// Standard error holds every one of `texts`.
    pub fn says(self, texts: &[&str]) -> Self {
        for text in texts {
            assert!(self.stderr.contains(text), "`{text}` is not said by {self}");
        }
        self
    }

    /// Refused as bad input: exit 3, nothing on standard output, `texts` and a cure on standard
    /// error.
    pub fn refuses(self, texts: &[&str]) {
        let answer = self.ends_with(3).says(texts);
        assert!(answer.stdout.is_empty(), "{answer}");
        assert!(answer.stderr.contains("help: "), "no cure: {answer}");
    }

    /// Standard output is one JSON object and nothing else.
    pub fn object(&self) -> Value {
        let value: Value = serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self}"));
        assert!(value.is_object(), "{self}");
        value
    }

    /// The object of a run that was carried out.
    pub fn result(self) -> Value {
        self.ends_with(0).object()
    }
}

/// Says that a test was skipped, past the test harness, which keeps what a passing test prints.
pub fn skipped(why: &str) {
    use std::io::Write;
    std::io::stderr().write_all(format!("front_door: skipped: {why}\n").as_bytes()).unwrap();
}

/// Rows of one domain.
pub fn estimates<'a>(result: &'a Value, domain: &str) -> &'a [Value] {
    result["estimates"][domain].as_array().unwrap()
}

/// The number under `key`.
pub fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("`{key}` is no number in {row}"))
}

/// A folder of a test's own, removed with it.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("front-door-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file and gives its name within the folder.
    pub fn file<'a>(&self, name: &'a str, bytes: impl AsRef<[u8]>) -> &'a str {
        std::fs::write(self.0.join(name), bytes).unwrap();
        name
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.join(name)).unwrap()
    }

    pub fn ask(&self, arguments: &[&str]) -> Answer {
        ask_in(&self.0, arguments)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
