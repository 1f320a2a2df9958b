//! Held samples: a channel that is logged faster than its sensor is updated.
//!
//! Fresh values of an even update clock arrive at the rows `⌈φ + ρ j⌉`, ρ rows a value: the changes
//! of the channel stay on a straight line over their number, however many there are. Changes that
//! come by chance (the levels of a quantised signal, a signal at rest) do not: lengths of their
//! runs add up to a random walk. Of h neighbouring runs the length varies by `V_h ≤ 2/12` on the
//! line, by `h ρ (ρ - 1)` where each row has its own chance of a change (geometric lengths). The
//! channel is held if `V_h` is so small with a probability below `UPDATE_CHANCE` under the second
//! law.
//!
//! A ramp through the levels of a converter also changes at even rows, by one level each time, and
//! a piecewise constant command changes at few rows of its clock. So most changes must exceed one
//! level, many levels where a value stands for fewer than two rows, and most fresh values must
//! differ from the ones before.

use crate::lattice::lattice;
use estimation::quantiles::quantile;
use identification::statistics::chi_squared_tail;

/// Probability that changes which come by chance are taken for an update clock.
const UPDATE_CHANCE: f64 = 1e-6;
/// Runs added up, h: long enough for a walk of two rows a value to leave the line, √(8·2) rows.
const RUNS: usize = 8;
/// Changes looked at: six independent sums of [`RUNS`].
const CHANGES_MIN: usize = 6 * RUNS;
/// Longest deviation of the sums [rows²]: rounding to rows, 2/12, and one row of jitter each way at
/// both ends, 2·2/3.
const SUM_VARIANCE_MAX: f64 = 2.0 / 12.0 + 4.0 / 3.0;
/// Fewest rows a value: below, one row in ten repeats.
const ROWS_PER_VALUE_MIN: f64 = 1.1;
/// Share of the updates that bring another value; a command that is switched changes more seldom.
const FRESH_SHARE_MIN: f64 = 0.7;
/// Share of the changes that exceed the levels of the converter by as much as they must.
const LARGE_SHARE_MIN: f64 = 0.5;
/// Levels that a change must exceed where every row but few repeats: more than the one of a ramp.
const LEVELS_OF_REPEATS: f64 = 1.5;
/// As [`LEVELS_OF_REPEATS`], where a row seldom repeats: a change of eight levels is lost to
/// rounding once in eight times at most, and an oscillation loses it at even distances.
const LEVELS_OF_SELDOM: f64 = 8.0;
/// Share of single rows up to which every value repeats: a jitter of one row makes some.
const SINGLE_SHARE_MAX: f64 = 0.05;

/// The update clock of a channel whose values stand for several rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Rows from one fresh value to the next, ρ; the update rate is the rate of the rows over it.
    pub rows_per_value: f64,
    /// Rows at which fresh values arrive, ascending; among them those whose value repeats the one
    /// before.
    pub fresh_rows: Vec<usize>,
}

/// The update clock of a channel, if its values are held; `values` has one entry a row of an even
/// clock, NaN where there is none.
///
/// Needs 48 changes, and more of them the less ρ exceeds one. `None`: updated at every row, at
/// rest, quantised, switched, or too short to tell.
///
/// ```
/// let fresh = |k: usize| (1.3 * (k as f64)).sin();
/// let values: Vec<f64> = (0..1400).map(|row| fresh(row / 7)).collect();
/// let held = examination::held::held(&values).unwrap();
/// assert_eq!(held.rows_per_value, 7.0);
/// assert_eq!(held.fresh_rows[..3], [7, 14, 21]);
/// ```
#[must_use]
pub fn held(values: &[f64]) -> Option<Held> {
    let pair = |k: &usize| values[*k - 1].is_finite() && values[*k].is_finite();
    let pairs = (1..values.len()).filter(pair).count() as f64;
    let changes: Vec<usize> = (1..values.len()).filter(pair).filter(|&k| values[k] != values[k - 1]).collect();
    if changes.len() < CHANGES_MIN || pairs < ROWS_PER_VALUE_MIN * changes.len() as f64 {
        return None;
    }
    let single = changes.windows(2).filter(|pair| pair[1] - pair[0] == 1).count() as f64;
    let all_repeat = single <= SINGLE_SHARE_MAX * changes.len() as f64;
    if !large(values, &changes, if all_repeat { LEVELS_OF_REPEATS } else { LEVELS_OF_SELDOM }) {
        return None;
    }
    let (rows_per_value, updates) = updates(&changes);
    let share = (changes.len() - 1) as f64 / updates.iter().sum::<f64>();
    if rows_per_value < ROWS_PER_VALUE_MIN || share < FRESH_SHARE_MIN || !even(&changes, &updates, rows_per_value) {
        return None;
    }
    Some(Held { rows_per_value, fresh_rows: fresh_rows(&changes, &updates) })
}

/// Whether most changes exceed some levels.
fn large(values: &[f64], changes: &[usize], levels: f64) -> bool {
    let Some(lattice) = lattice(values) else {
        // few values are those of a switch or a coarse converter; off any lattice hardly two are
        // equal
        let different = changes.iter().map(|&k| values[k].to_bits()).collect::<std::collections::BTreeSet<_>>().len();
        return different as f64 >= LARGE_SHARE_MIN * changes.len() as f64;
    };
    let large = changes.iter().filter(|&&k| (values[k] - values[k - 1]).abs() > levels * lattice.step).count();
    large as f64 >= LARGE_SHARE_MIN * changes.len() as f64
}

/// Rows a value, and how many updates lie from each change to the next.
///
/// Runs up to one and a half times the usual one are one update. Below two rows a value two rows
/// are one update, too: a repeated value cannot be detected there.
fn updates(changes: &[usize]) -> (f64, Vec<f64>) {
    let runs: Vec<f64> = changes.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let usual = quantile(&mut runs.clone(), 0.5);
    let single: Vec<f64> = runs.iter().copied().filter(|run| *run <= (1.5 * usual).max(2.0)).collect();
    let mut rows_per_value = single.iter().sum::<f64>() / single.len() as f64;
    let count = |run: f64, rho: f64| if run <= 2.0 && rho < 2.0 { 1.0 } else { libm::round(run / rho).max(1.0) };
    for _ in 0..3 {
        let updates: f64 = runs.iter().map(|run| count(*run, rows_per_value)).sum();
        rows_per_value = runs.iter().sum::<f64>() / updates;
    }
    let updates = runs.iter().map(|run| count(*run, rows_per_value)).collect();
    (rows_per_value, updates)
}

/// Whether the changes stay on the line as the module's law asks.
fn even(changes: &[usize], updates: &[f64], rows_per_value: f64) -> bool {
    let mut number = 0.0;
    let mut off = vec![0.0];
    for (change, count) in changes[1..].iter().zip(updates) {
        number += count;
        off.push((change - changes[0]) as f64 - rows_per_value * number);
    }
    let sums: Vec<f64> = off.windows(RUNS + 1).map(|w| (w[RUNS] - w[0]) * (w[RUNS] - w[0])).collect();
    let variance = sums.iter().sum::<f64>() / sums.len() as f64;
    let independent = updates.len() as f64 / RUNS as f64;
    let by_chance = RUNS as f64 * rows_per_value * (rows_per_value - 1.0);
    let below = 1.0 - chi_squared_tail(independent * variance / by_chance, independent);
    variance <= SUM_VARIANCE_MAX && below < UPDATE_CHANCE
}

/// The changes, and between them the updates that brought the same value, evenly.
fn fresh_rows(changes: &[usize], updates: &[f64]) -> Vec<usize> {
    let mut rows = vec![changes[0]];
    for (pair, count) in changes.windows(2).zip(updates) {
        let run = (pair[1] - pair[0]) as f64;
        let count = *count as usize;
        rows.extend((1..=count).map(|j| pair[0] + libm::round(run * j as f64 / count as f64) as usize));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::held;
    use crate::noise::Noise;

    fn filtered(noise: &mut Noise, n: usize) -> Vec<f64> {
        let (mut x, mut v) = (0.0, 0.0);
        (0..n)
            .map(|_| {
                v += 0.3 * noise.normal() - 0.08 * x - 0.02 * v;
                x += v;
                x
            })
            .collect()
    }

    /// Values at `ratio` rows each, from a phase of its own.
    fn logged(fresh: &[f64], ratio: f64, phase: f64) -> Vec<f64> {
        let rows = (fresh.len() as f64 - 2.0) * ratio;
        (0..rows as usize).map(|row| fresh[(row as f64 / ratio + phase) as usize]).collect()
    }

    #[test]
    fn every_ratio_of_rates_is_found_with_its_phase() {
        for (seed, ratio) in [1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 50.0 / 12.0, 50.0 / 7.0, 7.0, 13.3].into_iter().enumerate()
        {
            let mut noise = Noise::new(seed as u64 + 9100);
            let phase = noise.uniform();
            let values = logged(&filtered(&mut noise, 700), ratio, phase);
            let found = held(&values).unwrap_or_else(|| panic!("{ratio}"));
            assert!((found.rows_per_value / ratio - 1.0).abs() < 0.01 / ratio, "{ratio} {}", found.rows_per_value);
            let rows: Vec<usize> = (1..values.len()).filter(|&k| values[k] != values[k - 1]).collect();
            assert_eq!(found.fresh_rows, rows, "{ratio}");
        }
    }

    #[test]
    fn a_repeated_value_among_fresh_ones_does_not_hide_the_clock() {
        let mut noise = Noise::new(9200);
        let coarse: Vec<f64> = filtered(&mut noise, 600).iter().map(|v| (2.0 * v).round() / 2.0).collect();
        let repeated = coarse.windows(2).filter(|w| w[0] == w[1]).count();
        assert!(repeated > 20, "{repeated}");
        let found = held(&logged(&coarse, 4.0, 0.0)).unwrap();
        assert_eq!(found.rows_per_value, 4.0);
        assert!(found.fresh_rows.windows(2).all(|w| w[1] - w[0] == 4));
    }

    #[test]
    fn a_jitter_of_one_row_and_missing_rows_do_not_hide_the_clock() {
        let mut noise = Noise::new(9300);
        let fresh = filtered(&mut noise, 600);
        let mut values = Vec::new();
        for (k, value) in fresh.iter().enumerate() {
            let end = 5 * (k + 1) + (noise.uniform() * 2.0) as usize;
            values.resize(end.max(values.len()), *value);
        }
        values.iter_mut().skip(700).step_by(311).for_each(|value| *value = f64::NAN);
        let found = held(&values).unwrap();
        assert!((found.rows_per_value - 5.0).abs() < 0.02, "{}", found.rows_per_value);
    }

    #[test]
    fn quantised_resting_switched_and_ramping_channels_are_not_held() {
        for seed in 0..40 {
            let mut noise = Noise::new(9400 + seed);
            let signal = filtered(&mut noise, 3000);
            for step in [0.05, 0.5, 2.0, 8.0] {
                let quantised: Vec<f64> = signal.iter().map(|v| (v / step).round() * step).collect();
                assert_eq!(held(&quantised), None, "quantised at {step}");
                let slow: Vec<f64> = (0..4000).map(|k| ((0.01 * k as f64).sin() * 9.0 / step).round() * step).collect();
                assert_eq!(held(&slow), None, "slow at {step}");
            }
            let rest: Vec<f64> = noise.series(3000, 0.4).iter().map(|v| v.round()).collect();
            assert_eq!(held(&rest), None, "rest");
            let ramp: Vec<f64> = (0..3000).map(|k| (0.3 * f64::from(k)).floor()).collect();
            assert_eq!(held(&ramp), None, "ramp");
            let (mut level, mut switched) = (0.0, Vec::new());
            for k in 0..3000 {
                if k % 10 == 0 && noise.uniform() < 0.4 {
                    level = noise.normal();
                }
                switched.push(level);
            }
            assert_eq!(held(&switched), None, "switched");
            assert_eq!(held(&signal), None, "fresh at every row");
        }
    }
}
