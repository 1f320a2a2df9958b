//! The dynamic equation integrated against test functions: inertial parameters from torques without
//! any acceleration.
//!
//! Multiplied by `w(t) = sin²(πt/L)` and integrated by parts over a window, Lagrange's form becomes
//! `−∫ ẇ p α − ∫ w (∂T/∂θ) α = ∫ w τ`, p linear in α: rates are integrated, never differentiated.
//! The base's row is homogeneous and the torques give the scale, so that no momentum need be known.
//!
//! **Weights are those of the sensors, not of the residuals.** Windows overlap by half, so the
//! noise of neighbours is correlated; its blocks `C_ww` and `C_w,w−1` (3 × 3) follow from the
//! channel sigmas at the last α, and a block Cholesky factor whitens row after row. The covariance
//! `(Σ A' C⁻¹ A)⁻¹` is then honest and no degree of freedom is spent on estimating weights.
//!
//! Window length: noise in the regressors leaves a bias that falls with L² (0.5 s: 0.1 %; 2 s:
//! below 0.005 %), while long windows see less of the motion. Memory is one window of sums; cost
//! per sample and pass 0.6 µs.

use crate::dynamic_equation::{ArmSample, LagrangeForm, lagrange_form};
use crate::momentum::{CHANNELS, MomentumSample};
use estimation::weighted_least_squares::{Estimate, LeastSquaresError};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Passes over the record: the first without weights, the others with those of the last estimate.
const PASSES: usize = 3;

/// How the record was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakSettings {
    pub interval_s: f64,
    /// Length of a window in samples, even.
    pub window_samples: usize,
    /// In channel order (w0, d1, d2, th1, th2).
    pub channel_sigma: [f64; CHANNELS],
    pub torque_sigma_n_m: f64,
}

/// One window: `rows α = observed`, and the noise of `rows α − observed`.
struct Window<const P: usize> {
    rows: SMatrix<f64, 3, P>,
    observed: Vector3<f64>,
    noise: Matrix3<f64>,
    /// With the window before.
    shared: Matrix3<f64>,
}

/// Values of the test function and its slope at sample j of n, and its integral over the period
/// that follows.
fn test_function(j: usize, settings: &WeakSettings) -> (f64, f64, f64) {
    let (n, dt) = (settings.window_samples as f64, settings.interval_s);
    let angle = |j: f64| 2.0 * core::f64::consts::PI * j / n;
    let (sine, cosine) = libm::sincos(angle(j as f64));
    let next = libm::sin(angle(j as f64 + 1.0));
    let slope = core::f64::consts::PI / (n * dt) * sine;
    (0.5 * (1.0 - cosine), slope, 0.5 * dt - n * dt / (4.0 * core::f64::consts::PI) * (next - sine))
}

/// `∂(p α)/∂channel · σ` and the same of the gradient (3 × channels), by central differences of a
/// bilinear form.
fn sensitivities<const P: usize>(
    sample: &MomentumSample,
    alpha: &SVector<f64, P>,
    sigma: &[f64; CHANNELS],
) -> (SMatrix<f64, 3, CHANNELS>, SMatrix<f64, 3, CHANNELS>) {
    const CHANNEL_STEP: f64 = 1e-5;
    let (mut momentum, mut gradient) = (SMatrix::<f64, 3, CHANNELS>::zeros(), SMatrix::<f64, 3, CHANNELS>::zeros());
    for (channel, sigma) in sigma.iter().enumerate() {
        let at = |step: f64| {
            let mut moved = *sample;
            match channel {
                0 => moved.omega0_z_rad_s += step,
                1 | 2 => moved.joint_rate_rad_s[channel - 1] += step,
                _ => moved.joint_angle_rad[channel - 3] += step,
            }
            let LagrangeForm { momentum, gradient } = lagrange_form::<P>(&moved);
            (momentum * alpha, gradient * alpha)
        };
        let (plus, minus, scale) = (at(CHANNEL_STEP), at(-CHANNEL_STEP), sigma / (2.0 * CHANNEL_STEP));
        momentum.set_column(channel, &((plus.0 - minus.0) * scale));
        gradient.set_column(channel, &((plus.1 - minus.1) * scale));
    }
    (momentum, gradient)
}

impl<const P: usize> Window<P> {
    /// Window over `samples` (one window long and one sample more); noise at `alpha`, when there is
    /// one.
    fn of(samples: &[ArmSample], alpha: Option<&SVector<f64, P>>, settings: &WeakSettings) -> Self {
        let (n, dt) = (settings.window_samples, settings.interval_s);
        let mut window = Self {
            rows: SMatrix::zeros(),
            observed: Vector3::zeros(),
            noise: Matrix3::identity(),
            shared: Matrix3::zeros(),
        };
        if alpha.is_some() {
            window.noise.fill(0.0);
        }
        for (j, sample) in samples[..n].iter().enumerate() {
            let (w, slope, torque_weight) = test_function(j, settings);
            let form = lagrange_form::<P>(&sample.motion);
            window.rows -= (form.momentum * slope + form.gradient * w) * dt;
            window.observed += Vector3::new(0.0, sample.torque_n_m[0], sample.torque_n_m[1]) * torque_weight;
            let Some(alpha) = alpha else { continue };
            let (momentum, gradient) = sensitivities(&sample.motion, alpha, &settings.channel_sigma);
            let mine = (momentum * slope + gradient * w) * dt;
            window.noise += mine * mine.transpose();
            let torque = torque_weight * settings.torque_sigma_n_m;
            window.add_torque_noise(torque * torque, false);
            if j < n / 2 {
                let (w, slope, torque_weight) = test_function(j + n / 2, settings);
                let before = (momentum * slope + gradient * w) * dt;
                window.shared += mine * before.transpose();
                window.add_torque_noise(torque * torque_weight * settings.torque_sigma_n_m, true);
            }
        }
        window
    }

    fn add_torque_noise(&mut self, variance: f64, shared: bool) {
        let block = if shared { &mut self.shared } else { &mut self.noise };
        block[(1, 1)] += variance;
        block[(2, 2)] += variance;
    }
}

/// Sums of the whitened rows, and what the next row must be freed of.
struct Whitened<const P: usize> {
    information: SMatrix<f64, P, P>,
    moment: SVector<f64, P>,
    squares: f64,
    windows: u64,
    before: Option<(Matrix3<f64>, SMatrix<f64, 3, P>, Vector3<f64>)>,
}

impl<const P: usize> Whitened<P> {
    fn empty() -> Self {
        Self { information: SMatrix::zeros(), moment: SVector::zeros(), squares: 0.0, windows: 0, before: None }
    }

    /// One row of the block Cholesky factor: `L_w,w−1 = C_w,w−1 L_w−1⁻ᵀ`,
    /// `L_w L_w' = C_ww − L_w,w−1 L_w,w−1'`.
    fn push(&mut self, window: Window<P>) -> Option<()> {
        let (mut noise, mut rows, mut observed) = (window.noise, window.rows, window.observed);
        if let Some((factor, rows_before, observed_before)) = &self.before {
            let coupling = factor.solve_lower_triangular(&window.shared.transpose())?.transpose();
            noise -= coupling * coupling.transpose();
            rows -= coupling * rows_before;
            observed -= coupling * observed_before;
        }
        let factor = noise.cholesky()?.l();
        let rows = factor.solve_lower_triangular(&rows)?;
        let observed = factor.solve_lower_triangular(&observed)?;
        self.information += rows.transpose() * rows;
        self.moment += rows.transpose() * observed;
        self.squares += observed.norm_squared();
        self.windows += 1;
        self.before = Some((factor, rows, observed));
        Some(())
    }

    fn solve(&self) -> Result<Estimate<P>, LeastSquaresError> {
        let refused = LeastSquaresError::InformationNotPositive { rows: self.windows, weakest: 0.0 };
        let scale = self.information.diagonal().map(|value| 1.0 / libm::sqrt(value));
        let scaling = SMatrix::<f64, P, P>::from_diagonal(&scale);
        let factor = (scaling * self.information * scaling).cholesky().ok_or(refused)?;
        let alpha = scaling * factor.solve(&(scaling * self.moment));
        Ok(Estimate { alpha, covariance: scaling * factor.inverse() * scaling })
    }
}

/// What [`weak_form`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakEstimate<const P: usize> {
    pub estimate: Estimate<P>,
    /// χ² of the whitened residuals per row: one when model and sigmas hold.
    pub chi_square_per_row: f64,
}

/// Parameters from rates, angles and torques, h unknown.
///
/// # Errors
/// [`LeastSquaresError::InformationNotPositive`]: too few windows, or a direction without trace.
pub fn weak_form<const P: usize>(
    samples: &[ArmSample],
    settings: &WeakSettings,
) -> Result<WeakEstimate<P>, LeastSquaresError> {
    assert!(settings.window_samples >= 4);
    assert!(settings.window_samples.is_multiple_of(2));
    let mut alpha: Option<SVector<f64, P>> = None;
    let mut outcome = None;
    for _ in 0..PASSES {
        let mut sums = Whitened::empty();
        let mut begin = 0;
        while begin + settings.window_samples < samples.len() + 1 {
            let window = Window::of(&samples[begin..], alpha.as_ref(), settings);
            let refused = LeastSquaresError::InformationNotPositive { rows: sums.windows, weakest: 0.0 };
            sums.push(window).ok_or(refused)?;
            begin += settings.window_samples / 2;
        }
        let estimate = sums.solve()?;
        let fitted = estimate.alpha.dot(&(sums.information * estimate.alpha)) - 2.0 * estimate.alpha.dot(&sums.moment);
        let chi_square_per_row = (sums.squares + fitted) / (3 * sums.windows) as f64;
        alpha = Some(estimate.alpha);
        outcome = Some(WeakEstimate { estimate, chi_square_per_row });
    }
    Ok(outcome.expect("there is at least one pass"))
}
