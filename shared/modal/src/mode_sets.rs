//! Two sets of modes of one structure: the matrix of their assurance criteria over the channels
//! that both have, and which mode of one is which of the other.
//!
//! Modes are paired by the distance `d = |f_a − f_b|/f_b + 1 − MAC` (Magalhães, Cunha & Caetano
//! 2009): each must be the nearest of the other. With one common channel the criterion is 1 for all
//! pairs, and frequency alone decides.

use crate::mac::modal_assurance_criterion;
use faer::c64;

/// Two modes at one frequency whose shapes share nothing have this distance: no pair beyond it.
const DISTANCE_MAX: f64 = 1.0;

/// A mode as one of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct SetMode {
    pub frequency_hz: f64,
    pub damping_ratio: Option<f64>,
    /// Per channel of the set; empty where there is no phase.
    pub shape: Vec<c64>,
}

/// Modes over named channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModeSet {
    pub channels: Vec<String>,
    pub modes: Vec<SetMode>,
}

/// A mode of the rows and the one of the columns that it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub row: usize,
    pub column: usize,
    pub mac: f64,
    /// `f_row / f_column − 1`.
    pub frequency_change: f64,
    /// `ζ_row − ζ_column`.
    pub damping_change: Option<f64>,
}

/// Rows against columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Channels of both sets, in the order of the rows.
    pub common: Vec<String>,
    /// Channels of one set only: of the rows, of the columns.
    pub unpaired: [Vec<String>; 2],
    /// MAC, one row per mode of the rows.
    pub values: Vec<Vec<f64>>,
    /// In the order of the rows.
    pub pairs: Vec<Pair>,
}

/// Compares two sets over the channels of the same name; without a common channel all values are
/// zero and there are no pairs.
///
/// ```
/// use modal::c64;
/// use modal::mode_sets::{ModeSet, SetMode, compare};
/// let set = |frequency_hz: f64, tip: f64| ModeSet {
///     channels: vec!["root".into(), "tip".into()],
///     modes: vec![SetMode {
///         frequency_hz,
///         damping_ratio: Some(0.01),
///         shape: vec![c64::new(1.0, 0.0), c64::new(tip, 0.0)],
///     }],
/// };
/// let found = compare(&set(5.1, 2.0), &set(5.0, 2.0));
/// assert!((found.pairs[0].mac - 1.0).abs() < 1e-12);
/// assert!((found.pairs[0].frequency_change - 0.02).abs() < 1e-12);
/// ```
#[must_use]
pub fn compare(rows: &ModeSet, columns: &ModeSet) -> Comparison {
    let place = |name: &String| columns.channels.iter().position(|other| other == name);
    let both: Vec<(usize, usize)> =
        rows.channels.iter().enumerate().filter_map(|(k, name)| Some((k, place(name)?))).collect();
    let only = |of: &[String], taken: &dyn Fn(usize) -> bool| -> Vec<String> {
        (0..of.len()).filter(|k| !taken(*k)).map(|k| of[k].clone()).collect()
    };
    let unpaired = [
        only(&rows.channels, &|k| both.iter().any(|pair| pair.0 == k)),
        only(&columns.channels, &|k| both.iter().any(|pair| pair.1 == k)),
    ];
    let mac = |a: &SetMode, b: &SetMode| {
        if a.shape.is_empty() || b.shape.is_empty() {
            return 0.0;
        }
        let a: Vec<c64> = both.iter().map(|pair| a.shape[pair.0]).collect();
        let b: Vec<c64> = both.iter().map(|pair| b.shape[pair.1]).collect();
        modal_assurance_criterion(&a, &b)
    };
    let values: Vec<Vec<f64>> = rows.modes.iter().map(|a| columns.modes.iter().map(|b| mac(a, b)).collect()).collect();
    let common = both.iter().map(|pair| rows.channels[pair.0].clone()).collect();
    Comparison { common, unpaired, pairs: pairs(rows, columns, &values), values }
}

/// Modes that are each other's nearest.
fn pairs(rows: &ModeSet, columns: &ModeSet, values: &[Vec<f64>]) -> Vec<Pair> {
    let distance = |i: usize, j: usize| {
        let (a, b) = (&rows.modes[i], &columns.modes[j]);
        (a.frequency_hz / b.frequency_hz - 1.0).abs() + 1.0 - values[i][j]
    };
    let nearest_row = |j: usize| (0..rows.modes.len()).min_by(|a, b| distance(*a, j).total_cmp(&distance(*b, j)));
    let nearest_column = |i: usize| (0..columns.modes.len()).min_by(|a, b| distance(i, *a).total_cmp(&distance(i, *b)));
    (0..rows.modes.len())
        .filter_map(|row| {
            let column = nearest_column(row)?;
            let (a, b) = (&rows.modes[row], &columns.modes[column]);
            (nearest_row(column) == Some(row) && distance(row, column) < DISTANCE_MAX).then(|| Pair {
                row,
                column,
                mac: values[row][column],
                frequency_change: a.frequency_hz / b.frequency_hz - 1.0,
                damping_change: a.damping_ratio.zip(b.damping_ratio).map(|(a, b)| a - b),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(channels: &[&str], modes: &[(f64, &[f64])]) -> ModeSet {
        let mode = |(frequency_hz, shape): &(f64, &[f64])| SetMode {
            frequency_hz: *frequency_hz,
            damping_ratio: None,
            shape: shape.iter().map(|x| c64::new(*x, 0.0)).collect(),
        };
        ModeSet {
            channels: channels.iter().map(|c| (*c).to_string()).collect(),
            modes: modes.iter().map(mode).collect(),
        }
    }

    #[test]
    fn channels_are_paired_by_name_whatever_their_order_and_the_rest_is_named() {
        let a = set(&["p", "q", "r"], &[(1.0, &[1.0, 2.0, 5.0])]);
        let b = set(&["q", "s", "p"], &[(1.0, &[-4.0, 9.0, -2.0])]);
        let found = compare(&a, &b);
        assert!((found.values[0][0] - 1.0).abs() < 1e-14);
        assert_eq!(found.common, ["p", "q"]);
        assert_eq!(found.unpaired, [vec!["r".to_string()], vec!["s".to_string()]]);
    }

    #[test]
    fn modes_that_changed_places_in_frequency_are_paired_by_their_shapes() {
        let a = set(&["p", "q"], &[(10.0, &[1.0, 0.1]), (10.4, &[-0.1, 1.0])]);
        let b = set(&["p", "q"], &[(10.1, &[-0.1, 1.0]), (10.5, &[1.0, 0.1])]);
        let pairs: Vec<(usize, usize)> = compare(&a, &b).pairs.iter().map(|pair| (pair.row, pair.column)).collect();
        assert_eq!(pairs, [(0, 1), (1, 0)]);
    }

    #[test]
    fn a_mode_that_the_other_set_lacks_has_no_partner() {
        let a = set(&["p", "q"], &[(10.0, &[1.0, 0.0]), (25.0, &[0.0, 1.0])]);
        let b = set(&["p", "q"], &[(10.1, &[1.0, 0.0])]);
        assert_eq!(compare(&a, &b).pairs.len(), 1);
    }
}
