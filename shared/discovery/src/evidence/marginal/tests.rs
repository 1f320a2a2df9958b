//! Laplace's method against sums over grids.

use super::*;

/// `−2 ln p = c − 2 rᵀ x + xᵀ M x` about a point in the middle of the prior.
fn normal(matrix: DMatrix<f64>, right: &[f64]) -> Normal {
    let n = right.len();
    let (chi2, objective) = (7.0, 7.0);
    Normal { unknowns: n, matrix, right: DVector::from_row_slice(right), chi2, objective, room: Vec::new() }
}

/// `ln ∫ exp(−½ (…)) dx / (2π)^(n/2)` over the box, less the prior's mass there, by the midpoint
/// rule.
fn by_sum(normal: &Normal, bounds: [[f64; 2]; 2]) -> f64 {
    const POINTS: usize = 1500;
    let axis = |[low, high]: [f64; 2]| {
        let (low, high) = (low.max(-12.0), high.min(12.0));
        let h = (high - low) / POINTS as f64;
        (0..POINTS).map(move |i| (low + (i as f64 + 0.5) * h, h)).collect::<Vec<_>>()
    };
    let (m, r) = (&normal.matrix, &normal.right);
    let mut sum = 0.0;
    for (x, h) in axis(bounds[0]) {
        for (y, k) in axis(bounds[1]) {
            let form = m[(0, 0)] * x * x + 2.0 * m[(0, 1)] * x * y + m[(1, 1)] * y * y;
            sum += h * k * libm::exp(r[0] * x + r[1] * y - 0.5 * form);
        }
    }
    let prior = log_mass(bounds[0][0], bounds[0][1]) + log_mass(bounds[1][0], bounds[1][1]);
    libm::log(sum / (2.0 * core::f64::consts::PI)) - 0.5 * normal.objective - prior
}

#[test]
fn an_evidence_is_the_integral_inside_at_and_beyond_a_bound() {
    let matrix = || DMatrix::from_row_slice(2, 2, &[3.0, 1.2, 1.2, 5.0]);
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    for (right, first) in [
        ([2.0, 1.0], free),
        ([2.0, 1.0], [0.0, f64::INFINITY]),
        ([0.0, 0.0], [0.0, f64::INFINITY]),
        ([-4.0, 1.0], [0.0, f64::INFINITY]),
        ([9.0, -3.0], [-0.5, 1.0]),
    ] {
        let own = normal(matrix(), &right);
        let bounds = [Bound { place: 0, room: first, prior: first }];
        let found = log_marginal(&own, &bounds).unwrap();
        let summed = by_sum(&own, [first, free]);
        // midpoint rule on 1500 points, and one bound is exact but where both ends are near
        assert!((found - summed).abs() < 2e-3, "{right:?} {first:?}: {found} {summed}");
    }
}

#[test]
fn two_bounds_are_near_the_integral() {
    let own = normal(DMatrix::from_row_slice(2, 2, &[3.0, 1.2, 1.2, 5.0]), &[-1.0, -2.0]);
    let half = [0.0, f64::INFINITY];
    let bounds = [0, 1].map(|place| Bound { place, room: half, prior: half });
    let (found, summed) = (log_marginal(&own, &bounds).unwrap(), by_sum(&own, [half, half]));
    // taken as independent: a tenth of a nat
    assert!((found - summed).abs() < 0.1, "{found} {summed}");
}

/// Freely the two would leave by opposite ends: once one is held, the other one stays inside.
#[test]
fn a_number_that_comes_back_from_its_edge_is_inside() {
    let own = normal(DMatrix::from_row_slice(2, 2, &[50.0, 49.0, 49.0, 50.0]), &[80.0, 60.0]);
    let rooms = [[f64::NEG_INFINITY, 1.0], [0.0, f64::INFINITY]];
    let bounds = [0, 1].map(|place| Bound { place, room: rooms[place], prior: rooms[place] });
    let (found, summed) = (log_marginal(&own, &bounds).unwrap(), by_sum(&own, rooms));
    assert!((found - summed).abs() < 0.3, "{found} {summed}");
}

#[test]
fn a_direction_that_no_reading_feels_costs_nothing_and_a_sharp_one_its_width() {
    let flat = normal(DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1.0]), &[0.0, 0.0]);
    assert!((log_marginal(&flat, &[]).unwrap() + 3.5).abs() < 1e-12);
    let sharp = normal(DMatrix::from_row_slice(2, 2, &[1e4, 0.0, 0.0, 1.0]), &[0.0, 0.0]);
    assert!((log_marginal(&sharp, &[]).unwrap() + 3.5 + libm::log(100.0)).abs() < 1e-12);
}

#[test]
fn the_logarithm_of_a_mass_keeps_its_digits_far_out() {
    assert!((log_mass(f64::NEG_INFINITY, 0.0) + core::f64::consts::LN_2).abs() < 1e-15);
    // ln Φ(−40) = −800 − ln(40 √2π) − 6.2e-4 (Abramowitz and Stegun 26.2.12)
    let far = -800.0 - libm::log(40.0 * (2.0 * core::f64::consts::PI).sqrt());
    assert!((log_mass(f64::NEG_INFINITY, -40.0) - far).abs() < 1e-3);
    assert!((log_mass(3.0, f64::INFINITY) - log_mass(f64::NEG_INFINITY, -3.0)).abs() < 1e-15);
}

/// Like amplitudes that err little: a width of prior that they have in common costs each of them
/// less than the width of what one could be.
#[test]
fn a_narrower_prior_is_the_same_likelihood_under_that_prior() {
    let likelihood = |width: f64| {
        let scales = [1.0, width, width];
        let curvature = DMatrix::from_row_slice(3, 3, &[2.0, 0.3, 0.1, 0.3, 900.0, 5.0, 0.1, 5.0, 700.0]);
        let matrix =
            DMatrix::from_fn(3, 3, |i, j| scales[i] * scales[j] * curvature[(i, j)] + if i == j { 1.0 } else { 0.0 });
        let right = [0.4, 300.0 * width, -250.0 * width];
        let room = scales.map(|scale| [-2.0 / scale, 2.0 / scale]).to_vec();
        Normal { unknowns: 1, room, ..normal(matrix, &right) }
    };
    let (given, found) = (likelihood(0.1), narrowed(&likelihood(1.0), &[0.1, 0.1]));
    assert!((&given.matrix - &found.matrix).amax() < 1e-12 && (&given.right - &found.right).amax() < 1e-12);
    assert!(given.room.iter().flatten().zip(found.room.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12));
    // amplitudes of a third of the width
    let of = |width| log_marginal(&likelihood(width), &[]).unwrap();
    assert!(of(0.4) > of(4.0) && of(0.4) > of(0.04), "{} {} {}", of(4.0), of(0.4), of(0.04));
}
