//! Unscented filter of the flying arm (BP1B): motion, wrench noise and the eight parameters, from
//! gyro, accelerometer, encoders, torques.
//!
//! State `(w0, th1, th2, d1, d2, n, π / π_nominal)`, n the five errors of the wrench held through
//! the present period. The accelerometer reads `a_B` *under* that wrench, so its innovation and the
//! step that follows share n: left out, the two would be taken as independent and the covariance
//! would lie. After each step n is drawn afresh. Position and velocity of the base do not enter the
//! equations.

use estimation::consistency::ChiSquareMean;
use estimation::unscented::{StateSpace, UnscentedError, UnscentedFilter};
use estimation::weighted_least_squares::Estimate;
use nalgebra::{SMatrix, SVector};
use physics::free_flying::{Five, FlyingGeometry, FlyingMotion, Pi, accelerations, dynamics, momentum_form};
use physics::momentum::{ChannelSigma, MomentumSample};
use serde::{Deserialize, Serialize};

/// States of motion, of the wrench's error, and all with the parameters.
const MOTION: usize = 5;
const WRENCH: usize = 5;
const FILTER_STATES: usize = MOTION + WRENCH + 8;
const FIRST_PARAMETER: usize = MOTION + WRENCH;
/// Innovations count as statistics from here on.
const SETTLED_SAMPLES: u64 = 1000;

type State = SVector<f64, FILTER_STATES>;

/// What the sensors say in one control period, and the wrench commanded and measured for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlyingSample {
    pub motion: MomentumSample,
    /// At the reference point, base axes, under the wrench of this period.
    pub acceleration_m_s2: [f64; 2],
    /// (force x, force y, torque about B, τ1, τ2), held through the period.
    pub wrench: [f64; WRENCH],
}

/// What is known before the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlyingSettings {
    pub geometry: FlyingGeometry,
    pub start: Pi,
    pub start_sd: Pi,
    /// Size of each parameter; not zero.
    pub scale: Pi,
    pub sigma: ChannelSigma,
    pub acceleration_sigma_m_s2: f64,
    pub wrench_sigma: [f64; WRENCH],
    pub interval_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Motion {
    geometry: FlyingGeometry,
    scale: Pi,
    interval_s: f64,
}

impl Motion {
    fn pi(&self, state: &State) -> Pi {
        SVector::from_fn(|i, _| state[FIRST_PARAMETER + i] * self.scale[i])
    }

    /// (a_Bx, a_By, w0dot, th1dd, th2dd) at motion x.
    fn accelerations(&self, pi: &Pi, x: &[f64; MOTION], wrench: &Five) -> Five {
        let found = accelerations(&self.geometry, pi, [x[1], x[2]], [x[0], x[3], x[4]], wrench);
        found.unwrap_or_else(|| Five::repeat(f64::NAN))
    }

    fn felt(state: &State, wrench: &SVector<f64, WRENCH>) -> Five {
        Five::from_fn(|i, _| wrench[i] + state[MOTION + i])
    }
}

impl StateSpace<FILTER_STATES, WRENCH, 2> for Motion {
    /// Midpoint rule; the error of the wrench is forgotten, for the next period brings its own.
    fn propagate(&self, state: &State, wrench: &SVector<f64, WRENCH>) -> State {
        let (pi, felt, h) = (self.pi(state), Self::felt(state, wrench), self.interval_s);
        let rate = |x: &[f64; MOTION]| {
            let a = self.accelerations(&pi, x, &felt);
            [a[2], x[3], x[4], a[3], a[4]]
        };
        let x: [f64; MOTION] = core::array::from_fn(|i| state[i]);
        let begin = rate(&x);
        let middle = rate(&core::array::from_fn(|i| x[i] + 0.5 * h * begin[i]));
        State::from_fn(|i, _| match i {
            0..MOTION => x[i] + h * middle[i],
            MOTION..FIRST_PARAMETER => 0.0,
            _ => state[i],
        })
    }

    /// The accelerometer.
    fn observe(&self, state: &State, wrench: &SVector<f64, WRENCH>) -> SVector<f64, 2> {
        let x = core::array::from_fn(|i| state[i]);
        let a = self.accelerations(&self.pi(state), &x, &Self::felt(state, wrench));
        SVector::<f64, 2>::new(a[0], a[1])
    }

    fn is_feasible(&self, state: &State) -> bool {
        let (mass, _) = dynamics(&self.geometry, &self.pi(state), [state[1], state[2]], [0.0; 3]);
        mass.cholesky().is_some()
    }
}

/// The filter. Fixed memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlyingFilter {
    model: Motion,
    filter: UnscentedFilter<FILTER_STATES>,
    settings: FlyingSettings,
    samples: u64,
    nis: ChiSquareMean,
}

impl FlyingFilter {
    /// A filter that waits for its first sample.
    pub fn new(settings: &FlyingSettings) -> Self {
        assert!(settings.scale.iter().all(|value| *value != 0.0));
        assert!(settings.interval_s > 0.0);
        let mean = State::from_fn(|i, _| match i.checked_sub(FIRST_PARAMETER) {
            Some(p) => settings.start[p] / settings.scale[p],
            None => 0.0,
        });
        let sigma = State::from_fn(|i, _| match i {
            0..MOTION => 0.0,
            MOTION..FIRST_PARAMETER => settings.wrench_sigma[i - MOTION],
            _ => settings.start_sd[i - FIRST_PARAMETER] / settings.scale[i - FIRST_PARAMETER].abs(),
        });
        Self {
            model: Motion { geometry: settings.geometry, scale: settings.scale, interval_s: settings.interval_s },
            filter: UnscentedFilter::new(mean, sigma),
            settings: *settings,
            samples: 0,
            nis: ChiSquareMean::default(),
        }
    }

    /// Takes one sample: its measurements, then the step to the next one under its wrench.
    ///
    /// # Errors
    /// See [`UnscentedError`].
    pub fn push(&mut self, sample: &FlyingSample) -> Result<(), UnscentedError> {
        let ([d1, d2], [th1, th2]) = (sample.motion.joint_rate_rad_s, sample.motion.joint_angle_rad);
        let measured = [sample.motion.omega0_z_rad_s, th1, th2, d1, d2];
        let ([rate_1, rate_2], [angle_1, angle_2]) =
            (self.settings.sigma.joint_rate_rad_s, self.settings.sigma.joint_angle_rad);
        let sigma = [self.settings.sigma.omega0_rad_s, angle_1, angle_2, rate_1, rate_2];
        let (model, wrench) = (self.model, SVector::from(sample.wrench));
        let is_feasible = |state: &State| model.is_feasible(state);
        let read = measured.iter().chain(&sample.acceleration_m_s2).chain(&sample.wrench);
        if !read.into_iter().all(|x| x.is_finite()) {
            return Err(UnscentedError::NotFinite);
        }
        let mut nis = 0.0;
        if self.samples == 0 {
            self.filter.begin_at(&measured, &sigma);
        } else {
            for i in 0..MOTION {
                let one = self.filter.update_component(i, measured[i], sigma[i], is_feasible)?.normalised();
                nis += one * one;
            }
        }
        let noise = SMatrix::<f64, 2, 2>::identity() * self.settings.acceleration_sigma_m_s2;
        nis += self.filter.update(&model, &wrench, &SVector::from(sample.acceleration_m_s2), &noise)?.nis;
        if self.samples >= SETTLED_SAMPLES {
            self.nis.push(nis, MOTION as u32 + 2);
        }
        let fresh = SMatrix::<f64, FILTER_STATES, WRENCH>::from_fn(|i, j| {
            if i == MOTION + j { self.settings.wrench_sigma[j] } else { 0.0 }
        });
        self.filter.predict(&model, &wrench, &fresh)?;
        self.samples += 1;
        Ok(())
    }

    /// Innovations squared over their covariance since they settled.
    pub fn nis(&self) -> &ChiSquareMean {
        &self.nis
    }

    /// The eight parameters with covariance after the last sample.
    pub fn estimate(&self) -> Estimate<8> {
        let (all, scale) = (self.filter.covariance(), &self.settings.scale);
        let at = |i: usize, j: usize| all[(FIRST_PARAMETER + i, FIRST_PARAMETER + j)] * scale[i] * scale[j];
        Estimate { alpha: self.model.pi(self.filter.mean()), covariance: SMatrix::from_fn(at) }
    }
}

/// Weak form of BP1B: the rows integrated by parts against `sin²(πt/L)` over windows that overlap
/// by half.
///
/// Rows are weighted with the variance of their own residuals (two passes); the covariance is
/// theirs and takes windows as independent, so it is some tens of per cent too small. Meant as a
/// start, and as the baseline. `None`: not excited.
pub fn weak_form(samples: &[FlyingSample], settings: &FlyingSettings, window_samples: usize) -> Option<Estimate<8>> {
    let mut weights = SVector::<f64, WRENCH>::repeat(1.0);
    let mut found = None;
    for _ in 0..2 {
        let (mut information, mut moment) = (SMatrix::<f64, 8, 8>::zeros(), Pi::zeros());
        let windows = || (0..(samples.len() + 1).saturating_sub(window_samples)).step_by(window_samples / 2);
        let window = |begin| weak_window(&samples[begin..begin + window_samples], settings);
        for (rows, observed) in windows().map(window) {
            information += rows.transpose() * SMatrix::from_diagonal(&weights) * rows;
            moment += rows.transpose() * weights.component_mul(&observed);
        }
        let scaling = SMatrix::<f64, 8, 8>::from_diagonal(&information.diagonal().map(|value| 1.0 / libm::sqrt(value)));
        let factor = (scaling * information * scaling).cholesky()?;
        let alpha: Pi = scaling * factor.solve(&(scaling * moment));
        found = Some(Estimate { alpha, covariance: scaling * factor.inverse() * scaling });
        let (mut squares, mut count) = (SVector::<f64, WRENCH>::zeros(), 0.0);
        for (rows, observed) in windows().map(window) {
            let residual = rows * alpha - observed;
            squares += residual.component_mul(&residual);
            count += 1.0;
        }
        weights = squares.map(|sum| count / sum);
    }
    found
}

fn weak_window(samples: &[FlyingSample], settings: &FlyingSettings) -> (SMatrix<f64, WRENCH, 8>, SVector<f64, WRENCH>) {
    use core::f64::consts::PI;
    let (n, dt) = (samples.len() as f64, settings.interval_s);
    let (mut rows, mut observed) = (SMatrix::zeros(), SVector::zeros());
    for (j, sample) in samples.iter().enumerate() {
        let (sine, cosine) = libm::sincos(2.0 * PI * j as f64 / n);
        let next = libm::sin(2.0 * PI * (j as f64 + 1.0) / n);
        let (value, slope) = (0.5 * (1.0 - cosine), PI / (n * dt) * sine);
        let period = 0.5 * dt - n * dt / (4.0 * PI) * (next - sine);
        let motion = &sample.motion;
        let form = |acceleration_m_s2, ahead_s: f64| {
            let [d1, d2] = motion.joint_rate_rad_s;
            let joint_angle_rad = [motion.joint_angle_rad[0] + ahead_s * d1, motion.joint_angle_rad[1] + ahead_s * d2];
            let rates_rad_s = [motion.omega0_z_rad_s, d1, d2];
            let now = FlyingMotion { acceleration_m_s2, joint_angle_rad, rates_rad_s, accelerations_rad_s2: [0.0; 3] };
            momentum_form(&settings.geometry, &now)
        };
        // The acceleration belongs to the wrench held through the period, hence to its middle; the
        // rates to its beginning.
        let moving = form([0.0; 2], 0.0);
        let held = form(sample.acceleration_m_s2, 0.5 * dt).remainder - form([0.0; 2], 0.5 * dt).remainder;
        rows += (moving.remainder * value - moving.momentum * slope) * dt + held * period;
        observed += SVector::from(sample.wrench) * period;
    }
    (rows, observed)
}
