#[path = "../../bench/src/modal_records/defects.rs"]
mod defects;
#[path = "../../bench/src/modal_records/generator.rs"]
mod generator;
#[path = "../../bench/src/modal_records/structure.rs"]
mod structure;
use modal::{Config, ModalIdentifier, Selection};
use {
    defects::{Defect, record},
    generator::Generator,
    structure::Structure,
};
fn flight(s: &Structure, rows: &[f64]) -> Selection {
    let mut id = ModalIdentifier::new(Config::new(s.channels, s.sample_rate_hz));
    rows.chunks(s.channels).for_each(|r| id.push(r));
    id.identify_with_reasons().unwrap()
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (seed, n, share): (u64, u64, f64) = (a[1].parse().unwrap(), a[2].parse().unwrap(), a[3].parse().unwrap());
    let kind = &a[4];
    let mut tot = (0, 0, 0, 0);
    let mut z = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    for k in 0..n {
        let mut g = Generator::new(seed * 1000 + k);
        let s = Structure::draw(&mut g);
        let r = record(&s, Defect::Clean, &mut g);
        let mut rows: Vec<f64> = (0..s.samples).flat_map(|t| r.columns.iter().map(move |c| c[t])).collect();
        let clean = flight(&s, &rows);
        let mut ng = Generator::new(seed * 777 + k);
        let l = s.channels;
        match kind.as_str() {
            "rows" => {
                for row in rows.chunks_mut(l) {
                    if ng.uniform() < share {
                        row.fill(f64::NAN)
                    }
                }
            }
            "cells" => {
                for y in rows.iter_mut() {
                    if ng.uniform() < share {
                        *y = f64::NAN
                    }
                }
            }
            "slow" => {
                for (t, row) in rows.chunks_mut(l).enumerate() {
                    if t % (share as usize) != 0 {
                        row[0] = f64::NAN
                    }
                }
            }
            "packets" => {
                let mut lost = 0;
                while (lost as f64) < share * s.samples as f64 {
                    let f = (ng.uniform() * (s.samples - 50) as f64) as usize;
                    let m = 2 + (ng.uniform() * 39.0) as usize;
                    rows[f * l..(f + m) * l].fill(f64::NAN);
                    lost += m;
                }
            }
            _ => {}
        }
        let found = modal::identifier::identify_by_pairs(&rows, &Config::new(l, s.sample_rate_hz)).unwrap();
        let take = |sel: &Selection, out: Option<&mut [Vec<f64>]>, print: bool| -> (Vec<bool>, usize) {
            let mut left: Vec<_> = sel.modes.clone();
            let mut o = out;
            let f: Vec<bool> = s
                .modes
                .iter()
                .map(|m| {
                    let best = (0..left.len())
                        .filter(|i| (left[*i].frequency_hz / m.frequency_hz - 1.0).abs() < 0.02 + 2.0 * m.damping_ratio)
                        .min_by(|x, y| {
                            ((left[*x].frequency_hz - m.frequency_hz).abs())
                                .total_cmp(&(left[*y].frequency_hz - m.frequency_hz).abs())
                        });
                    best.map(|i| {
                        let x = left.remove(i);
                        if let Some(o) = o.as_deref_mut() {
                            o[0].push((x.frequency_hz - m.frequency_hz) / x.sigma_frequency_hz);
                            o[1].push((x.damping_ratio - m.damping_ratio) / x.sigma_damping);
                        }
                    })
                    .is_some()
                })
                .collect();
            if print {
                for x in &left {
                    println!(
                        "  seed {k} invented {:.3} Hz {:.4} mpc {:.2} dec {} orders {}",
                        x.frequency_hz, x.damping_ratio, x.phase_collinearity, x.decimation, x.orders_found
                    )
                }
            }
            (f, left.len())
        };
        let (zc, zp) = z.split_at_mut(2);
        let (fc, ic) = take(&clean, Some(zc), false);
        let (fp, ip) = take(&found, Some(zp), true);
        for (i, m) in s.modes.iter().enumerate() {
            if fc[i] != fp[i] {
                println!(
                    "  seed {k} mode {:.3} Hz {:.4} clean {} pairs {}",
                    m.frequency_hz, m.damping_ratio, fc[i], fp[i]
                );
            }
        }
        tot.0 += fc.iter().filter(|x| **x).count();
        tot.1 += fp.iter().zip(&fc).filter(|(p, c)| !**p && **c).count();
        tot.2 += ic;
        tot.3 += ip;
    }
    let st = |v: &Vec<f64>| {
        let n = v.len() as f64;
        (
            format!("{:.2}", (v.iter().map(|x| x * x).sum::<f64>() / n).sqrt()),
            format!("{:.1}", 100.0 * v.iter().filter(|x| x.abs() < 1.96).count() as f64 / n),
            format!("{:.2}", v.iter().sum::<f64>() / n),
        )
    };
    println!("clean found {} lost by pairs {} invented clean {} pairs {}", tot.0, tot.1, tot.2, tot.3);
    for (n, v) in ["f clean", "z clean", "f pairs", "z pairs"].iter().zip(&z) {
        println!("{n}: rms z, coverage, mean {:?}", st(v));
    }
}
