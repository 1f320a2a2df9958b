//! The levels of a converter: values that are multiples of a step.

use core::f64::consts::PI;
use identification::statistics::mean;

/// Values that lie on multiples of a step.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Distance of neighbouring values, in their unit.
    pub step: f64,
    /// Number of different values.
    pub levels: usize,
}

/// The step whose multiples the values are, if there is one.
///
/// Candidates are low quantiles of the differences between neighbouring distinct values, each
/// refined by regressing the values on their counts. Accepted when the resultant R of the residues
/// exceeds 0.95 and Rayleigh's `exp(-U R²)` over U distinct values stays below 1e-6 over all
/// candidates.
///
/// Long series are judged by [`LATTICE_BLOCKS`] stretches of them, spread evenly: the levels of a
/// part lie on the lattice of the whole. Levels are counted in all samples.
pub fn lattice(values: &[f64]) -> Option<Lattice> {
    if values.len() <= LATTICE_SAMPLES_MAX {
        return lattice_of(&distinct(values.iter().copied()));
    }
    let (size, apart) = (LATTICE_SAMPLES_MAX / LATTICE_BLOCKS, values.len() / LATTICE_BLOCKS);
    let part = (0..LATTICE_BLOCKS).flat_map(|b| values[b * apart..b * apart + size].iter().copied());
    let found = lattice_of(&distinct(part))?;
    Some(Lattice { levels: distinct(values.iter().copied()).len(), ..found })
}

/// Samples that show a lattice: with U levels seen the Rayleigh bound is `exp(-U R²)`, and 17
/// levels reach it. Also where a series counts as long.
const LATTICE_SAMPLES_MAX: usize = 1 << 16;
/// Stretches of a long series: neighbours in time have neighbouring levels, whose distance is the
/// step; stretches meet levels all over the range.
const LATTICE_BLOCKS: usize = 64;

/// The different values in ascending order.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut distinct: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    // values that compare equal in this order have the same bits
    distinct.sort_unstable_by(f64::total_cmp);
    let largest = distinct.first().map_or(0.0, |v| v.abs()).max(distinct.last().map_or(0.0, |v| v.abs()));
    // Files carry at least seven digits; nearer values are one level.
    let apart = 3e-7 * largest;
    distinct.dedup_by(|b, a| *b - *a <= apart);
    distinct
}

fn lattice_of(distinct: &[f64]) -> Option<Lattice> {
    let levels = distinct.len();
    let mut gaps: Vec<f64> = distinct.windows(2).map(|w| w[1] - w[0]).collect();
    if levels < 6 {
        return None;
    }
    gaps.sort_by(f64::total_cmp);
    let at = |q: f64| gaps[(q * (gaps.len() - 1) as f64) as usize];
    let mut best: Option<(f64, f64)> = None;
    for start in [at(0.0), at(0.05), at(0.2), at(0.5)] {
        for part in [1.0, 2.0, 3.0] {
            let Some((step, resultant)) = refine(distinct, start / part) else { continue };
            // The largest step that fits: every divisor of a step fits too.
            if resultant > 0.95
                && levels as f64 * resultant * resultant > 17.0
                && best.is_none_or(|(s, _)| step > 1.2 * s)
            {
                best = Some((step, resultant));
            }
        }
    }
    best.map(|(step, _)| Lattice { step, levels })
}

/// Least-squares step near `start` and the resultant of the residues.
fn refine(distinct: &[f64], start: f64) -> Option<(f64, f64)> {
    let (mut step, mut offset) = (start, distinct[0]);
    for _ in 0..6 {
        let (mut count, mut previous) = (0.0, distinct[0]);
        let counts: Vec<f64> = distinct
            .iter()
            .map(|v| {
                count += libm::round((v - previous) / step);
                previous = *v;
                count
            })
            .collect();
        let (mean_k, mean_v) = (mean(&counts), mean(distinct));
        let squares: f64 = counts.iter().map(|k| (k - mean_k) * (k - mean_k)).sum();
        if squares == 0.0 {
            return None;
        }
        step = counts.iter().zip(distinct).map(|(k, v)| (k - mean_k) * (v - mean_v)).sum::<f64>() / squares;
        offset = mean_v - step * mean_k;
        if step.is_nan() || step <= 0.0 {
            return None;
        }
    }
    let (mut c, mut s) = (0.0, 0.0);
    for v in distinct {
        // whole turns first: of a large argument the library would take them out digit by digit
        let turns = (v - offset) / step;
        let phase = 2.0 * PI * (turns - libm::round(turns));
        c += libm::cos(phase);
        s += libm::sin(phase);
    }
    Some((step, (c * c + s * s).sqrt() / distinct.len() as f64))
}
