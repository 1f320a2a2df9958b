//! How fast the fastest thing in a plant is.

use nalgebra::DMatrix;

/// `‖A^64‖^(1/64)` (Gelfand): from above, within `κ^(1/64)` of the radius, κ the condition of the
/// eigenvectors. No iteration that may not end. Zero for a matrix that is not finite.
pub fn spectral_radius(a: DMatrix<f64>) -> f64 {
    let (mut power, mut log_scale) = (a, 0.0);
    for _ in 0..6 {
        let norm = power.norm();
        if norm == 0.0 || !norm.is_finite() {
            return 0.0;
        }
        power /= norm;
        log_scale = 2.0 * (log_scale + libm::log(norm));
        power = &power * &power;
    }
    let norm = power.norm();
    if norm == 0.0 { 0.0 } else { libm::exp((log_scale + libm::log(norm)) / 64.0) }
}

#[cfg(test)]
mod tests {
    use super::spectral_radius;
    use nalgebra::DMatrix;

    #[test]
    fn the_spectral_radius_of_an_oscillator_is_its_frequency_and_of_nothing_nothing() {
        let omega = 40.0;
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -omega * omega, 0.0]);
        // eigenvectors of condition ω: ω^(1/64) too large at most
        let radius = spectral_radius(a);
        assert!(radius >= omega * (1.0 - 1e-9) && radius < omega * 1.08, "{radius}");
        assert_eq!(spectral_radius(DMatrix::zeros(3, 3)), 0.0);
        assert_eq!(spectral_radius(DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0])), 0.0);
    }
}
