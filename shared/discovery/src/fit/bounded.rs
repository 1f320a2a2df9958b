//! Least squares with entries that may not leave their room.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Diagonal load of the scaled matrix: exact twins share their amplitude instead of failing.
const LOAD: f64 = 1e-11;
/// Share of the way to the free minimum that is all of it.
const WHOLE: f64 = 1.0 - 1e-12;
/// Rounds for each entry.
const ROUNDS: usize = 4;

/// Greatest decrease `2 bᵀx − xᵀMx` and its `x` over the entries at `places`; entry `i` stays within `room[i]` (nothing lies within it), entries
/// behind the list are free.
///
/// From nothing towards the minimum of what is free; who meets its edge first is held there, and who would rather be off it in the end is let go again
/// (primal active set: no round loses anything). `None`: the matrix is not positive.
///
/// Cost: O(k³) per round.
pub fn bounded(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    room: &[[f64; 2]],
    places: &[usize],
) -> Option<(f64, Vec<f64>)> {
    let room = |i: usize| room.get(places[i]).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let slope = |x: &[f64], i: usize| -> f64 {
        right[places[i]] - places.iter().zip(x).map(|(j, x)| matrix[(places[i], *j)] * x).sum::<f64>()
    };
    let mut x = vec![0.0; places.len()];
    let mut held = vec![false; places.len()];
    for _ in 0..ROUNDS * (places.len() + 1) {
        let free: Vec<usize> = (0..places.len()).filter(|i| !held[*i]).collect();
        let step = free_step(matrix, places, &free, &free.iter().map(|i| slope(&x, *i)).collect::<Vec<f64>>())?;
        let share = |(i, by): (&usize, &f64)| {
            let [low, high] = room(*i);
            let edge = if *by < 0.0 { low } else { high };
            (if *by == 0.0 { f64::INFINITY } else { ((edge - x[*i]) / by).max(0.0) }, *i, edge)
        };
        let first = free.iter().zip(&step).map(share).min_by(|a, b| a.0.total_cmp(&b.0));
        let blocked = first.filter(|(share, ..)| *share < WHOLE);
        let share = blocked.map_or(1.0, |(share, ..)| share);
        free.iter().zip(&step).for_each(|(i, by)| x[*i] += share * by);
        if let Some((_, i, edge)) = blocked {
            (x[i], held[i]) = (edge, true);
            continue;
        }
        // whose slope leads off its edge
        let leads_off = |i: &usize| {
            let by = slope(&x, *i) / matrix[(places[*i], places[*i])].max(1e-300).sqrt();
            let gain = if x[*i] <= room(*i)[0] { by } else { -by };
            (gain > 1e-9 && room(*i)[0] < room(*i)[1]).then_some((gain, *i))
        };
        let most = (0..places.len()).filter(|i| held[*i]).filter_map(|i| leads_off(&i));
        match most.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, i)) => held[i] = false,
            None => break,
        }
    }
    Some((decrease(matrix, right, places, &x), x))
}

/// From where the free entries have these slopes to their minimum.
fn free_step(matrix: &DMatrix<f64>, places: &[usize], free: &[usize], slopes: &[f64]) -> Option<Vec<f64>> {
    let scale: Vec<f64> = free.iter().map(|i| 1.0 / matrix[(places[*i], places[*i])].max(1e-300).sqrt()).collect();
    let k = free.len();
    let scaled = DMatrix::from_fn(k, k, |a, b| {
        matrix[(places[free[a]], places[free[b]])] * scale[a] * scale[b] * if a == b { 1.0 + LOAD } else { 1.0 }
    });
    let right = DVector::from_fn(k, |a, _| slopes[a] * scale[a]);
    let solved = Cholesky::new(scaled)?.solve(&right);
    Some(solved.iter().zip(&scale).map(|(x, scale)| x * scale).collect())
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
    fn twins_that_would_both_leave_lose_nothing_and_who_need_not_be_held_is_let_go() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 0.99, 0.99, 1.0]);
        let right = DVector::from_row_slice(&[0.1, -0.1]);
        let (gain, x) = bounded(&matrix, &right, &[[-5.0, 5.0], [-0.1, 0.1]], &[0, 1]).expect("positive");
        // x₂ at its edge, x₁ = 0.1 + 0.99 · 0.1
        assert!((x[0] - 0.199).abs() < 1e-9 && x[1] == -0.1, "{x:?}");
        assert!((gain - (0.199 * 0.199 + 0.02 - 0.01)).abs() < 1e-9, "{gain}");
        // the first way meets the edge of x₁, which lies inside once x₂ is held
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 0.9, 0.9, 1.0]);
        let right = DVector::from_row_slice(&[1.0, -1.0]);
        let (_, x) = bounded(&matrix, &right, &[[-9.0, 3.0], [-1.0, 1.0]], &[0, 1]).expect("positive");
        assert!((x[0] - 1.9).abs() < 1e-9 && x[1] == -1.0, "{x:?}");
        // x₁ meets its edge on the way and is let go at the end: nowhere within the room is better
        let matrix = DMatrix::from_row_slice(3, 3, &[1.79, -0.53, 0.78, -0.53, 1.31, 0.66, 0.78, 0.66, 1.83]);
        let right = DVector::from_row_slice(&[0.3, -2.2, 0.9]);
        let room = [[-0.1, 0.5], [-0.2, 0.6], [-0.1, 0.2]];
        let (gain, x) = bounded(&matrix, &right, &room, &[0, 1, 2]).expect("positive");
        assert!((x[0] - (0.3 - 0.53 * 0.2 - 0.78 * 0.2) / 1.79).abs() < 1e-9 && x[1..] == [-0.2, 0.2], "{x:?}");
        let value = |x: [f64; 3]| decrease(&matrix, &right, &[0, 1, 2], &x);
        let at = |k: usize, i: usize| room[k][0] + (room[k][1] - room[k][0]) * i as f64 / 60.0;
        let all = (0..=60).flat_map(|i| (0..=60).flat_map(move |j| (0..=60).map(move |k| [i, j, k])));
        let best = all.map(|[i, j, k]| value([at(0, i), at(1, j), at(2, k)])).fold(f64::NEG_INFINITY, f64::max);
        assert!(gain >= best - 1e-9 && gain < best + 0.01, "{gain} {best}");
    }

    #[test]
    fn entries_outside_the_list_stay_at_nothing() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]);
        let right = DVector::from_row_slice(&[4.0, 2.0]);
        let (gain, x) = bounded(&matrix, &right, &[], &[0]).expect("positive");
        assert!((x[0] - 2.0).abs() < 1e-9 && (gain - 8.0).abs() < 1e-9);
    }
}
