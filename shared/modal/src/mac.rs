//! Modal assurance criterion and modal phase collinearity of complex mode shapes.

use faer::c64;

/// Modal assurance criterion `|aᴴb|² / (aᴴa · bᴴb)`: 1 for the same shape whatever its scale and
/// phase, 0 for orthogonal ones.
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

/// Modal phase collinearity: 1 when all components lie on one line of the complex plane (a normal
/// mode).
///
/// `((S_xx − S_yy)² + 4 S_xy²) / (S_xx + S_yy)²`, x and y the real and imaginary parts. Pappa,
/// Elliott & Schenk 1993.
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

/// Modal phase deviation: root mean square angle \[rad\] of the components from their common line,
/// weighted by their size.
///
/// The line is that of the total least squares fit through the origin of the complex plane.
/// Reynders, Houbrechts & De Roeck 2012.
#[must_use]
pub fn mean_phase_deviation(shape: &[c64]) -> f64 {
    let (mut s_xx, mut s_yy, mut s_xy) = (0.0, 0.0, 0.0);
    for psi in shape {
        s_xx += psi.re * psi.re;
        s_yy += psi.im * psi.im;
        s_xy += psi.re * psi.im;
    }
    let line = 0.5 * libm::atan2(2.0 * s_xy, s_xx - s_yy);
    let (sine, cosine) = libm::sincos(line);
    let (mut angles, mut weights) = (0.0, 0.0);
    for psi in shape {
        let size = psi.norm_sqr().sqrt();
        if size > 0.0 {
            angles += size * libm::acos(((psi.re * cosine + psi.im * sine) / size).abs().min(1.0));
            weights += size;
        }
    }
    if weights > 0.0 { angles / weights } else { 0.0 }
}

/// Extended modal amplitude coherence of outputs: 1 when the component of a mode in the last block
/// row of the observability matrix is the one that its first block row and its pole predict (Pappa,
/// Elliott & Schenk 1993, output part; channels weighted by their power).
///
/// `first` and `last` are the mode's components in the first and in the last block row,
/// `growth = z^(i−1)` predicts `last = growth · first`.
#[must_use]
pub fn extended_modal_amplitude_coherence(first: &[c64], last: &[c64], growth: c64) -> f64 {
    assert_eq!(first.len(), last.len());
    let (mut sum, mut total) = (0.0, 0.0);
    for (first, last) in first.iter().zip(last) {
        let predicted = *first * growth;
        let (a, b) = (predicted.norm_sqr().sqrt(), last.norm_sqr().sqrt());
        let size = if a.max(b) > 0.0 { a.min(b) / a.max(b) } else { 0.0 };
        let cross = *last * predicted.conj();
        let angle = libm::atan2(cross.im, cross.re).abs();
        let phase = (1.0 - angle / std::f64::consts::FRAC_PI_4).max(0.0);
        sum += first.norm_sqr() * size * phase;
        total += first.norm_sqr();
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Scaled so that the largest component is 1.
pub(crate) fn normalised(shape: impl Iterator<Item = c64>) -> Vec<c64> {
    let shape: Vec<c64> = shape.collect();
    let largest =
        shape.iter().copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm_sqr() > a.norm_sqr() { b } else { a });
    if largest.norm_sqr() > 0.0 { shape.into_iter().map(|psi| psi / largest).collect() } else { shape }
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
