//! Real sensors attached to a running system: what drivers write arrives once, in order, or is
//! counted.

use crate::{Place, object, workspace};
use serde_json::Value;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use telemetry::{IMU, Imu, Layout, Sample, TICK};
use zerocopy::IntoBytes;

#[allow(dead_code)]
#[path = "../../deploy/examples/imu-driver/src/main.rs"]
mod imu_driver;

/// What is known of a craft with a tank; nothing that an inertial sensor alone could identify, so
/// that the run ends with a model that is not accepted.
const SCENARIO: &str = "format = 1\nname = \"bench\"\n[slosh]\nduration_s = 10.0\n[slosh.known]\nm_0_kg = 1000.0\naxis = \"x\"\n\
                        interval_s = 0.1\naccelerometer_vrw_m_s_sqrt_h = 0.008\nstarts_at_rest = true\n";
const MS: u64 = 1_000_000;
/// Behind the last frame, so that it closes: the lateness limit and a frame.
const RUN_ON_MS: u64 = 40;

fn sample(t_ms: u64) -> Imu {
    let mut sample = Imu { valid: 0x3f, interval_s: 1e-3, ..Imu::zeroed_at(t_ms * MS) };
    sample.header.layout = Imu::HASH;
    sample.acceleration_b_m_s2[0] = t_ms as f64 * 1e-3;
    sample
}

/// A gateway over `seconds`, recording to `flight.mcap`.
fn gateway(place: &Place, seconds: &str, more: &[&str]) -> Child {
    std::fs::write(place.file("craft.toml"), SCENARIO).unwrap();
    let (socket, file) = (place.file("s"), place.file("flight.mcap"));
    let fixed = ["gateway", &socket, "--scenario", "craft.toml", "--duration", seconds, "--record", &file, "--json"];
    // A driver that waits for a busy computer is not silent.
    let patience: &[&str] = if more.contains(&"--silence-ms") { &[] } else { &["--silence-ms", "60000"] };
    place.start(&[&fixed[..], patience, &crate::PATIENT, more].concat())
}

fn connect(place: &Place, gateway: &mut Child) -> UnixStream {
    loop {
        if let Ok(stream) = UnixStream::connect(place.file("s")) {
            return stream;
        }
        assert!(gateway.try_wait().unwrap().is_none(), "the gateway ended");
        std::thread::yield_now();
    }
}

/// Numbers that look random and are the same every time.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

/// Times of the samples of two seconds as a bad driver writes them: up to 15 ms out of order, every
/// 40th twice, every 100th again when its frame is long closed.
fn disorder(seed: u64) -> Vec<u64> {
    let mut state = seed;
    let mut keyed: Vec<(u64, u64)> = (1..2000 + RUN_ON_MS).map(|t| (t + random(&mut state) % 16, t)).collect();
    keyed.extend((1..=2000).step_by(40).map(|t| (t + 16, t)));
    keyed.extend((1..=1900).step_by(100).map(|t| (t + 100, t)));
    keyed.sort_by_key(|(key, _)| *key);
    [0].into_iter().chain(keyed.into_iter().map(|(_, t)| t)).collect()
}

/// Ticks and samples in the order of the recording, without what changes from run to run.
fn recorded(file: &str) -> (Vec<u64>, Vec<u8>) {
    let run = recording::read_mcap(Path::new(file)).unwrap();
    let first = run.of(IMU).next().map_or(0, |(_, sample)| sample.header.t_meas_ns);
    let mut bytes = Vec::new();
    for (_, sample) in run.of(IMU) {
        bytes.extend_from_slice(sample.as_bytes());
    }
    for (_, tick) in run.of(TICK).filter(|(_, tick)| tick.t_ns >= first && tick.last_seq[IMU.id] > 0) {
        bytes.extend_from_slice(&tick.frame.to_le_bytes());
        bytes.extend_from_slice(&tick.last_seq[IMU.id].to_le_bytes());
    }
    (run.of(IMU).map(|(_, sample)| (sample.header.t_meas_ns - first) / MS).collect(), bytes)
}

fn fed(seed: u64) -> (Value, Vec<u64>, Vec<u8>) {
    let place = Place::new();
    let mut child = gateway(&place, "2", &[]);
    let mut stream = connect(&place, &mut child);
    for t_ms in disorder(seed) {
        stream.write_all(sample(t_ms).as_bytes()).unwrap();
    }
    let output = child.wait_with_output().unwrap();
    let (times, bytes) = recorded(&place.file("flight.mcap"));
    (object(&output, output.status.code().unwrap()), times, bytes)
}

#[test]
fn disorder_late_and_repeated_samples_are_counted_exactly_and_the_recorded_ticks_repeat() {
    let (result, times, bytes) = fed(1);
    assert!(times.iter().copied().eq(0..2000), "every sample once, in order");
    let feed = &result["feed"];
    let counts = ["duplicates", "late", "surplus", "bad", "empty_frames", "strangers"].map(|key| feed[key].as_u64());
    assert_eq!(counts, [50, 19, 0, 0, 0, 0].map(Some), "{feed}");
    for seed in [1, 2] {
        let (again, _, same) = fed(seed);
        assert!(same == bytes, "another order within the limit, seed {seed}");
        assert_eq!(again["feed"]["late"], feed["late"]);
    }
}

#[test]
fn a_killed_gateway_sends_the_same_frames_again_and_loses_only_what_came_while_it_was_down() {
    let place = Place::new();
    let mut child = gateway(
        &place,
        "2",
        &["--kill", "sensor-sim@180:publish", "--kill", "inertial-id@230", "--silence-ms", "3000"],
    );
    let (mut stream, mut at, mut reconnections) = (connect(&place, &mut child), 0, 0);
    while at < 2000 + RUN_ON_MS {
        // the gateway has all it needs for the frame in which it dies: the stream ends with it
        let is_gone = at == 1800 + RUN_ON_MS + 10 && reconnections == 0 && !matches!(stream.read(&mut [0]), Ok(1..));
        if is_gone || stream.write_all(sample(at).as_bytes()).is_err() {
            reconnections += 1;
            stream = connect(&place, &mut child);
        } else {
            at += 1;
        }
    }
    let output = child.wait_with_output().unwrap();
    let result = object(&output, output.status.code().unwrap());
    let (times, _) = recorded(&place.file("flight.mcap"));
    // a dying gateway may still accept once
    assert!(reconnections > 0);
    assert!(times.is_sorted_by(|a, b| a < b), "none twice, none out of order");
    let rows = result["partitions"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["lost"] == 0 && row["bad"] == 0), "{rows:?}");
    assert_eq!(result["feed"]["late"], 0);
    let lost = 2000 - times.len() as u64;
    assert!(lost <= 10 * (result["feed"]["empty_frames"].as_u64().unwrap() + 2), "{lost} of {}", result["feed"]);
}

#[test]
fn a_driver_of_another_build_is_disconnected_and_the_run_goes_on() {
    let place = Place::new();
    let mut child = gateway(&place, "0.2", &[]);
    let mut stranger = connect(&place, &mut child);
    stranger.write_all(&[0xff; 88]).unwrap();
    let mut stream = connect(&place, &mut child);
    for t_ms in 0..200 + RUN_ON_MS {
        stream.write_all(sample(t_ms).as_bytes()).unwrap();
    }
    let output = child.wait_with_output().unwrap();
    let feed = &object(&output, output.status.code().unwrap())["feed"];
    assert_eq!((feed["strangers"].as_u64(), feed["empty_frames"].as_u64()), (Some(1), Some(0)), "{feed}");
}

/// The example drivers, as their readers would use them.
fn driven(driver: impl FnOnce(&str)) -> (Value, Vec<u8>) {
    let place = Place::new();
    let mut child = gateway(&place, "0.9", &[]);
    drop(connect(&place, &mut child));
    driver(&place.file("s"));
    let output = child.wait_with_output().unwrap();
    (object(&output, output.status.code().unwrap()), recorded(&place.file("flight.mcap")).1)
}

#[test]
fn the_drivers_in_rust_and_in_c_give_one_recording() {
    let (result, rust) = driven(|socket| assert_eq!(imu_driver::drive(socket, 1000, false).unwrap(), (1000, 0)));
    assert_eq!((result["feed"]["late"].as_u64(), result["feed"]["bad"].as_u64()), (Some(0), Some(0)));
    let place = Place::new();
    let (program, example) = (place.file("imu_driver"), workspace().join("deploy/examples/imu-driver"));
    let warnings = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-o", &program];
    let built = Command::new("cc").args(warnings).arg(example.join("imu_driver.c")).status().unwrap();
    assert!(built.success());
    let (_, c) = driven(|socket| {
        let output = Command::new(&program).args([socket, "1", "--unpaced"]).stdin(Stdio::null()).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stdout), "1000 samples written, 0 lost\n");
    });
    assert!(!c.is_empty() && c == rust);
}

#[test]
fn the_committed_header_is_the_one_of_this_build_and_its_assertions_catch_another_layout() {
    let place = Place::new();
    let output = place.command(&["icd", "--c-header"]).output().unwrap();
    let header = workspace().join("deploy/examples/imu-driver/obsid_telemetry.h");
    let cure = "write it with `obsid icd --c-header > deploy/examples/imu-driver/obsid_telemetry.h`";
    assert!(std::fs::read(&header).unwrap() == output.stdout, "{} is old: {cure}", header.display());
    // A field of another size is caught by the assertions.
    let text = String::from_utf8(output.stdout).unwrap();
    let wrong = text.replace("    double omega_bi_b_rad_s[3];", "    double omega_bi_b_rad_s[2];");
    assert_ne!(wrong, text);
    for (text, good) in [(&text, true), (&wrong, false)] {
        std::fs::write(place.file("h.c"), text).unwrap();
        let built = Command::new("cc").args(["-std=c11", "-fsyntax-only", &place.file("h.c")]).output().unwrap();
        assert_eq!(built.status.success(), good, "{}", String::from_utf8_lossy(&built.stderr));
    }
}
