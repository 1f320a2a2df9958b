//! Measured peaks and the plant's modes brought together in order.
//!
//! A spectrum holds peaks that are no modes of the plant (mains, other directions), and modes that were not excited are not in it. All
//! frequencies may be off by a common factor. For every factor in question the best assignment in rising order is found by dynamic
//! programming: a pair costs the square of its distance over [`SPREAD`], a mode left out [`LEFT_OUT`], a faint peak more than a tall one.

use super::MeasuredMode;

/// Distance in ln f at which a pair costs one, beyond the common factor.
const SPREAD: f64 = 0.04;
/// Cost of a mode of the plant without a peak; a pair never costs more.
const LEFT_OUT: f64 = 6.0;
/// Largest common factor in question, as |ln|, and its cost per square.
const FACTOR_MAX: f64 = 0.5;
const FACTOR_SPREAD: f64 = 0.25;

/// Pairs (mode of the plant, measured mode), both rising.
pub(super) fn pairs(plant_hz: &[f64], measured: &[MeasuredMode]) -> Vec<(usize, usize)> {
    if plant_hz.is_empty() || measured.is_empty() {
        return Vec::new();
    }
    let tallest = measured.iter().map(|m| libm::log(m.prominence)).fold(0.0, f64::max);
    let faint: Vec<f64> = measured.iter().map(|m| tallest - libm::log(m.prominence)).collect();
    // what was measured beyond the plant's last mode, or below its first, says nothing
    let mut factors = vec![0.0];
    for f in plant_hz {
        let near = measured.iter().map(|m| libm::log(m.frequency_hz / f));
        factors.extend(near.filter(|s| s.abs() < FACTOR_MAX));
    }
    let mut best: (f64, Vec<(usize, usize)>) = (f64::INFINITY, Vec::new());
    for s in factors {
        let (cost, list) = assign(plant_hz, measured, &faint, s);
        let cost = cost + (s / FACTOR_SPREAD) * (s / FACTOR_SPREAD);
        if cost < best.0 - 1e-9 {
            best = (cost, list);
        }
    }
    best.1
}

fn assign(plant_hz: &[f64], measured: &[MeasuredMode], faint: &[f64], s: f64) -> (f64, Vec<(usize, usize)>) {
    let (n, m) = (plant_hz.len(), measured.len());
    // modes above the last line or below the first were not looked for: they cost half
    let low = measured[0].frequency_hz * 0.8;
    let high = measured[m - 1].frequency_hz * 1.25;
    let left_out: Vec<f64> = plant_hz
        .iter()
        .map(|f| {
            let at = f * libm::exp(s);
            if at < low || at > high { 0.5 * LEFT_OUT } else { LEFT_OUT }
        })
        .collect();
    let pair = |i: usize, j: usize| {
        let away = (libm::log(measured[j].frequency_hz / plant_hz[i]) - s) / SPREAD;
        away * away + 0.3 * faint[j]
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
    (cost[n][m], list)
}
