#[path = "../../bench/src/modal_records/defects.rs"]
mod defects;
#[path = "../../bench/src/modal_records/generator.rs"]
mod generator;
#[path = "../../bench/src/modal_records/structure.rs"]
mod structure;
use defects::{Defect, record};
use generator::Generator;
use modal::{Config, operational, record::Record};
use structure::Structure;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (seed, n): (u64, u64) = (a[1].parse().unwrap(), a[2].parse().unwrap());
    let kinds: Vec<Defect> = Defect::ALL.into_iter().filter(|d| a[3..].iter().any(|k| d.name() == k)).collect();
    let verbose = std::env::var("V").is_ok();
    for kind in kinds {
        let (mut present, mut missed, mut invented, mut tones, mut named, mut false_tones, mut beside, mut beside_ok) =
            (0, 0, 0, 0, 0, 0, 0, 0);
        let (mut zf, mut zz) = (Vec::new(), Vec::new());
        let start = std::time::Instant::now();
        for k in 0..n {
            let mut g = Generator::new(seed * 1000 + k);
            let s = Structure::draw(&mut g);
            let r = record(&s, kind, &mut g);
            let rows: Vec<f64> = (0..r.columns[0].len()).flat_map(|t| r.columns.iter().map(move |c| c[t])).collect();
            let rec = Record::of_outputs(s.sample_rate_hz, s.channels, rows);
            let found = operational::identify(&rec, &[], &Config::new(s.channels, s.sample_rate_hz)).unwrap();
            let mut left = found.modes.clone();
            let mut miss = Vec::new();
            for (i, m) in s.modes.iter().enumerate() {
                present += 1;
                let d = |x: &modal::Mode| (x.frequency_hz - m.frequency_hz).abs();
                let best = (0..left.len())
                    .filter(|i| d(&left[*i]) < 0.015 * m.frequency_hz + m.damping_ratio * m.frequency_hz)
                    .min_by(|x, y| d(&left[*x]).total_cmp(&d(&left[*y])));
                let mut ok = false;
                match best {
                    Some(i) => {
                        let x = left.remove(i);
                        let (a, b) = (
                            (x.frequency_hz - m.frequency_hz) / x.sigma_frequency_hz,
                            (x.damping_ratio - m.damping_ratio) / x.sigma_damping,
                        );
                        zf.push(a);
                        zz.push(b);
                        ok = a.abs() < 4.0 && b.abs() < 4.0;
                        if verbose && !ok {
                            println!("  {k} mode {:.3} z {a:.1} {b:.1}", m.frequency_hz)
                        }
                    }
                    None => {
                        missed += 1;
                        miss.push((m.frequency_hz, m.damping_ratio));
                    }
                }
                if r.beside_mode == Some(i) {
                    beside += 1;
                    if ok {
                        beside_ok += 1
                    }
                }
            }
            let mut tl = found.tones.clone();
            for t in &r.tones_hz {
                tones += 1;
                if let Some(i) = tl.iter().position(|x| (x.frequency_hz / t - 1.0).abs() < 0.004) {
                    named += 1;
                    tl.remove(i);
                } else if verbose {
                    println!("  {k} tone {t:.3} not named");
                }
            }
            false_tones += tl.len();
            invented += left.len();
            if verbose {
                for x in &tl {
                    println!(
                        "  {k} false tone {:.3} wander {:.3} modes {:?}",
                        x.frequency_hz,
                        x.wander_hz,
                        s.modes.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect::<Vec<_>>()
                    )
                }
                for x in &left {
                    println!(
                        "  {k} invented {:.3} {:.4} dec {} orders {} mpc {:.2} tones {:?}",
                        x.frequency_hz, x.damping_ratio, x.decimation, x.orders_found, x.phase_collinearity, r.tones_hz
                    )
                }
                for x in &miss {
                    println!(
                        "  {k} missed {:.3} {:.4} all {:?} tones {:?}",
                        x.0,
                        x.1,
                        s.modes.iter().map(|m| m.frequency_hz).collect::<Vec<_>>(),
                        r.tones_hz
                    )
                }
            }
        }
        let rms = |v: &Vec<f64>| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
        let cov = |v: &Vec<f64>| 100.0 * v.iter().filter(|x| x.abs() < 1.96).count() as f64 / v.len() as f64;
        println!(
            "{:18} modes {present} missed {missed} invented {invented} z {:.2} {:.2} cov {:.0} {:.0} tones {tones} named {named} false {false_tones} beside {beside_ok}/{beside}  {:.2} s each",
            kind.name(),
            rms(&zf),
            rms(&zz),
            cov(&zf),
            cov(&zz),
            start.elapsed().as_secs_f64() / n as f64
        );
    }
}
