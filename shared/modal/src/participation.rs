//! Which of many poles carry a free decay: the one that explains most is taken, then the one that
//! explains most of the rest.

use crate::maximum_likelihood::free_columns;
use crate::projection::{Basis, dot};
use crate::record::Record;
use faer::c64;

/// The `count` poles (continuous time) that together explain most of the segments, each with
/// amplitudes of its own per segment.
///
/// Cost: candidates × chosen × samples × channels.
pub(crate) fn strongest(record: &Record, candidates: &[c64], count: usize) -> Vec<c64> {
    let mut rest = candidates.to_vec();
    let mut chosen: Vec<c64> = Vec::new();
    while chosen.len() < count && !rest.is_empty() {
        let mut gains = vec![0.0; rest.len()];
        for segment in record.segments.iter().filter(|segment| !segment.is_empty()) {
            let rows = segment.len();
            let mut known = vec![1.0; rows];
            chosen.iter().for_each(|pole| known.extend(free_columns(record.sample_rate_hz, rows, *pole)));
            let known = Basis::new(known, rows);
            let residuals: Vec<Vec<f64>> = (0..record.channels)
                .map(|c| {
                    let mut y = record.channel(c, segment.clone());
                    known.project_out(&mut y);
                    y
                })
                .collect();
            for (pole, gain) in rest.iter().zip(&mut gains) {
                *gain += explained(&known, free_columns(record.sample_rate_hz, rows, *pole), &residuals);
            }
        }
        let mut best = 0;
        for (k, gain) in gains.iter().enumerate() {
            if *gain > gains[best] {
                best = k;
            }
        }
        chosen.push(rest.swap_remove(best));
    }
    chosen
}

/// Power of `residuals` along the part of `columns` that is not known yet.
fn explained(known: &Basis, mut columns: Vec<f64>, residuals: &[Vec<f64>]) -> f64 {
    let rows = residuals[0].len();
    columns.chunks_exact_mut(rows).for_each(|column| {
        known.project_out(column);
    });
    let Ok([re, im]): Result<[&[f64]; 2], _> = columns.chunks_exact(rows).collect::<Vec<_>>().try_into() else {
        return 0.0;
    };
    // Solve the 2 × 2 problem of the two columns.
    let (a, b, c) = (dot(re, re), dot(re, im), dot(im, im));
    let determinant = a * c - b * b;
    if c <= 1e-20 * a {
        // A real pole has no second column.
        return if a > 0.0 { residuals.iter().map(|y| dot(re, y) * dot(re, y) / a).sum() } else { 0.0 };
    }
    if determinant.is_nan() || determinant <= 1e-20 * a * c {
        return 0.0;
    }
    let power = |y: &Vec<f64>| {
        let (p, q) = (dot(re, y), dot(im, y));
        (c * p * p - 2.0 * b * p * q + a * q * q) / determinant
    };
    residuals.iter().map(power).sum()
}
