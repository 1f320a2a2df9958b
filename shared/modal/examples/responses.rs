//! Modes of frequency responses: `responses ORDER FILE…`, each `frequency,real,imaginary` with a
//! header. Every line says the orders, the CPU time of the fit and the poles.

use modal::c64;
use modal::rational_fraction::{Orders, of_responses};

/// CPU time of this thread [s], from the scheduler.
fn cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    text.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut frequency_hz = Vec::new();
    let mut responses = Vec::new();
    for file in &arguments[1..] {
        let text = std::fs::read_to_string(file).expect("a file");
        let rows: Vec<Vec<f64>> =
            text.lines().skip(2).map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
        frequency_hz = rows.iter().map(|row| row[0]).collect();
        responses.push(rows.iter().map(|row| c64::new(row[1], row[2])).collect::<Vec<c64>>());
    }
    let most: usize = arguments[0].parse().expect("an order");
    for order in (10..=most).step_by(2) {
        for extra in [2, 4, 6, 10] {
            let orders = Orders { denominator: order, numerator: order + extra, transient: 0 };
            let begin = cpu_s();
            let found = of_responses(&frequency_hz, &responses, orders);
            let fit_s = cpu_s() - begin;
            match found {
                Ok(poles) => {
                    print!("{order}/{}: {fit_s:.4} s", order + extra);
                    for pole in poles {
                        let omega = pole.norm_sqr().sqrt();
                        print!("  {:.4} ({:.4} %)", omega / std::f64::consts::TAU, -100.0 * pole.re / omega);
                    }
                    println!();
                }
                Err(error) => println!("{order}: {error}"),
            }
        }
    }
}
