//! Modes of a flexible appendage on a hub that is free to turn: closed form and bound of two modes,
//! held-out check of one to six.
//!
//! ```text
//! [[J, cᵀ],[c, I]] q̈ + diag(0, 2 ζ_k w_k) q̇ + diag(0, w_k²) q = [torque, 0, 0]ᵀ,     q = [θ, d1, d2]
//! ```
//!
//! `w_k`, `ζ_k` belong to the hub held fast (**hub-locked**); what torque-excited acceleration
//! shows are the modes of the whole (**hub-free**), in the benchmark 56 % higher in the first mode.
//! A report must say which it gives.

pub mod parts;

use estimation::cramer_rao::FisherInformation;
use nalgebra::{Complex, Matrix4, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Modes of the appendage that are estimated.
pub const MODES: usize = 2;

/// Columns of a free decay that are linear in it: `e^{−σt}(cos, sin)` per mode and a constant
/// (sensor bias).
const LINEAR: usize = 2 * MODES + 1;

/// One damped mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Undamped natural frequency, `|λ| / 2π`.
    pub frequency_hz: f64,
    pub damping_ratio: f64,
}

impl Mode {
    /// `(σ, ω_d)` of the pole pair `−σ ± i ω_d`.
    fn pole(&self) -> (f64, f64) {
        let omega = 2.0 * core::f64::consts::PI * self.frequency_hz;
        (self.damping_ratio * omega, omega * libm::sqrt(1.0 - self.damping_ratio * self.damping_ratio))
    }
}

/// Hub with two appendage modes, mass-normalised hub-locked shapes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Appendage {
    /// Hub and undeformed appendage about the hub axis.
    pub inertia_kg_m2: f64,
    /// Momentum of each unit mode about the hub axis [√kg m].
    pub coupling: [f64; MODES],
    pub locked: [Mode; MODES],
}

impl Appendage {
    /// Hub-free modes, lower first: undamped from the quadratic in ω², then Newton on the damped
    /// quartic.
    ///
    /// With θ eliminated: `(I − c cᵀ/J) d̈ + D ḋ + K d = 0`. `None` when `J ≤ Σ c²`: no hub can
    /// carry such modes.
    pub fn hub_free_modes(&self) -> Option<[Mode; MODES]> {
        let ([c1, c2], j) = (self.coupling, self.inertia_kg_m2);
        let (m11, m22, m12) = (1.0 - c1 * c1 / j, 1.0 - c2 * c2 / j, -c1 * c2 / j);
        let omega = self.locked.map(|mode| 2.0 * core::f64::consts::PI * mode.frequency_hz);
        let [k1, k2] = omega.map(|w| w * w);
        let [d1, d2] = [0, 1].map(|k| 2.0 * self.locked[k].damping_ratio * omega[k]);
        let determinant = m11 * m22 - m12 * m12;
        if determinant.is_nan() || determinant <= 0.0 {
            return None;
        }
        let half = (m11 * k2 + m22 * k1) / (2.0 * determinant);
        let root = libm::sqrt(half * half - k1 * k2 / determinant);
        let quartic = [determinant, m11 * d2 + m22 * d1, m11 * k2 + m22 * k1 + d1 * d2, d1 * k2 + d2 * k1, k1 * k2];
        // The smaller root from the product: half − root would cancel.
        let larger = half + root;
        let squares = [k1 * k2 / (determinant * larger), larger];
        let [first, second] = squares.map(|square| pole_near(&quartic, libm::sqrt(square)));
        Some([first?, second?])
    }

    /// `[θ̈, d̈1, d̈2]` under a torque on the hub, [rad/s²] and [√kg m/s²].
    ///
    /// The third and second row give `d̈ = −c θ̈ − 2 ζ w ḋ − w² d`; put into the first,
    /// `(J − c1² − c2²) θ̈ = torque + Σ c (2 ζ w ḋ + w² d)`. Meaningless when `J ≤ Σ c²`, see
    /// [`hub_free_modes`](Self::hub_free_modes).
    pub fn accelerations(&self, torque_n_m: f64, modal: [f64; MODES], modal_rate: [f64; MODES]) -> [f64; 1 + MODES] {
        let [c1, c2] = self.coupling;
        let [pull1, pull2] = [0, 1].map(|k| {
            let w = 2.0 * core::f64::consts::PI * self.locked[k].frequency_hz;
            w * (2.0 * self.locked[k].damping_ratio * modal_rate[k] + w * modal[k])
        });
        let hub = (torque_n_m + c1 * pull1 + c2 * pull2) / (self.inertia_kg_m2 - c1 * c1 - c2 * c2);
        [hub, -c1 * hub - pull1, -c2 * hub - pull2]
    }
}

/// Newton on the characteristic polynomial (highest power first) from `i ω`; `None` if it does not
/// settle on a vibration.
fn pole_near(polynomial: &[f64; 5], omega_rad_s: f64) -> Option<Mode> {
    const POLE_ITERATIONS_MAX: usize = 50;
    let mut s = Complex::new(0.0, omega_rad_s);
    for _ in 0..POLE_ITERATIONS_MAX {
        let (mut value, mut slope) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for coefficient in polynomial {
            slope = slope * s + value;
            value = value * s + coefficient;
        }
        let step = value / slope;
        s -= step;
        // Quadratic convergence: the step after one of 1e-10 is rounding.
        if step.norm_sqr() <= 1e-20 * s.norm_sqr() {
            let omega = libm::hypot(s.re, s.im);
            let mode = Mode { frequency_hz: omega / (2.0 * core::f64::consts::PI), damping_ratio: -s.re / omega };
            return (s.im > 0.0).then_some(mode);
        }
    }
    None
}

/// Acceleration of one channel at the start of the decay:
/// `Σ_k e^{−σ_k t} (a_k cos ω_k t + b_k sin ω_k t)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelAmplitude {
    pub cosine_m_s2: [f64; MODES],
    pub sine_m_s2: [f64; MODES],
}

/// A planned or recorded free decay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreeDecay {
    pub samples: u32,
    pub rate_hz: f64,
    /// White, per sample and channel.
    pub sigma_m_s2: f64,
}

/// Values of the linear columns at time `t`.
fn linear_columns(modes: &[Mode; MODES], time_s: f64) -> SVector<f64, LINEAR> {
    let mut columns = SVector::from_element(1.0);
    for (k, mode) in modes.iter().enumerate() {
        let (sigma, omega) = mode.pole();
        let envelope = libm::exp(-sigma * time_s);
        let (sine, cosine) = libm::sincos(omega * time_s);
        columns[2 * k] = envelope * cosine;
        columns[2 * k + 1] = envelope * sine;
    }
    columns
}

/// Standard deviations of frequency \[Hz\] and damping ratio a free decay should reach: Cramér–Rao
/// bound with amplitude, phase and bias of every channel unknown.
///
/// The derivative by a pole is `t` times the decay itself, so one Gram matrix of nine functions
/// serves all channels; the unknown linear columns are projected out (Schur complement). `None`
/// when the channels show a mode not at all. Cost O(samples).
pub fn predicted_sigma(
    modes: &[Mode; MODES],
    channels: &[ChannelAmplitude],
    decay: &FreeDecay,
) -> Option<[Mode; MODES]> {
    let gram = projected_gram(modes, decay)?;
    let mut information = Matrix4::zeros(); // (σ1, ω1, σ2, ω2)
    for channel in channels {
        let mut map = Matrix4::zeros();
        for k in 0..MODES {
            let (a, b) = (channel.cosine_m_s2[k], channel.sine_m_s2[k]);
            map[(2 * k, 2 * k)] = -a;
            map[(2 * k + 1, 2 * k)] = -b;
            map[(2 * k, 2 * k + 1)] = b;
            map[(2 * k + 1, 2 * k + 1)] = -a;
        }
        information += map.transpose() * gram * map / (decay.sigma_m_s2 * decay.sigma_m_s2);
    }
    let mut jacobian = Matrix4::zeros(); // ∂(σ, ω_d)/∂(f, ζ)
    for (k, mode) in modes.iter().enumerate() {
        let (two_pi, zeta) = (2.0 * core::f64::consts::PI, mode.damping_ratio);
        let root = libm::sqrt(1.0 - zeta * zeta);
        jacobian[(2 * k, 2 * k)] = two_pi * zeta;
        jacobian[(2 * k, 2 * k + 1)] = two_pi * mode.frequency_hz;
        jacobian[(2 * k + 1, 2 * k)] = two_pi * root;
        jacobian[(2 * k + 1, 2 * k + 1)] = -two_pi * mode.frequency_hz * zeta / root;
    }
    let sigmas = FisherInformation { matrix: jacobian.transpose() * information * jacobian }.sigmas()?;
    Some([0, 1].map(|k| Mode { frequency_hz: sigmas[2 * k], damping_ratio: sigmas[2 * k + 1] }))
}

/// Gram matrix of `t × (decay functions)` after projection on what the linear columns cannot
/// explain.
fn projected_gram(modes: &[Mode; MODES], decay: &FreeDecay) -> Option<Matrix4<f64>> {
    let mut linear = SMatrix::<f64, LINEAR, LINEAR>::zeros();
    let mut cross = SMatrix::<f64, LINEAR, 4>::zeros();
    let mut slopes = Matrix4::zeros();
    for n in 0..decay.samples {
        let time_s = f64::from(n) / decay.rate_hz;
        let columns = linear_columns(modes, time_s);
        let slope = columns.fixed_rows::<4>(0) * time_s;
        linear += columns * columns.transpose();
        cross += columns * slope.transpose();
        slopes += slope * slope.transpose();
    }
    Some(slopes - cross.transpose() * linear.cholesky()?.solve(&cross))
}

/// Why a free decay gives no modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeDecayError {
    /// Fewer samples than twice the linear columns: `need > got`.
    SegmentTooShort { got: usize, need: usize },
    /// A sample is NaN or infinite.
    SampleNotFinite { sample: usize, channel: usize },
    /// Two modes, or a mode and the constant, are the same function over this segment: too short
    /// for these poles.
    ModesNotDistinct,
}

/// What fixed poles leave unexplained in a segment they were not fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreeDecayResidual {
    /// Over all channels, corrected for the linear unknowns of each: the sensor sigma when the
    /// poles hold.
    pub residual_rms_m_s2: f64,
    /// Over all channels, fitted constant removed.
    pub signal_rms_m_s2: f64,
}

/// Most modes a refit takes.
pub const REFIT_MODES_MAX: usize = 6;

/// Linear unknowns of a refit at most.
const REFIT_LINEAR_MAX: usize = refit_unknowns(REFIT_MODES_MAX);

/// Linear unknowns per channel of a refit of so many modes: cosine and sine of each mode, constant.
pub const fn refit_unknowns(modes: usize) -> usize {
    2 * modes + 1
}

/// Held-out check: poles fixed (one to [`REFIT_MODES_MAX`]), amplitudes and constant refitted per
/// channel by least squares.
///
/// `accelerations_m_s2` holds sample after sample, `channels` values each. Cost O(samples ×
/// channels), nothing is kept.
///
/// # Errors
/// [`FreeDecayError`]: a property of the segment.
pub fn refit_free_decay_residual(
    modes: &[Mode],
    accelerations_m_s2: &[f64],
    channels: usize,
    rate_hz: f64,
) -> Result<FreeDecayResidual, FreeDecayError> {
    let (mut residual, mut signal) = (0.0, 0.0);
    let time_s = |sample: usize| sample as f64 / rate_hz;
    for_each_residual(modes, accelerations_m_s2, channels, time_s, |error, moving| {
        residual += error * error;
        signal += moving * moving;
    })?;
    let samples = accelerations_m_s2.len() / channels;
    let (count, degrees) = ((samples * channels) as f64, ((samples - refit_unknowns(modes.len())) * channels) as f64);
    Ok(FreeDecayResidual {
        residual_rms_m_s2: libm::sqrt(residual / degrees),
        signal_rms_m_s2: libm::sqrt(signal / count),
    })
}

/// Hands residual and signal (constant removed) of every sample to `sink`, channel after channel,
/// each in order of time.
///
/// `time_s` gives the time of a sample behind the first one; the spacing need not be even.
///
/// # Errors
/// As [`refit_free_decay_residual`].
pub fn for_each_residual(
    modes: &[Mode],
    accelerations_m_s2: &[f64],
    channels: usize,
    time_s: impl Fn(usize) -> f64,
    mut sink: impl FnMut(f64, f64),
) -> Result<(), FreeDecayError> {
    assert!(channels > 0);
    assert!(accelerations_m_s2.len().is_multiple_of(channels));
    let refit = Refit::new(modes, accelerations_m_s2.len() / channels, &time_s)?;
    for channel in 0..channels {
        let fit = refit.channel(accelerations_m_s2, channels, channel, &time_s)?;
        let constant = fit[refit.unknowns() - 1];
        for (n, sample) in accelerations_m_s2.chunks_exact(channels).enumerate() {
            sink(sample[channel] - dot(&fit, &refit.columns(time_s(n))), sample[channel] - constant);
        }
    }
    Ok(())
}

/// Values of the linear columns, or one number for each; zero behind the unknowns in use.
type Linear = [f64; REFIT_LINEAR_MAX];

fn dot(a: &Linear, b: &Linear) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Cholesky factor of the normal equations, which all channels share.
struct Refit<'a> {
    modes: &'a [Mode],
    /// Lower triangle.
    factor: [Linear; REFIT_LINEAR_MAX],
}

impl<'a> Refit<'a> {
    fn new(modes: &'a [Mode], samples: usize, time_s: &impl Fn(usize) -> f64) -> Result<Self, FreeDecayError> {
        assert!(!modes.is_empty());
        assert!(modes.len() <= REFIT_MODES_MAX);
        let mut refit = Refit { modes, factor: [[0.0; REFIT_LINEAR_MAX]; REFIT_LINEAR_MAX] };
        let need = 2 * refit.unknowns();
        if samples < need {
            return Err(FreeDecayError::SegmentTooShort { got: samples, need });
        }
        for n in 0..samples {
            let columns = refit.columns(time_s(n));
            for (row, a) in refit.factor.iter_mut().zip(columns) {
                row.iter_mut().zip(columns).for_each(|(sum, b)| *sum += a * b);
            }
        }
        refit.factorise()?;
        Ok(refit)
    }

    fn unknowns(&self) -> usize {
        refit_unknowns(self.modes.len())
    }

    /// `e^{−σt}(cos, sin)` per mode and one.
    fn columns(&self, time_s: f64) -> Linear {
        let mut columns = [0.0; REFIT_LINEAR_MAX];
        for (pair, mode) in columns.chunks_exact_mut(2).zip(self.modes) {
            let (sigma, omega) = mode.pole();
            let envelope = libm::exp(-sigma * time_s);
            let (sine, cosine) = libm::sincos(omega * time_s);
            pair.copy_from_slice(&[envelope * cosine, envelope * sine]);
        }
        columns[self.unknowns() - 1] = 1.0;
        columns
    }

    /// Gram matrix to its Cholesky factor, in place.
    fn factorise(&mut self) -> Result<(), FreeDecayError> {
        let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
        for j in 0..self.unknowns() {
            for i in j..self.unknowns() {
                let known: f64 = (0..j).map(|k| self.factor[i][k] * self.factor[j][k]).sum();
                let left = self.factor[i][j] - known;
                self.factor[i][j] = if i == j { libm::sqrt(left) } else { left / self.factor[j][j] };
            }
            let pivot = self.factor[j][j];
            // Condition of the Gram matrix above 1e12: half the digits are gone and the fit would
            // be rounding. A pivot that is not a number (root of a negative one) fails the
            // comparison too.
            (smallest, largest) = (smallest.min(pivot), largest.max(pivot));
            let distinct = pivot > 0.0 && smallest > 1e-6 * largest;
            if !distinct {
                return Err(FreeDecayError::ModesNotDistinct);
            }
        }
        Ok(())
    }

    /// Amplitudes (cosine, sine per mode) and constant of one channel.
    fn channel(
        &self,
        accelerations_m_s2: &[f64],
        channels: usize,
        channel: usize,
        time_s: &impl Fn(usize) -> f64,
    ) -> Result<Linear, FreeDecayError> {
        let mut fit = [0.0; REFIT_LINEAR_MAX];
        for (n, sample) in accelerations_m_s2.chunks_exact(channels).enumerate() {
            if !sample[channel].is_finite() {
                return Err(FreeDecayError::SampleNotFinite { sample: n, channel });
            }
            let columns = self.columns(time_s(n));
            fit.iter_mut().zip(columns).for_each(|(sum, column)| *sum += column * sample[channel]);
        }
        for i in 0..self.unknowns() {
            let known: f64 = (0..i).map(|k| self.factor[i][k] * fit[k]).sum();
            fit[i] = (fit[i] - known) / self.factor[i][i];
        }
        for i in (0..self.unknowns()).rev() {
            let known: f64 = (i + 1..self.unknowns()).map(|k| self.factor[k][i] * fit[k]).sum();
            fit[i] = (fit[i] - known) / self.factor[i][i];
        }
        Ok(fit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;
    use nalgebra::{Matrix3, Vector3, Vector6};
    use std::vec::Vec;

    /// Benchmark page 3, section 1.
    pub(super) const BEAM: Appendage = Appendage {
        inertia_kg_m2: 177.503_333_33,
        coupling: [10.231_943_38, 2.121_261_81],
        locked: [
            Mode { frequency_hz: 1.001_027_19, damping_ratio: 0.005 },
            Mode { frequency_hz: 6.273_330_30, damping_ratio: 0.008 },
        ],
    };

    /// Clamped beam of 5 m and 10 kg, 2 kg/m, at `x`.
    fn shape(k: usize, x_m: f64) -> f64 {
        let beta = [1.875_104_068_711_961, 4.694_091_132_974_175][k];
        let (cosh, sinh, cos, sin) = (libm::cosh(beta), libm::sinh(beta), libm::cos(beta), libm::sin(beta));
        let (b, s) = (beta * x_m / 5.0, (cosh + cos) / (sinh + sin));
        (libm::cosh(b) - libm::cos(b) - s * (libm::sinh(b) - libm::sin(b))) / 10.0_f64.sqrt()
    }

    #[test]
    fn accelerations_satisfy_the_three_equations() {
        let mut noise = SeededNoise::new(31);
        let [c1, c2] = BEAM.coupling;
        let mass = Matrix3::new(BEAM.inertia_kg_m2, c1, c2, c1, 1.0, 0.0, c2, 0.0, 1.0);
        for _ in 0..100 {
            let mut draw = || noise.normal();
            let (torque, modal, rate) = (10.0 * draw(), [draw(), draw()], [draw(), draw()]);
            let force = Vector3::from_fn(|i, _| match i {
                0 => torque,
                _ => {
                    let w = 2.0 * core::f64::consts::PI * BEAM.locked[i - 1].frequency_hz;
                    -2.0 * BEAM.locked[i - 1].damping_ratio * w * rate[i - 1] - w * w * modal[i - 1]
                }
            });
            let error = mass * Vector3::from(BEAM.accelerations(torque, modal, rate)) - force;
            assert!(error.amax() < 1e-11, "{error}"); // rounding of 1.5e3 × J c/(J − Σc²)
        }
    }

    /// Independent oracle: all three coordinates, full mass matrix, RK4 at 0.5 ms; 2 N m for one
    /// second, sampled at 200 Hz from one to five seconds at ten points of the beam.
    fn pulse_decay() -> Vec<f64> {
        let [c1, c2] = BEAM.coupling;
        let mass = Matrix3::new(BEAM.inertia_kg_m2, c1, c2, c1, 1.0, 0.0, c2, 0.0, 1.0);
        let inverse = mass.try_inverse().expect("positive");
        let w = BEAM.locked.map(|mode| 2.0 * core::f64::consts::PI * mode.frequency_hz);
        let acceleration = |x: &Vector6<f64>, torque: f64| {
            let force = |k: usize| -w[k] * w[k] * x[1 + k] - 2.0 * BEAM.locked[k].damping_ratio * w[k] * x[4 + k];
            inverse * Vector3::new(torque, force(0), force(1))
        };
        let rate = |x: &Vector6<f64>, torque: f64| {
            let a = acceleration(x, torque);
            Vector6::new(x[3], x[4], x[5], a[0], a[1], a[2])
        };
        let (mut x, h, mut record) = (Vector6::zeros(), 5e-4, Vec::new());
        for step in 0..10_000 {
            let torque = if step < 2000 { 2.0 } else { 0.0 };
            if step >= 2000 && step % 10 == 0 {
                let a = acceleration(&x, 0.0);
                record.extend((1..=10).map(|i| {
                    let at = 0.5 * f64::from(i);
                    (0.5 + at) * a[0] + shape(0, at) * a[1] + shape(1, at) * a[2]
                }));
            }
            let k1 = rate(&x, torque);
            let k2 = rate(&(x + k1 * (h / 2.0)), torque);
            let k3 = rate(&(x + k2 * (h / 2.0)), torque);
            let k4 = rate(&(x + k3 * h), torque);
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        record
    }

    #[test]
    fn hub_free_modes_equal_the_printed_ones() {
        let [first, second] = BEAM.hub_free_modes().expect("heavy hub");
        assert!((first.frequency_hz - 1.561_099_92).abs() < 2e-8 && (second.frequency_hz - 6.484_425_84).abs() < 2e-8);
        assert!(
            (first.damping_ratio - 0.007_782_72).abs() < 1e-8 && (second.damping_ratio - 0.008_330_56).abs() < 1e-8
        );
    }

    #[test]
    fn a_hub_of_great_inertia_leaves_the_locked_modes() {
        let heavy = Appendage { inertia_kg_m2: 1e12, ..BEAM };
        for (free, locked) in heavy.hub_free_modes().expect("heavy").iter().zip(BEAM.locked) {
            assert!((free.frequency_hz / locked.frequency_hz - 1.0).abs() < 1e-9); // c²/2J = 5e-11
            assert!((free.damping_ratio / locked.damping_ratio - 1.0).abs() < 1e-9);
        }
        assert_eq!(Appendage { inertia_kg_m2: 100.0, ..BEAM }.hub_free_modes(), None);
    }

    #[test]
    fn hub_free_modes_explain_a_simulated_decay_and_detuned_ones_do_not() {
        let (modes, record) = (BEAM.hub_free_modes().expect("heavy hub"), pulse_decay());
        let exact = refit_free_decay_residual(&modes, &record, 10, 200.0).expect("long");
        // RK4 phase error of the second mode: (ωh)⁴ ω t / 120 = 2.3e-7 with ωh = 0.020, ωt = 163.
        assert!(exact.residual_rms_m_s2 < 1e-6 * exact.signal_rms_m_s2);
        assert!(exact.signal_rms_m_s2 > 0.01);
        let mut wrong = modes;
        wrong[0].damping_ratio *= 1.05;
        let detuned = refit_free_decay_residual(&wrong, &record, 10, 200.0).expect("long");
        assert!(detuned.residual_rms_m_s2 > 1e-3 * detuned.signal_rms_m_s2);
    }

    #[test]
    fn residual_of_true_poles_is_the_sensor_noise_whatever_the_bias() {
        let (modes, mut record, mut noise) =
            (BEAM.hub_free_modes().expect("heavy hub"), pulse_decay(), SeededNoise::new(1));
        for (n, value) in record.iter_mut().enumerate() {
            *value += 3.1e-4 * noise.normal() + 0.01 * (n % 10) as f64;
        }
        let residual = refit_free_decay_residual(&modes, &record, 10, 200.0).expect("long");
        assert!((residual.residual_rms_m_s2 / 3.1e-4 - 1.0).abs() < 0.03); // 4.2 sigma of √(1/2/8000)
    }

    #[test]
    fn bound_of_the_decay_equals_the_independent_prototype() {
        let (modes, record) = (BEAM.hub_free_modes().expect("heavy hub"), pulse_decay());
        let time_s = |n: usize| n as f64 / 200.0;
        let refit = Refit::new(&modes, record.len() / 10, &time_s).expect("distinct");
        let channels: Vec<_> = (0..10)
            .map(|channel| {
                let fit = refit.channel(&record, 10, channel, &time_s).expect("long");
                ChannelAmplitude { cosine_m_s2: [fit[0], fit[2]], sine_m_s2: [fit[1], fit[3]] }
            })
            .collect();
        let decay = FreeDecay { samples: 800, rate_hz: 200.0, sigma_m_s2: 3.10e-4 };
        let sigma = predicted_sigma(&modes, &channels, &decay).expect("both modes seen");
        for (k, printed) in [[0.000606, 0.0797], [0.000579, 0.0694]].into_iter().enumerate() {
            let percent = [
                100.0 * sigma[k].frequency_hz / modes[k].frequency_hz,
                100.0 * sigma[k].damping_ratio / modes[k].damping_ratio,
            ];
            for (value, print) in percent.into_iter().zip(printed) {
                assert!((value / print - 1.0).abs() < 0.02, "mode {k}: {percent:?}"); // sigma printed to 3 digits
            }
        }
    }

    #[test]
    fn a_mode_no_channel_shows_has_no_bound() {
        let modes = BEAM.hub_free_modes().expect("heavy hub");
        let silent = ChannelAmplitude { cosine_m_s2: [0.1, 0.0], sine_m_s2: [0.0, 0.0] };
        let decay = FreeDecay { samples: 800, rate_hz: 200.0, sigma_m_s2: 3.10e-4 };
        assert_eq!(predicted_sigma(&modes, &[silent], &decay), None);
    }

    #[test]
    fn unusable_segments_are_refused_by_name() {
        let modes = BEAM.hub_free_modes().expect("heavy hub");
        let short = refit_free_decay_residual(&modes, &[0.0; 9], 1, 200.0);
        assert_eq!(short, Err(FreeDecayError::SegmentTooShort { got: 9, need: 10 }));
        let mut broken = pulse_decay();
        broken[37] = f64::NAN;
        let outcome = refit_free_decay_residual(&modes, &broken, 10, 200.0);
        assert_eq!(outcome, Err(FreeDecayError::SampleNotFinite { sample: 3, channel: 7 }));
        let same = refit_free_decay_residual(&[modes[0], modes[0]], &pulse_decay(), 10, 200.0);
        assert_eq!(same, Err(FreeDecayError::ModesNotDistinct));
    }

    #[test]
    fn any_number_of_modes_up_to_six_is_refitted_to_the_noise_and_one_mode_less_is_not() {
        let all: Vec<Mode> =
            (0u8..6).map(|k| Mode { frequency_hz: 1.7 * libm::pow(1.6, f64::from(k)), damping_ratio: 0.01 }).collect();
        for count in 1..=REFIT_MODES_MAX {
            let (modes, mut noise) = (&all[..count], SeededNoise::new(7));
            // Uneven times: every third sample is missing.
            let time_s = |n: usize| (n + n / 2) as f64 / 200.0;
            let mut record = Vec::new();
            for n in 0..600 {
                for channel in 0..3 {
                    let decay = |(k, mode): (usize, &Mode)| {
                        let (sigma, omega) = mode.pole();
                        let phase = omega * time_s(n) + (channel * k) as f64;
                        0.1 * libm::exp(-sigma * time_s(n)) * libm::sin(phase)
                    };
                    record.push(0.02 + modes.iter().enumerate().map(decay).sum::<f64>() + 1e-3 * noise.normal());
                }
            }
            let rms = |modes: &[Mode]| {
                let mut squares = 0.0;
                for_each_residual(modes, &record, 3, time_s, |error, _| squares += error * error).expect("long");
                libm::sqrt(squares / ((600 - refit_unknowns(modes.len())) * 3) as f64)
            };
            // Standard deviation of the ratio √(1/2/1800) = 1.7 %; four of them.
            assert!((rms(modes) / 1e-3 - 1.0).abs() < 0.07, "{count} modes: {}", rms(modes));
            assert!(count == 1 || rms(&modes[1..]) > 10e-3, "{count} modes");
        }
    }
}
