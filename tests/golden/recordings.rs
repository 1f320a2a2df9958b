//! The public recordings, cut as the README cuts them.

use crate::answers::{diagnosis, digest};
use crate::store::scratch;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

/// The folder of the recordings.
pub struct Recordings(PathBuf);

impl Recordings {
    /// `None` (said) where there is none.
    pub fn find() -> Option<Self> {
        let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings");
        let root = std::env::var_os("OBSID_RECORDINGS").map_or_else(beside, PathBuf::from);
        if root.join("README.md").is_file() {
            return Some(Self(root));
        }
        let required = std::env::var("OBSID_REQUIRE").unwrap_or_default();
        assert!(!required.split(',').any(|word| word == "recordings"), "recordings are required: {}", root.display());
        std::io::stderr().write_all(b"golden: skipped: no recordings (set OBSID_RECORDINGS)\n").unwrap();
        None
    }

    fn path(&self, file: &str) -> String {
        self.0.join(file).display().to_string()
    }

    /// Digests of both replays with a scenario of their own.
    pub fn digests(&self) -> Value {
        let replay = |file: &str, scenario: &str| {
            digest(&["replay", &self.path(file), "--scenario", &format!("deploy/scenarios/{scenario}.toml")])
        };
        let mut digests = Map::new();
        digests.insert("r1".into(), replay("basilisk_slosh/r1_1d_seed_sine.csv.gz", "replay-r1"));
        digests.insert("slab".into(), replay("slab_vibration/slab_vibration.csv.gz", "replay-slab"));
        Value::Object(digests)
    }

    /// The diagnoses of all of them, by name, made once for every test that looks at them; `None`
    /// (said) without recordings.
    pub fn diagnoses() -> Option<&'static BTreeMap<String, Value>> {
        static ALL: OnceLock<Option<BTreeMap<String, Value>>> = OnceLock::new();
        ALL.get_or_init(|| Self::find().map(|recordings| recordings.diagnosed(&scratch("recordings")))).as_ref()
    }

    /// Slices are written to `folder`.
    fn diagnosed(&self, folder: &Path) -> BTreeMap<String, Value> {
        let jobs = self.jobs(&Slices { recordings: self, folder });
        let (next, done) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
        let work = || {
            while let Some((name, arguments)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(["--threads", "1"]).collect();
                let found = diagnosis(&arguments);
                done.lock().unwrap().insert((*name).to_owned(), found);
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        std::thread::scope(|scope| (0..cores).for_each(|_| drop(scope.spawn(work))));
        std::fs::remove_dir_all(folder).unwrap();
        done.into_inner().unwrap()
    }

    /// Name and arguments of every diagnosis, the longest first.
    fn jobs(&self, slices: &Slices<'_>) -> Vec<(&'static str, Vec<String>)> {
        let pair = |rig_name: &str, fitted: String, held_out: String| {
            vec![fitted, "--plant".to_owned(), rig(rig_name), "--held-out".to_owned(), held_out]
        };
        let mut jobs = vec![("friction damper", Self::friction_damper(slices))];
        let tenth =
            |begin: f64, end: f64| move |row: usize, t: f64, _: f64| row.is_multiple_of(10) && t >= begin && t < end;
        let swing = "multiarm_pendulum/single_free_swing.csv.gz";
        let (a, b) =
            (slices.cut(swing, "swing_a", tenth(0.05, 40.05)), slices.cut(swing, "swing_b", tenth(40.05, 54.9)));
        jobs.push(("pendulum", pair("single_pendulum", a, b)));
        let before = |limit: f64| move |_: usize, first: f64, _: f64| first < limit;
        let step = "cubesat_adcs/step_response.csv";
        let (a, b) = (slices.cut(step, "step_a", before(45.0)), slices.cut(step, "step_b", |_, t, _| t >= 45.0));
        jobs.push(("cubesat", pair("cubesat_gyro_step", a, b)));
        let throw = "flatball_freeflight/throw_imu.csv";
        let (a, b) = (
            slices.cut(throw, "throw_a", |_, _, second| second < 1717.0),
            slices.cut(throw, "throw_b", |_, _, second| second >= 1717.0),
        );
        jobs.push(("thrown disc", pair("thrown_disc", a, b)));
        for ball in BALLS {
            let [a, b] = [1.0, 2.0].map(|drop: f64| {
                slices.cut(&format!("ball_drops/{ball}.csv"), &format!("{ball}_{drop}"), move |_, _, n| n == drop)
            });
            jobs.push((ball, pair("ball_drop", a, b)));
        }
        let spectrum = self.path("cantilever_impulse_fft/impulse_spectrum.csv.gz");
        jobs.push(("cantilever", vec![spectrum, "--plant".to_owned(), rig("cantilever")]));
        jobs
    }

    /// Two records jointly, three held out, every second sample.
    fn friction_damper(slices: &Slices<'_>) -> Vec<String> {
        let half = |name: &str| {
            slices.cut(&format!("brfd_friction_backlash/sine_{name}.csv"), name, |row, _, _| row.is_multiple_of(2))
        };
        let mut arguments = ["0.5Hz_1in_30lb", "1Hz_0.5in_30lb"].map(half).to_vec();
        arguments.extend(["--plant".to_owned(), rig("friction_damper")]);
        for held_out in ["1Hz_1in_30lb", "2Hz_0.5in_30lb", "0.5Hz_0.5in_30lb"].map(half) {
            arguments.extend(["--held-out".to_owned(), held_out]);
        }
        arguments
    }
}

const BALLS: [&str; 11] = [
    "baseball",
    "blue_basketball",
    "bowling_ball",
    "golf_ball",
    "green_basketball",
    "orange_whiffle_ball",
    "tennis_ball",
    "volleyball",
    "whiffle_ball_1",
    "whiffle_ball_2",
    "yellow_whiffle_ball",
];

fn rig(name: &str) -> String {
    format!("deploy/plants/rigs/{name}.toml")
}

/// Parts of recordings as files of their own.
struct Slices<'a> {
    recordings: &'a Recordings,
    folder: &'a Path,
}

impl Slices<'_> {
    /// The rows that `keep` (row, first and second cell as numbers) takes, under the header of the
    /// file.
    fn cut(&self, file: &str, name: &str, keep: impl Fn(usize, f64, f64) -> bool) -> String {
        let text = read(&self.recordings.0.join(file));
        let mut lines = text.lines();
        let mut kept = format!("{}\n", lines.next().expect("a header"));
        for (row, line) in lines.enumerate() {
            let mut cells = line.split(',').map(|cell| cell.trim().parse().unwrap_or(f64::NAN));
            let (first, second) = (cells.next().unwrap_or(f64::NAN), cells.next().unwrap_or(f64::NAN));
            if keep(row, first, second) {
                writeln!(kept, "{line}").unwrap();
            }
        }
        let path = self.folder.join(format!("{name}.csv"));
        std::fs::write(&path, kept).unwrap();
        path.display().to_string()
    }
}

fn read(path: &Path) -> String {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    if path.extension().is_some_and(|extension| extension == "gz") {
        let mut text = String::new();
        flate2::read::MultiGzDecoder::new(bytes.as_slice()).read_to_string(&mut text).unwrap();
        return text;
    }
    String::from_utf8(bytes).unwrap()
}
