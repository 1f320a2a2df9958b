//! A few leading eigenvectors of a large symmetric matrix.

use faer::{Mat, MatRef, Side};

/// Vectors iterated beyond the requested ones: the ratio of eigenvalues that far apart decides the
/// speed.
const SPARE: usize = 10;
/// If a state of noise is requested there is no gap, and the full decomposition is cheaper than
/// more passes.
const PASSES_MAX: usize = 8;
/// Change of the Ritz vectors' eigenvalues per pass, relative to each, at which they stand: their
/// error is its square root squared.
const SETTLED: f64 = 1e-13;

/// Eigenvectors of the `count` largest eigenvalues of a positive semi-definite matrix, and these,
/// largest first.
///
/// Subspace iteration with Rayleigh–Ritz from a fixed start; the full decomposition where it does
/// not settle or would cost no less. `None` when the decomposition fails.
pub(crate) fn leading_eigenvectors(matrix: MatRef<'_, f64>, count: usize) -> Option<(Mat<f64>, Vec<f64>)> {
    let n = matrix.nrows();
    let block = count + SPARE;
    if 4 * block < n
        && let Some(found) = iterate(matrix, count, block)
    {
        return Some(found);
    }
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let count = count.min(n);
    let vectors = Mat::from_fn(n, count, |r, c| eigen.U()[(r, n - 1 - c)]);
    Some((vectors, (0..count).map(|k| eigen.S().column_vector()[n - 1 - k]).collect()))
}

fn iterate(matrix: MatRef<'_, f64>, count: usize, block: usize) -> Option<(Mat<f64>, Vec<f64>)> {
    let n = matrix.nrows();
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut q = Mat::from_fn(n, block, |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    });
    let mut before = vec![0.0; count];
    for _ in 0..PASSES_MAX {
        let basis = (matrix * &q).qr().compute_thin_Q();
        let image = matrix * &basis;
        let small = basis.transpose() * &image;
        let eigen = small.self_adjoint_eigen(Side::Lower).ok()?;
        let turned = Mat::from_fn(block, block, |r, c| eigen.U()[(r, block - 1 - c)]);
        let values: Vec<f64> = (0..count).map(|k| eigen.S().column_vector()[block - 1 - k]).collect();
        q = &basis * &turned;
        let settled = values.iter().zip(&before).all(|(now, then)| (now - then).abs() <= SETTLED * now.abs());
        if settled {
            return Some((q.get(.., ..count).to_owned(), values));
        }
        before = values;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    #[test]
    fn leading_vectors_are_those_of_the_whole_decomposition() {
        let mut noise = Noise::new(3);
        let factor = Mat::from_fn(120, 200, |r, c| {
            let strong = if c < 5 { 50.0 / (1 + c) as f64 * libm::cos(0.1 * ((c + 1) * r) as f64) } else { 0.0 };
            strong + 0.1 * noise.normal()
        });
        let matrix = &factor * factor.transpose();
        let (vectors, values) = leading_eigenvectors(matrix.as_ref(), 5).unwrap();
        let eigen = matrix.self_adjoint_eigen(Side::Lower).unwrap();
        for k in 0..5 {
            assert!((values[k] / eigen.S().column_vector()[119 - k] - 1.0).abs() < 1e-11);
            let along: f64 = (0..120).map(|r| vectors[(r, k)] * eigen.U()[(r, 119 - k)]).sum();
            assert!((along.abs() - 1.0).abs() < 1e-10); // the square of the vectors' error
        }
    }
}
