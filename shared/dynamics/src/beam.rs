//! Uniform cantilever beam (Euler–Bernoulli): eigenvalues, mode functions, frequencies.

/// A uniform beam clamped at its root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cantilever {
    pub length_m: f64,
    /// Mass per length ρA.
    pub mass_per_length_kg_m: f64,
    /// Bending stiffness EI.
    pub bending_stiffness_n_m2: f64,
}

/// One clamped mode of a cantilever, its mode function normalised to unit modal mass:
/// `∫ ρA φ² dx = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CantileverMode {
    /// Root βL of `cos(βL) cosh(βL) = −1`.
    beta_l: f64,
    /// `(sinh − sin) / (cosh + cos)` would lose digits; this is `(cosh + cos) / (sinh + sin)` at
    /// βL.
    ratio: f64,
    amplitude: f64,
    length_m: f64,
    pub angular_frequency_rad_s: f64,
}

/// Beyond this the difference of hyperbolic functions loses more than seven digits at the tip.
const MODE_NUMBER_MAX: usize = 6;

impl Cantilever {
    /// Clamped mode `number`, counted from 1.
    pub fn mode(&self, number: usize) -> CantileverMode {
        assert!((1..=MODE_NUMBER_MAX).contains(&number));
        let beta_l = eigenvalue(number);
        let beta = beta_l / self.length_m;
        let (sin, cos) = libm::sincos(beta_l);
        CantileverMode {
            beta_l,
            ratio: (libm::cosh(beta_l) + cos) / (libm::sinh(beta_l) + sin),
            amplitude: 1.0 / (self.mass_per_length_kg_m * self.length_m).sqrt(),
            length_m: self.length_m,
            angular_frequency_rad_s: beta * beta * (self.bending_stiffness_n_m2 / self.mass_per_length_kg_m).sqrt(),
        }
    }
}

impl CantileverMode {
    /// Mode function φ at distance `x_m` from the root [1/√kg].
    pub fn shape(&self, x_m: f64) -> f64 {
        let bx = self.beta_l * x_m / self.length_m;
        let (sin, cos) = libm::sincos(bx);
        self.amplitude * (libm::cosh(bx) - cos - self.ratio * (libm::sinh(bx) - sin))
    }
}

/// n-th root of `cos z cosh z = −1`, by bisection of `cos z + 1/cosh z` around (n − ½)π, where it
/// changes sign once.
fn eigenvalue(number: usize) -> f64 {
    let centre = (number as f64 - 0.5) * core::f64::consts::PI;
    let f = |z: f64| libm::cos(z) + 1.0 / libm::cosh(z);
    let (mut low, mut high) = (centre - 0.5, centre + 0.5);
    let low_is_positive = f(low) > 0.0;
    // 60 halvings of an interval of 1 end below the spacing of doubles
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == low_is_positive {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// `∫₀ᴸ f dx` by Gauss–Legendre quadrature with five points on each of 64 equal pieces.
pub fn integrate(length_m: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PIECES: usize = 64;
    const NODES: [(f64, f64); 3] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * length_m / PIECES as f64;
    let mut sum = 0.0;
    for piece in 0..PIECES {
        let centre = (2 * piece + 1) as f64 * half;
        sum += NODES[0].1 * f(centre);
        for (node, weight) in &NODES[1..] {
            sum += weight * (f(centre - half * node) + f(centre + half * node));
        }
    }
    sum * half
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM: Cantilever = Cantilever { length_m: 5.0, mass_per_length_kg_m: 2.0, bending_stiffness_n_m2: 4000.0 };

    #[test]
    fn eigenvalues_are_the_tabulated_ones() {
        // Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1
        let table = [1.875_104_07, 4.694_091_13, 7.854_757_44, 10.995_540_73, 14.137_168_39];
        for (n, beta_l) in table.into_iter().enumerate() {
            assert!((eigenvalue(n + 1) - beta_l).abs() < 0.6e-8);
        }
    }

    #[test]
    fn mode_functions_are_orthonormal_in_mass() {
        for m in 1..=5 {
            for n in 1..=5 {
                let (a, b) = (BEAM.mode(m), BEAM.mode(n));
                let product = integrate(5.0, |x| 2.0 * a.shape(x) * b.shape(x));
                let expected = f64::from(u8::from(m == n));
                // cancellation of cosh(14) at the fifth mode: 1e6 ε = 1e-10
                assert!((product - expected).abs() < 1e-9, "{m} {n}: {product}");
            }
        }
    }

    #[test]
    fn clamped_root_does_not_move_and_a_free_tip_carries_no_moment() {
        let h = 1e-3;
        for n in 1..=3 {
            let mode = BEAM.mode(n);
            assert_eq!(mode.shape(0.0), 0.0);
            let curvature = |x: f64| (mode.shape(x + h) - 2.0 * mode.shape(x) + mode.shape(x - h)) / (h * h);
            // one-sided value at the tip falls with the distance from it (zero shear too, so
            // quadratically)
            assert!((curvature(5.0 - h) / curvature(h)).abs() < 1e-4, "mode {n}");
        }
    }

    #[test]
    fn quadrature_is_exact_for_polynomials_of_degree_nine() {
        let exact = 5.0f64.powi(10) / 10.0;
        assert!((integrate(5.0, |x| x.powi(9)) / exact - 1.0).abs() < 1e-14);
    }
}
