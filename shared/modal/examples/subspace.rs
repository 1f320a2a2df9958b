//! Times and poles of one record: `subspace FILE CHANNELS RATE_HZ BLOCK_ROWS ORDER cov|data`, FILE
//! raw little-endian f64, sample by sample. One thread. CPU times. Prints one JSON object;
//! `tests/peers/modal.py` sets it beside other tools.

use modal::gram::gram;
use modal::ssi_cov::{Projection, realise_by};
use modal::streaming::StreamingCovariance;

/// CPU time of this thread [s], from the scheduler: what else the machine does has no part in it.
fn cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    text.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

/// Largest resident memory so far [kB].
fn memory_kb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("Linux");
    line.split_whitespace().next().and_then(|kb| kb.parse().ok()).expect("a number")
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments[k].parse::<f64>().expect("a number");
    let (channels, rate_hz, block_rows, order) =
        (number(1) as usize, number(2), number(3) as usize, number(4) as usize);
    let projection = if arguments[5] == "data" { Projection::Data } else { Projection::Covariance };
    let samples: Vec<f64> = std::fs::read(&arguments[0])
        .expect("a file")
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes")))
        .collect();
    let rows = samples.len() / channels;
    let mut streaming = StreamingCovariance::new(channels, block_rows);
    let begin = cpu_s();
    let streamed = rows.min(20_000);
    samples[..streamed * channels].chunks_exact(channels).for_each(|row| streaming.push(row));
    let update_us = 1e6 * (cpu_s() - begin) / streamed as f64;
    drop(streaming);
    let begin = cpu_s();
    let gram = gram(&samples, channels, block_rows, std::slice::from_ref(&(0..rows)));
    let gram_s = cpu_s() - begin;
    let realisation = realise_by(&gram, order, projection).expect("a record with signal");
    let factor_s = (cpu_s() - begin) - gram_s;
    let orders = 1..=realisation.order_max();
    let all: Vec<Vec<_>> = orders.map(|order| realisation.poles(order, rate_hz)).collect();
    let total_s = cpu_s() - begin;
    let last = all.last().expect("an order");
    let poles: Vec<String> = last
        .iter()
        .filter(|pole| pole.eigenvalue.im > 0.0)
        .map(|pole| format!("[{:.9},{:.9}]", pole.frequency_hz, pole.damping_ratio))
        .collect();
    println!(
        "{{\"memory_kb\":{},\"gram_s\":{gram_s:.4},\"factor_s\":{factor_s:.4},\"poles_s\":{:.4},\"total_s\":{total_s:.4},\"update_us\":{update_us:.2},\"poles\":[{}]}}",
        memory_kb(),
        total_s - gram_s - factor_s,
        poles.join(",")
    );
}
