//! Sums of products of whitened columns, without the whitened columns themselves: what a likelihood
//! under another noise takes.
//!
//! Gains, whitening and products go over a few events at a time, so that what is read twice is
//! still near the processor.

use super::gains::gains_in_parts;
use super::whiten::{Apart, LANES, Lane, PART, beside, samples};
use super::wide::wide;
use super::{Linear, NoiseModel};
use crate::problem::Timeline;

/// Adds `cᵢᵀ cⱼ` of the whitened `columns` of one run to `products` (row by row, j ≥ i); returns
/// `Σ ln |S|`. `None`: a covariance is not positive.
///
/// Cost: one recursion of the covariance, and per sample columns × (size of z + columns) products.
pub fn products(
    (linear, timeline): (&Linear, &Timeline),
    noise: &NoiseModel,
    columns: &[&[f64]],
    products: &mut [f64],
) -> Option<f64> {
    let bundles: Vec<&[&[f64]]> = columns.chunks(LANES).collect();
    let mut rows: Vec<Vec<Lane<LANES>>> = vec![Vec::new(); bundles.len()];
    let mut aparts: Vec<Apart<LANES>> = Vec::new();
    gains_in_parts(linear, timeline, noise, PART, &mut |gains, events| {
        while aparts.len() < bundles.len() {
            aparts.push(Apart::new(&gains.layout, timeline));
        }
        for ((bundle, apart), rows) in bundles.iter().zip(&mut aparts).zip(&mut rows) {
            beside(bundle, samples(timeline, &events), rows);
            apart.whiten((linear, timeline), (gains, events.start), events.clone(), rows);
        }
        for (a, left) in rows.iter().enumerate() {
            for (b, right) in rows.iter().enumerate().skip(a) {
                let found = wide(
                    #[inline(always)]
                    || block(left, right),
                );
                for (i, row) in found.iter().enumerate().take(bundles[a].len()) {
                    let at = (a * LANES + i) * columns.len() + b * LANES;
                    products[at..at + bundles[b].len()].iter_mut().zip(row).for_each(|(sum, part)| *sum += part);
                }
            }
        }
    })
}

/// Adds `aᵢᵀ bⱼ` of columns as they are to `sums`, row by row.
pub fn crossed(a: &[&[f64]], b: &[&[f64]], sums: &mut [f64]) {
    const STRETCH: usize = 512;
    let samples = a.first().map_or(0, |column| column.len());
    let (mut left, mut right): (Vec<Lane<LANES>>, Vec<Vec<Lane<LANES>>>) = (Vec::new(), Vec::new());
    right.resize(b.len().div_ceil(LANES), Vec::new());
    for begin in (0..samples).step_by(STRETCH) {
        let stretch = begin..(begin + STRETCH).min(samples);
        b.chunks(LANES).zip(&mut right).for_each(|(bundle, rows)| beside(bundle, stretch.clone(), rows));
        for (i, bundle) in a.chunks(LANES).enumerate() {
            beside(bundle, stretch.clone(), &mut left);
            for (j, right) in right.iter().enumerate() {
                let found = wide(
                    #[inline(always)]
                    || block(&left, right),
                );
                let width = LANES.min(b.len() - j * LANES);
                for (k, row) in found.iter().enumerate().take(bundle.len()) {
                    let at = (i * LANES + k) * b.len() + j * LANES;
                    sums[at..at + width].iter_mut().zip(row).for_each(|(sum, part)| *sum += part);
                }
            }
        }
    }
}

/// `Σ x yᵀ` over a stretch, half of x at a time: as many sums as the processor has room for.
#[inline(always)]
fn block(left: &[Lane<LANES>], right: &[Lane<LANES>]) -> [Lane<LANES>; LANES] {
    const HALF: usize = LANES / 2;
    let mut whole = [[0.0; LANES]; LANES];
    for half in [0, HALF] {
        let mut sums = [[0.0; LANES]; HALF];
        for (x, y) in left.iter().zip(right) {
            for (sums, x) in sums.iter_mut().zip(&x[half..]) {
                for (sum, y) in sums.iter_mut().zip(y) {
                    *sum += x * y;
                }
            }
        }
        whole[half..half + HALF].copy_from_slice(&sums);
    }
    whole
}
