//! Batch estimators on the conservation of momentum: what the literature uses, and the one that
//! attains the bound.
//!
//! `Y_h α = h` sample by sample, the noise in Y_h. Least squares, total least squares, generalised
//! total least squares and iterated instrumental variables leave 2–8 % of the accuracy; weights
//! `1/s²(α)` with noise compensation leave none. All of them pass over a slice and keep only sums:
//! no memory grows with the record.
//!
//! Scale: every parameter is proportional to `h`; `sigma_h_nms` is carried into the covariance as
//! `(σ_h/h)² α α'`.

use estimation::generalised_total_least_squares::GeneralisedTotalLeastSquares;
use estimation::instrumental_variables::{InstrumentError, InstrumentalVariables};
use estimation::total_least_squares::{TlsError, TotalLeastSquares};
use estimation::weighted_least_squares::{Estimate, LeastSquaresError};
use estimation::weighted_pass::WeightedPass;
use nalgebra::SVector;
use physics::excitation::JointReference;
use physics::momentum::{
    CHANNELS, ChannelSigma, MomentumSample, momentum_regressor, noisy_momentum_row, predict_base_rate,
};

/// Passes of [`weighted`]: weights move the estimate by less than 1e-4 of its sigma from the third
/// on.
const WEIGHTED_PASSES: usize = 3;
/// Passes of [`instrumental`].
const INSTRUMENT_PASSES: usize = 5;

/// Momentum about the centre of mass, as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownMomentum {
    pub h_nms: f64,
    pub sigma_h_nms: f64,
}

/// Why a batch estimator gives no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MomentumError {
    /// `Y_h α = h` is homogeneous in (α, h): without h only the ratios of the parameters exist.
    /// Give h from the wheels' book-keeping, or torques (`dynamic_equation`), or modulate a wheel
    /// of known momentum (`momentum_extended`).
    ScaleUnknown {
        h_nms: f64,
        sigma_h_nms: f64,
    },
    /// The wheel's momentum moved by less than its noise can show: `(α, h)` are known up to a
    /// factor. Modulate it by more, or longer.
    WheelUnmoved {
        wheel_rms_nms: f64,
        needed_nms: f64,
    },
    NotExcited(LeastSquaresError),
    TotalLeastSquares(TlsError),
    Instruments(InstrumentError),
    /// The parameters found have no positive inertia in some posture, so no base rate can be
    /// simulated with them.
    NotPhysical,
}

impl KnownMomentum {
    /// # Errors
    /// [`MomentumError::ScaleUnknown`] when the sigma is not smaller than the momentum itself.
    pub fn checked(self) -> Result<Self, MomentumError> {
        let Self { h_nms, sigma_h_nms } = self;
        let known = h_nms.is_finite() && sigma_h_nms >= 0.0 && sigma_h_nms < h_nms.abs();
        if known { Ok(self) } else { Err(MomentumError::ScaleUnknown { h_nms, sigma_h_nms }) }
    }

    /// What an error of the momentum adds: every parameter moves with it.
    pub(crate) fn scaled<const P: usize>(&self, mut estimate: Estimate<P>) -> Estimate<P> {
        let share = self.sigma_h_nms / self.h_nms;
        estimate.covariance += estimate.alpha * estimate.alpha.transpose() * (share * share);
        estimate
    }
}

/// Ordinary least squares; covariance `(Y'Y)⁻¹ (Σ s² y y') (Y'Y)⁻¹` with `s²` of the channels,
/// attenuation not included.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::Instruments`] when a direction is not excited.
pub fn least_squares<const P: usize>(
    samples: &[MomentumSample],
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
) -> Result<Estimate<P>, MomentumError> {
    let h = momentum.checked()?.h_nms;
    let pass = |alpha: Option<SVector<f64, P>>| {
        let (mut sums, channels) = (InstrumentalVariables::default(), sigma.in_channel_order());
        for sample in samples {
            let row = noisy_momentum_row::<P>(sample, h, &channels);
            let variance = alpha.map_or(1.0, |alpha| row.residual_variance(&alpha));
            sums.push(&row.regressor, &row.regressor, h, 1.0, variance);
        }
        sums.estimate().map_err(MomentumError::Instruments)
    };
    let first = pass(None)?;
    pass(Some(first.alpha)).map(|estimate| momentum.scaled(estimate))
}

/// Plain total least squares of `[Y h]`, every column taken as equally noisy; the baseline of the
/// literature.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::TotalLeastSquares`].
pub fn total_least_squares<const P: usize, const A: usize>(
    samples: &[MomentumSample],
    momentum: KnownMomentum,
) -> Result<SVector<f64, P>, MomentumError> {
    let h_nms = momentum.checked()?.h_nms;
    let mut factor = TotalLeastSquares::<P, A>::default();
    for sample in samples {
        factor.push(&momentum_regressor(sample), h_nms);
    }
    factor.estimate().map_err(MomentumError::TotalLeastSquares)
}

/// Total least squares with the mean noise covariance of the rows and h exact.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::TotalLeastSquares`].
pub fn generalised_total_least_squares<const P: usize, const A: usize>(
    samples: &[MomentumSample],
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
) -> Result<SVector<f64, P>, MomentumError> {
    let (h_nms, channels) = (momentum.checked()?.h_nms, sigma.in_channel_order());
    let mut factor = GeneralisedTotalLeastSquares::<P, A>::default();
    for sample in samples {
        let row = noisy_momentum_row::<P>(sample, h_nms, &channels);
        factor.push(&row.regressor, h_nms, &row.noise);
    }
    factor.estimate().map_err(MomentumError::TotalLeastSquares)
}

/// Iterated instrumental variables (the paper's Fig. 2): the base rate is simulated from the
/// *commanded* joint motion with the last estimate, and the simulated rows are the instruments.
/// `reference(k)` is the command at sample k.
///
/// # Errors
/// See [`MomentumError`].
pub fn instrumental<const P: usize>(
    samples: &[MomentumSample],
    reference: impl Fn(usize) -> JointReference,
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
) -> Result<Estimate<P>, MomentumError> {
    let channels = sigma.in_channel_order();
    let mut estimate = least_squares::<P>(samples, KnownMomentum { sigma_h_nms: 0.0, ..momentum }, sigma)?;
    for _ in 0..INSTRUMENT_PASSES {
        let mut sums = InstrumentalVariables::default();
        for (k, sample) in samples.iter().enumerate() {
            let instrument = simulated(&estimate.alpha, momentum.h_nms, &reference(k))?;
            let row = noisy_momentum_row::<P>(sample, momentum.h_nms, &channels);
            let variance = row.residual_variance(&estimate.alpha);
            sums.push(&momentum_regressor(&instrument), &row.regressor, row.observed, 1.0, variance);
        }
        estimate = sums.estimate().map_err(MomentumError::Instruments)?;
    }
    Ok(momentum.scaled(estimate))
}

/// Base and arm as they would move without noise if they followed the command.
fn simulated<const P: usize>(
    alpha: &SVector<f64, P>,
    h_nms: f64,
    command: &JointReference,
) -> Result<MomentumSample, MomentumError> {
    let rate = predict_base_rate(alpha, h_nms, command.angle_rad, command.rate_rad_s);
    Ok(MomentumSample {
        omega0_z_rad_s: rate.ok_or(MomentumError::NotPhysical)?,
        joint_rate_rad_s: command.rate_rad_s,
        joint_angle_rad: command.angle_rad,
    })
}

/// Weighted least squares with noise compensation in three passes from `start`; also `χ²/N` of the
/// residuals.
///
/// # Errors
/// [`MomentumError::ScaleUnknown`], [`MomentumError::NotExcited`].
pub fn weighted<const P: usize>(
    samples: &[MomentumSample],
    momentum: KnownMomentum,
    sigma: &ChannelSigma,
    start: &SVector<f64, P>,
) -> Result<(Estimate<P>, f64), MomentumError> {
    let (h_nms, channels): (f64, [f64; CHANNELS]) = (momentum.checked()?.h_nms, sigma.in_channel_order());
    let mut alpha = *start;
    let mut outcome = None;
    for _ in 0..WEIGHTED_PASSES {
        let mut pass = WeightedPass::at(alpha);
        for sample in samples {
            pass.push(&noisy_momentum_row::<P>(sample, h_nms, &channels));
        }
        let estimate = pass.estimate().map_err(MomentumError::NotExcited)?;
        alpha = estimate.alpha;
        outcome = Some((momentum.scaled(estimate), pass.chi_square_per_row(&alpha)));
    }
    Ok(outcome.expect("there is at least one pass"))
}
