//! Modal assurance criterion and modal phase collinearity of complex mode shapes.

use faer::c64;

/// Modal assurance criterion `|aᴴb|² / (aᴴa · bᴴb)`: 1 for the same shape whatever its scale and phase, 0 for orthogonal ones.
///
/// Allemang & Brown 1982. Zero when a shape vanishes. One channel always gives 1.
#[must_use]
pub fn modal_assurance_criterion(a: &[c64], b: &[c64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let (mut cross, mut norm_a, mut norm_b) = (c64::new(0.0, 0.0), 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        cross += a.conj() * b;
        norm_a += a.norm_sqr();
        norm_b += b.norm_sqr();
    }
    if norm_a * norm_b > 0.0 { cross.norm_sqr() / (norm_a * norm_b) } else { 0.0 }
}

/// Modal phase collinearity: 1 when all components lie on one line of the complex plane (a normal mode).
///
/// `((S_xx − S_yy)² + 4 S_xy²) / (S_xx + S_yy)²`, x and y the real and imaginary parts. Pappa, Elliott & Schenk 1993.
#[must_use]
pub fn modal_phase_collinearity(shape: &[c64]) -> f64 {
    let (mut s_xx, mut s_yy, mut s_xy) = (0.0, 0.0, 0.0);
    for psi in shape {
        s_xx += psi.re * psi.re;
        s_yy += psi.im * psi.im;
        s_xy += psi.re * psi.im;
    }
    let total = s_xx + s_yy;
    if total > 0.0 { ((s_xx - s_yy) * (s_xx - s_yy) + 4.0 * s_xy * s_xy) / (total * total) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assurance_criterion_ignores_scale_and_phase_and_sees_orthogonality() {
        let a = [c64::new(1.0, 0.2), c64::new(-0.5, 0.7), c64::new(0.1, -2.0)];
        let b = a.map(|psi| psi * c64::new(-3.0, 0.4));
        assert!((modal_assurance_criterion(&a, &b) - 1.0).abs() < 1e-14);
        let (x, y) = ([c64::new(1.0, 0.0), c64::new(0.0, 1.0)], [c64::new(1.0, 0.0), c64::new(0.0, -1.0)]);
        assert!(modal_assurance_criterion(&x, &y) < 1e-30);
    }

    #[test]
    fn collinear_shape_has_unit_collinearity_at_any_phase_and_a_circle_has_none() {
        let shape = [1.0, -0.4, 2.0].map(|real| c64::new(real, 0.0) * c64::new(0.6, 0.8));
        assert!((modal_phase_collinearity(&shape) - 1.0).abs() < 1e-14);
        assert!(modal_phase_collinearity(&[c64::new(1.0, 0.0), c64::new(0.0, 1.0)]) < 1e-30);
    }
}
