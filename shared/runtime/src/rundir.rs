//! The folder of a run: on tmpfs, private, gone when the run is over.
//!
//! `<parent>/obsid-<pid>-<n>/` holds the run's configuration, iceoryx2's root, checkpoints and
//! statistics; the folder's name is also the iceoryx2 prefix of its files in `/dev/shm`. A lock
//! tells a living run from debris.

use crate::config::RunConfig;
use rustix::fs::{FlockOperation, flock};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;
use telemetry::PartitionId;

const NAME: &str = "obsid-";
/// Where iceoryx2 has its segments: one folder for all runs of a computer.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// `sun_path` of `sockaddr_un` without its final zero \[bytes\].
const SOCKET_PATH_MAX: usize = 107;
/// Number of this process's next run. `/dev/shm` is one for all parents, so that a number is given
/// once in a process and not once in a parent.
static NEXT_NUMBER: AtomicU32 = AtomicU32::new(0);

/// Paths inside a run's folder.
#[derive(Clone, Debug)]
pub struct RunDir(PathBuf);

impl RunDir {
    /// Names the folder; touches no file.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        RunDir(path.to_path_buf())
    }
    /// The folder itself.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
    /// iceoryx2 prefix of this run.
    #[must_use]
    pub fn prefix(&self) -> String {
        let name = self.0.file_name().unwrap_or_default().to_string_lossy();
        format!("{name}_")
    }
    /// Folder of iceoryx2's service and node files.
    #[must_use]
    pub fn iceoryx_root(&self) -> PathBuf {
        self.0.join("iox")
    }
    /// Folder of `partition` alone: its checkpoints and figures.
    #[must_use]
    pub fn own(&self, partition: PartitionId) -> PathBuf {
        self.0.join(partition.text())
    }
    /// The [`RunConfig`] as JSON.
    #[must_use]
    pub fn config(&self) -> PathBuf {
        self.0.join("run.json")
    }
    /// Exists once all services exist.
    #[must_use]
    pub fn ready(&self) -> PathBuf {
        self.0.join("ready")
    }
    /// Figures of `partition` as JSON, rewritten while it runs.
    #[must_use]
    pub fn statistics(&self, partition: PartitionId) -> PathBuf {
        self.own(partition).join("stats.json")
    }

    /// Newest events of `partition`: a ring, see [`crate::events`].
    #[must_use]
    pub fn events(&self, partition: PartitionId) -> PathBuf {
        self.own(partition).join("events")
    }
    /// Tables of `partition` as JSON, rewritten when one changes.
    #[must_use]
    pub fn tables(&self, partition: PartitionId) -> PathBuf {
        self.own(partition).join("tables.json")
    }
    /// Socket that takes commands.
    #[must_use]
    pub fn ground(&self) -> PathBuf {
        self.own(PartitionId::Supervisor).join("ground")
    }

    /// The warden's reports, one JSON object a line.
    #[must_use]
    pub fn log(&self) -> PathBuf {
        self.0.join("log.jsonl")
    }
    /// The newest frame and mode, as the supervisor reported them.
    #[must_use]
    pub fn status(&self) -> PathBuf {
        self.0.join("status.json")
    }

    /// Sockets lie in iceoryx2's root: `<prefix><up to 31 digits>.event`.
    fn check_length(&self) -> io::Result<()> {
        let bytes = self.iceoryx_root().as_os_str().len() + 1 + self.prefix().len() + 31 + ".event".len();
        if bytes <= SOCKET_PATH_MAX {
            return Ok(());
        }
        let (path, excess) = (self.0.display(), bytes - SOCKET_PATH_MAX);
        Err(io::Error::other(format!("{path}: {excess} bytes too long for the sockets in it; choose a shorter root")))
    }

    /// Removes every service of the run, whole or half-made; configuration and checkpoints stay.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn clear_services(&self) -> io::Result<()> {
        remove_shared_memory(self);
        if self.ready().exists() {
            fs::remove_file(self.ready())?;
        }
        fs::remove_dir_all(self.iceoryx_root())?;
        fs::create_dir(self.iceoryx_root())
    }

    /// Reads the run's configuration.
    ///
    /// # Errors
    /// When the file is missing or of another build.
    pub fn load(&self) -> io::Result<RunConfig> {
        let text = fs::read_to_string(self.config())?;
        serde_json::from_str(&text).map_err(|error| io::Error::other(format!("{}: {error}", self.config().display())))
    }
}

/// A run's folder as its warden holds it: locked, and removed with everything in shared memory on
/// drop.
#[derive(Debug)]
pub struct OwnedRunDir {
    dir: RunDir,
    _lock: File,
}

impl OwnedRunDir {
    /// Makes the folder under `parent` and writes `run` into it.
    ///
    /// # Errors
    /// When a file or folder cannot be made, locked or written, or its path is too long for the
    /// sockets in it.
    pub fn create(parent: &Path, run: &RunConfig) -> io::Result<Self> {
        let path = make_folder(parent, std::iter::repeat_with(|| NEXT_NUMBER.fetch_add(1, Ordering::Relaxed)));
        let path =
            path.ok_or_else(|| io::Error::other(format!("{}: cannot make a folder for the run", parent.display())))?;
        let dir = RunDir(path);
        if let Err(error) = dir.check_length() {
            let _ = fs::remove_dir(&dir.0);
            return Err(error);
        }
        OwnedRunDir::furnish(dir, run)
    }

    /// Makes the folder at `path`, in the place of one whose keeper is dead, and writes `run` into
    /// it.
    ///
    /// # Errors
    /// As [`OwnedRunDir::create`]; when a living run has the folder, or the folder is none of a
    /// run.
    pub fn create_at(path: &Path, run: &RunConfig) -> io::Result<Self> {
        let dir = RunDir(std::path::absolute(path)?);
        dir.check_length()?;
        if dir.path().exists() {
            if is_alive(dir.path()) {
                return Err(io::Error::other(format!("{}: a run lives there", dir.path().display())));
            }
            if !dir.config().exists() {
                return Err(io::Error::other(format!("{}: not the folder of a run", dir.path().display())));
            }
            remove_all(&dir);
        }
        make_private(dir.path())?;
        OwnedRunDir::furnish(dir, run)
    }

    fn furnish(dir: RunDir, run: &RunConfig) -> io::Result<Self> {
        let lock = File::create(dir.path().join("lock"))?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        let owned = OwnedRunDir { dir, _lock: lock };
        fs::create_dir(owned.dir.iceoryx_root())?;
        PartitionId::ALL.iter().try_for_each(|&id| fs::create_dir(owned.dir.own(id)))?;
        let text = serde_json::to_string(run).map_err(io::Error::other)?;
        fs::write(owned.dir.config(), text)?;
        Ok(owned)
    }

    /// Paths inside the folder; they are void once `self` is dropped.
    #[must_use]
    pub fn dir(&self) -> &RunDir {
        &self.dir
    }

    /// Removes files of the run in shared memory that have stayed empty for `age`: their maker died
    /// between making and sizing them, and whoever opens one to clean up after the dead waits for
    /// ever (iceoryx2 0.10, seen once in some 50 runs with several young kills). A living maker
    /// leaves a file empty for microseconds.
    pub fn remove_stillborn(&self, age: Duration) {
        for entry in shared_memory(&self.dir) {
            let Ok(file) = entry.metadata() else { continue };
            let old = file.modified().is_ok_and(|made| made.elapsed().is_ok_and(|elapsed| elapsed >= age));
            if file.len() == 0 && old {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

impl Drop for OwnedRunDir {
    fn drop(&mut self) {
        remove_all(&self.dir);
    }
}

/// Makes the first folder of `numbers` under `parent` that is free and whose prefix is free: a dead
/// process of the same number may have left files in shared memory from under another parent.
fn make_folder(parent: &Path, numbers: impl Iterator<Item = u32>) -> Option<PathBuf> {
    let pid = std::process::id();
    let paths = numbers.take(1000).map(|number| parent.join(format!("{NAME}{pid}-{number}")));
    let mut free = paths.filter(|path| shared_memory(&RunDir::at(path)).next().is_none());
    free.find(|path| make_private(path).is_ok())
}

/// A folder that only its owner can enter.
fn make_private(path: &Path) -> io::Result<()> {
    fs::DirBuilder::new().mode(0o700).create(path)
}

fn remove_all(dir: &RunDir) {
    remove_shared_memory(dir);
    let _ = fs::remove_dir_all(dir.path());
}

fn remove_shared_memory(dir: &RunDir) {
    for entry in shared_memory(dir) {
        let _ = fs::remove_file(entry.path());
    }
}

/// The run's files in shared memory.
fn shared_memory(dir: &RunDir) -> impl Iterator<Item = fs::DirEntry> + use<> {
    let prefix = dir.prefix();
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    entries.filter(move |entry| entry.file_name().to_string_lossy().starts_with(&prefix))
}

/// Removes what killed wardens left under `parent`: folders whose maker is dead and whose lock is
/// free.
pub fn purge_debris(parent: &Path) -> usize {
    let mut purged = 0;
    for entry in fs::read_dir(parent).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(pid) = name.strip_prefix(NAME).and_then(|rest| rest.split('-').next()) else { continue };
        // The lock tells; a number of a process may have been given to another since. Without a
        // lock file yet, the maker.
        let debris = match File::open(entry.path().join("lock")) {
            Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok(),
            Err(_) => !Path::new("/proc").join(pid).exists(),
        };
        if entry.path().is_dir() && debris {
            remove_all(&RunDir(entry.path()));
            purged += 1;
        }
    }
    purged
}

/// Whether `folder` is one of a run whose warden lives.
#[must_use]
pub fn is_alive(folder: &Path) -> bool {
    let lock = File::open(folder.join("lock"));
    folder.join("run.json").exists()
        && lock.is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockShared).is_err())
}

/// The folder of the newest living run below `root`.
#[must_use]
pub fn living(root: &Path) -> Option<PathBuf> {
    let folders = fs::read_dir(root).ok()?.flatten().map(|entry| entry.path());
    let made = |path: &PathBuf| fs::metadata(path.join("run.json")).and_then(|file| file.modified()).ok();
    folders.filter(|path| is_alive(path)).max_by_key(made)
}

#[cfg(test)]
mod tests {
    use super::{OwnedRunDir, RunDir, SHARED_MEMORY, purge_debris};
    use crate::config::tests::toy_run;
    use rustix::fs::{FlockOperation, flock};
    use std::fs::{self, File};
    use std::path::{Path, PathBuf};
    use telemetry::PartitionId;

    /// A folder for runs that is gone when the test is.
    struct Parent(PathBuf);

    impl Parent {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("rundir-{test}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Parent(path)
        }
    }

    impl Drop for Parent {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    /// The number of a process that is dead and buried.
    fn dead_pid() -> u32 {
        let mut child = std::process::Command::new("true").spawn().unwrap();
        child.wait().unwrap();
        child.id()
    }

    /// A run's folder as a killed warden leaves it, and a file of it in shared memory.
    fn debris(parent: &Path, pid: u32, number: u32) -> (RunDir, PathBuf) {
        let dir = RunDir::at(&parent.join(format!("obsid-{pid}-{number}")));
        fs::create_dir_all(dir.iceoryx_root()).unwrap();
        File::create(dir.path().join("lock")).unwrap();
        let shared = Path::new(SHARED_MEMORY).join(format!("{}leftover", dir.prefix()));
        fs::write(&shared, "16 bytes of junk").unwrap();
        (dir, shared)
    }

    #[test]
    fn a_dead_run_is_purged_with_its_shared_memory_and_a_living_one_is_not() {
        let parent = Parent::new("purge");
        let (dead, dead_shared) = debris(&parent.0, dead_pid(), 0);
        let living = OwnedRunDir::create(&parent.0, &toy_run()).unwrap();
        let living_shared = Path::new(SHARED_MEMORY).join(format!("{}in_use", living.dir().prefix()));
        fs::write(&living_shared, "").unwrap();
        assert_eq!(purge_debris(&parent.0), 1);
        assert!(!dead.path().exists() && !dead_shared.exists());
        assert!(living.dir().config().exists() && living_shared.exists());
        let folder = living.dir().path().to_path_buf();
        drop(living);
        assert!(!folder.exists() && !living_shared.exists(), "a run that ends leaves nothing");
    }

    #[test]
    fn a_folder_whose_lock_is_held_is_not_purged_although_its_maker_is_gone() {
        let parent = Parent::new("locked");
        let (dir, shared) = debris(&parent.0, dead_pid(), 0);
        let lock = File::open(dir.path().join("lock")).unwrap();
        flock(&lock, FlockOperation::NonBlockingLockExclusive).unwrap();
        assert_eq!(purge_debris(&parent.0), 0);
        drop(lock);
        assert_eq!(purge_debris(&parent.0), 1);
        assert!(!shared.exists());
    }

    #[test]
    fn the_end_of_a_run_does_not_touch_a_run_whose_number_begins_alike() {
        let parent = Parent::new("alike");
        let pid = dead_pid();
        let (one, one_shared) = debris(&parent.0, pid, 1);
        let (_eleven, eleven_shared) = debris(&parent.0, pid, 11);
        super::remove_all(&one);
        assert!(!one_shared.exists() && eleven_shared.exists());
        assert_eq!(purge_debris(&parent.0), 1);
        assert!(!eleven_shared.exists());
    }

    #[test]
    fn what_is_no_folder_of_a_run_is_left_alone() {
        let parent = Parent::new("foreign");
        let pid = dead_pid();
        for folder in ["other".to_string(), "obsid-".into(), format!("myobsid-{pid}-0")] {
            fs::create_dir(parent.0.join(folder)).unwrap();
        }
        fs::write(parent.0.join(format!("obsid-{pid}-7")), "a file").unwrap();
        purge_debris(&parent.0);
        assert_eq!(fs::read_dir(&parent.0).unwrap().count(), 4);
    }

    #[test]
    fn two_runs_of_one_process_have_their_own_folders_and_their_configuration_is_read_back() {
        let parent = Parent::new("two");
        let [one, two] = [1, 2].map(|seed| {
            let mut run = toy_run();
            run.seed = seed;
            OwnedRunDir::create(&parent.0, &run).unwrap()
        });
        assert_ne!(one.dir().path(), two.dir().path());
        assert_eq!([one.dir(), two.dir()].map(|dir| dir.load().unwrap().seed), [1, 2]);
    }

    #[test]
    fn the_end_of_a_run_leaves_the_shared_memory_of_a_run_under_another_parent() {
        let parents = ["here", "there"].map(Parent::new);
        let [one, two] = [&parents[0], &parents[1]].map(|parent| OwnedRunDir::create(&parent.0, &toy_run()).unwrap());
        let shared = Path::new(SHARED_MEMORY).join(format!("{}in_use", two.dir().prefix()));
        fs::write(&shared, "").unwrap();
        drop(one);
        assert!(shared.exists());
    }

    #[test]
    fn a_run_takes_no_prefix_under_which_a_dead_run_of_another_parent_left_files() {
        let parent = Parent::new("recycled");
        let pid = std::process::id();
        let left = Path::new(SHARED_MEMORY).join(format!("obsid-{pid}-900000_leftover"));
        fs::write(&left, "").unwrap();
        let taken = super::make_folder(&parent.0, 900_000..).unwrap();
        fs::remove_file(left).unwrap();
        assert_eq!(taken, parent.0.join(format!("obsid-{pid}-900001")));
        assert_eq!(super::make_folder(&parent.0, 900_001..).unwrap(), parent.0.join(format!("obsid-{pid}-900002")));
    }

    #[test]
    fn a_place_too_deep_for_sockets_is_refused_before_the_run_and_by_how_much_is_said() {
        let name = "obsid-12345-0";
        let bytes_after_parent = "/obsid-12345-0/iox/obsid-12345-0_".len() + 31 + ".event".len();
        let check = |excess: usize| {
            let parent = format!("/{}", "d".repeat(super::SOCKET_PATH_MAX + excess - bytes_after_parent - 1));
            RunDir::at(&Path::new(&parent).join(name)).check_length().map_err(|error| error.to_string())
        };
        assert_eq!(check(0), Ok(()));
        let refusal = check(1).unwrap_err();
        assert!(refusal.contains("1 bytes too long") && refusal.contains("/ddd"), "{refusal}");
        // A run that is refused leaves no folder.
        let parent = Parent::new("deep");
        let deep = parent.0.join("d".repeat(super::SOCKET_PATH_MAX));
        fs::create_dir(&deep).unwrap();
        assert!(OwnedRunDir::create(&deep, &toy_run()).is_err());
        assert_eq!(fs::read_dir(&deep).unwrap().count(), 0);
    }

    #[test]
    fn what_a_maker_left_empty_is_removed_once_it_is_old_and_nothing_else() {
        let parent = Parent::new("stillborn");
        let owned = OwnedRunDir::create(&parent.0, &toy_run()).unwrap();
        let file = |name: &str| Path::new(SHARED_MEMORY).join(format!("{}{name}", owned.dir().prefix()));
        fs::write(file("empty"), "").unwrap();
        fs::write(file("sized"), "16 bytes of data").unwrap();
        owned.remove_stillborn(std::time::Duration::from_secs(3600));
        assert!(file("empty").exists() && file("sized").exists());
        owned.remove_stillborn(std::time::Duration::ZERO);
        assert!(!file("empty").exists() && file("sized").exists());
    }

    #[test]
    fn services_are_cleared_and_what_carries_a_run_over_stays() {
        let parent = Parent::new("clear");
        let owned = OwnedRunDir::create(&parent.0, &toy_run()).unwrap();
        let dir = owned.dir();
        let shared = Path::new(SHARED_MEMORY).join(format!("{}half_made", dir.prefix()));
        let (service, checkpoint) =
            (dir.iceoryx_root().join("service"), dir.own(PartitionId::SloshId).join("slosh-id.0"));
        for file in [&shared, &service, &checkpoint, &dir.ready()] {
            fs::write(file, "").unwrap();
        }
        owned.dir().clear_services().unwrap();
        let there = [&shared, &service, &dir.ready(), &checkpoint, &dir.config()].map(|file| file.exists());
        assert_eq!(there, [false, false, false, true, true]);
        owned.dir().clear_services().unwrap();
    }

    #[test]
    fn a_configuration_of_another_build_is_an_error_that_names_the_file() {
        let parent = Parent::new("other-build");
        let owned = OwnedRunDir::create(&parent.0, &toy_run()).unwrap();
        fs::write(owned.dir().config(), "{}").unwrap();
        let text = owned.dir().load().unwrap_err().to_string();
        assert!(text.contains("run.json") && text.contains("missing field"), "{text}");
    }
}
