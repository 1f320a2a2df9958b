//! Both estimators of the arm that fly, sample by sample: momentum with its known `h`, and motion
//! with the torques, which need no `h`.
//!
//! The weighted fit on the momentum says the *shape* of the parameters within seconds (`Y_h α = h`
//! is homogeneous: an error of h is one of scale). Once it is settled the unscented filter starts
//! from it, its scale set free again to [`SCALE_SD`], on samples that the start has not seen: no
//! datum is counted twice, and the torques alone say the scale. The two estimates disagree by
//! exactly the error of h, or of the torque sensors' scale.
//!
//! Fixed memory. Cost of a sample: 0.3 µs for the momentum, some 10 µs for the filter.

use crate::arm_filter::{ArmFilter, ArmFilterSettings, MOTION};
use crate::consider::{ConsiderSums, SensorSheet};
use crate::dynamic_equation::ArmSample;
use crate::inertial_estimator::{InertialError, InertialEstimate, InertialEstimator, InertialSettings};
use estimation::Innovation;
use estimation::weighted_least_squares::Estimate;
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// The scale that the filter starts with is known to this, relative, whatever is claimed of h.
pub const SCALE_SD: f64 = 0.2;
/// Sigmas of the shape that the filter starts with: a recursive fit at its beginning takes its
/// weights at poor parameters and is a little too sure of itself (mean NEES 10 for 9 mated, 200
/// records, when it was believed).
const SHAPE_SIGMAS: f64 = 2.0;
/// The shape is settled when each parameter is known to this, relative. Nonlinear effects of such a
/// start are its square.
const SHAPE_SETTLED: f64 = 0.01;
/// Parameters below this share of the root mean square count as being so large.
const SMALL_SHARE: f64 = 0.05;
/// It is looked so many samples whether the shape is settled.
const LOOK_EVERY: u64 = 50;

/// Prior knowledge and noise that the estimators assume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiveSettings<const P: usize> {
    pub momentum: InertialSettings<P>,
    /// `None`: torques are not measured, and no filter runs.
    pub torque_sigma_n_m: Option<f64>,
    /// Sigma of the torque sensors' common scale, relative: every parameter of the filter moves
    /// with it.
    pub torque_scale_sd: f64,
    /// Between samples.
    pub interval_ns: u64,
}

/// Both estimators and the sums for the sensor sheet's sigma; `X = P + 5`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiveEstimators<const P: usize, const X: usize> {
    settings: LiveSettings<P>,
    momentum: InertialEstimator<P>,
    consider: ConsiderSums<P>,
    filter: Option<ArmFilter<P, X>>,
    samples: u64,
    last_ns: Option<u64>,
}

impl<const P: usize> LiveSettings<P> {
    /// The second sample is the next one: a hundredth of the interval is the jitter of a clock, a
    /// thousandth of the gyro's noise.
    fn follows(&self, last_ns: u64, t_ns: u64) -> bool {
        t_ns.wrapping_sub(last_ns).abs_diff(self.interval_ns) <= self.interval_ns / 100
    }
}

impl<const P: usize, const X: usize> LiveEstimators<P, X> {
    /// # Errors
    /// [`InertialError::MomentumUnknown`].
    pub fn new(settings: &LiveSettings<P>) -> Result<Self, InertialError> {
        const { assert!(X == P + MOTION) }
        assert!(settings.interval_ns > 0);
        Ok(Self {
            settings: *settings,
            momentum: InertialEstimator::new(&settings.momentum)?,
            consider: ConsiderSums::new(
                1e-9 * settings.interval_ns as f64,
                &settings.momentum.prior_sd().map(|sd| 1.0 / (sd * sd)),
            ),
            filter: None,
            samples: 0,
            last_ns: None,
        })
    }

    /// Takes the sample of time `t_ns`; the innovation is that of the momentum.
    ///
    /// # Errors
    /// [`InertialError::SampleNotFinite`] for the motion; the state is untouched then. A torque
    /// that is no number interrupts its filter alone.
    pub fn push(&mut self, t_ns: u64, sample: &ArmSample) -> Result<Innovation, InertialError> {
        let innovation = self.momentum.push(&sample.motion)?;
        let follows = self.last_ns.is_none_or(|last| self.settings.follows(last, t_ns));
        if !follows {
            self.consider.interrupt();
        }
        if self.momentum.settled(&innovation) {
            let settings = &self.settings.momentum;
            self.consider.push(&sample.motion, settings.h_nms, &settings.sigma, self.momentum.reference());
        } else {
            // its differences must not reach over what is left out
            self.consider.interrupt();
        }
        self.run_filter(sample, follows);
        self.last_ns = Some(t_ns);
        self.samples += 1;
        Ok(innovation)
    }

    /// A filter that fails is given up and starts again from the momentum.
    fn run_filter(&mut self, sample: &ArmSample, follows: bool) {
        if let Some(filter) = &mut self.filter {
            if !(follows && sample.is_finite()) {
                filter.interrupt();
            }
            if sample.is_finite() && filter.push(sample).is_err() {
                self.filter = None;
            }
        } else if self.samples.is_multiple_of(LOOK_EVERY) {
            self.filter = self.started();
        }
    }

    /// From the shape that the momentum has found; its first sample is the next one.
    fn started(&self) -> Option<ArmFilter<P, X>> {
        let torque_sigma_n_m = self.settings.torque_sigma_n_m?;
        let found = self.momentum.estimate().ok().filter(|found| found.consistent)?;
        let floor = SMALL_SHARE * found.alpha.norm() / libm::sqrt(P as f64);
        let scale = found.alpha.map(|value| value.abs().max(floor));
        let shape_sd = SVector::<f64, P>::from_fn(|i, _| libm::sqrt(found.noise_covariance[(i, i)]) / scale[i]);
        if !shape_sd.iter().all(|sd| *sd < SHAPE_SETTLED) {
            return None;
        }
        let settings = &self.settings;
        let filter = ArmFilter::new(&ArmFilterSettings {
            start: found.alpha,
            start_sd: scale * SCALE_SD,
            scale,
            sigma: settings.momentum.sigma,
            torque_sigma_n_m,
            interval_s: 1e-9 * settings.interval_ns as f64,
            h_nms: None,
        });
        let free = found.alpha * found.alpha.transpose() * (SCALE_SD * SCALE_SD);
        filter.with_covariance(&(found.noise_covariance * (SHAPE_SIGMAS * SHAPE_SIGMAS) + free))
    }

    /// From the momentum.
    ///
    /// # Errors
    /// [`InertialError::NotExcited`].
    pub fn estimate(&self) -> Result<InertialEstimate<P>, InertialError> {
        self.momentum.estimate()
    }

    /// From torques and motion; `None` until the shape is known.
    pub fn filter(&self) -> Option<&ArmFilter<P, X>> {
        self.filter.as_ref()
    }

    /// The filter's estimate, the sigma of the torques' scale included; `None` while it has
    /// predicted nothing and says what it began with.
    pub fn torque(&self) -> Option<Estimate<P>> {
        let filter = self.filter.as_ref().filter(|filter| filter.nis().count() > 0)?;
        let Estimate { alpha, covariance } = filter.estimate();
        let scale_sd = self.settings.torque_scale_sd;
        Some(Estimate { alpha, covariance: covariance + alpha * alpha.transpose() * (scale_sd * scale_sd) })
    }

    /// The one of the two with the smaller relative variances: the momentum's, with the systematic
    /// errors that the sensors' data sheet allows, while h is known better than torques tell. The
    /// momentum's is rejected where the effect of these errors is not known. `None`: neither.
    pub fn best(&self, sheet: &SensorSheet) -> Option<Estimate<P>> {
        let total = |(found, systematic): (InertialEstimate<P>, SMatrix<f64, P, P>)| Estimate {
            alpha: found.alpha,
            covariance: found.covariance + systematic,
        };
        let momentum = self.estimate().ok().zip(self.consider(sheet)).map(total);
        let torque = self.torque();
        let relative = |found: &Estimate<P>| found.covariance.trace() / found.alpha.norm_squared();
        match (momentum, torque) {
            (Some(one), Some(two)) => Some(if relative(&one) <= relative(&two) { one } else { two }),
            (one, two) => one.or(two),
        }
    }

    /// Standard deviations of the prior.
    pub fn prior_sd(&self) -> SVector<f64, P> {
        self.settings.momentum.prior_sd()
    }

    /// Covariance of the momentum's estimate from the systematic errors of the sensors' data sheet;
    /// `None` until it has settled, and where the samples since do not determine the parameters.
    pub fn consider(&self, sheet: &SensorSheet) -> Option<SMatrix<f64, P, P>> {
        self.consider.covariance(sheet, self.samples)
    }
}
