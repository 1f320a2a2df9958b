//! Throughput of the formats that obsid writes:
//! `cargo bench -p obsid-recording --bench throughput`. Each figure is the best of five; ratios to
//! the copy of as many bytes say what of it is the machine. Why without a harness:
//! `dynamics/benches/multibody.rs`.

use recording::csv::{read_csv, write_csv};
use recording::{Column, McapRecorder, Table, read_mcap};
use std::path::{Path, PathBuf};
use std::time::Instant;
use telemetry::{ACCELEROMETERS, ACTUATORS, Accelerometers, Actuators, Header, IMU, Imu, JOINTS, Joints};
use telemetry::{Sample, Stamps, TOPICS, Topic, TopicId, crc32};

/// Runs of each measurement, of which the fastest counts.
const RUNS: usize = 5;

fn main() {
    mcap();
    for name in ["throughput.csv", "throughput.csv.gz"] {
        csv(name);
    }
}

/// A minute of every stream of sensors, at 1 kHz in frames of 10 ms.
fn mcap() {
    let mut samples = Vec::new();
    for frame in 1..=6000u64 {
        for seq in 10 * frame..10 * frame + 10 {
            samples.push(sealed::<Imu>(IMU, seq));
            samples.push(sealed::<Joints>(JOINTS, seq));
            samples.push(sealed::<Actuators>(ACTUATORS, seq));
        }
        // ten rows used of 64, as it flies
        samples.push(sealed_as(ACCELEROMETERS, frame, |batch: &mut Accelerometers| {
            (batch.count, batch.channels) = (10, 12);
            batch.offset_ns[10..].fill(0);
            batch.acceleration_m_s2[10..].fill([0.0; 12]);
        }));
    }
    let bytes: usize = samples.iter().map(|(_, _, payload)| payload.len()).sum();
    let path = scratch("throughput.mcap");
    report("mcap write", bytes, || {
        let mut recorder = McapRecorder::create(&path).unwrap();
        samples.iter().for_each(|(topic, stamps, payload)| recorder.write(*topic, stamps, payload).unwrap());
        recorder.finish().unwrap();
    });
    report("mcap read", bytes, || assert_eq!(read_mcap(&path).unwrap().len(), samples.len()));
}

/// Six channels of 200 000 rows.
fn csv(name: &str) {
    let (rows, mut numbers) = (200_000usize, Numbers(1));
    let columns = (0..6).map(|c| Column::si(&format!("c{c}"), "-", (0..rows).map(|_| numbers.unit()).collect()));
    let time_s = (0..rows).map(|i| i as f64 * 0.001).collect();
    let table = Table::from_columns("memory", time_s, columns.collect()).unwrap();
    let path = scratch(name);
    let bytes = 7 * rows * size_of::<f64>();
    report(&format!("{name} write"), bytes, || write_csv(&table, &path).unwrap());
    report(&format!("{name} read"), bytes, || assert_eq!(read_csv(&path).unwrap().time_s.len(), rows));
}

/// Prints the megabytes a second of a call that moves `bytes` of numbers.
fn report(name: &str, bytes: usize, mut call: impl FnMut()) {
    let fastest_s = |call: &mut dyn FnMut()| {
        let one = |_| {
            let begin = Instant::now();
            call();
            begin.elapsed().as_secs_f64()
        };
        (0..RUNS).map(one).fold(f64::INFINITY, f64::min)
    };
    let from = vec![1u8; bytes];
    let copy_s = fastest_s(&mut || drop(std::hint::black_box(from.clone())));
    let own_s = fastest_s(&mut call);
    let (mega, ratio) = (bytes as f64 * 1e-6, own_s / copy_s);
    println!("{name:24} {mega:6.1} MB {:7.1} MB/s {ratio:7.0} times as long as a copy", mega / own_s);
}

/// A payload full of numbers with header, and its stamps.
fn sealed<T: Sample>(topic: Topic<T>, seq: u64) -> (TopicId, Stamps, Vec<u8>) {
    sealed_as(topic, seq, |_| ())
}

fn sealed_as<T: Sample>(topic: Topic<T>, seq: u64, shape: impl Fn(&mut T)) -> (TopicId, Stamps, Vec<u8>) {
    let (mut numbers, mut bytes) = (Numbers(seq), vec![0; size_of::<T>()]);
    bytes.chunks_exact_mut(8).for_each(|word| word.copy_from_slice(&numbers.unit().to_le_bytes()));
    let mut sample = T::read_from_bytes(&bytes).unwrap();
    shape(&mut sample);
    *sample.header_mut() = Header::at(1_000_000 * seq);
    let header = sample.header_mut();
    (header.layout, header.seq) = (TOPICS[topic.id].layout, seq);
    let payload = sample.as_bytes().to_vec();
    let stamps = Stamps { epoch: 0, crc32: crc32(&payload), sent_ns: 1_000_000 * seq };
    (topic.id, stamps, payload)
}

/// SplitMix64.
struct Numbers(u64);

impl Numbers {
    /// From −1 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recording");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}
