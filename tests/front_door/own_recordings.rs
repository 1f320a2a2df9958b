//! What `obsid run --record` wrote: its digest, its replay, and what is refused.

use crate::desk::{Folder, estimates, number, scenario};
use recording::{RecordedRun, read_mcap, write_mcap};
use std::path::Path;
use telemetry::{IMU, Stamps, crc32};

/// The short scenario with one of its experiments alone.
fn experiment_alone(section: &str) -> String {
    let text = std::fs::read_to_string(scenario("short.toml")).unwrap();
    let (head, experiments) = text.split_at(text.find("\n[").unwrap());
    let tables = experiments
        .split("\n[")
        .filter(|table| table.starts_with(&format!("{section}]")) || table.starts_with(&format!("{section}.")));
    tables.fold(head.to_string(), |all, table| format!("{all}\n[{table}\n"))
}

/// Runs one experiment with a recording, returns the estimates.
fn record(folder: &Folder, section: &str) -> serde_json::Value {
    folder.file("alone.toml", experiment_alone(section));
    folder.ask(&["run", "alone.toml", "--link", "lockstep", "--record", "own.mcap", "--json"]).result()
}

#[test]
fn an_experiment_replayed_from_its_recording_gives_the_numbers_of_the_flight() {
    for section in ["modal", "slosh", "inertial"] {
        let folder = Folder::new(&format!("own-{section}"));
        let flown = record(&folder, section);
        let replayed =
            folder.ask(&["replay", "own.mcap", "--scenario", "alone.toml", "--link", "lockstep", "--json"]).result();
        let (flown, replayed) = (estimates(&flown, section), estimates(&replayed, section));
        assert!(!flown.is_empty() && flown.len() == replayed.len(), "{section}");
        for (flown, replayed) in flown.iter().zip(replayed) {
            assert_eq!(replayed["phase"], "replay");
            // A recording holds no truth.
            assert!(replayed["truth"].is_null() && replayed["error_percent"].is_null(), "{replayed}");
            for key in ["name", "value", "sigma", "complete", "adequate", "accepted", "reason"] {
                assert_eq!(flown[key], replayed[key], "{section} {key}");
            }
        }
    }
}

#[test]
fn a_mission_of_several_experiments_is_not_replayed_as_one() {
    let folder = Folder::new("own-mission");
    let short = scenario("short.toml");
    folder.ask(&["run", &short, "--link", "lockstep", "--record", "own.mcap", "--json"]).ends_with(0);
    folder.ask(&["replay", "own.mcap", "--scenario", &short, "--link", "lockstep", "--json"]).refuses(&[
        "own.mcap",
        "4 experiments",
        "modal (frames 40 to 339)",
        "mated inertial",
        "one experiment per file",
    ]);
}

#[test]
fn the_digest_of_a_recording_is_the_digest_of_its_run() {
    let folder = Folder::new("own-digest");
    let flown = record(&folder, "modal");
    let digest = folder.ask(&["digest", "own.mcap", "--json"]).result();
    assert_eq!(digest["digest"], flown["digest"]);
    assert!(digest["samples"]["mode"].as_u64().unwrap() >= 2);
    let plain = folder.ask(&["digest", "own.mcap"]).ends_with(0);
    assert!(plain.stdout.starts_with(digest["digest"].as_str().unwrap()), "{plain}");
}

#[test]
fn a_recording_is_not_written_over_by_its_own_replay() {
    let folder = Folder::new("own-over");
    record(&folder, "modal");
    let before = folder.bytes("own.mcap");
    folder
        .ask(&["replay", "own.mcap", "--record", "./own.mcap", "--link", "lockstep"])
        .refuses(&["own.mcap", "--record"]);
    assert!(folder.bytes("own.mcap") == before);
}

#[test]
fn a_truncated_or_corrupt_recording_names_the_byte_and_what_is_readable() {
    let folder = Folder::new("own-damage");
    record(&folder, "inertial");
    let whole = folder.bytes("own.mcap");
    folder.file("cut.mcap", &whole[..whole.len() / 2]);
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0xff;
    folder.file("flipped.mcap", flipped);
    folder.file("head.mcap", &whole[..5]);
    for verb in ["replay", "digest"] {
        folder.ask(&[verb, "cut.mcap"]).refuses(&["cut.mcap: byte ", "truncated", "readable", "mcap recover"]);
        folder.ask(&[verb, "flipped.mcap"]).refuses(&[
            "flipped.mcap: byte ",
            "corrupt",
            "readable",
            "copy the file again",
        ]);
        folder.ask(&[verb, "head.mcap"]).refuses(&["head.mcap: byte 0", "truncated"]);
    }
}

#[test]
fn a_sample_that_is_no_number_is_counted_dropped_and_the_estimate_goes_on() {
    let folder = Folder::new("own-nan");
    let flown = record(&folder, "inertial");
    let poisoned = with_one_nan(&folder.path().join("own.mcap"));
    write_mcap(&poisoned, &folder.path().join("nan.mcap")).unwrap();
    let result =
        folder.ask(&["replay", "nan.mcap", "--scenario", "alone.toml", "--link", "lockstep", "--json"]).result();
    let partitions = result["partitions"].as_array().unwrap();
    let bad = partitions.iter().find(|row| row["name"] == "inertial-id").unwrap()["bad"].as_u64();
    assert_eq!(bad, Some(1), "{result}");
    for (flown, row) in estimates(&flown, "inertial").iter().zip(estimates(&result, "inertial")) {
        // One row of 1600 less: the estimate moves by a fraction of its sigma.
        let moved = (number(row, "value") - number(flown, "value")).abs();
        assert!(moved < number(flown, "sigma"), "{row}");
    }
}

/// The recording with one rate in the middle that is no number; its CRC is right.
fn with_one_nan(path: &Path) -> RecordedRun {
    let run = read_mcap(path).unwrap();
    let count = run.of(IMU).filter(|(_, imu)| imu.valid & 4 != 0).count();
    let mut copy = RecordedRun::new("nan.mcap");
    let mut seen = 0;
    for sample in run.samples() {
        let mut payload = sample.payload.to_vec();
        if sample.get(IMU).is_some_and(|imu| imu.valid & 4 != 0) {
            seen += 1;
            if seen == count / 2 {
                let at = core::mem::offset_of!(telemetry::Imu, omega_bi_b_rad_s) + 16;
                payload[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
            }
        }
        let stamps = Stamps { crc32: crc32(&payload), ..*sample.stamps };
        copy.push(sample.topic, &stamps, &payload).unwrap();
    }
    assert!(seen > 1000, "the recording holds the arm experiment");
    copy
}
