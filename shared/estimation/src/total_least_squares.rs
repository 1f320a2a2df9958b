//! Total least squares streamed through the triangular factor of `[Y b]`: the baseline estimator of
//! the literature.
//!
//! Givens rotations rather than normal equations: `[Y b]'[Y b]` squares the condition number, and
//! the answer sits in the *smallest* singular direction, exactly where squaring loses half the
//! digits.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Data without a total least squares estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TlsError {
    /// Fewer rows than unknowns plus one: `need > got`.
    TooFewRows { got: u64, need: u64 },
    /// The noise direction lies in the span of `Y`: `|v_qq|` is below `A ε`. Excite more, or drop a
    /// column.
    Nongeneric { v_qq: f64 },
    /// Generalised form: some combination of the columns carries no noise.
    NoiseSingular,
    /// The singular value decomposition did not settle within its iteration bound (non-finite
    /// data).
    NotConverged,
}

/// Upper triangular factor of the rows `[y' b]` seen so far; `A = P + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TotalLeastSquares<const P: usize, const A: usize> {
    factor: SMatrix<f64, A, A>,
    rows: u64,
}

impl<const P: usize, const A: usize> Default for TotalLeastSquares<P, A> {
    fn default() -> Self {
        const { assert!(A == P + 1) }
        Self { factor: SMatrix::zeros(), rows: 0 }
    }
}

impl<const P: usize, const A: usize> TotalLeastSquares<P, A> {
    /// Rotates one row into the factor. O(A²), no allocation.
    pub fn push(&mut self, regressor: &SVector<f64, P>, observed: f64) {
        let row = SVector::<f64, A>::from_fn(|i, _| if i < P { regressor[i] } else { observed });
        rotate_in(&mut self.factor, row);
        self.rows += 1;
    }

    /// `α = −v_pq / v_qq`, `v` the right singular vector of the smallest singular value of `[Y b]`
    /// (Golub & Van Loan §6.3). Cost O(A³). Whiten the columns first if their noises differ.
    ///
    /// # Errors
    /// [`TlsError::Nongeneric`]: no finite α explains the data.
    pub fn estimate(&self) -> Result<SVector<f64, P>, TlsError> {
        if self.rows < A as u64 {
            return Err(TlsError::TooFewRows { got: self.rows, need: A as u64 });
        }
        let v = smallest_right_singular_vector(&self.factor).ok_or(TlsError::NotConverged)?;
        let v_qq = v[P];
        if v_qq.abs() <= A as f64 * f64::EPSILON {
            return Err(TlsError::Nongeneric { v_qq });
        }
        Ok(SVector::from_fn(|i, _| -v[i] / v_qq))
    }
}

/// Triangular factor with one more row: Givens rotations from the left, `R' R + row row'`
/// afterwards.
pub(crate) fn rotate_in<const A: usize>(factor: &mut SMatrix<f64, A, A>, mut row: SVector<f64, A>) {
    for i in 0..A {
        let radius = libm::hypot(factor[(i, i)], row[i]);
        if radius == 0.0 {
            continue;
        }
        let (cosine, sine) = (factor[(i, i)] / radius, row[i] / radius);
        for j in i..A {
            let (upper, lower) = (factor[(i, j)], row[j]);
            factor[(i, j)] = cosine * upper + sine * lower;
            row[j] = cosine * lower - sine * upper;
        }
    }
}

/// One-sided Jacobi: columns of `R V` are rotated pairwise until orthogonal; the shortest names the
/// direction.
///
/// Jacobi because it keeps *relative* accuracy of the smallest singular value of a scaled
/// triangular factor.
pub(crate) fn smallest_right_singular_vector<const A: usize>(factor: &SMatrix<f64, A, A>) -> Option<SVector<f64, A>> {
    const SWEEPS_MAX: usize = 60;
    let (mut work, mut v) = (*factor, SMatrix::<f64, A, A>::identity());
    for _ in 0..SWEEPS_MAX {
        let mut rotated = false;
        for p in 0..A {
            for q in p + 1..A {
                let (alpha, beta) = (work.column(p).norm_squared(), work.column(q).norm_squared());
                let gamma = work.column(p).dot(&work.column(q));
                if gamma.abs() <= 1e-15 * libm::sqrt(alpha * beta) {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let t = 1.0_f64.copysign(zeta) / (zeta.abs() + libm::sqrt(1.0 + zeta * zeta));
                let c = 1.0 / libm::sqrt(1.0 + t * t);
                rotate_columns(&mut work, p, q, c, c * t);
                rotate_columns(&mut v, p, q, c, c * t);
            }
        }
        if !rotated {
            let shortest = (0..A).min_by(|i, j| work.column(*i).norm().total_cmp(&work.column(*j).norm()))?;
            return Some(v.column(shortest).into_owned());
        }
    }
    None
}

fn rotate_columns<const A: usize>(matrix: &mut SMatrix<f64, A, A>, p: usize, q: usize, c: f64, s: f64) {
    for i in 0..A {
        let (x, y) = (matrix[(i, p)], matrix[(i, q)]);
        matrix[(i, p)] = c * x - s * y;
        matrix[(i, q)] = s * x + c * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use nalgebra::vector;

    fn stream(sigma: f64, rows: usize, seed: u64) -> TotalLeastSquares<3, 4> {
        let mut noise = SeededNoise::new(seed);
        let (truth, mut tls) = (vector![2.0, -1.0, 0.5], TotalLeastSquares::default());
        for _ in 0..rows {
            let y = SVector::<f64, 3>::from_fn(|_, _| noise.normal());
            let noisy = y + SVector::from_fn(|_, _| sigma * noise.normal());
            tls.push(&noisy, y.dot(&truth) + sigma * noise.normal());
        }
        tls
    }

    #[test]
    fn noise_free_rows_are_solved_to_rounding() {
        let alpha = stream(0.0, 50, 1).estimate().expect("generic");
        assert!((alpha - vector![2.0, -1.0, 0.5]).norm() < 1e-13);
    }

    #[test]
    fn equal_noise_in_all_columns_leaves_no_bias() {
        // Ordinary least squares would be low by σ² = 9 %; the spread of TLS over 40 000 rows is
        // about 0.4 %.
        let alpha = stream(0.3, 40_000, 2).estimate().expect("generic");
        assert!((alpha - vector![2.0, -1.0, 0.5]).norm() < 0.02, "{alpha}");
    }

    #[test]
    fn a_right_hand_side_outside_the_model_is_nongeneric() {
        let mut tls = TotalLeastSquares::<1, 2>::default();
        tls.push(&vector![0.0], 1.0);
        tls.push(&vector![0.0], -2.0);
        assert!(matches!(tls.estimate(), Err(TlsError::Nongeneric { .. })));
    }

    #[test]
    fn too_few_rows_are_refused() {
        assert_eq!(stream(0.1, 3, 1).estimate(), Err(TlsError::TooFewRows { got: 3, need: 4 }));
    }
}
