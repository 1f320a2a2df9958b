//! Every CSV of the recordings folder is read, and replayed or rejected for the right reason.
//!
//! The folder is `$OBSID_RECORDINGS`, else `../shared/recordings` beside the workspace; where it is
//! absent the tests say that they are skipped, and fail when `$OBSID_REQUIRE` contains
//! `recordings`.

use recording::{ChannelMap, Imported, ReplayFrames, ReplaySample, read};
use std::path::{Path, PathBuf};

fn recordings() -> Option<PathBuf> {
    let folder = match std::env::var_os("OBSID_RECORDINGS") {
        Some(folder) => PathBuf::from(folder),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings"),
    };
    if folder.join("README.md").is_file() {
        return Some(folder);
    }
    let required = std::env::var("OBSID_REQUIRE").is_ok_and(|list| list.contains("recordings"));
    assert!(!required, "recordings are required (OBSID_REQUIRE) and absent: {}", folder.display());
    println!("SKIPPED: no recordings folder at {} (set OBSID_RECORDINGS)", folder.display());
    None
}

fn tables(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            tables(&path, found);
        } else if name.ends_with(".csv") || name.ends_with(".csv.gz") {
            found.push(path);
        }
    }
}

#[test]
fn every_recording_of_the_folder_is_read_as_what_it_is() {
    let Some(folder) = recordings() else { return };
    let mut paths = Vec::new();
    tables(&folder, &mut paths);
    assert!(paths.len() >= 30, "{} tables", paths.len());
    for path in paths {
        let name = path.display().to_string();
        let imported = read(&path).unwrap();
        match &imported {
            Imported::Table(table) => {
                println!(
                    "{name}: {} rows, {} columns, interval {:.9} s, jitter {:.2e}, gaps {}",
                    table.time_s.len(),
                    table.columns.len(),
                    table.timing.interval_s,
                    table.timing.jitter,
                    table.timing.gaps.len()
                );
                // what is noted of a good recording is its gaps
                assert!(table.notes.iter().all(|note| note.contains("gap")), "{name}: {:?}", table.notes);
                assert!(table.notes.is_empty() || !table.timing.gaps.is_empty(), "{name}: {:?}", table.notes);
            }
            Imported::Segments(segments) => {
                println!("{name}: {} recordings", segments.parts.len());
                assert!(segments.parts.len() >= 2, "{name}: {:?}", segments.restarts);
                assert!(!name.contains("ball_drops") || segments.parts.len() == 2, "two drops each");
                let error = ReplayFrames::new(&imported, None, 10_000_000).unwrap_err().explain();
                assert!(error.contains("time runs backwards") && error.contains("split it before line"), "{error}");
            }
            Imported::Spectrum(spectrum) => {
                println!("{name}: {} lines, {} columns", spectrum.frequency_hz.len(), spectrum.columns.len());
                assert!(name.contains("cantilever_impulse_fft") || name.contains("free_beam_frf"), "{name}");
                let error = ReplayFrames::new(&imported, None, 10_000_000).unwrap_err().explain();
                assert!(error.contains("`frequency [Hz]`") && error.contains("spectrum"), "{error}");
            }
            // why it is no table is said
            Imported::Series(set) => {
                assert!(set.notes.iter().any(|note| note.contains("not one rate")), "{name}: {:?}", set.notes);
            }
            Imported::Run(_) => panic!("{name} is no run"),
        }
    }
}

fn frames(folder: &Path, name: &str, map: Option<&str>) -> ReplayFrames {
    let map = map.map(|text| ChannelMap::parse("map.toml", text).unwrap());
    ReplayFrames::new(&read(&folder.join(name)).unwrap(), map.as_ref(), 10_000_000).unwrap()
}

fn count(frames: &ReplayFrames) -> [usize; 4] {
    let mut count = [0; 4];
    for k in 0..frames.frame_count() {
        frames.frame(k, &mut |sample| match sample {
            ReplaySample::Imu(_) => count[0] += 1,
            ReplaySample::Joints(_) => count[1] += 1,
            ReplaySample::Actuators(_) => count[2] += 1,
            ReplaySample::Accelerometers(batch) => count[3] += batch.count as usize,
        });
    }
    count
}

#[test]
fn real_recordings_replay_every_row_and_say_what_can_be_identified() {
    let Some(folder) = recordings() else { return };
    let slosh = frames(&folder, "basilisk_slosh/r1_1d_seed_sine.csv.gz", None);
    assert_eq!(count(&slosh), [10_000, 0, 10_000, 0]);
    let domains = slosh.identifiable();
    assert_eq!((domains.inertial, domains.slosh, domains.modal), (false, true, false));

    let slab = frames(&folder, "slab_vibration/slab_vibration.csv.gz", None);
    assert_eq!(count(&slab), [25_291, 0, 0, 25_291]);
    assert!(slab.identifiable().modal);

    let imu = frames(&folder, "flatball_freeflight/throw_imu.csv", None);
    assert_eq!(count(&imu), [3558, 0, 0, 0]);

    let map = "[channels]\njoint1.angle = \"angle [rad]\"\njoint1.rate = \"angle_rate_denoised [rad/s]\"\n";
    let pendulum = frames(&folder, "multiarm_pendulum/single_free_swing.csv.gz", Some(map));
    assert_eq!(count(&pendulum), [0, 55_001, 0, 0]);
}
