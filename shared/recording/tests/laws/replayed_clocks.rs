//! Replay by every clock: the frames are those that plain seconds give.

use crate::file;
use recording::{Intake, ReplayFrames, ReplaySample, read_with, series};
use std::fmt::Write;

const PERIOD_NS: u64 = 10_000_000;
const ROWS: usize = 300;

/// Header of a column of times, and the time of a row [s] in it.
type Clock = (&'static str, fn(f64) -> String);

const CLOCKS: [Clock; 9] = [
    ("elapsed", |t| format!("PT{t:.3}S")),
    ("run time", |t| format!("{}m{:.3}s", (t / 60.0).floor(), t % 60.0)),
    ("min", |t| format!("{:.12}", t / 60.0)),
    ("timestamp", |t| format!("{}", 133_541_246_980_000_000_u64 + (t * 1e7).round() as u64)),
    ("Ticks", |t| format!("{}", 638_452_478_980_000_000_u64 + (t * 1e7).round() as u64)),
    ("time [ns]", |t| format!("{}", (t * 1e9).round())),
    ("time", |t| format!("09{:02}{:05.2}", (t / 60.0) as u64, t % 60.0)),
    ("Date/Time", |t| format!("25/03/2024 1:{:02}:{:06.3} pm", (t / 60.0) as u64, t % 60.0)),
    ("시간", |t| format!("2024-03-05 오후 1:{:02}:{:06.3}", (t / 60.0) as u64, t % 60.0)),
];

/// Rates and their times since the first [ns], in the order of the frames.
fn replayed((name, stamp): Clock) -> Vec<(u64, f64)> {
    let mut text = format!("{name},rate [rad/s]\n");
    (0..ROWS).for_each(|k| writeln!(text, "{},{:.6}", stamp(0.01 * k as f64), (0.3 * k as f64).sin()).unwrap());
    let imported = read_with(&file("replayed_clock.csv", &text), &Intake::default());
    let set = imported.and_then(series).unwrap_or_else(|error| panic!("{name}: {}", error.explain()));
    let table = set.table().unwrap_or_else(|error| panic!("{name}: {}", error.explain()));
    let frames = ReplayFrames::from_table(&table, None, PERIOD_NS).unwrap();
    let mut all = Vec::new();
    for k in 0..frames.frame_count() {
        frames.frame(k, &mut |sample| {
            if let ReplaySample::Imu(imu) = sample {
                all.push((imu.header.t_meas_ns, imu.omega_bi_b_rad_s[2]));
            }
        });
    }
    let first_ns = all.first().map_or(0, |(time_ns, _)| *time_ns);
    all.iter().map(|(time_ns, rate)| (time_ns - first_ns, *rate)).collect()
}

#[test]
fn every_clock_gives_the_frames_that_plain_seconds_give() {
    let plain = replayed(("time [s]", |t| format!("{t:.2}")));
    assert_eq!(plain.len(), ROWS);
    for clock in CLOCKS {
        let other = replayed(clock);
        assert_eq!(other.len(), ROWS, "{}", clock.0);
        for ((plain_ns, plain_rate), (time_ns, rate)) in plain.iter().zip(&other) {
            // seconds in the afternoon are a double of 7 ps, minutes have twelve decimals
            assert!(plain_ns.abs_diff(*time_ns) <= 100, "{}: {time_ns} is not {plain_ns}", clock.0);
            assert_eq!(plain_rate, rate, "{}", clock.0);
        }
    }
}
