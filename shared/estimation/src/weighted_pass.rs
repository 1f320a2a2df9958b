//! One pass of weighted least squares with noise compensation, weights taken at one fixed α: the
//! batch form.
//!
//! `(F − B) α = g`, `cov = (F − B)⁻¹`, `w_k = 1/s_k²(α°)`; pass after pass with the α found before,
//! three suffice. No data is kept: whoever has the rows sends them again. The recursive form is
//! [`crate::weighted_least_squares`].

use crate::weighted_least_squares::{Estimate, LeastSquaresError, NoisyRow, add_outer_product, solve_compensated};
use nalgebra::{SMatrix, SVector};

/// How much of a row's noise is taken off its share of `B`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Compensation {
    /// `S`, for every row.
    Expected,
    /// `S e²/s²`, `e` the row's residual at the reference.
    Shown,
}

/// Sums of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedPass<const P: usize> {
    /// Where the weights are taken.
    reference: SVector<f64, P>,
    compensation: Compensation,
    information: SMatrix<f64, P, P>,
    noise: SMatrix<f64, P, P>,
    moment: SVector<f64, P>,
    squares: f64,
    rows: u64,
}

impl<const P: usize> WeightedPass<P> {
    /// Weights are those of `reference`.
    pub fn at(reference: SVector<f64, P>) -> Self {
        Self::with(reference, Compensation::Expected)
    }

    /// Weights are those of `reference`, and each row's noise is compensated by its share in the
    /// residual: a fixed point is one of the likelihood, `Σ (y e − S α e²/s²)/s² = 0`.
    /// [`at`](Self::at) takes the mean of `e²/s²`, one, for itself; the difference is noise of
    /// relative variance `s²` over the signal's in the direction of α, and matters where a weak
    /// signal gives the scale. Needs a reference within some residual sigmas: go there by
    /// [`at`](Self::at).
    pub fn likely_at(reference: SVector<f64, P>) -> Self {
        Self::with(reference, Compensation::Shown)
    }

    fn with(reference: SVector<f64, P>, compensation: Compensation) -> Self {
        let zero = SMatrix::zeros();
        Self {
            reference,
            compensation,
            information: zero,
            noise: zero,
            moment: SVector::zeros(),
            squares: 0.0,
            rows: 0,
        }
    }

    /// Adds one row; O(P² C).
    pub fn push<const C: usize>(&mut self, row: &NoisyRow<P, C>) {
        let weight = 1.0 / row.residual_variance(&self.reference);
        add_outer_product(&mut self.information, &row.regressor, &(row.regressor * weight));
        let shown = match self.compensation {
            Compensation::Expected => weight,
            Compensation::Shown => {
                let residual = row.observed - row.regressor.dot(&self.reference);
                weight * weight * residual * residual
            }
        };
        for c in 0..C {
            let column = row.noise.column(c).into_owned();
            add_outer_product(&mut self.noise, &column, &(column * shown));
        }
        self.moment += row.regressor * (weight * row.observed);
        self.squares += weight * row.observed * row.observed;
        self.rows += 1;
    }

    /// # Errors
    /// [`LeastSquaresError::InformationNotPositive`]: noise exceeds signal in some direction.
    pub fn estimate(&self) -> Result<Estimate<P>, LeastSquaresError> {
        solve_compensated(&self.information, &self.noise, &self.moment, self.rows)
    }

    /// `χ²/N` of the residuals at `alpha`: one when model and sigmas hold, its spread `√(2/N)`.
    pub fn chi_square_per_row(&self, alpha: &SVector<f64, P>) -> f64 {
        let sum = self.squares - 2.0 * alpha.dot(&self.moment) + alpha.dot(&(self.information * alpha));
        sum / self.rows as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use crate::weighted_least_squares::BiasCompensatedLeastSquares;
    use nalgebra::{matrix, vector};

    fn rows(seed: u64, sigma: f64) -> impl Iterator<Item = NoisyRow<2, 1>> {
        let mut noise = SeededNoise::new(seed);
        (0..1500).map(move |k| {
            let u = 0.7 * libm::sin(0.013 * f64::from(k)); // slope between 0.6 and 3.4
            let measured = u + sigma * noise.normal();
            NoisyRow {
                regressor: vector![measured, measured * measured],
                observed: 2.0 * u - u * u,
                observed_variance: 1e-6,
                noise: matrix![sigma; sigma * 2.0 * measured],
            }
        })
    }

    #[test]
    fn passes_converge_to_what_late_weights_find_recursively() {
        let mut alpha = vector![1.0, 1.0];
        for _ in 0..6 {
            let mut pass = WeightedPass::at(alpha);
            rows(1, 0.01).for_each(|row| pass.push(&row));
            alpha = pass.estimate().expect("excited").alpha;
        }
        // 1500 rows in blocks of 50 all fit into the window of late weights.
        let mut recursive = BiasCompensatedLeastSquares::new(alpha, vector![1e-12, 1e-12], 50);
        for row in rows(1, 0.01) {
            recursive.update(&row);
        }
        let other = recursive.estimate().expect("excited");
        // A block shares one weight, a row here has its own: a part of a sigma.
        let sigma = other.covariance.diagonal().map(libm::sqrt);
        assert!((alpha - other.alpha).component_div(&sigma).amax() < 0.5, "{alpha} {}", other.alpha);
    }

    #[test]
    fn without_compensation_a_noisy_regressor_is_attenuated_and_with_it_not() {
        let (mut plain, mut compensated) = (0.0, 0.0);
        for seed in 0..40 {
            let (mut noise, mut pass) = (SeededNoise::new(seed), WeightedPass::at(vector![2.0, -1.0]));
            for k in 0..1500 {
                let clean = vector![libm::sin(0.013 * f64::from(k)), libm::cos(0.031 * f64::from(k))];
                let regressor = clean + vector![0.2 * noise.normal(), 0.0];
                let observed = 2.0 * clean[0] - clean[1];
                pass.push(&NoisyRow { regressor, observed, observed_variance: 0.01, noise: matrix![0.2; 0.0] });
            }
            compensated += (pass.estimate().expect("excited").alpha[0] - 2.0) / 40.0;
            pass.noise.fill(0.0);
            plain += (pass.estimate().expect("excited").alpha[0] - 2.0) / 40.0;
        }
        assert!((plain + 2.0 * 0.04 / 0.54).abs() < 0.01, "{plain}"); // noise over signal and noise
        assert!(compensated.abs() < 0.01, "{compensated}"); // 0.4 √2 / √(1500 · 40) = 0.0023, four of them
    }

    #[test]
    fn what_residuals_show_of_the_noise_nearly_halves_the_variance_where_noise_is_as_large_as_the_signal() {
        // Signal of rms √½, noise of 0.5 in the regressor and 0.3 in the observed: s² = 0.34.
        let (mut expected, mut shown) = (0.0, 0.0);
        for seed in 0..200 {
            let mut noise = SeededNoise::new(seed);
            let rows: [NoisyRow<1, 1>; 1000] = core::array::from_fn(|k| {
                let clean = libm::sin(0.013 * k as f64);
                let (regressor, observed) = (vector![clean + 0.5 * noise.normal()], clean + 0.3 * noise.normal());
                NoisyRow { regressor, observed, observed_variance: 0.09, noise: matrix![0.5] }
            });
            let solved = |mut pass: WeightedPass<1>| {
                rows.iter().for_each(|row| pass.push(row));
                pass.estimate().expect("excited").alpha
            };
            let plain = (0..4).fold(vector![0.8], |alpha, _| solved(WeightedPass::at(alpha)));
            let likely = (0..8).fold(plain, |alpha, _| solved(WeightedPass::likely_at(alpha)));
            let bound = 0.34 / 500.0;
            expected += (plain[0] - 1.0).powi(2) / bound / 200.0;
            shown += (likely[0] - 1.0).powi(2) / bound / 200.0;
        }
        // 1 + (0.25 + 0.25²/0.34)/½ = 1.87 and 1 + 0.25 · 0.09/0.34/½ = 1.13; 200 records spread a
        // variance by a tenth, three of them.
        assert!((1.3..2.45).contains(&expected), "{expected}");
        assert!((0.79..1.47).contains(&shown), "{shown}");
    }
}
