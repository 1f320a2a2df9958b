//! Monte Carlo figures: `campaign decay SEEDS [bias]`, `campaign ambient SEEDS`,
//! `campaign twelve SEEDS`, `campaign random SEEDS`.

#[path = "../tests/laws/cases/mod.rs"]
mod cases;

use cases::TrueMode;
use cases::appendage::{Appendage, CHANNELS, SAMPLE_RATE_HZ, SIGMA_M_S2};
use cases::noise::Noise;
use cases::random_system::{Excitation, add_mode, random_record};
use modal::{Config, ModalIdentifier, Mode};
use std::time::Instant;

fn profile() {
    let record = Appendage::new().record(1, SIGMA_M_S2, 0.0);
    let mut covariance = modal::streaming::StreamingCovariance::new(CHANNELS, 40);
    record.iter().for_each(|sample| covariance.push(sample));
    for _ in 0..3 {
        let t_0 = Instant::now();
        let gram = covariance.gram();
        let t_1 = Instant::now();
        let realisation = modal::ssi_cov::realise(&gram, 30).expect("signal");
        let t_2 = Instant::now();
        let poles: Vec<_> = (1..=30).flat_map(|order| realisation.poles(order, SAMPLE_RATE_HZ)).collect();
        let t_3 = Instant::now();
        let residual = modal::uncertainty::residual(&gram, &realisation, 4);
        let t_4 = Instant::now();
        let few: Vec<_> = poles.iter().filter(|pole| pole.order == 4).collect();
        let deviations = modal::uncertainty::pole_deviations(
            &gram,
            modal::uncertainty::Blocks::Windows(&[]),
            &realisation,
            &few,
            SAMPLE_RATE_HZ,
        );
        println!(
            "gram {:?} factorise {:?} poles {:?} residual {:?} ({:.2}) deviations of {} {:?}",
            t_1 - t_0,
            t_2 - t_1,
            t_3 - t_2,
            t_4 - t_3,
            residual.whiteness_ratio,
            deviations.len(),
            t_4.elapsed()
        );
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let seeds: u64 = arguments[2].parse().expect("number of seeds");
    match arguments[1].as_str() {
        "decay" => {
            let bias = arguments.get(3).map_or(0.0, |b| b.parse().expect("bias in m/s2"));
            let truth = Appendage::new();
            coverage(seeds, SAMPLE_RATE_HZ, CHANNELS, &truth.modes, &[6.06e-6, 7.97e-4, 5.79e-6, 6.94e-4], |seed| {
                truth.record(seed, SIGMA_M_S2, bias)
            });
        }
        "ambient" => {
            let modes: Vec<TrueMode> = [(1.3, 0.012), (4.1, 0.008), (9.7, 0.015)]
                .map(|(frequency_hz, damping_ratio)| TrueMode { frequency_hz, damping_ratio })
                .into();
            let seconds: f64 = arguments.get(3).map_or(300.0, |b| b.parse().expect("seconds"));
            coverage(seeds, 50.0, 4, &modes, &[0.0; 4], |seed| {
                let mut noise = Noise::new(seed);
                let mut record = vec![vec![0.0; 4]; (50.0 * seconds) as usize];
                for mode in &modes {
                    add_mode(
                        &mut record,
                        mode.frequency_hz / 50.0,
                        mode.damping_ratio,
                        Excitation::WhiteNoise,
                        &mut noise,
                    );
                }
                record.iter_mut().flatten().for_each(|y| *y += 0.02 * noise.normal());
                record
            });
        }
        "twelve" => twelve(seeds),
        "profile" => profile(),
        "random" => {
            for (name, excitation) in [("decay", Excitation::Decay), ("white noise", Excitation::WhiteNoise)] {
                random(name, seeds, excitation);
            }
        }
        other => panic!("unknown campaign {other}"),
    }
}

/// Twelve modes between 0.5 and 20 Hz, at least three half-power widths apart, ten channels, sensor
/// noise 20 dB below, 2000 periods of the slowest.
fn twelve(seeds: u64) {
    const RATE_HZ: f64 = 50.0;
    let (mut counted, mut missed, mut spurious) = (0, 0, 0);
    let (mut in_f, mut in_z) = (0, 0);
    for seed in 0..seeds {
        let mut noise = Noise::new(seed);
        let mut truth: Vec<TrueMode> = Vec::new();
        while truth.len() < 12 {
            let frequency_hz = 0.5 * libm::pow(40.0, noise.uniform());
            let damping_ratio = noise.between(0.003, 0.02);
            let width = |f: f64, zeta: f64| 2.0 * zeta * f;
            let apart = |other: &TrueMode| {
                (other.frequency_hz - frequency_hz).abs()
                    > 3.0 * width(frequency_hz, damping_ratio).max(width(other.frequency_hz, other.damping_ratio))
            };
            if truth.iter().all(apart) {
                truth.push(TrueMode { frequency_hz, damping_ratio });
            }
        }
        truth.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let seconds = 2000.0 / truth[0].frequency_hz;
        let mut record = vec![vec![0.0; 10]; (RATE_HZ * seconds) as usize];
        for mode in &truth {
            add_mode(&mut record, mode.frequency_hz / RATE_HZ, mode.damping_ratio, Excitation::WhiteNoise, &mut noise);
        }
        let power = record.iter().flatten().map(|y| y * y).sum::<f64>() / (10 * record.len()) as f64;
        record.iter_mut().flatten().for_each(|y| *y += 0.1 * power.sqrt() * noise.normal());
        let mut config = Config::new(10, RATE_HZ);
        config.selection.order_max = 60;
        let mut identifier = ModalIdentifier::new(config);
        record.iter().for_each(|sample| identifier.push(sample));
        let mut modes = identifier.identify().unwrap_or_default();
        for t in &truth {
            // What an ambient record of that length allows, to first order.
            let bound = (t.damping_ratio / (4.0 * std::f64::consts::PI * t.frequency_hz * seconds)).sqrt();
            let near = |m: &Mode| (m.frequency_hz / t.frequency_hz - 1.0).abs() < t.damping_ratio.max(0.005);
            match modes.iter().position(near) {
                Some(at) => {
                    let m = modes.remove(at);
                    counted += 1;
                    in_f += usize::from((m.frequency_hz - t.frequency_hz).abs() < 1.96 * m.sigma_frequency_hz);
                    in_z += usize::from((m.damping_ratio - t.damping_ratio).abs() < 1.96 * m.sigma_damping);
                }
                None if bound < 0.002 => {
                    counted += 1;
                    missed += 1;
                    println!("seed {seed}: missed {:.4} Hz zeta {:.4}", t.frequency_hz, t.damping_ratio);
                }
                None => {}
            }
        }
        for m in &modes {
            println!(
                "seed {seed}: false {:.4} +- {:.4} Hz zeta {:.4} +- {:.4} orders {} order {} rate 1/{}",
                m.frequency_hz,
                m.sigma_frequency_hz,
                m.damping_ratio,
                m.sigma_damping,
                m.orders_found,
                m.order,
                m.decimation
            );
        }
        spurious += modes.len();
    }
    let found = (counted - missed) as f64;
    println!(
        "{seeds} records, {counted} modes, missed {missed}, false {spurious}; 95 % intervals hold f {:.3} zeta {:.3}",
        in_f as f64 / found,
        in_z as f64 / found
    );
}

fn identify(rate_hz: f64, channels: usize, record: &[Vec<f64>]) -> (Vec<Mode>, f64, f64) {
    let mut config = Config::new(channels, rate_hz);
    if let Ok(halvings) = std::env::var("HALVINGS") {
        config.halvings = halvings.parse().expect("halvings");
    }
    let mut identifier = ModalIdentifier::new(config);
    let started = Instant::now();
    record.iter().for_each(|sample| identifier.push(sample));
    let pushed = started.elapsed().as_secs_f64();
    let modes = identifier.identify().unwrap_or_default();
    (modes, pushed / record.len() as f64, started.elapsed().as_secs_f64() - pushed)
}

fn matches(mode: &Mode, truth: &TrueMode) -> bool {
    (mode.frequency_hz / truth.frequency_hz - 1.0).abs() < 0.03
}

fn coverage(
    seeds: u64,
    rate_hz: f64,
    channels: usize,
    truth: &[TrueMode],
    bounds: &[f64],
    record: impl Fn(u64) -> Vec<Vec<f64>>,
) {
    let mut stats = vec![[0.0_f64; 8]; truth.len()];
    let (mut missed, mut spurious, mut push, mut solve) = (0, 0, 0.0, 0.0);
    let mut orders = std::collections::BTreeMap::<(usize, usize), u32>::new();
    for seed in 0..seeds {
        let (modes, per_push, per_solve) = identify(rate_hz, channels, &record(seed));
        push += per_push / seeds as f64;
        solve += per_solve / seeds as f64;
        spurious += modes.iter().filter(|mode| !truth.iter().any(|t| matches(mode, t))).count();
        for (t, s) in truth.iter().zip(&mut stats) {
            let Some(mode) = modes.iter().find(|mode| matches(mode, t)) else {
                missed += 1;
                continue;
            };
            *orders.entry((mode.decimation, mode.order)).or_default() += 1;
            let (e_f, e_z) = (mode.frequency_hz - t.frequency_hz, mode.damping_ratio - t.damping_ratio);
            for (slot, value) in s.iter_mut().zip([
                1.0,
                e_f * e_f,
                e_z * e_z,
                f64::from(u8::from(e_f.abs() < 1.96 * mode.sigma_frequency_hz)),
                f64::from(u8::from(e_z.abs() < 1.96 * mode.sigma_damping)),
                mode.sigma_frequency_hz,
                mode.sigma_damping,
                e_z,
            ]) {
                *slot += value;
            }
        }
    }
    println!(
        "missed {missed} spurious {spurious}; push {:.2} us, identify {:.1} ms; (decimation, order): {orders:?}",
        push * 1e6,
        solve * 1e3
    );
    for (k, (t, s)) in truth.iter().zip(&stats).enumerate() {
        let n = s[0];
        let (f, z) = ((s[1] / n).sqrt() / t.frequency_hz, (s[2] / n).sqrt() / t.damping_ratio);
        let bound = |index: usize| bounds.get(index).copied().unwrap_or(0.0);
        println!(
            "{:.4} Hz: RMSE f {:.5} % zeta {:.4} % (over bound {:.2} {:.2}), bias zeta {:.3} %, coverage f {:.3} zeta {:.3}, mean sigma / RMSE f {:.2} zeta {:.2}",
            t.frequency_hz,
            100.0 * f,
            100.0 * z,
            f / bound(2 * k),
            z / bound(2 * k + 1),
            100.0 * s[7] / n / t.damping_ratio,
            s[3] / n,
            s[4] / n,
            s[5] / n / (t.frequency_hz * f),
            s[6] / n / (t.damping_ratio * z)
        );
    }
}

fn random(name: &str, seeds: u64, excitation: Excitation) {
    let (mut total, mut found, mut spurious, mut in_f, mut in_z, mut solve) = (0, 0, 0, 0, 0, 0.0_f64);
    for seed in 0..seeds {
        let r = random_record(seed, excitation);
        let (modes, _, seconds) = identify(r.sample_rate_hz, r.channels, &r.samples);
        solve = solve.max(seconds);
        let mut used = vec![false; modes.len()];
        for t in &r.modes {
            total += 1;
            match (0..modes.len()).find(|&m| !used[m] && matches(&modes[m], t)) {
                Some(m) => {
                    used[m] = true;
                    found += 1;
                    let (z_f, z_z) = (
                        (modes[m].frequency_hz - t.frequency_hz) / modes[m].sigma_frequency_hz,
                        (modes[m].damping_ratio - t.damping_ratio) / modes[m].sigma_damping,
                    );
                    if std::env::var("VERBOSE").is_ok() && z_f.abs().max(z_z.abs()) > 1.96 {
                        println!(
                            "{name} {seed}: {:.5} fs zeta {:.4} off by {z_f:.1} {z_z:.1} sigma: {:.5} {:.4} ± {:.4} orders {} order {} dec {} ({} channels, {} samples, {} modes)",
                            t.frequency_hz / r.sample_rate_hz,
                            t.damping_ratio,
                            modes[m].frequency_hz / r.sample_rate_hz,
                            modes[m].damping_ratio,
                            modes[m].sigma_damping,
                            modes[m].orders_found,
                            modes[m].order,
                            modes[m].decimation,
                            r.channels,
                            r.samples.len(),
                            r.modes.len()
                        );
                    }
                    in_f += usize::from(
                        (modes[m].frequency_hz - t.frequency_hz).abs() < 1.96 * modes[m].sigma_frequency_hz,
                    );
                    in_z +=
                        usize::from((modes[m].damping_ratio - t.damping_ratio).abs() < 1.96 * modes[m].sigma_damping);
                }
                None if std::env::var("VERBOSE").is_ok() => println!(
                    "{name} {seed}: missed {:.5} fs zeta {:.4} ({} channels, {} samples, {} modes)",
                    t.frequency_hz / r.sample_rate_hz,
                    t.damping_ratio,
                    r.channels,
                    r.samples.len(),
                    r.modes.len()
                ),
                None => {}
            }
        }
        for (m, _) in modes.iter().zip(&used).filter(|(_, used)| !**used) {
            spurious += 1;
            if std::env::var("VERBOSE").is_ok() {
                println!(
                    "{name} {seed}: spurious {:.5} ± {:.5} fs zeta {:.4} ± {:.4} mpc {:.2} orders {} order {} dec {} ({} channels, {} samples, {} modes)",
                    m.frequency_hz / r.sample_rate_hz,
                    m.sigma_frequency_hz / r.sample_rate_hz,
                    m.damping_ratio,
                    m.sigma_damping,
                    m.phase_collinearity,
                    m.orders_found,
                    m.order,
                    m.decimation,
                    r.channels,
                    r.samples.len(),
                    r.modes.len()
                );
            }
        }
    }
    println!(
        "{name}: {seeds} systems, {total} modes, found {found}, missed {}, spurious {spurious}; 95 % intervals hold f {:.3} zeta {:.3}; slowest identify {:.0} ms",
        total - found,
        in_f as f64 / found as f64,
        in_z as f64 / found as f64,
        solve * 1e3
    );
}
