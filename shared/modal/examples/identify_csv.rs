//! Modes of a recording: `zcat record.csv.gz | identify_csv [first_row] [column ...]`. First column
//! time in seconds, then channels.

use modal::{Config, ModalIdentifier, Rejection};
use std::io::BufRead;

fn main() {
    let arguments: Vec<usize> = std::env::args().skip(1).map(|a| a.parse().expect("row and column numbers")).collect();
    let first_row = arguments.first().copied().unwrap_or(0);
    let rows: Vec<Vec<f64>> = std::io::stdin()
        .lock()
        .lines()
        .filter_map(|line| {
            let line = line.ok()?;
            let numbers: Result<Vec<f64>, _> =
                line.split(',').map(str::trim).filter(|x| !x.is_empty()).map(str::parse).collect();
            numbers.ok()
        })
        .skip(first_row)
        .collect();
    let columns: Vec<usize> = if arguments.len() > 1 { arguments[1..].to_vec() } else { (1..rows[0].len()).collect() };
    let rate_hz = (rows.len() - 1) as f64 / (rows[rows.len() - 1][0] - rows[0][0]);
    let mut identifier = ModalIdentifier::new(Config::new(columns.len(), rate_hz));
    let started = std::time::Instant::now();
    for row in &rows {
        let sample: Vec<f64> = columns.iter().map(|c| row[*c]).collect();
        identifier.push(&sample);
    }
    let pushed = started.elapsed();
    let selection = identifier.identify_with_reasons().expect("a record with signal");
    println!(
        "{} rows at {rate_hz:.4} Hz, push {:.2} us/sample, identify {:?}",
        rows.len(),
        pushed.as_secs_f64() * 1e6 / rows.len() as f64,
        started.elapsed() - pushed
    );
    for m in &selection.modes {
        println!(
            "{:9.4} ± {:.4} Hz  zeta {:.5} ± {:.5}  channel {} share {:.2?} mpc {:.2} orders {} order {} decimation {}",
            m.frequency_hz,
            m.sigma_frequency_hz,
            m.damping_ratio,
            m.sigma_damping,
            m.dominant_channel,
            m.channel_share,
            m.phase_collinearity,
            m.orders_found,
            m.order,
            m.decimation
        );
    }
    for pole in &selection.rejected {
        if std::env::var("VERBOSE").is_ok()
            && !matches!(pole.reason, Rejection::NotOscillating | Rejection::OutOfBand { .. })
        {
            println!(
                "rejected 1/{} order {} {:.3} Hz zeta {:.4}: {:?}",
                pole.decimation, pole.order, pole.frequency_hz, pole.damping_ratio, pole.reason
            );
        }
    }
}
