//! Recordings of real structures and of an independent simulator, through the program.
//!
//! The folder is `OBSID_RECORDINGS`, or `../shared/recordings` beside the workspace; without it the
//! tests say that they were skipped, and fail when `OBSID_REQUIRE` contains `recordings`.

use crate::desk::{ask, estimates, number, scenario, skipped, workspace};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn folder() -> Option<PathBuf> {
    let found = match std::env::var_os("OBSID_RECORDINGS") {
        Some(path) => Some(PathBuf::from(path)),
        None => Some(workspace().join("../shared/recordings")).filter(|path| path.join("README.md").is_file()),
    };
    if found.is_none() {
        let required = std::env::var("OBSID_REQUIRE").unwrap_or_default();
        assert!(!required.contains("recordings"), "no recordings found, and OBSID_REQUIRE asks for them");
        skipped("no recordings (set OBSID_RECORDINGS)");
    }
    found
}

fn replay(recording: &Path, with: &[&str], link: &str) -> Value {
    let path = recording.display().to_string();
    ask(&[&["replay", &path, "--link", link, "--json"], with].concat()).result()
}

/// Two runs over either link, four equal digests.
fn digests_agree(recording: &Path, with: &[&str]) {
    let digests = ["lockstep", "shm", "lockstep", "shm"].map(|link| replay(recording, with, link)["digest"].clone());
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");
}

#[test]
fn the_slab_has_one_vertical_mode_at_its_published_frequency() {
    let Some(folder) = folder() else { return };
    let slab = folder.join("slab_vibration/slab_vibration.csv.gz");
    let known = scenario("replay-slab.toml");
    let result = replay(&slab, &["--scenario", &known], "lockstep");
    let names: Vec<&Value> = estimates(&result, "modal").iter().map(|row| &row["name"]).collect();
    assert_eq!(names, ["f1", "zeta1"], "one mode in the scenario's band");
    let open = replay(&slab, &[], "lockstep");
    for (result, axis) in [(&result, None), (&open, Some(3))] {
        let row = estimates(result, "modal").iter().find(|row| row["name"] == "f1").unwrap();
        // Published: 17.85 Hz (line 86 of a coarse spectrum); the finer spectrum peaks at 17.69 Hz.
        assert!((17.6..=18.0).contains(&number(row, "value")), "{row}");
        assert!(number(row, "sigma") > 0.0 && number(row, "sigma") < 0.5, "{row}");
        assert!(row["truth"].is_null() && row["phase"] == "replay", "{row}");
        assert!(row["accepted"].is_boolean() && !row["reason"].as_str().unwrap().is_empty(), "{row}");
        // The vertical axis is the third channel of the file.
        assert!(axis.is_none_or(|axis| row["dominant_channel"] == axis), "{row}");
    }
    digests_agree(&slab, &["--scenario", &known]);
}

#[test]
fn an_independent_simulators_tank_is_found_within_three_sigma() {
    let Some(folder) = folder() else { return };
    let r1 = folder.join("basilisk_slosh/r1_1d_seed_sine.csv.gz");
    let known = scenario("replay-r1.toml");
    let result = replay(&r1, &["--scenario", &known], "lockstep");
    let rows = estimates(&result, "slosh");
    assert_eq!(rows.len(), 3);
    // Truth of the file's generator, in basilisk_slosh/README.md.
    for (row, (name, truth)) in rows.iter().zip([("m_s", 28.7), ("k_s", 0.16), ("c_s", 0.03)]) {
        assert_eq!(row["name"], name);
        let z = (number(row, "value") - truth) / number(row, "sigma");
        assert!(z.abs() < 3.0, "{row}: z = {z:.2}");
    }
    digests_agree(&r1, &["--scenario", &known]);
}

#[test]
fn every_recording_is_replayed_or_refused_with_its_name_and_a_cure() {
    let Some(folder) = folder() else { return };
    let mut recordings = Vec::new();
    collect(&folder, &mut recordings);
    recordings.sort();
    assert!(recordings.len() > 20, "{recordings:?}");
    let mut replayed = 0;
    for path in &recordings {
        let path = path.display().to_string();
        let answer = ask(&["replay", &path, "--link", "lockstep", "--json"]);
        match answer.code {
            Some(0) => {
                replayed += 1;
                answer.object();
            }
            _ => answer.refuses(&[&path]),
        }
    }
    assert!(replayed > 0, "the slab needs no scenario");
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.to_string_lossy().ends_with(".csv") || path.to_string_lossy().ends_with(".csv.gz") {
            found.push(path);
        }
    }
}

/// The modes that `obsid modal` gives.
fn modes(arguments: &[&str]) -> Vec<Value> {
    let answer = ask(&[&["modal"], arguments, &["--json"]].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    answer.object()["modes"].as_array().unwrap().clone()
}

#[test]
fn the_free_beams_six_modes_are_those_of_two_other_tools() {
    let Some(folder) = folder() else { return };
    let points =
        [1, 2, 3].map(|point| folder.join(format!("free_beam_frf/meas_point_{point}.csv")).display().to_string());
    let found = modes(&points.each_ref().map(String::as_str));
    assert_eq!(found.len(), 6, "{found:?}");
    // Of the recording's README: sdypy-EMA LSCF of order 30, and a global rational fraction; they
    // agree to 7 mHz and 10 %.
    let lscf = [51.5165, 142.1763, 278.6623, 460.3951, 687.1658, 958.5290];
    let rational = [51.5183, 142.1768, 278.6666, 460.4012, 687.1647, 958.5304];
    let damping =
        [[0.0570, 0.0515], [0.0368, 0.0366], [0.0191, 0.0188], [0.0188, 0.0192], [0.0165, 0.0159], [0.0140, 0.0134]];
    for (k, mode) in found.iter().enumerate() {
        let (f, zeta) = (number(mode, "frequency_hz"), 100.0 * number(mode, "damping"));
        for (peer_f, peer_zeta) in [(lscf[k], damping[k][0]), (rational[k], damping[k][1])] {
            assert!((f - peer_f).abs() < 0.010, "{f} Hz against {peer_f}");
            assert!((zeta / peer_zeta - 1.0).abs() < 0.10, "{zeta} % against {peer_zeta}");
        }
        assert_eq!(mode["shape"].as_array().unwrap().len(), 3);
        assert!(number(mode, "mpc") > 0.9, "a free beam has real modes: {mode}");
    }
}

#[test]
fn the_cantilevers_frequencies_are_those_of_its_spectrum() {
    let Some(folder) = folder() else { return };
    let found = modes(&[&folder.join("cantilever_impulse_fft/impulse_spectrum.csv.gz").display().to_string()]);
    // Of the recording's README.
    for frequency_hz in [6.604, 41.450, 117.920, 229.997, 380.334, 569.219] {
        let near = |mode: &&Value| (number(mode, "frequency_hz") / frequency_hz - 1.0).abs() < 0.002;
        assert_eq!(found.iter().filter(near).count(), 1, "{frequency_hz} Hz in {found:?}");
    }
}

#[test]
fn the_slabs_mode_is_known_with_its_deviation() {
    let Some(folder) = folder() else { return };
    let slab = folder.join("slab_vibration/slab_vibration.csv.gz").display().to_string();
    // As the author does: the vertical axis, without the first 2000 rows.
    let found = modes(&[&slab, "--channels", "acceleration_z", "--from", "4.71"]);
    let near = |mode: &&Value| (17.6..=18.0).contains(&number(mode, "frequency_hz"));
    let mode = found.iter().find(near).unwrap_or_else(|| panic!("{found:?}"));
    assert!(number(mode, "frequency_sd") > 0.0 && number(mode, "frequency_sd") < 0.2, "{mode}");
}
