//! The Fisher information of the poles: steps of the iteration, and the covariance in frequency and
//! damping.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side, c64};

/// `(F + damping · diag F)⁻¹ s`.
pub(crate) fn solve(information: &Mat<f64>, score: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = score.len();
    let scale: Vec<f64> = (0..n).map(|p| 1.0 / information[(p, p)].sqrt()).collect();
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let scaled =
        Mat::from_fn(n, n, |p, q| information[(p, q)] * scale[p] * scale[q] + if p == q { damping } else { 0.0 });
    let factor = scaled.llt(Side::Lower).ok()?;
    let right = Mat::from_fn(n, 1, |p, _| score[p] * scale[p]);
    let solved = factor.solve(&right);
    Some((0..n).map(|p| solved[(p, 0)] * scale[p]).collect())
}

/// `F⁻¹`; `None` where a direction leaves no trace.
pub(crate) fn inverse(information: &Mat<f64>) -> Option<Mat<f64>> {
    let n = information.nrows();
    let mut inverse = Mat::<f64>::zeros(n, n);
    for column in 0..n {
        let unit: Vec<f64> = (0..n).map(|row| f64::from(u8::from(row == column))).collect();
        for (row, x) in solve(information, &unit, 0.0)?.into_iter().enumerate() {
            inverse[(row, column)] = x;
        }
    }
    Some(inverse)
}

/// Inverse information in (f \[Hz\], ζ) of every pole.
pub(super) fn covariance(information: &Mat<f64>, poles: &[c64]) -> Option<Vec<f64>> {
    Some(frequency_and_damping(&inverse(information)?, poles))
}

/// Covariance of (f \[Hz\], ζ) of every pole, row by row, from that of (Re λ, Im λ).
pub(crate) fn frequency_and_damping(inverse: &Mat<f64>, poles: &[c64]) -> Vec<f64> {
    let n = 2 * poles.len();
    // f = |λ|/2π, ζ = −Re λ/|λ|
    let mut slope = Mat::<f64>::zeros(n, n);
    for (k, pole) in poles.iter().enumerate() {
        let omega = pole.norm_sqr().sqrt();
        let cube = omega * omega * omega;
        slope[(2 * k, 2 * k)] = pole.re / (2.0 * std::f64::consts::PI * omega);
        slope[(2 * k, 2 * k + 1)] = pole.im / (2.0 * std::f64::consts::PI * omega);
        slope[(2 * k + 1, 2 * k)] = -pole.im * pole.im / cube;
        slope[(2 * k + 1, 2 * k + 1)] = pole.re * pole.im / cube;
    }
    let all = &slope * inverse * slope.transpose();
    (0..n * n).map(|k| all[(k / n, k % n)]).collect()
}
