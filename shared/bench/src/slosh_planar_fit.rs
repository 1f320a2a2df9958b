//! Maximum likelihood of slosh in the plane: output error over accelerometer and gyro, bias and
//! trend of every channel projected out.
//!
//! A model is a function from N numbers to hub, slosh masses, thrusters and start; sensitivities
//! are differences of N runs beside the nominal one. Levenberg–Marquardt converges to the nearest
//! minimum: begin where the modes are right (`slosh_planar_scan`), and look at χ², which tells a
//! wrong minimum (66 per degree of freedom against 1).

use estimation::consistency::Whiteness;
use estimation::levenberg_marquardt::{End, Minimum, Quadratic, Settings, minimise};
use nalgebra::{Const, Matrix2, SMatrix, SVector, Vector2, Vector3};

use crate::slosh_planar::{PlanarHub, PlanarSlosh, PlanarState};
use crate::slosh_planar_record::{CHANNELS, PlanarError, PlanarRecord, PlanarThrust};
use crate::slosh_planar_scan::PlanarSample;

/// Bound of the iterations.
pub const ITERATIONS_MAX: u32 = 30;
/// Of the fit. At the bottom rounding of χ², and of the differences that its gradient is made of,
/// decides, whatever the damping.
const FIT: Settings = Settings {
    iterations_max: ITERATIONS_MAX,
    step_sigmas: 1e-3,
    gain_share: 0.0,
    rounding: (0.02, f64::INFINITY),
    damping_max: f64::INFINITY,
};

/// What a hypothesis of N numbers says of the craft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarCraft<const M: usize> {
    pub hub: PlanarHub,
    pub masses: [PlanarSlosh; M],
    pub thrust: PlanarThrust,
    pub start: PlanarState<M>,
}

impl<const M: usize> PlanarCraft<M> {
    /// At rest under thrusters that follow their commands exactly.
    pub fn at_rest(hub: PlanarHub, masses: [PlanarSlosh; M]) -> Self {
        Self { hub, masses, thrust: PlanarThrust::default(), start: PlanarState::default() }
    }

    fn step(&mut self, record: &PlanarRecord<'_>, k: usize) -> Option<Vector3<f64>> {
        let acting = self.thrust.acting(record, k)?;
        self.start.step_along(&self.hub, &self.masses, &acting, record.interval_s)
    }
}

/// What is known of the numbers before the record: `(θ − mean)' information (θ − mean)` is added to
/// χ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPrior<const N: usize> {
    pub mean: SVector<f64, N>,
    /// Zero of what is not known.
    pub information: SMatrix<f64, N, N>,
}

impl<const N: usize> PlanarPrior<N> {
    /// Nothing is known.
    pub fn none() -> Self {
        Self { mean: SVector::zeros(), information: SMatrix::zeros() }
    }

    fn chi_square(&self, theta: &SVector<f64, N>) -> f64 {
        let off = theta - self.mean;
        off.dot(&(self.information * off))
    }

    /// How many numbers it speaks of.
    fn rows(&self) -> usize {
        self.information.diagonal().iter().filter(|value| **value > 0.0).count()
    }
}

/// A maximum-likelihood estimate with its goodness of fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarEstimate<const N: usize> {
    pub theta: SVector<f64, N>,
    pub covariance: SMatrix<f64, N, N>,
    pub chi_square: f64,
    pub degrees_of_freedom: f64,
    pub iterations: u32,
    /// False where the iterations ended before a minimum: what a wrong model does.
    pub is_converged: bool,
}

impl<const N: usize> PlanarEstimate<N> {
    /// Standard deviations, in the units of `theta`.
    pub fn sigmas(&self) -> SVector<f64, N> {
        self.covariance.diagonal().map(libm::sqrt)
    }

    /// `(χ² − dof)/√(2 dof)`: a unit normal number when the model holds.
    pub fn z_score(&self) -> f64 {
        (self.chi_square - self.degrees_of_freedom) / libm::sqrt(2.0 * self.degrees_of_freedom)
    }
}

/// Bias and trend of each channel at their best.
type Trends = [Vector2<f64>; CHANNELS];

/// With what is known before the record.
fn beside<const N: usize>(
    mut here: Quadratic<Const<N>>,
    prior: &PlanarPrior<N>,
    theta: &SVector<f64, N>,
) -> Quadratic<Const<N>> {
    here.chi_square += prior.chi_square(theta);
    here.gradient -= prior.information * (theta - prior.mean);
    here.information += prior.information;
    here
}

/// Sums of one channel: `[1, t]` against itself, the residual and the sensitivities.
struct Offsets<const N: usize> {
    normal: Matrix2<f64>,
    residual: Vector2<f64>,
    sensitivity: SMatrix<f64, 2, N>,
}

impl<const N: usize> Offsets<N> {
    const fn zero() -> Self {
        Self {
            normal: Matrix2::new(0.0, 0.0, 0.0, 0.0),
            residual: Vector2::new(0.0, 0.0),
            sensitivity: SMatrix::<f64, 2, N>::from_array_storage(nalgebra::ArrayStorage([[0.0; 2]; N])),
        }
    }
}

/// Maximum likelihood from `start`; `scale` states what a small change of each number is.
///
/// # Errors
/// [`PlanarError`].
pub fn fit<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    start: &SVector<f64, N>,
    scale: &SVector<f64, N>,
) -> Result<PlanarEstimate<N>, PlanarError> {
    fit_with(record, craft, (start, scale), &PlanarPrior::none(), ITERATIONS_MAX)
}

/// As [`fit`], from `(start, scale)`, beside what is known of the numbers and in at most
/// `iterations_max`.
///
/// # Errors
/// [`PlanarError`].
pub fn fit_with<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    (start, scale): (&SVector<f64, N>, &SVector<f64, N>),
    prior: &PlanarPrior<N>,
    iterations_max: u32,
) -> Result<PlanarEstimate<N>, PlanarError> {
    let (got, need) = (record.samples.len(), 2 * N);
    if got < need {
        return Err(PlanarError::TooShort { got, need });
    }
    let at = |theta: SVector<f64, N>| {
        let (here, _) = quadratic(record, craft, &theta, scale)?;
        Some((theta, beside(here, prior, &theta)))
    };
    let settings = Settings { iterations_max, ..FIT };
    let found = minimise(at(*start).ok_or(PlanarError::NotObserved)?, &settings, |from, step, below| {
        let trial = from + step;
        let reached = chi_square(record, craft, &trial)? + prior.chi_square(&trial);
        if reached < below { at(trial) } else { None }
    });
    match found.end {
        End::Singular => Err(PlanarError::NotObserved),
        End::Converged | End::Exhausted => report(record, &found, prior),
    }
}

fn report<const N: usize>(
    record: &PlanarRecord<'_>,
    found: &Minimum<Const<N>, SVector<f64, N>>,
    prior: &PlanarPrior<N>,
) -> Result<PlanarEstimate<N>, PlanarError> {
    let channels = record.noise.weights().iter().filter(|weight| **weight > 0.0).count();
    let rows = channels * record.samples.len() + prior.rows();
    let covariance = estimation::cramer_rao::FisherInformation::<N> { matrix: found.quadratic.information }.bound();
    Ok(PlanarEstimate {
        theta: found.point,
        covariance: covariance.ok_or(PlanarError::NotObserved)?,
        chi_square: found.quadratic.chi_square,
        degrees_of_freedom: rows.saturating_sub(N + 2 * channels) as f64,
        iterations: found.iterations,
        is_converged: found.end == End::Converged,
    })
}

/// Cramér–Rao bound of `theta` under these forces, beside what is known before: what is measured
/// does not matter. `None`: some number leaves no trace.
pub fn bound<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    (theta, scale): (&SVector<f64, N>, &SVector<f64, N>),
    prior: &PlanarPrior<N>,
) -> Option<SMatrix<f64, N, N>> {
    let here = beside(quadratic(record, craft, theta, scale)?.0, prior, theta);
    estimation::cramer_rao::FisherInformation::<N> { matrix: here.information }.bound()
}

/// Residuals of each channel on block means at several scales.
pub fn whiteness<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    estimate: &PlanarEstimate<N>,
) -> Option<[Whiteness; CHANNELS]> {
    let (_, trends) = quadratic(record, craft, &estimate.theta, &estimate.sigmas())?;
    let mut craft = craft(&estimate.theta)?;
    let mut white = [Whiteness::default(); CHANNELS];
    for (k, sample) in record.samples.iter().enumerate() {
        let residual = measured(sample) - craft.step(record, k)?;
        for (c, weight) in record.noise.weights().into_iter().enumerate().filter(|(_, weight)| *weight > 0.0) {
            white[c].push((residual[c] - trends[c].dot(&ramp(record, k))) * libm::sqrt(weight));
        }
    }
    Some(white)
}

fn measured(sample: &PlanarSample) -> Vector3<f64> {
    Vector3::new(sample.acceleration_m_s2[0], sample.acceleration_m_s2[1], sample.rate_rad_s)
}

/// `[1, t]`, t from −1 to 1 over the record.
fn ramp(record: &PlanarRecord<'_>, k: usize) -> Vector2<f64> {
    let half = record.samples.len() as f64 / 2.0;
    Vector2::new(1.0, (k as f64 - half) / half)
}

/// χ² with the offsets at their best.
pub fn chi_square<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    theta: &SVector<f64, N>,
) -> Option<f64> {
    let mut craft = craft(theta)?;
    let weights = record.noise.weights();
    let (mut sum, mut normal, mut right) = (0.0, Matrix2::zeros(), [Vector2::zeros(); CHANNELS]);
    for (k, sample) in record.samples.iter().enumerate() {
        let residual = measured(sample) - craft.step(record, k)?;
        let ramp = ramp(record, k);
        normal += ramp * ramp.transpose();
        for c in 0..CHANNELS {
            sum += residual[c] * residual[c] * weights[c];
            right[c] += ramp * residual[c];
        }
    }
    let inverse = normal.try_inverse()?;
    let explained: f64 = right.iter().zip(weights).map(|(right, weight)| right.dot(&(inverse * right)) * weight).sum();
    Some(sum - explained).filter(|value| value.is_finite())
}

fn quadratic<const N: usize, const M: usize>(
    record: &PlanarRecord<'_>,
    craft: &impl Fn(&SVector<f64, N>) -> Option<PlanarCraft<M>>,
    theta: &SVector<f64, N>,
    scale: &SVector<f64, N>,
) -> Option<(Quadratic<Const<N>>, Trends)> {
    /// Of the scale, forward. A frequency that is moved by a part moves the phase by half ωT times
    /// that, some hundred over an hour of slosh: truncation 1e-5 of the sensitivity, rounding below
    /// (1e-5 of the scale promised 6 % too little of σ).
    const FORWARD_STEP_SHARE: f64 = 1e-7;
    let mut nominal = craft(theta)?;
    let mut beside = [nominal; N];
    for (i, beside) in beside.iter_mut().enumerate() {
        let mut moved = *theta;
        moved[i] += FORWARD_STEP_SHARE * scale[i];
        *beside = craft(&moved)?;
    }
    let weights = record.noise.weights();
    let mut sums =
        Quadratic { chi_square: 0.0, information: SMatrix::<f64, N, N>::zeros(), gradient: SVector::zeros() };
    let mut trends = [Vector2::zeros(); CHANNELS];
    let mut offsets = [const { Offsets::<N>::zero() }; CHANNELS];
    for (k, sample) in record.samples.iter().enumerate() {
        let expected = nominal.step(record, k)?;
        let residual = measured(sample) - expected;
        let mut sensitivity = SMatrix::<f64, CHANNELS, N>::zeros();
        for (i, beside) in beside.iter_mut().enumerate() {
            sensitivity.set_column(i, &((beside.step(record, k)? - expected) / (FORWARD_STEP_SHARE * scale[i])));
        }
        let ramp = ramp(record, k);
        for c in 0..CHANNELS {
            let row = sensitivity.row(c);
            sums.chi_square += residual[c] * residual[c] * weights[c];
            sums.gradient += row.transpose() * (residual[c] * weights[c]);
            sums.information += row.transpose() * (row * weights[c]);
            offsets[c].normal += ramp * ramp.transpose();
            offsets[c].residual += ramp * residual[c];
            offsets[c].sensitivity += ramp * row;
        }
    }
    for (c, Offsets { normal, residual, sensitivity }) in offsets.iter().enumerate() {
        let inverse = normal.try_inverse()?;
        let best = inverse * residual;
        sums.chi_square -= residual.dot(&best) * weights[c];
        sums.gradient -= sensitivity.transpose() * best * weights[c];
        sums.information -= sensitivity.transpose() * (inverse * sensitivity) * weights[c];
        trends[c] = best;
    }
    sums.chi_square.is_finite().then_some((sums, trends))
}

#[cfg(test)]
mod tests;
