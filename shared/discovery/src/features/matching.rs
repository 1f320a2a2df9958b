//! Pairs of measured modes and the plant's, in order or by their shapes.
//!
//! A spectrum holds peaks that are no modes of the plant (mains, other directions), and modes that
//! were not excited are not in it. All frequencies may be off by a common factor. For every factor
//! the best assignment in rising order is found by dynamic programming: a pair costs the square of
//! its distance over [`PAIR_SPREAD`], an unmatched mode [`UNMATCHED_COST`], a faint peak more than
//! a tall one.
//!
//! Where shapes were measured, a pair costs by them as well, and pairs may cross: of two modes
//! whose frequencies have changed places the shapes identify each. A shape that is the same over
//! [`CHANNELS_MIN`] channels lets a frequency be further away.

use super::MeasuredMode;

/// Distance in ln f at which a pair costs one, beyond the common factor. Chosen, no derivation.
const PAIR_SPREAD: f64 = 0.04;
/// Cost of a mode of the plant without a peak; a pair never costs more. Chosen, no derivation.
const UNMATCHED_COST: f64 = 6.0;
/// Largest common factor in question, as |ln|, and its cost per square.
const FACTOR_MAX: f64 = 0.5;
const FACTOR_SPREAD: f64 = 0.25;

/// Cost of a pair of orthogonal shapes. Chosen, no derivation.
const SHAPE_COST: f64 = 4.0;
/// Shapes over so many channels with such a criterion are the same mode, whatever its frequency:
/// few are alike by accident.
const CHANNELS_MIN: usize = 3;
const SAME_MAC: f64 = 0.9;

/// How alike two shapes are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alike {
    pub mac: f64,
    pub channels: usize,
}

/// Pairs (mode of the plant, measured mode), the first rising; the second, too, where `alike`
/// (plant mode, measured mode) knows no shapes.
pub(super) fn pairs(
    plant_hz: &[f64],
    measured: &[MeasuredMode],
    alike: &dyn Fn(usize, usize) -> Option<Alike>,
) -> Vec<(usize, usize)> {
    if plant_hz.is_empty() || measured.is_empty() {
        return Vec::new();
    }
    let shapes: Vec<Vec<Option<Alike>>> =
        (0..plant_hz.len()).map(|i| (0..measured.len()).map(|j| alike(i, j)).collect()).collect();
    let tallest = measured.iter().map(|m| libm::log(m.prominence)).fold(0.0, f64::max);
    let faint: Vec<f64> = measured.iter().map(|m| tallest - libm::log(m.prominence)).collect();
    // a measured mode beyond the plant's last one, or below its first, is no evidence
    let mut factors = vec![0.0];
    for f in plant_hz {
        let near = measured.iter().map(|m| libm::log(m.frequency_hz / f));
        factors.extend(near.filter(|s| s.abs() < FACTOR_MAX));
    }
    let mut best: (f64, Vec<(usize, usize)>) = (f64::INFINITY, Vec::new());
    for s in factors {
        let (cost, list) = assign(plant_hz, measured, &faint, &shapes, s);
        let cost = cost + (s / FACTOR_SPREAD) * (s / FACTOR_SPREAD);
        if cost < best.0 - 1e-9 {
            best = (cost, list);
        }
    }
    best.1
}

fn assign(
    plant_hz: &[f64],
    measured: &[MeasuredMode],
    faint: &[f64],
    shapes: &[Vec<Option<Alike>>],
    s: f64,
) -> (f64, Vec<(usize, usize)>) {
    let (n, m) = (plant_hz.len(), measured.len());
    // modes above the last line or below the first were not looked for: they cost half
    let low = measured[0].frequency_hz * 0.8;
    let high = measured[m - 1].frequency_hz * 1.25;
    let left_out: Vec<f64> = plant_hz
        .iter()
        .map(|f| {
            let at = f * libm::exp(s);
            if at < low || at > high { 0.5 * UNMATCHED_COST } else { UNMATCHED_COST }
        })
        .collect();
    let pair = |i: usize, j: usize| {
        let ratio = libm::log(measured[j].frequency_hz / plant_hz[i]);
        let away = ((ratio - s) / PAIR_SPREAD) * ((ratio - s) / PAIR_SPREAD);
        let by_shape = match shapes[i][j] {
            Some(Alike { mac, channels }) if channels >= CHANNELS_MIN && mac > SAME_MAC && ratio.abs() < FACTOR_MAX => {
                away.min(libm::log1p(away)) + SHAPE_COST * (1.0 - mac)
            }
            Some(Alike { mac, .. }) => away + SHAPE_COST * (1.0 - mac),
            None => away,
        };
        by_shape + 0.3 * faint[j]
    };
    // cost[i][j]: the first i modes and the first j peaks
    let mut cost = vec![vec![0.0; m + 1]; n + 1];
    for i in 1..=n {
        for j in 0..=m {
            let mut least = cost[i - 1][j] + left_out[i - 1];
            if j > 0 {
                least = least.min(cost[i][j - 1]).min(cost[i - 1][j - 1] + pair(i - 1, j - 1));
            }
            cost[i][j] = least;
        }
    }
    let (mut i, mut j, mut list) = (n, m, Vec::new());
    while i > 0 && j > 0 {
        if cost[i][j] == cost[i][j - 1] {
            j -= 1;
        } else if cost[i][j] == cost[i - 1][j] + left_out[i - 1] {
            i -= 1;
        } else {
            list.push((i - 1, j - 1));
            (i, j) = (i - 1, j - 1);
        }
    }
    list.reverse();
    if shapes.iter().flatten().all(Option::is_none) {
        return (cost[n][m], list);
    }
    exchanged(list, m, &left_out, &pair)
}

/// Cost and pairs after every exchange that helps: two modes exchange their peaks.
fn exchanged(
    list: Vec<(usize, usize)>,
    peaks: usize,
    left_out: &[f64],
    pair: &dyn Fn(usize, usize) -> f64,
) -> (f64, Vec<(usize, usize)>) {
    let n = left_out.len();
    let mut of: Vec<Option<usize>> = vec![None; n];
    list.iter().for_each(|(i, j)| of[*i] = Some(*j));
    let cost = |i: usize, j: Option<usize>| j.map_or(left_out[i], |j| pair(i, j));
    // each exchange lowers the cost; more sweeps than modes have not been seen
    for _ in 0..n + 2 {
        let mut helped = false;
        for i in 0..n {
            for wanted in (0..peaks).map(Some).chain([None]) {
                let had = of[i];
                if wanted == had {
                    continue;
                }
                let holder = wanted.and_then(|j| of.iter().position(|of| *of == Some(j)));
                let before = cost(i, had) + holder.map_or(0.0, |h| cost(h, of[h]));
                let after = cost(i, wanted) + holder.map_or(0.0, |h| cost(h, had));
                if after < before - 1e-9 {
                    of[i] = wanted;
                    holder.into_iter().for_each(|h| of[h] = had);
                    helped = true;
                }
            }
        }
        if !helped {
            break;
        }
    }
    let total = (0..n).map(|i| cost(i, of[i])).sum();
    (total, of.iter().enumerate().filter_map(|(i, j)| j.map(|j| (i, j))).collect())
}
