//! What recordings may take of a disk: size of one, number, size and age of older ones.
//!
//! A recording that fills up leaves topics out, the least important first, never a result. Older
//! recordings are kept beside a new one under the time at which they ended, and the oldest are
//! removed.

use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use telemetry::{TOPICS, TopicId, is_result, topic_named};

const MB: f64 = 1e6;
const S_PER_DAY: f64 = 86_400.0;

/// The table `[recording]` of the table of limits; without a key there is no such limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingLimits {
    /// Of the recording of one run \[MB\]: at this size it takes results alone.
    pub size_mb: Option<f64>,
    /// Groups of topics that are left out one after the other from half of that size on.
    #[serde(default)]
    pub least_first: Vec<Vec<String>>,
    /// What is kept of earlier runs; without it a recording replaces the one before.
    pub older: Option<OlderRecordings>,
}

/// Recordings of earlier runs under the same name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OlderRecordings {
    /// How many.
    pub files_max: Option<usize>,
    /// All of them together \[MB\].
    pub total_mb: Option<f64>,
    /// Since they ended \[days\].
    pub age_days: Option<f64>,
}

/// Older recordings that a new one has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RemovedRecordings {
    /// Files.
    pub files: u64,
    /// Their size together \[B\].
    pub bytes: u64,
}

impl RecordingLimits {
    /// Why they cannot be used.
    ///
    /// # Errors
    /// Names key, value and cure.
    pub fn check(&self) -> Result<(), String> {
        let older = self.older.clone().unwrap_or_default();
        let sizes = [("size_mb", self.size_mb), ("older.total_mb", older.total_mb), ("older.age_days", older.age_days)];
        for (name, value) in sizes {
            if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
                return Err(format!("[recording] {name} = {}: must be above 0", value.unwrap_or(f64::NAN)));
            }
        }
        if self.size_mb.is_none() && !self.least_first.is_empty() {
            return Err("[recording] least_first: says what is left out at size_mb, which is missing".into());
        }
        for name in self.least_first.iter().flatten() {
            match topic_named(name) {
                None => return Err(format!("[recording] least_first: no topic '{name}'; `obsid icd` lists them")),
                Some(topic) if is_result(topic) => {
                    return Err(format!("[recording] least_first: '{name}' is a result, which is never left out"));
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// How many steps of leaving out a recording of `bytes` has come to: step i of the n groups at
    /// `size (1 + i / n) / 2`, and at the whole size one more.
    #[must_use]
    pub fn step(&self, bytes: u64) -> usize {
        let Some(size_mb) = self.size_mb else { return 0 };
        let (fill, groups) = (bytes as f64 / (size_mb * MB), self.least_first.len());
        let reached = |step: usize| fill >= 0.5 * (1.0 + step as f64 / groups as f64);
        (0..groups).filter(|step| reached(*step)).count() + usize::from(fill >= 1.0)
    }

    /// Topics that step `step` leaves out.
    pub fn left_out(&self, step: usize) -> impl Iterator<Item = TopicId> + '_ {
        let is_full = step > self.least_first.len();
        let named = self.least_first.iter().take(step).flatten();
        let named: Vec<TopicId> = named.filter_map(|name| topic_named(name)).collect();
        (0..TOPICS.len()).filter(move |topic| !is_result(*topic) && (is_full || named.contains(topic)))
    }
}

/// Puts what lies at `path` among the older recordings (`flight.1795912345.mcap`, the time \[s\] at
/// which it was last written), and removes the oldest ones, as `limits` say at `now_s`.
///
/// # Errors
/// The file system's.
pub fn make_room(path: &Path, limits: &OlderRecordings, now_s: u64) -> io::Result<RemovedRecordings> {
    if path.exists() {
        let mut ended_s = age_of(path)?;
        while aside(path, ended_s).exists() {
            ended_s += 1;
        }
        fs::rename(path, aside(path, ended_s))?;
    }
    let mut older = older_than(path)?;
    // The newest first.
    older.sort_unstable_by(|a, b| b.cmp(a));
    let (mut total, mut removed) = (0_u64, RemovedRecordings::default());
    for (place, (ended_s, bytes, file)) in older.into_iter().enumerate() {
        total += bytes;
        let is_too_old = limits.age_days.is_some_and(|days| now_s.saturating_sub(ended_s) as f64 > days * S_PER_DAY);
        let is_too_much = limits.total_mb.is_some_and(|total_mb| total as f64 > total_mb * MB);
        if is_too_old || is_too_much || limits.files_max.is_some_and(|most| place >= most) {
            fs::remove_file(&file)?;
            removed.files += 1;
            removed.bytes += bytes;
        }
    }
    Ok(removed)
}

fn age_of(path: &Path) -> io::Result<u64> {
    let modified = fs::metadata(path)?.modified()?;
    Ok(modified.duration_since(std::time::UNIX_EPOCH).map_or(0, |since| since.as_secs()))
}

fn parts(path: &Path) -> (String, String) {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    (text(path.file_stem()), text(path.extension()))
}

fn aside(path: &Path, ended_s: u64) -> PathBuf {
    let (stem, extension) = parts(path);
    path.with_file_name(format!("{stem}.{ended_s}.{extension}"))
}

/// Time, size and path of every older recording of this name.
fn older_than(path: &Path) -> io::Result<Vec<(u64, u64, PathBuf)>> {
    let (stem, extension) = parts(path);
    let mut found = Vec::new();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let middle =
            name.strip_prefix(&format!("{stem}.")).and_then(|rest| rest.strip_suffix(&format!(".{extension}")));
        if let Some(ended_s) = middle.and_then(|middle| middle.parse().ok()) {
            found.push((ended_s, entry.metadata()?.len(), entry.path()));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use telemetry::{ACCELEROMETERS, IMU, TICK};

    fn limits() -> RecordingLimits {
        let groups = [&["accelerometers", "craft"][..], &["imu"]];
        let least_first = groups.map(|group| group.iter().map(|name| (*name).to_string()).collect()).to_vec();
        RecordingLimits { size_mb: Some(100.0), least_first, older: None }
    }

    #[test]
    fn a_recording_that_fills_up_leaves_out_the_least_important_first_and_never_a_result() {
        let limits = limits();
        let steps = [0, 49, 50, 74, 75, 99, 100, 500].map(|mb| limits.step(mb * 1_000_000));
        assert_eq!(steps, [0, 0, 1, 1, 2, 2, 3, 3]);
        let left_out = |step| limits.left_out(step).collect::<Vec<_>>();
        assert!(left_out(0).is_empty());
        assert!(left_out(1).contains(&ACCELEROMETERS.id) && !left_out(1).contains(&IMU.id));
        assert!(left_out(2).contains(&IMU.id) && !left_out(2).contains(&TICK.id));
        assert!(left_out(3).contains(&TICK.id));
        assert!((0..=3).all(|step| left_out(step).into_iter().all(|topic| !is_result(topic))));
        assert_eq!(RecordingLimits::default().step(u64::MAX), 0);
    }

    #[test]
    fn limits_that_cannot_be_meant_are_refused_with_their_key() {
        assert_eq!(limits().check(), Ok(()));
        let named =
            |name: &str| RecordingLimits { least_first: vec![vec![name.into()]], ..limits() }.check().unwrap_err();
        assert!(named("imus").contains("'imus'") && named("verdict").contains("result"));
        assert!(RecordingLimits { size_mb: None, ..limits() }.check().unwrap_err().contains("size_mb"));
        assert!(RecordingLimits { size_mb: Some(-1.0), ..limits() }.check().unwrap_err().contains("-1"));
    }

    /// Files of a folder that is gone with the test, in the order of their names.
    struct Shelf(PathBuf);

    impl Shelf {
        fn new(name: &str, ended_s: &[u64]) -> Self {
            let folder = std::env::temp_dir().join(format!("obsid-shelf-{name}-{}", std::process::id()));
            fs::create_dir_all(&folder).unwrap();
            for ended_s in ended_s {
                fs::write(folder.join(format!("flight.{ended_s}.mcap")), [0; 1000]).unwrap();
            }
            fs::write(folder.join("other.5.mcap"), "of somebody else").unwrap();
            Shelf(folder)
        }

        fn names(&self) -> Vec<String> {
            let entries = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
            let mut names: Vec<String> = entries.collect();
            names.sort();
            names
        }
    }

    impl Drop for Shelf {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn the_oldest_recordings_go_by_number_size_and_age_and_no_other_file_does() {
        let kept = ["flight.300.mcap", "flight.400.mcap", "other.5.mcap"];
        let none = OlderRecordings::default();
        for (name, limits) in [
            ("files", OlderRecordings { files_max: Some(2), ..none.clone() }),
            ("total", OlderRecordings { total_mb: Some(0.0025), ..none.clone() }),
            ("age", OlderRecordings { age_days: Some(1.0), ..none.clone() }),
        ] {
            let shelf = Shelf::new(name, &[100, 200, 300, 400]);
            let removed = make_room(&shelf.0.join("flight.mcap"), &limits, 250 + 86_400).unwrap();
            assert_eq!(
                (shelf.names(), removed),
                (kept.map(String::from).to_vec(), RemovedRecordings { files: 2, bytes: 2000 })
            );
        }
        let shelf = Shelf::new("none", &[100]);
        assert_eq!(make_room(&shelf.0.join("flight.mcap"), &none, u64::MAX).unwrap(), RemovedRecordings::default());
    }

    #[test]
    fn a_recording_of_an_earlier_run_is_put_aside_under_its_time_and_none_replaces_another() {
        let shelf = Shelf::new("aside", &[]);
        let path = shelf.0.join("flight.mcap");
        for content in ["one", "two"] {
            fs::write(&path, content).unwrap();
            make_room(&path, &OlderRecordings::default(), 0).unwrap();
        }
        assert!(!path.exists());
        let contents: Vec<String> =
            shelf.names()[..2].iter().map(|name| fs::read_to_string(shelf.0.join(name)).unwrap()).collect();
        assert_eq!(contents, ["one", "two"]);
    }
}
