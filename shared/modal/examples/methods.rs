//! Monte Carlo of every method on the free decay and the forced record of the appendage:
//! `methods SEEDS`.

#[path = "../tests/laws/cases/mod.rs"]
mod cases;

use cases::appendage::{Appendage, CHANNELS, SAMPLE_RATE_HZ, SIGMA_M_S2};
use modal::mac::modal_assurance_criterion;
use modal::maximum_likelihood::{Model, bound};
use modal::methods::{METHODS, Settings};
use modal::record::Record;
use std::time::Instant;

fn main() {
    let seeds: u64 = std::env::args().nth(1).map_or(20, |n| n.parse().expect("number of seeds"));
    let bias = std::env::args().nth(2).is_none_or(|b| b != "unbiased");
    let truth = Appendage::new();
    let settings = Settings { band_hz: Some((0.5, 10.0)), bias, ..Settings::new(truth.modes.len()) };
    let poles: Vec<modal::c64> = truth
        .modes
        .iter()
        .map(|m| {
            let omega = 2.0 * std::f64::consts::PI * m.frequency_hz;
            modal::c64::new(-m.damping_ratio * omega, omega * (1.0 - m.damping_ratio * m.damping_ratio).sqrt())
        })
        .collect();
    let record = |seed: u64, sigma: f64| {
        let (torque, rows) = truth.forced(seed, sigma);
        let samples = rows.len();
        Record::of_outputs(SAMPLE_RATE_HZ, CHANNELS, rows.concat())
            .with_input(1, torque)
            .with_segments(std::iter::once(200..samples).collect())
    };
    let limits = bound(&record(0, 0.0), Model::FORCED, &poles, &[SIGMA_M_S2; CHANNELS]).expect("the torque excites");
    let only = std::env::args().nth(3);
    for method in METHODS.iter().filter(|m| only.as_ref().is_none_or(|o| o == m.name)) {
        let mut stats = vec![[0.0_f64; 6]; truth.modes.len()];
        let (mut seconds, mut failed) = (f64::INFINITY, 0);
        let mut worst = 0.0_f64;
        for seed in 0..seeds {
            let record = record(seed, SIGMA_M_S2);
            let begin = Instant::now();
            let found = (method.identify)(&record, &settings);
            seconds = seconds.min(begin.elapsed().as_secs_f64());
            let found = match found {
                Ok(found) => found,
                Err(error) => {
                    println!("{} seed {seed}: {error}", method.name);
                    failed += 1;
                    continue;
                }
            };
            for (k, t) in truth.modes.iter().enumerate() {
                let near = |f: f64| (f / t.frequency_hz - 1.0).abs();
                let Some(e) = found.iter().min_by(|a, b| near(a.frequency_hz).total_cmp(&near(b.frequency_hz))) else {
                    failed += 1;
                    continue;
                };
                let (e_f, e_z) = (e.frequency_hz - t.frequency_hz, e.damping_ratio - t.damping_ratio);
                stats[k][0] += e_f * e_f;
                stats[k][1] += e_z * e_z;
                if let Some(d) = e.deviation {
                    stats[k][2] += f64::from(u8::from(e_f.abs() < 1.96 * d.frequency_hz));
                    stats[k][3] += f64::from(u8::from(e_z.abs() < 1.96 * d.damping_ratio));
                }
                worst = worst.max(1.0 - modal_assurance_criterion(&e.mode_shape, &truth.shapes[k]));
            }
        }
        print!("{:<9} failed {failed} {:7.2} ms  1-MAC {worst:.1e}", method.name, 1e3 * seconds);
        for (k, (t, s)) in truth.modes.iter().zip(&stats).enumerate() {
            let (f, z) = ((s[0] / seeds as f64).sqrt(), (s[1] / seeds as f64).sqrt());
            let limit = |p: usize| limits[p * 4 + p].sqrt();
            print!(
                "  f {:.5} % ({:.3}, {:.3})  zeta {:.4} % ({:.3}, {:.3})",
                100.0 * f / t.frequency_hz,
                f / limit(2 * k),
                s[2] / seeds as f64,
                100.0 * z / t.damping_ratio,
                z / limit(2 * k + 1),
                s[3] / seeds as f64
            );
        }
        println!();
    }
    let percent = |p: usize, t: f64| 100.0 * limits[p * 4 + p].sqrt() / t;
    println!(
        "bound % {:.6} {:.4} {:.6} {:.4}",
        percent(0, truth.modes[0].frequency_hz),
        percent(1, truth.modes[0].damping_ratio),
        percent(2, truth.modes[1].frequency_hz),
        percent(3, truth.modes[1].damping_ratio)
    );
}
