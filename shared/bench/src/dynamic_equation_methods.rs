//! The dynamic equation row by row, `Y_τ α = [0, τ1, τ2]`: least squares, total least squares,
//! instrumental variables.
//!
//! Accelerations are central differences of the rates, torques the mean over the same interval, so
//! that both are attenuated alike. Unfiltered, the noise of the differences (1e-4 / 0.014 s) drowns
//! the regressors and the errors are tens of per cent: that, and nothing else, is the paper's Table
//! IV. A symmetric low-pass before the regressors brings the same rows to hundredths.
//!
//! *Why a finite symmetric kernel and not a Butterworth filter forth and back?* Its memory is
//! bounded, its delay exactly half its length, and it does not depend on where the record begins.

use crate::momentum_methods::MomentumError;
use estimation::instrumental_variables::InstrumentalVariables;
use estimation::total_least_squares::TotalLeastSquares;
use nalgebra::{SMatrix, SVector, Vector3};
use physics::dynamic_equation::{ArmMotion, ArmSample, torque_regressor};
use physics::excitation::JointReference;
use physics::momentum::{MomentumSample, momentum, predict_base_rate};

/// Longest reach of a kernel to either side.
pub const REACH_MAX: usize = 300;
/// Passes of the instruments.
const INSTRUMENT_PASSES: usize = 5;

/// Symmetric low-pass: `y_k = Σ_j h_|j| x_k+j`; the rows are taken every `stride` samples.
#[derive(Clone, Debug, PartialEq)]
pub struct RowFilter {
    reach: usize,
    taps: [f64; REACH_MAX + 2],
    stride: usize,
}

impl RowFilter {
    /// Every sample as it is.
    pub fn raw() -> Self {
        let mut taps = [0.0; REACH_MAX + 2];
        taps[0] = 1.0;
        Self { reach: 0, taps, stride: 1 }
    }

    /// Windowed sinc (Blackman) of the longest reach, half amplitude at `cut_hz`; four to six times
    /// the top harmonic of the motion.
    pub fn low_pass(cut_hz: f64, interval_s: f64, stride: usize) -> Self {
        use core::f64::consts::PI;
        let mut taps = [0.0; REACH_MAX + 2];
        for (j, tap) in taps.iter_mut().enumerate().take(REACH_MAX + 1) {
            let phase = PI * j as f64 / (REACH_MAX + 1) as f64;
            let window = 0.42 + 0.5 * libm::cos(phase) + 0.08 * libm::cos(2.0 * phase);
            let turn = 2.0 * PI * cut_hz * interval_s * j as f64;
            *tap = window * if j == 0 { 1.0 } else { libm::sin(turn) / turn };
        }
        let sum = 2.0 * taps[1..].iter().sum::<f64>() + taps[0];
        taps.iter_mut().for_each(|tap| *tap /= sum);
        Self { reach: REACH_MAX, taps, stride }
    }

    fn tap(&self, offset: isize) -> f64 {
        self.taps.get(offset.unsigned_abs()).copied().unwrap_or(0.0)
    }

    /// Indices at which all samples of kernel and difference exist.
    fn centres(&self, samples: usize) -> impl Iterator<Item = usize> + Clone + use<> {
        (self.reach + 1..samples.saturating_sub(self.reach + 1)).step_by(self.stride)
    }

    /// Filtered motion and torque at sample `centre`.
    fn row(&self, samples: &[ArmSample], centre: usize, interval_s: f64) -> (ArmMotion, Vector3<f64>) {
        let (mut angles, mut rates, mut slopes) = ([0.0; 2], [0.0; 3], [0.0; 3]);
        let mut torque = Vector3::zeros();
        let reach = self.reach as isize + 1;
        for offset in -reach..=reach {
            let sample = &samples[centre.wrapping_add_signed(offset)];
            let (tap, below, above) = (self.tap(offset), self.tap(offset - 1), self.tap(offset + 1));
            let motion = &sample.motion;
            let now = [motion.omega0_z_rad_s, motion.joint_rate_rad_s[0], motion.joint_rate_rad_s[1]];
            for i in 0..3 {
                rates[i] += tap * now[i];
                slopes[i] += (below - above) * now[i];
            }
            for i in 0..2 {
                angles[i] += tap * motion.joint_angle_rad[i];
                torque[i + 1] += 0.5 * (tap + above) * sample.torque_n_m[i];
            }
        }
        let accelerations_rad_s2 = slopes.map(|slope| slope / (2.0 * interval_s));
        (ArmMotion { joint_angle_rad: angles, rates_rad_s: rates, accelerations_rad_s2 }, torque)
    }
}

/// Record, its filter and its sampling.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    pub samples: &'a [ArmSample],
    pub filter: &'a RowFilter,
    pub interval_s: f64,
}

impl Rows<'_> {
    fn each<const P: usize>(&self) -> impl Iterator<Item = (usize, SMatrix<f64, 3, P>, Vector3<f64>)> {
        self.filter.centres(self.samples.len()).map(|centre| {
            let (motion, torque) = self.filter.row(self.samples, centre, self.interval_s);
            (centre, torque_regressor::<P>(&motion), torque)
        })
    }
}

/// Ordinary least squares.
///
/// *Why not weighted with the residuals' covariance?* The base's residual is the derivative of a
/// white noise: its power lies at high frequencies, its variance says little of what disturbs the
/// slow motion, and weighting by it cost a factor 1.6 (trajectory B).
///
/// # Errors
/// [`MomentumError::Instruments`]: a direction is not excited.
pub fn least_squares<const P: usize>(rows: &Rows<'_>) -> Result<SVector<f64, P>, MomentumError> {
    let mut sums = InstrumentalVariables::<P>::default();
    for (_, regressor, torque) in rows.each::<P>() {
        for i in 0..3 {
            let row = regressor.row(i).transpose();
            sums.push(&row, &row, torque[i], 1.0, 1.0);
        }
    }
    Ok(sums.estimate().map_err(MomentumError::Instruments)?.alpha)
}

/// Total least squares of all rows, every column taken as equally noisy.
///
/// # Errors
/// [`MomentumError::TotalLeastSquares`].
pub fn total_least_squares<const P: usize, const A: usize>(rows: &Rows<'_>) -> Result<SVector<f64, P>, MomentumError> {
    let mut factor = TotalLeastSquares::<P, A>::default();
    for (_, regressor, torque) in rows.each::<P>() {
        for i in 0..3 {
            factor.push(&regressor.row(i).transpose(), torque[i]);
        }
    }
    factor.estimate().map_err(MomentumError::TotalLeastSquares)
}

/// Iterated instrumental variables: motion simulated along the command `reference(time)` with the
/// last estimate, the momentum being the mean that this estimate sees in the record. `time` counts
/// from the first sample.
///
/// # Errors
/// See [`MomentumError`].
pub fn instrumental<const P: usize>(
    rows: &Rows<'_>,
    reference: impl Fn(f64) -> JointReference,
    start: &SVector<f64, P>,
) -> Result<SVector<f64, P>, MomentumError> {
    let mut alpha = *start;
    for _ in 0..INSTRUMENT_PASSES {
        let h_nms = mean_momentum(rows.samples, &alpha);
        let mut sums = InstrumentalVariables::<P>::default();
        for (centre, regressor, torque) in rows.each::<P>() {
            let time_s = centre as f64 * rows.interval_s;
            let motion =
                simulated(&alpha, h_nms, &reference, time_s, rows.interval_s).ok_or(MomentumError::NotPhysical)?;
            let instruments = torque_regressor::<P>(&motion);
            for i in 0..3 {
                sums.push(&instruments.row(i).transpose(), &regressor.row(i).transpose(), torque[i], 1.0, 1.0);
            }
        }
        alpha = sums.estimate().map_err(MomentumError::Instruments)?.alpha;
    }
    Ok(alpha)
}

fn mean_momentum<const P: usize>(samples: &[ArmSample], alpha: &SVector<f64, P>) -> f64 {
    samples.iter().map(|sample| momentum(alpha, &sample.motion)).sum::<f64>() / samples.len() as f64
}

/// Motion along the command, accelerations by the same central differences as the rows'.
fn simulated<const P: usize>(
    alpha: &SVector<f64, P>,
    h_nms: f64,
    reference: &impl Fn(f64) -> JointReference,
    time_s: f64,
    interval_s: f64,
) -> Option<ArmMotion> {
    let at = |time_s: f64| -> Option<MomentumSample> {
        let command = reference(time_s);
        Some(MomentumSample {
            omega0_z_rad_s: predict_base_rate(alpha, h_nms, command.angle_rad, command.rate_rad_s)?,
            joint_rate_rad_s: command.rate_rad_s,
            joint_angle_rad: command.angle_rad,
        })
    };
    let rates =
        |sample: &MomentumSample| [sample.omega0_z_rad_s, sample.joint_rate_rad_s[0], sample.joint_rate_rad_s[1]];
    let (before, now, after) = (at(time_s - interval_s)?, at(time_s)?, at(time_s + interval_s)?);
    let (low, high) = (rates(&before), rates(&after));
    let accelerations_rad_s2 = core::array::from_fn(|i| (high[i] - low[i]) / (2.0 * interval_s));
    Some(ArmMotion { joint_angle_rad: now.joint_angle_rad, rates_rad_s: rates(&now), accelerations_rad_s2 })
}
