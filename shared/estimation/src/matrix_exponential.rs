//! Exponential of a matrix by scaling, Taylor series and squaring (Moler and Van Loan 2003).

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix};

/// `e^m` of a square matrix (n × n).
///
/// Relative error a few ε, doubled by each squaring: the scaled norm is at most ½, where 18 terms
/// leave 0.5¹⁹/19! = 2e-23. Cost: 18 products of matrices and one a squaring, O(n³) each; no
/// allocation where `D` is constant.
///
/// # Panics
/// The norm exceeds 2⁵⁹: the step is not short beside any time constant.
pub fn matrix_exponential<D: Dim>(mut m: OMatrix<f64, D, D>) -> OMatrix<f64, D, D>
where
    DefaultAllocator: Allocator<D, D>,
{
    const TERMS: u32 = 18;
    const SQUARINGS_MAX: u32 = 60;
    let mut squarings = 0;
    while m.norm() > 0.5 {
        m *= 0.5;
        squarings += 1;
        assert!(squarings <= SQUARINGS_MAX, "the step is not short beside any time constant");
    }
    let (rows, columns) = m.shape_generic();
    let identity = OMatrix::<f64, D, D>::identity_generic(rows, columns);
    // Horner: 1 + m (1 + m/2 (1 + m/3 (…)))
    let mut sum = identity.clone_owned();
    for term in (1..=TERMS).rev() {
        sum = &identity + &m * sum / f64::from(term);
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3};

    #[test]
    fn a_turn_and_a_chain_of_integrators_have_their_closed_forms() {
        let (sine, cosine) = (libm::sin(2.5), libm::cos(2.5));
        let turn = matrix_exponential(Matrix2::new(0.0, -2.5, 2.5, 0.0));
        // rounding, doubled by three squarings
        assert!((turn - Matrix2::new(cosine, -sine, sine, cosine)).norm() < 1e-15 * 8.0);
        let chain = matrix_exponential(Matrix3::new(0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0));
        assert!((chain - Matrix3::new(1.0, 3.0, 3.0, 0.0, 1.0, 2.0, 0.0, 0.0, 1.0)).norm() < 1e-14);
    }

    #[test]
    fn the_exponential_of_the_opposite_is_the_inverse() {
        let m = Matrix3::from_fn(|i, j| (i as f64 - 2.0 * j as f64) * 0.7);
        let product = matrix_exponential(m) * matrix_exponential(-m);
        assert!((product - Matrix3::identity()).norm() < 1e-12); // entries up to 20, six squarings
    }
}
