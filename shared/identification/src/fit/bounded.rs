//! Least squares with entries that may not leave their room.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Diagonal load of the scaled matrix: exact twins share their amplitude instead of failing.
const LOAD: f64 = 1e-11;
/// Relative overstep that is rounding.
const OVERSTEP: f64 = 1e-9;

/// Slope at an edge, over the largest one, below which it is rounding.
const LEVEL_SLOPE: f64 = 1e-9;

/// Greatest decrease `2 bᵀx − xᵀMx` and its `x` over the entries at `places`; entry `i` stays
/// within `room[i]`, entries behind the list are free.
///
/// Active set: entries that would leave are held at their edge, and let go where the decrease
/// rises inwards; every further step decreases the form, so that no face is met twice (Lawson and
/// Hanson, Solving Least Squares Problems, ch. 23). `None`: the matrix is not positive.
///
/// Cost: O(k³) per change of the held ones.
pub fn bounded(
    matrix: &DMatrix<f64>,
    right: &DVector<f64>,
    room: &[[f64; 2]],
    places: &[usize],
) -> Option<(f64, Vec<f64>)> {
    let form = Form { matrix, right, room, places };
    let (mut x, mut held) = form.begun()?;
    for _ in 0..RELEASES_PER_ENTRY * places.len() {
        let Some(inward) = form.inward(&x, &held) else { break };
        held[inward] = false;
        form.descend(&mut x, &mut held)?;
    }
    Some((decrease(matrix, right, places, &x), x))
}

/// Entries let go at most, of each one. A budget, for the rounding of flat directions.
const RELEASES_PER_ENTRY: usize = 4;

/// The entries of a quadratic form that may move, and their room.
struct Form<'a> {
    matrix: &'a DMatrix<f64>,
    right: &'a DVector<f64>,
    room: &'a [[f64; 2]],
    places: &'a [usize],
}

impl Form<'_> {
    fn room(&self, entry: usize) -> [f64; 2] {
        self.room.get(self.places[entry]).copied().unwrap_or([f64::NEG_INFINITY, f64::INFINITY])
    }

    /// The free entries at their best beside the held ones.
    fn solved(&self, x: &[f64], held: &[bool]) -> Option<(Vec<usize>, Vec<f64>)> {
        let Self { matrix, right, places, .. } = *self;
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
        let all = solved.iter().zip(&scale).map(|(solved, scale)| solved * scale).collect();
        Some((free, all))
    }

    /// Entries that leave are held, all at once, until none does.
    fn begun(&self) -> Option<(Vec<f64>, Vec<bool>)> {
        let (mut x, mut held) = (vec![0.0; self.places.len()], vec![false; self.places.len()]);
        loop {
            let (free, solved) = self.solved(&x, &held)?;
            let mut left = false;
            for (entry, own) in free.into_iter().zip(solved) {
                let [low, high] = self.room(entry);
                x[entry] = own;
                if own < low - OVERSTEP || own > high + OVERSTEP {
                    x[entry] = own.clamp(low, high);
                    held[entry] = true;
                    left = true;
                }
            }
            if !left {
                return Some((x, held));
            }
        }
    }

    /// The held entry from whose edge the form decreases most.
    fn inward(&self, x: &[f64], held: &[bool]) -> Option<usize> {
        let Self { matrix, right, places, .. } = *self;
        let size = |i: usize| matrix[(places[i], places[i])].max(1e-300).sqrt();
        let slope = |i: usize| {
            let known: f64 = places.iter().zip(x).map(|(j, x)| matrix[(places[i], *j)] * x).sum();
            let inwards = if x[i] <= self.room(i)[0] { 1.0 } else { -1.0 };
            inwards * (right[places[i]] - known) / size(i)
        };
        let most = (0..x.len()).map(|i| (right[places[i]] / size(i)).abs()).fold(0.0, f64::max);
        let has_room = |i: &usize| self.room(*i)[0] < self.room(*i)[1];
        let all = (0..x.len()).filter(|i| held[*i]).filter(has_room).map(|i| (slope(i), i));
        all.filter(|(slope, _)| *slope > LEVEL_SLOPE * most).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    }

    /// From a possible point to the best one of its face, holding each entry that meets its edge.
    fn descend(&self, x: &mut [f64], held: &mut [bool]) -> Option<()> {
        loop {
            let (free, solved) = self.solved(x, held)?;
            let mut share = 1.0;
            let mut meets = None;
            for (entry, own) in free.iter().zip(&solved) {
                let [low, high] = self.room(*entry);
                let end = if *own < low - OVERSTEP {
                    low
                } else if *own > high + OVERSTEP {
                    high
                } else {
                    continue;
                };
                let own = ((end - x[*entry]) / (own - x[*entry])).max(0.0);
                if own < share {
                    (share, meets) = (own, Some((*entry, end)));
                }
            }
            for (entry, own) in free.iter().zip(&solved) {
                x[*entry] += share * (own - x[*entry]);
            }
            let Some((entry, end)) = meets else { return Some(()) };
            (x[entry], held[entry]) = (end, true);
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

    /// Two that pull the same way: held together at first, and only one of them at its best.
    #[test]
    fn an_entry_at_its_edge_comes_back_where_another_one_is_held() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 0.99, 0.99, 1.0]);
        let right = DVector::from_row_slice(&[5.0, 4.8]);
        let (gain, x) = bounded(&matrix, &right, &[[-20.0, 1.0], [0.0, 20.0]], &[0, 1]).expect("positive");
        // free: 12.5 and −7.5; held both: 1 and 0; best: 1 and 4.8 − 0.99
        assert!(x[0] == 1.0 && (x[1] - 3.81).abs() < 1e-9, "{x:?}");
        assert!(gain > 2.0 * 5.0 - 1.0 + 3.0);
    }

    #[test]
    fn an_entry_without_room_keeps_no_other_one_at_its_edge() {
        let matrix = DMatrix::from_row_slice(3, 3, &[1.0, 0.99, 0.0, 0.99, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let right = DVector::from_row_slice(&[5.0, 4.8, 50.0]);
        let (_, x) = bounded(&matrix, &right, &[[-20.0, 1.0], [0.0, 20.0], [0.0, 0.0]], &[0, 1, 2]).expect("positive");
        assert!(x[0] == 1.0 && (x[1] - 3.81).abs() < 1e-9 && x[2] == 0.0, "{x:?}");
    }

    /// Against all faces of a box, for forms whose entries interact.
    #[test]
    fn no_face_of_the_box_has_a_greater_decrease() {
        let mut seed = 9u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for _ in 0..400 {
            let half = DMatrix::from_fn(3, 3, |_, _| draw());
            let matrix = &half * half.transpose() + DMatrix::identity(3, 3) * 1e-3;
            let right = DVector::from_fn(3, |_, _| draw());
            let room: Vec<[f64; 2]> = (0..3).map(|_| [-0.5 * draw().abs(), draw().abs()]).collect();
            let (gain, x) = bounded(&matrix, &right, &room, &[0, 1, 2]).expect("positive");
            assert!(x.iter().zip(&room).all(|(x, [low, high])| (low - 1e-9..=high + 1e-9).contains(x)));
            for face in 0..27usize {
                let ends = [face % 3, face / 3 % 3, face / 9];
                let held: Vec<bool> = ends.iter().map(|end| *end > 0).collect();
                let mut point: Vec<f64> =
                    (0..3).map(|i| if ends[i] > 0 { room[i][ends[i] - 1] } else { 0.0 }).collect();
                let form = Form { matrix: &matrix, right: &right, room: &room, places: &[0, 1, 2] };
                let (free, solved) = form.solved(&point, &held).expect("positive");
                free.iter().zip(&solved).for_each(|(i, own)| point[*i] = *own);
                let is_in = point.iter().zip(&room).all(|(x, [low, high])| (*low..=*high).contains(x));
                assert!(!is_in || decrease(&matrix, &right, &[0, 1, 2], &point) <= gain + 1e-8, "{point:?} {x:?}");
            }
        }
    }

    #[test]
    fn entries_outside_the_list_stay_at_nothing() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]);
        let right = DVector::from_row_slice(&[4.0, 2.0]);
        let (gain, x) = bounded(&matrix, &right, &[], &[0]).expect("positive");
        assert!((x[0] - 2.0).abs() < 1e-9 && (gain - 8.0).abs() < 1e-9);
    }
}
