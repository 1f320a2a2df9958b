//! What holds of obsid as it is deployed: real sensors attached, partitions hardened, images and
//! units complete.
#![forbid(unsafe_code)]

mod gateway;
mod hardening;
mod images;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Root of the workspace.
fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A scenario of `deploy/scenarios`.
fn scenario(name: &str) -> String {
    workspace().join("deploy/scenarios").join(name).display().to_string()
}

/// No partition is taken for hung while a busy computer starves it: hangs are not the point here.
const PATIENT: [&str; 2] = ["--hang-ms", "60000"];

/// A test's own folder outside `/dev/shm`, in which partitions can be kept out of each other's
/// folders; its path is short, for sockets lie in it.
struct Place(PathBuf);

impl Place {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("deployed-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let place = Place(std::env::temp_dir().join(name));
        std::fs::create_dir(&place.0).unwrap();
        place
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    /// The program with its runs in this folder.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_obsid"));
        command.env("OBSID_ROOT", &self.0).current_dir(&self.0);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments).spawn().unwrap()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The object on standard output of a program that ended with `code`.
fn object(output: &Output, code: i32) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {said}"))
}
