//! Square-root unscented Kalman filter: states and constants of a nonlinear model together,
//! additive noise, fixed memory.
//!
//! The covariance lives as a factor, `P = S S'`, and is never formed: every step appends columns to
//! a factor and rotates them away. Symmetric sigma points `x ± h_i s_i`, `s_i` the columns of S,
//! **each pair with a spread of its own**:
//!
//! - mean `f(x) + Σ (f(x + h s) + f(x − h s) − 2 f(x)) / 2h²`, the unscented mean with n + λ = h²;
//! - factor `[(f(x + h s) − f(x − h s)) / 2h, √(h² − 1)/2h² · (f(x + h s) + f(x − h s) − 2 f(x))]`:
//!   the unscented covariance to second order, its fourth-order terms a sum of squares (Nørgaard,
//!   Poulsen, Ravn 2000, Eqs. 41–50).
//!
//! *Why not the scaled unscented weights?* With n = 13 and α = 0.3 the weight of the central point
//! is −7: the factor must be down-dated, and the down-date fails exactly when the start is poor. A
//! sum of squares cannot fail.
//!
//! *Why a spread per pair?* A parameter known to 30 % has sigma points with negative inertia. A
//! pair that the model calls infeasible is drawn in until it is feasible; the others keep the
//! spread √3 that is best for normal densities.

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Spread of sigma points in standard deviations: fourth moment of the normal density.
pub const SPREAD: f64 = 1.732_050_807_568_877_2;

/// How often a spread is halved before a direction is given up.
const HALVINGS_MAX: usize = 40;

/// `x⁺ = f(x, u) + w`, `z = g(x, u) + v`, with X states (constants to be found among them), U
/// inputs, Z measurements.
pub trait StateSpace<const X: usize, const U: usize, const Z: usize> {
    /// State one step later under the input held over the step.
    fn propagate(&self, state: &SVector<f64, X>, input: &SVector<f64, U>) -> SVector<f64, X>;

    fn observe(&self, state: &SVector<f64, X>, input: &SVector<f64, U>) -> SVector<f64, Z>;

    /// Where both functions have a meaning; sigma points are drawn there only.
    fn is_feasible(&self, _state: &SVector<f64, X>) -> bool {
        true
    }
}

/// Condition under which a prediction or update is impossible; the belief is then unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnscentedError {
    /// The mean itself left the region where the model has a meaning: prior too wide, or the model
    /// is wrong.
    MeanInfeasible,
    /// The model gave NaN or infinity.
    NotFinite,
    /// Measurement noise and uncertainty leave an innovation without variance.
    InnovationCertain,
}

/// Difference between a measurement and its prediction, before the update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorInnovation<const Z: usize> {
    /// Measured minus predicted.
    pub innovation: SVector<f64, Z>,
    /// Lower triangular factor of its covariance.
    pub factor: SMatrix<f64, Z, Z>,
    /// `innovation' (factor factor')⁻¹ innovation`: χ² with Z degrees of freedom when the model
    /// holds.
    pub nis: f64,
}

/// Mean and factor of the covariance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnscentedFilter<const X: usize> {
    mean: SVector<f64, X>,
    /// Any square root of the covariance; lower triangular after a prediction.
    factor: SMatrix<f64, X, X>,
    spread: f64,
}

/// Images of the sigma points: centre, half differences and half second differences over h, by
/// columns.
struct Transformed<const X: usize, const Y: usize> {
    mean: SVector<f64, Y>,
    /// Column j: all first-order columns' entry of component j (X × Y, that is transposed).
    first: SMatrix<f64, X, Y>,
    second: SMatrix<f64, X, Y>,
}

impl<const X: usize> UnscentedFilter<X> {
    /// Independent standard deviations; zero: known exactly.
    pub fn new(mean: SVector<f64, X>, sigma: SVector<f64, X>) -> Self {
        assert!(mean.iter().all(|value| value.is_finite()));
        assert!(sigma.iter().all(|value| *value >= 0.0 && value.is_finite()));
        Self { mean, factor: SMatrix::from_diagonal(&sigma), spread: SPREAD }
    }

    /// Components from `first` on, with their covariance, independent of those before; `None`: it
    /// is not positive definite.
    #[must_use]
    pub fn with_block<const B: usize>(
        mut self,
        first: usize,
        mean: &SVector<f64, B>,
        covariance: &SMatrix<f64, B, B>,
    ) -> Option<Self> {
        let factor = covariance.cholesky()?;
        for i in 0..B {
            self.mean[first + i] = mean[i];
            self.factor.row_mut(first + i).fill(0.0);
            for j in 0..=i {
                self.factor[(first + i, first + j)] = factor.l_dirty()[(i, j)];
            }
        }
        Some(self)
    }

    /// Another spread, in standard deviations; below one the covariance is that of first
    /// differences.
    pub fn with_spread(mut self, spread: f64) -> Self {
        assert!(spread > 0.0);
        self.spread = spread;
        self
    }

    /// A first measurement of the leading components, after the start or after a gap: they take the
    /// measured values, independent of the other components, which keep theirs.
    pub fn begin_at(&mut self, measured: &[f64], sigma: &[f64]) {
        assert_eq!(measured.len(), sigma.len());
        assert!(measured.len() <= X);
        let mut kept = self.factor.transpose();
        kept.columns_mut(0, measured.len()).fill(0.0);
        self.factor = SMatrix::zeros();
        fold(&mut self.factor, kept);
        for (i, (value, sd)) in measured.iter().zip(sigma).enumerate() {
            self.mean[i] = *value;
            self.factor[(i, i)] = *sd;
        }
    }

    /// Mean of the states and constants.
    pub fn mean(&self) -> &SVector<f64, X> {
        &self.mean
    }

    /// `P = S Sᵀ` (X × X). Cost: X³ multiplications, no allocation.
    pub fn covariance(&self) -> SMatrix<f64, X, X> {
        self.factor * self.factor.transpose()
    }

    /// Standard deviation of each component.
    pub fn sigmas(&self) -> SVector<f64, X> {
        SVector::from_fn(|i, _| self.factor.row(i).norm())
    }

    /// One step of the model; `noise` (X × W) is a factor of the process noise, W its rank.
    ///
    /// Cost: 2X + 1 evaluations of the model and 2X³ multiplications; no allocation.
    ///
    /// # Errors
    /// See [`UnscentedError`]; the filter is untouched then.
    pub fn predict<const U: usize, const Z: usize, const W: usize>(
        &mut self,
        model: &impl StateSpace<X, U, Z>,
        input: &SVector<f64, U>,
        noise: &SMatrix<f64, X, W>,
    ) -> Result<(), UnscentedError> {
        let Transformed { mean, first, second } =
            self.transform(|x| model.is_feasible(x), |x| model.propagate(x, input))?;
        if !model.is_feasible(&mean) {
            return Err(UnscentedError::MeanInfeasible);
        }
        self.mean = mean;
        self.factor = SMatrix::zeros();
        fold(&mut self.factor, first);
        fold(&mut self.factor, second);
        fold(&mut self.factor, noise.transpose());
        Ok(())
    }

    /// A measurement; `noise` is a factor of its covariance. Joseph form: the new factor is
    /// `[S − K C, K C₂, K N]`.
    ///
    /// # Errors
    /// See [`UnscentedError`]; the filter is untouched then.
    pub fn update<const U: usize, const Z: usize>(
        &mut self,
        model: &impl StateSpace<X, U, Z>,
        input: &SVector<f64, U>,
        measured: &SVector<f64, Z>,
        noise: &SMatrix<f64, Z, Z>,
    ) -> Result<VectorInnovation<Z>, UnscentedError> {
        let seen = self.transform(|x| model.is_feasible(x), |x| model.observe(x, input))?;
        self.correct(&seen, measured, noise, |x| model.is_feasible(x))
    }

    /// The same for a measurement that is no part of the model (a pseudo-measurement, another
    /// sensor's rate).
    ///
    /// # Errors
    /// See [`UnscentedError`]; the filter is untouched then.
    pub fn update_with<const Z: usize>(
        &mut self,
        observe: impl Fn(&SVector<f64, X>) -> SVector<f64, Z>,
        is_feasible: impl Fn(&SVector<f64, X>) -> bool,
        measured: &SVector<f64, Z>,
        noise: &SMatrix<f64, Z, Z>,
    ) -> Result<VectorInnovation<Z>, UnscentedError> {
        let seen = self.transform(&is_feasible, observe)?;
        self.correct(&seen, measured, noise, is_feasible)
    }

    /// Measurement of component `index` itself with independent noise (Potter's form); returns
    /// innovation and its variance.
    ///
    /// Equal to [`Self::update`] with that row, at O(X²): the factor is only multiplied. A
    /// measurement that would carry the mean out of the model's region is believed less, its sigma
    /// doubled until the mean stays inside: information is given up, never misused.
    ///
    /// # Errors
    /// See [`UnscentedError`]; the filter is untouched then.
    pub fn update_component(
        &mut self,
        index: usize,
        measured: f64,
        sigma: f64,
        is_feasible: impl Fn(&SVector<f64, X>) -> bool,
    ) -> Result<crate::Innovation, UnscentedError> {
        let row: SVector<f64, X> = self.factor.row(index).transpose();
        let uncertainty = row.norm_squared();
        let innovation = crate::Innovation::new(measured - self.mean[index], sigma * sigma, uncertainty);
        if innovation.variance.is_nan() || innovation.variance <= 0.0 {
            return Err(UnscentedError::InnovationCertain);
        }
        if !innovation.innovation.is_finite() {
            return Err(UnscentedError::NotFinite);
        }
        let cross = self.factor * row;
        let mut believed = sigma;
        for _ in 0..HALVINGS_MAX {
            let variance = believed * believed + uncertainty;
            let mean = self.mean + cross * (innovation.innovation / variance);
            if is_feasible(&mean) {
                self.mean = mean;
                self.deflate(&row, &cross, believed, variance);
                return Ok(innovation);
            }
            believed = 2.0 * believed.max(libm::sqrt(uncertainty));
        }
        Err(UnscentedError::MeanInfeasible)
    }

    /// `S ← S (1 − row row' / (s + σ √s))`, s the variance of the innovation.
    fn deflate(&mut self, row: &SVector<f64, X>, cross: &SVector<f64, X>, sigma: f64, variance: f64) {
        let share = 1.0 / (variance + sigma * libm::sqrt(variance));
        for j in 0..X {
            let scale = share * row[j];
            for i in 0..X {
                self.factor[(i, j)] -= cross[i] * scale;
            }
        }
    }

    fn correct<const Z: usize>(
        &mut self,
        seen: &Transformed<X, Z>,
        measured: &SVector<f64, Z>,
        noise: &SMatrix<f64, Z, Z>,
        is_feasible: impl Fn(&SVector<f64, X>) -> bool,
    ) -> Result<VectorInnovation<Z>, UnscentedError> {
        let mut factor = SMatrix::<f64, Z, Z>::zeros();
        fold(&mut factor, seen.first);
        fold(&mut factor, seen.second);
        fold(&mut factor, noise.transpose());
        let innovation = measured - seen.mean;
        if !innovation.iter().all(|value| value.is_finite()) {
            return Err(UnscentedError::NotFinite);
        }
        let whitened = factor.solve_lower_triangular(&innovation).ok_or(UnscentedError::InnovationCertain)?;
        // K' = (L L')⁻¹ C S'
        let cross = seen.first.transpose() * self.factor.transpose();
        let half = factor.solve_lower_triangular(&cross).ok_or(UnscentedError::InnovationCertain)?;
        let gain = factor.tr_solve_lower_triangular(&half).ok_or(UnscentedError::InnovationCertain)?.transpose();
        let mean = self.mean + gain * innovation;
        if !is_feasible(&mean) {
            return Err(UnscentedError::MeanInfeasible);
        }
        let kept = self.factor - gain * seen.first.transpose();
        self.mean = mean;
        self.factor = SMatrix::zeros();
        fold(&mut self.factor, kept.transpose());
        fold(&mut self.factor, seen.second * gain.transpose());
        fold(&mut self.factor, noise.transpose() * gain.transpose());
        Ok(VectorInnovation { innovation, factor, nis: whitened.norm_squared() })
    }

    fn transform<const Y: usize>(
        &self,
        is_feasible: impl Fn(&SVector<f64, X>) -> bool,
        map: impl Fn(&SVector<f64, X>) -> SVector<f64, Y>,
    ) -> Result<Transformed<X, Y>, UnscentedError> {
        let centre = map(&self.mean);
        let (mut first, mut second) = (SMatrix::<f64, X, Y>::zeros(), SMatrix::<f64, X, Y>::zeros());
        let mut mean = centre;
        for i in 0..X {
            let column: SVector<f64, X> = self.factor.column(i).into_owned();
            let (spread, plus, minus) = self.feasible_pair(&column, &is_feasible)?;
            let (plus, minus) = (map(&plus), map(&minus));
            let curvature = plus + minus - centre * 2.0;
            mean += curvature * (0.5 / (spread * spread));
            let root = libm::sqrt((spread * spread - 1.0).max(0.0)) * 0.5 / (spread * spread);
            for j in 0..Y {
                first[(i, j)] = (plus[j] - minus[j]) * (0.5 / spread);
                second[(i, j)] = curvature[j] * root;
            }
        }
        let finite = mean.iter().chain(first.iter()).all(|value| value.is_finite());
        if finite { Ok(Transformed { mean, first, second }) } else { Err(UnscentedError::NotFinite) }
    }

    /// `mean ± spread · column`, the spread halved until both are feasible.
    fn feasible_pair(
        &self,
        column: &SVector<f64, X>,
        is_feasible: &impl Fn(&SVector<f64, X>) -> bool,
    ) -> Result<(f64, SVector<f64, X>, SVector<f64, X>), UnscentedError> {
        let mut spread = self.spread;
        for _ in 0..HALVINGS_MAX {
            let (plus, minus) = (self.mean + column * spread, self.mean - column * spread);
            if is_feasible(&plus) && is_feasible(&minus) {
                return Ok((spread, plus, minus));
            }
            spread *= 0.5;
        }
        Err(UnscentedError::MeanInfeasible)
    }
}

/// Lower triangular L' with `L' L'' = L L' + C C'`; `columns` is `C'` (K × N). Householder
/// reflections, row by row of L.
///
/// Cost 2 K N² multiplications; rows of zeros cost nothing.
fn fold<const N: usize, const K: usize>(factor: &mut SMatrix<f64, N, N>, mut columns: SMatrix<f64, K, N>) {
    for i in 0..N {
        let tail = columns.column(i).norm_squared();
        if tail == 0.0 {
            continue;
        }
        let pivot = factor[(i, i)];
        let norm = libm::sqrt(pivot * pivot + tail);
        // v = (pivot + sign(pivot) norm, C_i): no cancellation; the pivot becomes −sign(pivot)
        // norm, turned positive below.
        let sign = if pivot < 0.0 { -1.0 } else { 1.0 };
        let head = pivot + sign * norm;
        let scale = 1.0 / (norm * head.abs()); // 2 / v'v
        let reflector: SVector<f64, K> = columns.column(i).into_owned();
        for j in i..N {
            let mut target = columns.column_mut(j);
            let product = scale * (head * factor[(j, i)] + reflector.dot(&target));
            factor[(j, i)] = -sign * (factor[(j, i)] - product * head);
            target.axpy(-product, &reflector, 1.0);
        }
    }
}

#[cfg(test)]
mod tests;
