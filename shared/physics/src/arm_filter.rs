//! Unscented filter of the floating arm: motion and inertial parameters together, from rates,
//! angles and torques.
//!
//! State `(w0, th1, th2, d1, d2, α_i / α_nominal)`, the midpoint rule over one control period under
//! the measured torque: its error is that of 1e-5 N m, the mean of the torque's noise over a minute
//! is 1e-3 N m. What makes it work: process noise is the torque's noise mapped through `∂q̈/∂τ` and
//! nothing else (none on α); measurement noise is that of the data sheets, quantisation included;
//! parameters are scaled; sigma points are drawn only where `P(α)` is positive definite.
//!
//! With the momentum known, `Y_h α = h` is taken as a scalar measurement every tenth sample;
//! unknown, the torques alone give the scale, and an error of their scale goes into every
//! parameter.

use crate::dynamic_equation::ArmSample;
use crate::free_floating::{accelerations, dynamics};
use crate::momentum::{ChannelSigma, MomentumSample, is_physically_consistent, momentum, noisy_momentum_row};
use crate::weak_form::{WeakSettings, weak_form};
use estimation::consistency::ChiSquareMean;
use estimation::unscented::{StateSpace, UnscentedError, UnscentedFilter};
use estimation::weighted_least_squares::Estimate;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use serde::{Deserialize, Serialize};

/// States of motion before the parameters: w0, th1, th2, d1, d2.
pub const MOTION: usize = 5;
/// `Y_h α = h` is taken at every so many samples: oftener says the same again.
const MOMENTUM_EVERY: u64 = 10;
/// Its sigma as a share of the momentum's own noise at one sample, `s = √(Σ (σ_c ∂Y_h/∂c α)²)`:
/// over a minute that loses a fortieth of the accuracy, and it stands above the curvature of
/// `Y_h α` over the sigma points, whose motion is known far better than one sample says.
const MOMENTUM_SIGMA_SHARE: f64 = 0.2;
/// Innovations count as statistics from here on: before, the parameters still settle.
const SETTLED_SAMPLES: u64 = 1000;

/// What is known before the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmFilterSettings<const P: usize> {
    pub start: SVector<f64, P>,
    pub start_sd: SVector<f64, P>,
    /// Size of each parameter; not zero.
    pub scale: SVector<f64, P>,
    pub sigma: ChannelSigma,
    pub torque_sigma_n_m: f64,
    pub interval_s: f64,
    /// Momentum about the centre of mass, where it is known exactly.
    pub h_nms: Option<f64>,
}

/// Equations of motion in the filter's state; `X = P + 5`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Motion<const P: usize> {
    scale: SVector<f64, P>,
    interval_s: f64,
}

impl<const P: usize> Motion<P> {
    fn alpha<const X: usize>(&self, state: &SVector<f64, X>) -> SVector<f64, P> {
        SVector::from_fn(|i, _| state[MOTION + i] * self.scale[i])
    }

    /// Time derivative of (w0, th1, th2, d1, d2).
    fn rate(alpha: &SVector<f64, P>, x: &[f64; MOTION], torque: [f64; 2]) -> [f64; MOTION] {
        let [w0, th1, th2, d1, d2] = *x;
        match accelerations(alpha, [th1, th2], [w0, d1, d2], torque) {
            Some(a) => [a[0], d1, d2, a[1], a[2]],
            None => [f64::NAN; MOTION],
        }
    }
}

impl<const P: usize, const X: usize> StateSpace<X, 2, MOTION> for Motion<P> {
    fn propagate(&self, state: &SVector<f64, X>, torque: &SVector<f64, 2>) -> SVector<f64, X> {
        let (alpha, h, torque) = (self.alpha(state), self.interval_s, [torque[0], torque[1]]);
        let x: [f64; MOTION] = core::array::from_fn(|i| state[i]);
        let begin = Self::rate(&alpha, &x, torque);
        let middle = core::array::from_fn(|i| x[i] + 0.5 * h * begin[i]);
        let rate = Self::rate(&alpha, &middle, torque);
        let mut next = *state;
        for i in 0..MOTION {
            next[i] += h * rate[i];
        }
        next
    }

    fn observe(&self, state: &SVector<f64, X>, _: &SVector<f64, 2>) -> SVector<f64, MOTION> {
        state.fixed_rows::<MOTION>(0).into_owned()
    }

    fn is_feasible(&self, state: &SVector<f64, X>) -> bool {
        is_physically_consistent(&self.alpha(state))
    }
}

/// The filter; `X = P + 5`. Fixed memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmFilter<const P: usize, const X: usize> {
    model: Motion<P>,
    filter: UnscentedFilter<X>,
    sigma: ChannelSigma,
    torque_sigma_n_m: f64,
    h_nms: Option<f64>,
    samples: u64,
    /// The next sample is the first of a stretch: nothing predicts it.
    begins: bool,
    nis: ChiSquareMean,
}

/// A start from the first stretch of the record itself, whatever the prior: the weak form needs
/// none.
///
/// A start wrong by half, known to 30 %, makes the filter's first seconds nonlinear and its
/// covariance too small for good (mean NEES 8.9 for 8 in trajectory B). The weak form of the first
/// twenty seconds is within 0.1 %; taken as a start with **ten** times its sigma, it counts the
/// stretch twice by a hundredth of its information. `None`: the stretch does not determine the
/// parameters better than `start_sd`, or they are not physical; keep the prior.
pub fn self_start<const P: usize>(
    stretch: &[ArmSample],
    settings: &ArmFilterSettings<P>,
) -> Option<ArmFilterSettings<P>> {
    const SIGMAS: f64 = 10.0;
    const WINDOW_S: f64 = 2.0;
    let weak = WeakSettings {
        interval_s: settings.interval_s,
        window_samples: 2 * libm::round(0.5 * WINDOW_S / settings.interval_s) as usize,
        channel_sigma: settings.sigma.in_channel_order(),
        torque_sigma_n_m: settings.torque_sigma_n_m,
    };
    let Estimate { alpha, covariance } = weak_form::<P>(stretch, &weak).ok()?.estimate;
    let start_sd = covariance.diagonal().map(|variance| SIGMAS * libm::sqrt(variance));
    let better = start_sd.iter().zip(settings.start_sd.iter()).all(|(found, prior)| found < prior);
    (better && is_physically_consistent(&alpha)).then_some(ArmFilterSettings { start: alpha, start_sd, ..*settings })
}

impl<const P: usize, const X: usize> ArmFilter<P, X> {
    /// A filter that waits for its first sample.
    pub fn new(settings: &ArmFilterSettings<P>) -> Self {
        const { assert!(X == P + MOTION) }
        assert!(settings.scale.iter().all(|value| *value != 0.0));
        assert!(settings.interval_s > 0.0);
        let of = |motion: f64, i: usize, of_alpha: &dyn Fn(usize) -> f64| {
            if i < MOTION { motion } else { of_alpha(i - MOTION) }
        };
        let mean = SVector::from_fn(|i, _| of(0.0, i, &|p| settings.start[p] / settings.scale[p]));
        let sigma = SVector::from_fn(|i, _| of(0.0, i, &|p| settings.start_sd[p] / settings.scale[p].abs()));
        Self {
            model: Motion { scale: settings.scale, interval_s: settings.interval_s },
            filter: UnscentedFilter::new(mean, sigma),
            sigma: settings.sigma,
            torque_sigma_n_m: settings.torque_sigma_n_m,
            h_nms: settings.h_nms,
            samples: 0,
            begins: true,
            nis: ChiSquareMean::default(),
        }
    }

    /// The same with a start whose errors hang together; `None`: the covariance is not positive
    /// definite.
    #[must_use]
    pub fn with_covariance(self, covariance: &SMatrix<f64, P, P>) -> Option<Self> {
        let scale = &self.model.scale;
        let scaled = SMatrix::from_fn(|i, j| covariance[(i, j)] / (scale[i] * scale[j]));
        let mean: SVector<f64, P> = self.filter.mean().fixed_rows::<P>(MOTION).into_owned();
        let filter = self.filter.with_block(MOTION, &mean, &scaled)?;
        Some(Self { filter, ..self })
    }

    /// Samples are missing before the next one: the motion begins anew, the parameters keep what
    /// they have learnt.
    pub fn interrupt(&mut self) {
        self.begins = true;
    }

    /// Takes one sample: its measurements, then the step to the next one under its torque.
    ///
    /// # Errors
    /// See [`UnscentedError`].
    pub fn push(&mut self, sample: &ArmSample) -> Result<(), UnscentedError> {
        if !sample.is_finite() {
            return Err(UnscentedError::NotFinite);
        }
        let measured = in_state_order(&sample.motion);
        let ([rate_1, rate_2], [angle_1, angle_2]) = (self.sigma.joint_rate_rad_s, self.sigma.joint_angle_rad);
        let sigma = [self.sigma.omega0_rad_s, angle_1, angle_2, rate_1, rate_2];
        let begins = core::mem::take(&mut self.begins);
        if begins {
            self.filter.begin_at(&measured, &sigma);
        } else {
            self.take(&measured, &sigma)?;
        }
        if self.samples.is_multiple_of(MOMENTUM_EVERY) && !begins {
            self.take_momentum()?;
        }
        let noise = self.torque_noise();
        self.filter.predict(&self.model, &SVector::from(sample.torque_n_m), &noise)?;
        self.samples += 1;
        Ok(())
    }

    fn take(&mut self, measured: &[f64; MOTION], sigma: &[f64; MOTION]) -> Result<(), UnscentedError> {
        let (model, mut nis) = (self.model, 0.0);
        for i in 0..MOTION {
            let is_feasible = |state: &SVector<f64, X>| StateSpace::<X, 2, MOTION>::is_feasible(&model, state);
            let innovation = self.filter.update_component(i, measured[i], sigma[i], is_feasible)?.normalised();
            nis += innovation * innovation;
        }
        if self.samples >= SETTLED_SAMPLES {
            self.nis.push(nis, MOTION as u32);
        }
        Ok(())
    }

    fn take_momentum(&mut self) -> Result<(), UnscentedError> {
        let Some(h_nms) = self.h_nms else { return Ok(()) };
        let model = self.model;
        let motion = |state: &SVector<f64, X>| MomentumSample {
            omega0_z_rad_s: state[0],
            joint_rate_rad_s: [state[3], state[4]],
            joint_angle_rad: [state[1], state[2]],
        };
        let observe = |state: &SVector<f64, X>| SVector::<f64, 1>::new(momentum(&model.alpha(state), &motion(state)));
        let is_feasible = |state: &SVector<f64, X>| StateSpace::<X, 2, MOTION>::is_feasible(&model, state);
        let mean = self.filter.mean();
        let row = noisy_momentum_row::<P>(&motion(mean), h_nms, &self.sigma.in_channel_order());
        let sigma_nms = MOMENTUM_SIGMA_SHARE * libm::sqrt(row.residual_variance(&model.alpha(mean)));
        let noise = SMatrix::<f64, 1, 1>::new(sigma_nms);
        self.filter.update_with(observe, is_feasible, &SVector::<f64, 1>::new(h_nms), &noise).map(|_| ())
    }

    /// `∂(state)/∂τ σ_τ` over one period: rates `H⁻¹ σ dt`, joint angles half a period of it.
    fn torque_noise(&self) -> SMatrix<f64, X, 2> {
        let x = self.filter.mean();
        let alpha = self.model.alpha(x);
        let (mass, _) = dynamics(&alpha, [x[1], x[2]], [x[0], x[3], x[4]]);
        let inverse = mass.cholesky().map_or(Matrix3::zeros(), |factor| factor.inverse());
        let dt = self.model.interval_s;
        let mut noise = SMatrix::<f64, X, 2>::zeros();
        for joint in 0..2 {
            let kick: Vector3<f64> = inverse.column(joint + 1) * (self.torque_sigma_n_m * dt);
            let column = [kick[0], 0.5 * dt * kick[1], 0.5 * dt * kick[2], kick[1], kick[2]];
            for (i, value) in column.into_iter().enumerate() {
                noise[(i, joint)] = value;
            }
        }
        noise
    }

    /// Samples used so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Innovations squared over their covariance since they settled: one per degree of freedom when
    /// model and noises hold.
    pub fn nis(&self) -> &ChiSquareMean {
        &self.nis
    }

    /// Parameters with covariance after the last sample, in the units of the parameters.
    pub fn estimate(&self) -> Estimate<P> {
        let (all, scale) = (self.filter.covariance(), &self.model.scale);
        let covariance = SMatrix::from_fn(|i, j| all[(MOTION + i, MOTION + j)] * scale[i] * scale[j]);
        Estimate { alpha: self.model.alpha(self.filter.mean()), covariance }
    }
}

fn in_state_order(motion: &MomentumSample) -> [f64; MOTION] {
    let ([d1, d2], [th1, th2]) = (motion.joint_rate_rad_s, motion.joint_angle_rad);
    [motion.omega0_z_rad_s, th1, th2, d1, d2]
}
