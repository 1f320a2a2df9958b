//! Temporary files of a run, and the recording that `--record` keeps.
//!
//! Scratch lies in `<root>/obsid-<pid>-console/`, private and beside the runs' own folders, so that
//! whoever starts next removes what a killed console left. Console and warden share the folder's
//! lock: what one of them still writes to is not debris.

use crate::Failure;
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, getppid};
use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const VARIABLE: &str = "OBSID_ROOT";
const DEFAULT_ROOT: &str = "/dev/shm";
const LOCK: &str = "lock";
const CONFIG: &str = "config.json";
/// Folders of one process at one time; more are debris of processes that had its number before.
const FOLDERS_MAX: u32 = 100;

/// A console's folder, removed on drop.
pub struct Scratch {
    root: PathBuf,
    folder: PathBuf,
    /// Shared with the warden: the folder is debris when neither holds it.
    _lock: File,
}

impl Scratch {
    /// Makes the folder where runs make theirs: whether that can be done is found out before
    /// anything is started.
    ///
    /// # Errors
    /// [`Failure::Input`] when there is no such place or nothing may be written to it.
    pub fn new() -> Result<Self, Failure> {
        let asked = std::env::var_os(VARIABLE).filter(|value| !value.is_empty());
        Scratch::at(&asked.map_or_else(|| PathBuf::from(DEFAULT_ROOT), PathBuf::from))
    }

    /// As [`Scratch::new`], below `root`.
    ///
    /// # Errors
    /// [`Failure::Input`] when nothing may be written there.
    pub fn at(root: &Path) -> Result<Self, Failure> {
        let make = || -> std::io::Result<Self> {
            let root = std::path::absolute(root)?;
            let folder = make_folder(&root)?;
            let lock = File::create_new(folder.join(LOCK))?;
            flock(&lock, FlockOperation::NonBlockingLockShared)?;
            Ok(Scratch { root, folder, _lock: lock })
        };
        make().map_err(|error| {
            Failure::Input(miette::miette!(
                help = "set OBSID_ROOT to an existing folder in memory (tmpfs) that may be written to; without it runs \
                        make their folders in /dev/shm",
                "{VARIABLE}: {}: no run can make its folder there: {error}",
                root.display()
            ))
        })
    }

    /// A file of this process's own, gone with the scratch folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Where runs make their folders.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Leaves the run's configuration for the warden, which removes it when it has read it.
    ///
    /// # Errors
    /// When the file system denies it.
    pub fn leave_config(&self, run: &runtime::RunConfig) -> std::io::Result<PathBuf> {
        let path = self.folder.join(CONFIG);
        File::create_new(&path)?.write_all(serde_json::to_string(run).map_err(std::io::Error::other)?.as_bytes())?;
        Ok(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A folder that did not exist, readable by this user alone.
fn make_folder(root: &Path) -> std::io::Result<PathBuf> {
    let pid = std::process::id();
    for number in 0..FOLDERS_MAX {
        let name = if number == 0 { format!("obsid-{pid}-console") } else { format!("obsid-{pid}-console-{number}") };
        let folder = root.join(name);
        match DirBuilder::new().mode(0o700).create(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(std::io::Error::from(ErrorKind::AlreadyExists))
}

/// The warden's hold on the scratch folder of the console that started it.
pub struct Held {
    folder: PathBuf,
    _lock: File,
    console: Option<Pid>,
}

impl Held {
    /// Takes over the folder in which `config` was left and removes `config`; a file that its user
    /// wrote stays.
    #[must_use]
    pub fn of_config(config: &Path) -> Option<Self> {
        let folder = config.parent()?;
        let lock = File::open(folder.join(LOCK)).ok().filter(|_| config.ends_with(CONFIG))?;
        flock(&lock, FlockOperation::NonBlockingLockShared).ok()?;
        std::fs::remove_file(config).ok()?;
        Some(Held { folder: folder.into(), _lock: lock, console: getppid() })
    }
}

impl Drop for Held {
    /// A console that is gone does not remove its folder.
    fn drop(&mut self) {
        if getppid() != self.console {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// Where the results of a run go.
pub struct ResultsFile {
    path: PathBuf,
    /// A file of the user's that did not exist before: it goes again when nothing was recorded.
    made: bool,
    /// Before the run.
    before: Option<Mark>,
}

/// Length and time of the last write: what tells a file of an earlier run from one of this run.
type Mark = (u64, SystemTime);

fn mark(path: &Path) -> Option<Mark> {
    let file = std::fs::metadata(path).ok()?;
    Some((file.len(), file.modified().ok()?))
}

impl ResultsFile {
    /// The file the user asked for, or one of our own; whether it can be written is found out
    /// before the run.
    ///
    /// # Errors
    /// [`Failure::Input`] when it cannot.
    pub fn new(asked: Option<&Path>, scratch: &Scratch) -> Result<Self, Failure> {
        let Some(path) = asked else {
            return Ok(ResultsFile { path: scratch.folder.join("results.mcap"), made: false, before: None });
        };
        // Nothing is cut here: a file of an earlier run stands until the new run begins.
        let made = match File::create_new(path) {
            Ok(_) => Ok(true),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                OpenOptions::new().append(true).open(path).map(|_| false)
            }
            Err(error) => Err(error),
        };
        let made = made.map_err(|error| {
            Failure::Input(miette::miette!(
                help = "--record takes the path of a file, in a folder that exists and may be written to",
                "{}: cannot be written: {error}",
                path.display()
            ))
        })?;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        Ok(ResultsFile { before: mark(&path), path, made })
    }

    /// Where the file lies until it is kept or removed.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The run began to record.
    pub fn is_written(&self) -> bool {
        mark(&self.path) != self.before
    }
}

impl Drop for ResultsFile {
    fn drop(&mut self) {
        if self.made && !self.is_written() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
