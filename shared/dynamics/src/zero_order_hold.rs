//! Exact discretisation of a linear system whose input is held over the step.

use estimation::matrix_exponential;
use nalgebra::DMatrix;

/// `x' = A x + B u` with u held for `step_s`: returns `(e^{A h}, ∫₀ʰ e^{A s} ds B)`.
///
/// One exponential of `[[A, B], [0, 0]] h` (Van Loan 1978).
pub fn discretise(a: &DMatrix<f64>, b: &DMatrix<f64>, step_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    assert!(step_s > 0.0 && step_s.is_finite());
    let (n, inputs) = (a.nrows(), b.ncols());
    let mut augmented = DMatrix::<f64>::zeros(n + inputs, n + inputs);
    augmented.view_mut((0, 0), (n, n)).copy_from(&(a * step_s));
    augmented.view_mut((0, n), (n, inputs)).copy_from(&(b * step_s));
    let exponential = matrix_exponential(augmented);
    (exponential.view((0, 0), (n, n)).into_owned(), exponential.view((0, n), (n, inputs)).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_oscillator_has_its_closed_form() {
        for (omega, zeta, h) in [(0.0757, 0.0071, 0.1), (10.0, 0.005, 0.005), (40.0, 0.3, 1.0)] {
            let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, -2.0 * zeta * omega]);
            let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
            let (phi, gamma) = discretise(&a, &b, h);
            let (s, d) = (zeta * omega, omega * (1.0f64 - zeta * zeta).sqrt());
            let decay = (-s * h).exp();
            let (sin, cos) = (d * h).sin_cos();
            let closed = [
                decay * (cos + s / d * sin),
                -decay * omega * omega / d * sin,
                decay * sin / d,
                decay * (cos - s / d * sin),
            ];
            for (got, want) in phi.iter().zip(closed) {
                // rounding, doubled by each of the 12 squarings of the stiffest case: 2¹² ε = 9e-13
                assert!((got - want).abs() < 1e-12 * phi.amax(), "{got} {want}");
            }
            assert!(
                (gamma[0] - (1.0 - phi[(0, 0)]) / (omega * omega)).abs()
                    < 1e-13 * (gamma[0].abs() + 1.0 / (omega * omega))
            );
        }
    }

    #[test]
    fn two_half_steps_are_one_step() {
        let a = DMatrix::from_fn(5, 5, |i, j| ((7 * i + 3 * j) % 5) as f64 - 2.0);
        let b = DMatrix::from_fn(5, 2, |i, j| (i + 2 * j) as f64);
        let (whole, whole_in) = discretise(&a, &b, 0.3);
        let (half, half_in) = discretise(&a, &b, 0.15);
        assert!((&half * &half - &whole).norm() < 1e-13 * whole.norm());
        assert!((&half * &half_in + &half_in - &whole_in).norm() < 1e-13 * whole_in.norm());
    }
}
