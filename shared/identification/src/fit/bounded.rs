//! Least squares with entries that may not leave their room.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Diagonal load of the scaled matrix: exact twins share their amplitude instead of failing.
const LOAD: f64 = 1e-11;
/// Relative overstep that is rounding.
const OVERSTEP: f64 = 1e-9;

/// Greatest decrease `2 bᵀx − xᵀMx` and its `x` over the entries at `places`; entry `i` stays
/// within `room[i]`, entries behind the list are free.
///
/// Entries that would leave are held at their edge and the rest solved again, until none leaves (at
/// most once per entry). What is held is not let go again: the minimum is one of its face, which is
/// the constrained one where the entries hardly interact. `None`: the matrix is not positive.
///
/// Cost: O(k³) per round of holding.
pub fn bounded(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    room: &[[f64; 2]],
    places: &[usize],
) -> Option<(f64, Vec<f64>)> {
    let mut x = vec![0.0; places.len()];
    let mut held = vec![false; places.len()];
    loop {
        let free: Vec<usize> = (0..places.len()).filter(|i| !held[*i]).collect();
        let scale: Vec<f64> = free.iter().map(|i| 1.0 / matrix[(places[*i], places[*i])].max(1e-300).sqrt()).collect();
        let k = free.len();
        let scaled = DMatrix::from_fn(k, k, |a, b| {
            matrix[(places[free[a]], places[free[b]])] * scale[a] * scale[b] * if a == b { 1.0 + LOAD } else { 1.0 }
        });
        let known = |row: usize| -> f64 {
            let fixed = (0..places.len()).filter(|j| held[*j]);
            fixed.map(|j| matrix[(places[row], places[j])] * x[j]).sum()
        };
        let b = DVector::from_fn(k, |a, _| (right[places[free[a]]] - known(free[a])) * scale[a]);
        let solved = Cholesky::new(scaled)?.solve(&b);
        let mut left = false;
        for (a, i) in free.iter().enumerate() {
            x[*i] = solved[a] * scale[a];
            let Some([low, high]) = room.get(places[*i]) else { continue };
            if x[*i] < low - OVERSTEP || x[*i] > high + OVERSTEP {
                x[*i] = x[*i].clamp(*low, *high);
                held[*i] = true;
                left = true;
            }
        }
        if !left {
            return Some((decrease(matrix, right, places, &x), x));
        }
    }
}

fn decrease(matrix: &DMatrix<f64>, right: &DVector<f64>, places: &[usize], x: &[f64]) -> f64 {
    let row = |i: usize| -> f64 { places.iter().zip(x).map(|(j, x)| matrix[(places[i], *j)] * x).sum() };
    (0..x.len()).map(|i| x[i] * (2.0 * right[places[i]] - row(i))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entry_that_would_leave_its_room_stands_at_the_edge_and_the_others_make_the_best_of_it() {
        let matrix = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.3, 1.0, 3.0, 0.2, 0.3, 0.2, 1.5]);
        let right = DVector::from_row_slice(&[-1.0, 2.0, 0.7]);
        let (gain, x) = bounded(&matrix, &right, &[[0.0, 5.0], [-9.0, 9.0]], &[0, 1, 2]).expect("positive");
        assert_eq!(x[0], 0.0);
        // the two others by hand, 2 x 2; tolerance: the diagonal load
        let determinant = 3.0 * 1.5 - 0.2 * 0.2;
        let by_hand = [(2.0 * 1.5 - 0.7 * 0.2) / determinant, (3.0 * 0.7 - 0.2 * 2.0) / determinant];
        assert!((x[1] - by_hand[0]).abs() < 1e-10 && (x[2] - by_hand[1]).abs() < 1e-10);
        assert!((gain - (by_hand[0] * 2.0 + by_hand[1] * 0.7)).abs() < 1e-10);
        // free, the decrease is the larger one
        let (free, y) = bounded(&matrix, &right, &[], &[0, 1, 2]).expect("positive");
        assert!(free > gain && y[0] < 0.0);
    }

    #[test]
    fn entries_outside_the_list_stay_at_nothing() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]);
        let right = DVector::from_row_slice(&[4.0, 2.0]);
        let (gain, x) = bounded(&matrix, &right, &[], &[0]).expect("positive");
        assert!((x[0] - 2.0).abs() < 1e-9 && (gain - 8.0).abs() < 1e-9);
    }
}
