//! A driver of an inertial measurement unit at 1 kHz: fills an `Imu` sample, writes its bytes to
//! the socket of `obsid gateway`. `imu_driver.c` beside it is the same in C.
//!
//! `obsid-imu-driver SOCKET SECONDS [--unpaced]`. Put the reading of your device into
//! [`read_device`].
#![forbid(unsafe_code)]

use std::io::Write;
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use telemetry::{Imu, Layout, Sample};
use zerocopy::IntoBytes;

const PERIOD: Duration = Duration::from_millis(1);
/// How long a gateway may take to come, or to come back.
const PATIENCE: Duration = Duration::from_secs(10);
/// Rate x, y, z and acceleration x, y, z.
const ALL_VALID: u64 = 0b11_1111;

/// Angular rate \[rad/s\] and mean acceleration \[m/s^2\] of sample `k`, in body axes.
fn read_device(k: u64) -> ([f64; 3], [f64; 3]) {
    let phase = (k % 1000) as f64 / 1000.0;
    ([0.0, 0.0, 0.02 * phase], [0.1 * phase, -0.05, 0.0])
}

fn sample(k: u64) -> Imu {
    let (omega_bi_b_rad_s, acceleration_b_m_s2) = read_device(k);
    let mut sample = Imu {
        interval_s: PERIOD.as_secs_f64(),
        omega_bi_b_rad_s,
        acceleration_b_m_s2,
        valid: ALL_VALID,
        ..Imu::zeroed_at(k * PERIOD.as_nanos() as u64)
    };
    sample.header.layout = Imu::HASH;
    sample
}

/// Waits for the gateway: it makes the socket, and makes it anew when it is restarted.
fn connect(path: &str) -> std::io::Result<UnixStream> {
    let since = Instant::now();
    loop {
        match UnixStream::connect(path) {
            Err(_) if since.elapsed() < PATIENCE => std::thread::sleep(10 * PERIOD),
            answer => return answer,
        }
    }
}

/// Samples written and samples lost.
pub fn drive(path: &str, count: u64, paced: bool) -> std::io::Result<(u64, u64)> {
    let (mut stream, mut lost) = (connect(path)?, 0);
    let begin = Instant::now();
    for k in 0..count {
        if paced {
            let due = PERIOD * u32::try_from(k).unwrap_or(u32::MAX);
            std::thread::sleep(due.saturating_sub(begin.elapsed()));
        }
        if stream.write_all(sample(k).as_bytes()).is_err() {
            lost += 1;
            stream = connect(path)?;
        }
    }
    Ok((count - lost, lost))
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (path, seconds, paced) = match &arguments[..] {
        [path, seconds] => (path, seconds.parse::<u64>(), true),
        [path, seconds, unpaced] if unpaced == "--unpaced" => (path, seconds.parse(), false),
        _ => {
            eprintln!("usage: obsid-imu-driver SOCKET SECONDS [--unpaced]");
            return ExitCode::from(2);
        }
    };
    match seconds.map_err(std::io::Error::other).and_then(|seconds| drive(path, 1000 * seconds, paced)) {
        Ok((written, lost)) => println!("{written} samples written, {lost} lost"),
        Err(error) => {
            eprintln!("obsid-imu-driver: {path}: {error}");
            return ExitCode::from(1);
        }
    }
    ExitCode::SUCCESS
}
