//! Ridge regression of a map's weights with one prior scale, and the values of the map.

use super::noise_hypotheses::NoiseHypothesis;
use super::places::{FUNCTIONS, Span, basis};
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

/// Cells of the reported map, along each of two coordinates and along one.
const CELLS: usize = 9;
const CELLS_ALONE: usize = 49;

/// One value of a map; a map over one coordinate has all cells at zero of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub at: [f64; 2],
    pub value: f64,
    pub sigma: f64,
}

/// Weights with one prior scale, by eigenvectors of their information.
pub(super) struct Ridge {
    pub objective: f64,
    weights: DVector<f64>,
    covariance: DMatrix<f64>,
    /// `1/s²`.
    pub precision: f64,
}

impl Ridge {
    /// The scale that maximises the evidence on `hypothesis`.
    pub fn new(hypothesis: &NoiseHypothesis, samples: f64) -> Option<Self> {
        let eigen = SymmetricEigen::try_new(hypothesis.reduced.clone(), 1e-12, 10_000)?;
        let g = eigen.eigenvectors.tr_mul(&hypothesis.reduced_right);
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let mut best: Option<(f64, f64, f64)> = None;
        for step in 0..40 {
            // from a prior that allows nothing to one without effect
            let variance = libm::exp(0.5 * (step as f64 - 8.0)) / largest;
            let (mut gain, mut price) = (0.0, 0.0);
            for (l, g) in eigen.eigenvalues.iter().zip(g.iter()) {
                let seen = variance * l.max(0.0);
                gain += variance * g * g / (1.0 + seen);
                price += libm::log(1.0 + seen);
            }
            let objective = hypothesis.at(hypothesis.reduced_chi2 - gain, samples) + price;
            if best.is_none_or(|best| objective < best.0) {
                best = Some((objective, variance, gain));
            }
        }
        let (objective, variance, gain) = best?;
        let scale = (hypothesis.reduced_chi2 - gain).max(0.0) / samples;
        let n = hypothesis.reduced.nrows();
        let factor = Cholesky::new(&hypothesis.reduced + DMatrix::identity(n, n) / variance)?;
        let weights = factor.solve(&hypothesis.reduced_right);
        Some(Self { objective, weights, covariance: factor.inverse() * scale, precision: 1.0 / variance })
    }

    /// Values over the box.
    pub fn cells(&self, span: &Span) -> Vec<Cell> {
        let mut phi = vec![0.0; FUNCTIONS];
        let mut cell = |at: [f64; 2]| {
            basis(span, &at, &mut phi);
            let phi = DVector::from_column_slice(&phi);
            let sigma = phi.dot(&(&self.covariance * &phi)).max(0.0).sqrt();
            Cell { at, value: phi.dot(&self.weights), sigma }
        };
        cells(span).into_iter().map(&mut cell).collect()
    }
}

/// Cells at which a map over `span` is reported.
pub(super) fn cells(span: &Span) -> Vec<[f64; 2]> {
    let (side, other) = if span.len() == 1 { (CELLS_ALONE, 1) } else { (CELLS, CELLS) };
    let along = |k: usize, i: usize, side: usize| {
        span.get(k).map_or(0.0, |[low, high]| low + (high - low) * i as f64 / (side - 1) as f64)
    };
    let all = (0..side).flat_map(|i| (0..other).map(move |j| (i, j)));
    all.map(|(i, j)| [along(0, i, side), along(1, j, other)]).collect()
}
