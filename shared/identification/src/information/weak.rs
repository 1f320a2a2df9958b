//! Combinations of numbers that an experiment does not show.

use dynamics::description::Parameter;
use nalgebra::DMatrix;

/// Entries of a weak combination that are named, of its largest.
const NAMED_SHARE: f64 = 0.1;

/// A combination of numbers that the experiment does not show: it may move along it by a prior
/// sigma and the data hardly change.
#[derive(Clone, Debug, PartialEq)]
pub struct Blind {
    /// Weights in prior sigmas, of unit length as a whole, largest first.
    pub weights: Vec<(String, f64)>,
    /// Posterior to prior sigma of the combination that it is.
    pub ratio: f64,
}

/// A sparse basis of the space that the orthonormal rows of `weak` span.
pub(super) fn combinations(
    weak: DMatrix<f64>,
    uncertain: &[(Parameter, f64)],
    covariance: &DMatrix<f64>,
) -> Vec<Blind> {
    let mut found: Vec<(usize, Blind)> = echelon(weak)
        .row_iter()
        .map(|row| {
            let unit = row.transpose().normalize();
            let ratio = unit.dot(&(covariance * &unit)).max(0.0).sqrt();
            let largest = unit.amax();
            let named = unit.iter().enumerate().filter(|(_, weight)| weight.abs() > NAMED_SHARE * largest);
            let mut weights: Vec<(usize, f64)> = named.map(|(i, weight)| (i, *weight)).collect();
            // the first in file order moves up
            let sign = weights.first().map_or(1.0, |(_, weight)| weight.signum());
            let first = weights.first().map_or(0, |(i, _)| *i);
            weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let weights = weights.into_iter().map(|(i, weight)| (uncertain[i].0.name.clone(), sign * weight)).collect();
            (first, Blind { weights, ratio })
        })
        .collect();
    found.sort_by_key(|(first, _)| *first);
    found.into_iter().map(|(_, blind)| blind).collect()
}

/// Reduced echelon form with complete pivoting: every row owns a number that no other row moves.
/// Singly unseen numbers come out alone.
fn echelon(mut rows: DMatrix<f64>) -> DMatrix<f64> {
    let mut open: Vec<usize> = (0..rows.nrows()).collect();
    while !open.is_empty() {
        let entries = open.iter().flat_map(|r| (0..rows.ncols()).map(move |c| (*r, c)));
        let size = |at: &(usize, usize)| rows[*at].abs();
        let Some((r, c)) = entries.max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        if rows[(r, c)] == 0.0 {
            break;
        }
        let pivot = rows.row(r) / rows[(r, c)];
        rows.row_mut(r).copy_from(&pivot);
        for other in (0..rows.nrows()).filter(|other| *other != r) {
            let reduced = rows.row(other) - &pivot * rows[(other, c)];
            rows.row_mut(other).copy_from(&reduced);
        }
        open.retain(|row| *row != r);
    }
    rows
}
