//! Maximum likelihood over motion and parameters together: iterated extended Kalman filter and
//! smoother, in batch.
//!
//! One pass: forward filter linearised along the last smoothed motion, backward pass of Bryson and
//! Frazier (equal to Rauch, Tung and Striebel's without their inverse: only the smoothed motion is
//! wanted, the parameters do not move). Two passes settle: the motion is measured to 1e-4, so its
//! own linearisation errors are 1e-8. Linearised along the *true* motion at the true parameters the
//! filter's covariance is the Cramér–Rao bound: [`bound`].
//!
//! The joints' and base's equations are those of `arm_filter`; Jacobians come from the regressor:
//! `∂q̈/∂α = −H⁻¹ Y_τ(q, q̇, q̈)`, and `∂q̈/∂x = −H⁻¹ ∂(Y_τ α)/∂x` at fixed accelerations. A known
//! momentum is conserved by the dynamics and therefore taken once.
//!
//! Memory: one [`SmootherStep`] per sample, given by the caller. Cost: some 4 µs per sample and
//! pass.

use estimation::consistency::ChiSquareMean;
use estimation::weighted_least_squares::Estimate;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use physics::arm_filter::MOTION;
use physics::dynamic_equation::{ArmMotion, ArmSample, torque_regressor};
use physics::free_floating::{accelerations, dynamics};
use physics::momentum::{ChannelSigma, MomentumSample, channel_jacobian, momentum_regressor};

/// (w0, th1, th2, d1, d2).
type State = SVector<f64, MOTION>;
type Motion5 = SMatrix<f64, MOTION, MOTION>;

/// How the record was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmootherSettings {
    pub sigma: ChannelSigma,
    pub torque_sigma_n_m: f64,
    pub interval_s: f64,
    /// Momentum about the centre of mass and its sigma, where it is known.
    pub momentum_nms: Option<(f64, f64)>,
}

/// Why a record gives no smoothed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SmootherError {
    /// Parameters on the way were not those of bodies: the start is too poor.
    NotPhysical { sample: usize },
    /// As many steps as samples are needed.
    WorkspaceTooShort { got: usize, need: usize },
}

/// What the backward pass must know of a sample; `X = P + 5`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmootherStep<const X: usize> {
    /// Where the equations are linearised: the smoothed motion.
    path: State,
    predicted: State,
    /// Rows of the motion in the predicted covariance.
    covariance: SMatrix<f64, MOTION, X>,
    gain: SMatrix<f64, X, MOTION>,
    /// `S⁻¹ (z − ẑ)`.
    weighted_innovation: State,
    /// Rows of the motion in the transition to the next sample.
    transition: SMatrix<f64, MOTION, X>,
}

impl<const X: usize> Default for SmootherStep<X> {
    fn default() -> Self {
        Self {
            path: State::zeros(),
            predicted: State::zeros(),
            covariance: SMatrix::zeros(),
            gain: SMatrix::zeros(),
            weighted_innovation: State::zeros(),
            transition: SMatrix::zeros(),
        }
    }
}

/// What [`smooth`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed<const P: usize> {
    pub estimate: Estimate<P>,
    /// Innovations squared over their covariance in the last pass.
    pub nis: ChiSquareMean,
}

/// Motion and covariance of one instant on the way forward.
struct Forward<const P: usize, const X: usize> {
    motion: State,
    alpha: SVector<f64, P>,
    covariance: SMatrix<f64, X, X>,
    nis: ChiSquareMean,
}

/// One step of the motion from a point of linearisation.
struct Linearised<const P: usize> {
    next: State,
    motion: Motion5,
    parameters: SMatrix<f64, MOTION, P>,
    /// Factor of the process noise per unit of torque.
    torque: SMatrix<f64, MOTION, 2>,
}

fn state_of(sample: &MomentumSample) -> State {
    let ([d1, d2], [th1, th2]) = (sample.joint_rate_rad_s, sample.joint_angle_rad);
    State::from([sample.omega0_z_rad_s, th1, th2, d1, d2])
}

fn sample_of(x: &State) -> MomentumSample {
    MomentumSample { omega0_z_rad_s: x[0], joint_angle_rad: [x[1], x[2]], joint_rate_rad_s: [x[3], x[4]] }
}

fn rate<const P: usize>(alpha: &SVector<f64, P>, x: &State, torque: [f64; 2]) -> Option<State> {
    let a = accelerations(alpha, [x[1], x[2]], [x[0], x[3], x[4]], torque)?;
    Some(State::from([a[0], x[3], x[4], a[1], a[2]]))
}

/// `∂q̈/∂x` and `∂q̈/∂α`, with `H⁻¹`.
fn acceleration_jacobians<const P: usize>(
    alpha: &SVector<f64, P>,
    x: &State,
    torque: [f64; 2],
) -> Option<(SMatrix<f64, 3, MOTION>, SMatrix<f64, 3, P>, Matrix3<f64>)> {
    const STEP: f64 = 1e-5; // quadratic in rates, sines of angles: truncation 1e-10
    let (mass, coriolis) = dynamics(alpha, [x[1], x[2]], [x[0], x[3], x[4]]);
    let inverse = mass.cholesky()?.inverse();
    let acceleration = inverse * (Vector3::new(0.0, torque[0], torque[1]) - coriolis);
    let regressor = |x: &State| {
        torque_regressor::<P>(&ArmMotion {
            joint_angle_rad: [x[1], x[2]],
            rates_rad_s: [x[0], x[3], x[4]],
            accelerations_rad_s2: acceleration.into(),
        })
    };
    let mut of_state = SMatrix::<f64, 3, MOTION>::zeros();
    for i in 0..MOTION {
        let (mut plus, mut minus) = (*x, *x);
        plus[i] += STEP;
        minus[i] -= STEP;
        of_state.set_column(i, &((regressor(&plus) - regressor(&minus)) * alpha / (2.0 * STEP)));
    }
    Some((-inverse * of_state, -inverse * regressor(x), inverse))
}

/// Runge–Kutta over one period, Jacobians at its middle to second order in the period.
fn linearise<const P: usize>(alpha: &SVector<f64, P>, x: &State, torque: [f64; 2], dt: f64) -> Option<Linearised<P>> {
    let k1 = rate(alpha, x, torque)?;
    let k2 = rate(alpha, &(x + k1 * (0.5 * dt)), torque)?;
    let middle = x + k2 * (0.5 * dt);
    let k3 = rate(alpha, &middle, torque)?;
    let k4 = rate(alpha, &(x + k3 * dt), torque)?;
    let (of_state, of_alpha, inverse) = acceleration_jacobians(alpha, &middle, torque)?;
    let (mut a, mut b) = (Motion5::zeros(), SMatrix::<f64, MOTION, P>::zeros());
    let mut torque_columns = SMatrix::<f64, MOTION, 2>::zeros();
    a[(1, 3)] = 1.0;
    a[(2, 4)] = 1.0;
    for (row, i) in [0, 3, 4].into_iter().enumerate() {
        a.set_row(i, &of_state.row(row));
        b.set_row(i, &of_alpha.row(row));
        for joint in 0..2 {
            torque_columns[(i, joint)] = dt * inverse[(row, joint + 1)];
        }
    }
    for joint in 0..2 {
        torque_columns[(1, joint)] = 0.5 * dt * torque_columns[(3, joint)];
        torque_columns[(2, joint)] = 0.5 * dt * torque_columns[(4, joint)];
    }
    Some(Linearised {
        next: x + (k1 + (k2 + k3) * 2.0 + k4) * (dt / 6.0),
        motion: Motion5::identity() + a * dt + a * a * (0.5 * dt * dt),
        parameters: b * dt + a * b * (0.5 * dt * dt),
        torque: torque_columns,
    })
}

impl<const P: usize, const X: usize> Forward<P, X> {
    fn new(first: &ArmSample, alpha: &SVector<f64, P>, sigma: &State) -> Self {
        const { assert!(X == P + MOTION) }
        // A start without information: the data know a thousand times more.
        let prior = SVector::<f64, X>::from_fn(|i, _| {
            let sd = if i < MOTION { sigma[i] } else { 0.3 * alpha.amax() };
            sd * sd
        });
        Self {
            motion: state_of(&first.motion),
            alpha: *alpha,
            covariance: SMatrix::from_diagonal(&prior),
            nis: ChiSquareMean::default(),
        }
    }

    /// `Y_h(x) α = h`, linearised at (path, reference).
    fn take_momentum(&mut self, path: &State, reference: &SVector<f64, P>, h_nms: f64, sigma_nms: f64) {
        let sample = sample_of(path);
        let by_channel = channel_jacobian::<P>(&sample).tr_mul(reference); // (w0, d1, d2, th1, th2)
        let by_state = State::from([by_channel[0], by_channel[3], by_channel[4], by_channel[1], by_channel[2]]);
        let regressor = momentum_regressor::<P>(&sample);
        let row = SVector::<f64, X>::from_fn(|i, _| if i < MOTION { by_state[i] } else { regressor[i - MOTION] });
        let expected = regressor.dot(&self.alpha) + by_state.dot(&(self.motion - path));
        let cross = self.covariance * row;
        let variance = row.dot(&cross) + sigma_nms * sigma_nms;
        let correction = cross * ((h_nms - expected) / variance);
        self.covariance -= cross * cross.transpose() / variance;
        self.shift(&correction);
    }

    fn shift(&mut self, correction: &SVector<f64, X>) {
        self.motion += correction.fixed_rows::<MOTION>(0);
        self.alpha += correction.fixed_rows::<P>(MOTION);
    }

    fn take(&mut self, measured: &State, sigma: &State, step: &mut SmootherStep<X>) -> Option<()> {
        let mut innovation_covariance: Motion5 = self.covariance.fixed_view::<MOTION, MOTION>(0, 0).into_owned();
        for i in 0..MOTION {
            innovation_covariance[(i, i)] += sigma[i] * sigma[i];
        }
        let innovation = measured - self.motion;
        let inverse = innovation_covariance.cholesky()?.inverse();
        let cross: SMatrix<f64, X, MOTION> = self.covariance.fixed_columns::<MOTION>(0).into_owned();
        step.weighted_innovation = inverse * innovation;
        step.gain = cross * inverse;
        self.nis.push(innovation.dot(&step.weighted_innovation), MOTION as u32);
        self.covariance -= step.gain * cross.transpose();
        self.shift(&(cross * step.weighted_innovation));
        Some(())
    }

    fn predict(&mut self, path: &State, reference: &SVector<f64, P>, step: &Linearised<P>, torque_sigma_n_m: f64) {
        let transition = joined::<P, X>(step);
        self.motion = step.next + step.motion * (self.motion - path) + step.parameters * (self.alpha - reference);
        let rows = transition * self.covariance;
        let noise = step.torque * torque_sigma_n_m;
        let motion = rows * transition.transpose() + noise * noise.transpose();
        for i in 0..MOTION {
            for j in 0..X {
                let value = if j < MOTION { 0.5 * (motion[(i, j)] + motion[(j, i)]) } else { rows[(i, j)] };
                self.covariance[(i, j)] = value;
                self.covariance[(j, i)] = value;
            }
        }
    }
}

fn joined<const P: usize, const X: usize>(step: &Linearised<P>) -> SMatrix<f64, MOTION, X> {
    SMatrix::from_fn(|i, j| if j < MOTION { step.motion[(i, j)] } else { step.parameters[(i, j - MOTION)] })
}

/// Forward pass at `reference`; the path is that of `steps`, or the filtered motion itself on the
/// first pass.
fn forward<const P: usize, const X: usize>(
    samples: &[ArmSample],
    reference: &SVector<f64, P>,
    settings: &SmootherSettings,
    steps: &mut [SmootherStep<X>],
    first_pass: bool,
) -> Result<Forward<P, X>, SmootherError> {
    let ([rate_1, rate_2], [angle_1, angle_2]) = (settings.sigma.joint_rate_rad_s, settings.sigma.joint_angle_rad);
    let sigma = State::from([settings.sigma.omega0_rad_s, angle_1, angle_2, rate_1, rate_2]);
    let mut now = Forward::<P, X>::new(&samples[0], reference, &sigma);
    for (k, sample) in samples.iter().enumerate() {
        let step = &mut steps[k];
        let refused = SmootherError::NotPhysical { sample: k };
        if k == 0 {
            let path = if first_pass { now.motion } else { step.path };
            if let Some((h_nms, sigma_nms)) = settings.momentum_nms {
                now.take_momentum(&path, reference, h_nms, sigma_nms);
            }
        }
        step.predicted = now.motion;
        step.covariance = now.covariance.fixed_rows::<MOTION>(0).into_owned();
        if k > 0 {
            now.take(&state_of(&sample.motion), &sigma, step).ok_or(refused)?;
        }
        if first_pass {
            step.path = now.motion;
        }
        if k + 1 < samples.len() {
            let path = step.path;
            let linear = linearise(reference, &path, sample.torque_n_m, settings.interval_s).ok_or(refused)?;
            step.transition = joined(&linear);
            now.predict(&path, reference, &linear, settings.torque_sigma_n_m);
        }
    }
    Ok(now)
}

/// Backward pass: the smoothed motion becomes the next path. `x_s = x̂ − P λ̃`, `λ̂_k−1 = F' λ̃_k`.
fn backward<const X: usize>(steps: &mut [SmootherStep<X>]) {
    let mut adjoint = SVector::<f64, X>::zeros();
    for k in (0..steps.len()).rev() {
        let step = &mut steps[k];
        let taken = step.weighted_innovation + step.gain.tr_mul(&adjoint);
        for i in 0..MOTION {
            adjoint[i] -= taken[i];
        }
        step.path = step.predicted - step.covariance * adjoint;
        if k > 0 {
            let head: State = adjoint.fixed_rows::<MOTION>(0).into_owned();
            let back = steps[k - 1].transition.tr_mul(&head);
            for i in 0..X {
                adjoint[i] = if i < MOTION { back[i] } else { adjoint[i] + back[i] };
            }
        }
    }
}

/// Parameters of the greatest likelihood from `start` in `passes` passes (two settle); `X = P + 5`.
///
/// # Errors
/// See [`SmootherError`].
pub fn smooth<const P: usize, const X: usize>(
    samples: &[ArmSample],
    start: &SVector<f64, P>,
    settings: &SmootherSettings,
    passes: usize,
    steps: &mut [SmootherStep<X>],
) -> Result<Smoothed<P>, SmootherError> {
    assert!(passes > 0);
    assert!(!samples.is_empty());
    let need = samples.len();
    let Some(steps) = steps.get_mut(..need) else {
        return Err(SmootherError::WorkspaceTooShort { got: steps.len(), need });
    };
    steps[0] = SmootherStep::default();
    let mut reference = *start;
    for pass in 0..passes {
        let end = forward(samples, &reference, settings, steps, pass == 0)?;
        reference = end.alpha;
        if pass + 1 == passes {
            let covariance = end.covariance.fixed_view::<P, P>(MOTION, MOTION).into_owned();
            return Ok(Smoothed { estimate: Estimate { alpha: end.alpha, covariance }, nis: end.nis });
        }
        backward(steps);
    }
    unreachable!("the last pass returns")
}

/// Cramér–Rao bound of the parameters from a noise-free record: the filter's covariance linearised
/// along it.
///
/// # Errors
/// See [`SmootherError`].
pub fn bound<const P: usize, const X: usize>(
    noise_free: &[ArmSample],
    truth: &SVector<f64, P>,
    settings: &SmootherSettings,
    steps: &mut [SmootherStep<X>],
) -> Result<SMatrix<f64, P, P>, SmootherError> {
    smooth(noise_free, truth, settings, 1, steps).map(|found| found.estimate.covariance)
}
