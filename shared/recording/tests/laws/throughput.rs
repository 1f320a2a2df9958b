//! Speed, measured on demand:
//! `cargo test --release -p obsid-recording -- --ignored --nocapture throughput`.

use crate::samples::{random, seal};
use crate::{Numbers, scratch};
use recording::csv::{read_csv, write_csv};
use recording::{Column, McapRecorder, Table, read_mcap};
use std::time::Instant;
use telemetry::{ACCELEROMETERS, ACTUATORS, Accelerometers, Actuators, IMU, Imu, JOINTS, Joints};

#[test]
#[ignore = "a measurement, not a law"]
fn throughput_of_mcap_and_csv() {
    let mut numbers = Numbers(1);
    let path = scratch("throughput.mcap");
    let mut samples = Vec::new();
    for frame in 1..=6000u64 {
        for i in 0..10 {
            let seq = 10 * frame + i;
            samples.push(seal(IMU, random::<Imu>(&mut numbers, seq), seq, 0));
            samples.push(seal(JOINTS, random::<Joints>(&mut numbers, seq), seq, 0));
            samples.push(seal(ACTUATORS, random::<Actuators>(&mut numbers, seq), seq, 0));
        }
        // A batch as it flies: ten rows used of 64.
        let mut batch = Accelerometers { count: 10, channels: 12, ..random(&mut numbers, frame) };
        batch.offset_ns[10..].fill(0);
        batch.acceleration_m_s2[10..].fill([0.0; 12]);
        samples.push(seal(ACCELEROMETERS, batch, frame, 0));
    }
    let bytes: usize = samples.iter().map(|(_, _, payload)| payload.len() + 16).sum();
    let report = |what: &str, bytes: f64, count: usize, start: Instant| {
        let s = start.elapsed().as_secs_f64();
        println!(
            "{what}: {:.1} MB in {s:.3} s = {:.0} MB/s, {:.2} M items/s",
            bytes * 1e-6,
            bytes * 1e-6 / s,
            count as f64 * 1e-6 / s
        );
    };
    let start = Instant::now();
    let mut recorder = McapRecorder::create(&path).unwrap();
    for (topic, stamps, payload) in &samples {
        recorder.write(*topic, stamps, payload).unwrap();
    }
    recorder.finish().unwrap();
    report("mcap write", bytes as f64, samples.len(), start);
    println!("mcap file: {:.1} MB", std::fs::metadata(&path).unwrap().len() as f64 * 1e-6);
    let start = Instant::now();
    assert_eq!(read_mcap(&path).unwrap().len(), samples.len());
    report("mcap read", bytes as f64, samples.len(), start);

    let rows = 200_000;
    let columns = (0..6).map(|c| Column::si(&format!("c{c}"), "-", (0..rows).map(|_| numbers.unit()).collect()));
    let table =
        Table::from_columns("memory", (0..rows).map(|i| i as f64 * 0.001).collect(), columns.collect()).unwrap();
    for name in ["throughput.csv", "throughput.csv.gz"] {
        let path = scratch(name);
        let start = Instant::now();
        write_csv(&table, &path).unwrap();
        let bytes = std::fs::metadata(&path).unwrap().len() as f64;
        report(&format!("{name} write"), bytes, rows, start);
        let start = Instant::now();
        assert_eq!(read_csv(&path).unwrap().time_s.len(), rows);
        report(&format!("{name} read"), bytes, rows, start);
    }
}
