//! Cramér–Rao bound of the flying arm (BP1B): Kalman's covariance recursion along a noise-free
//! record, no sigma points, no states of noise.
//!
//! `x_{k+1} = f(x_k, u_k + n_k, π)`, `z_k = (x_k + v_k, a_B(x_k, u_k + n_k, π) + v'_k)`: the
//! accelerometer feels the wrench's error n that also moves the arm, so process and measurement
//! noise are correlated within a sample. With `F, G, H, D` the Jacobians by state (motion and
//! parameters) and by n: `S = H P H' + D Q D' + R`, `K = (F P H' + G Q D') S⁻¹`,
//! `P ← F P F' + G Q G' − K S K'` (Anderson & Moore 1979, section 5.5). At the truth along the true
//! motion this is the bound; the unscented filter has another structure (the wrench's error a
//! state, motion and accelerometer taken one after the other), so that an error in one of them
//! shows.

use crate::flying_filter::{FlyingSample, FlyingSettings};
use nalgebra::{SMatrix, SVector};
use physics::free_flying::{Five, Pi, accelerations};

const MOTION: usize = 5;
const WRENCH: usize = 5;
const BOUND_STATES: usize = MOTION + 8;
const MEASURED: usize = MOTION + 2;
/// The next state, then what is measured at this one.
const BOTH: usize = BOUND_STATES + MEASURED;

type State = SVector<f64, BOUND_STATES>;

/// Step and accelerometer at a state (π scaled) under a wrench.
fn next_and_seen(settings: &FlyingSettings, x: &State, wrench: &Five) -> Option<SVector<f64, BOTH>> {
    let pi = Pi::from_fn(|i, _| x[MOTION + i] * settings.scale[i]);
    let h = settings.interval_s;
    let rate = |m: &[f64; MOTION]| {
        let a = accelerations(&settings.geometry, &pi, [m[1], m[2]], [m[0], m[3], m[4]], wrench)?;
        Some(([a[2], m[3], m[4], a[3], a[4]], [a[0], a[1]]))
    };
    let begin: [f64; MOTION] = core::array::from_fn(|i| x[i]);
    let (first, seen) = rate(&begin)?;
    let (middle, _) = rate(&core::array::from_fn(|i| begin[i] + 0.5 * h * first[i]))?;
    Some(SVector::from_fn(|i, _| match i {
        0..MOTION => begin[i] + h * middle[i],
        MOTION..BOUND_STATES => x[i],
        _ if i < BOUND_STATES + MOTION => begin[i - BOUND_STATES],
        _ => seen[i - BOUND_STATES - MOTION],
    }))
}

/// Central differences by the state and by the wrench.
fn jacobians(
    settings: &FlyingSettings,
    x: &State,
    wrench: &Five,
) -> Option<(SMatrix<f64, BOTH, BOUND_STATES>, SMatrix<f64, BOTH, WRENCH>)> {
    const STEP: f64 = 1e-5; // of rad, rad/s and relative parameters
    const WRENCH_STEP: f64 = 1e-2; // linear in the wrench
    let mut by_state = SMatrix::<f64, BOTH, BOUND_STATES>::zeros();
    let mut by_wrench = SMatrix::<f64, BOTH, WRENCH>::zeros();
    for i in 0..BOUND_STATES {
        let (mut plus, mut minus) = (*x, *x);
        plus[i] += STEP;
        minus[i] -= STEP;
        let change = next_and_seen(settings, &plus, wrench)? - next_and_seen(settings, &minus, wrench)?;
        by_state.set_column(i, &(change / (2.0 * STEP)));
    }
    for i in 0..WRENCH {
        let (mut plus, mut minus) = (*wrench, *wrench);
        plus[i] += WRENCH_STEP;
        minus[i] -= WRENCH_STEP;
        let change = next_and_seen(settings, x, &plus)? - next_and_seen(settings, x, &minus)?;
        by_wrench.set_column(i, &(change / (2.0 * WRENCH_STEP)));
    }
    Some((by_state, by_wrench))
}

/// Bound of the eight parameters from a noise-free record at `settings.start` = truth;
/// `settings.start_sd` is a prior, to be made wide.
///
/// `None`: the parameters are not physical, or a covariance lost its positive definiteness to
/// rounding.
pub fn bound(noise_free: &[FlyingSample], settings: &FlyingSettings) -> Option<SMatrix<f64, 8, 8>> {
    let ([rate_1, rate_2], [angle_1, angle_2]) = (settings.sigma.joint_rate_rad_s, settings.sigma.joint_angle_rad);
    let read = settings.acceleration_sigma_m_s2;
    let sd = [settings.sigma.omega0_rad_s, angle_1, angle_2, rate_1, rate_2, read, read];
    let noise = SMatrix::<f64, MEASURED, MEASURED>::from_diagonal(&SVector::from(sd).map(|sd| sd * sd));
    let wrench_noise =
        SMatrix::<f64, WRENCH, WRENCH>::from_diagonal(&Five::from(settings.wrench_sigma).map(|sd| sd * sd));
    // Nothing is known of the motion before the first sample: a rad and a rad/s, ten thousand times
    // what one sample says.
    let mut covariance = SMatrix::<f64, BOUND_STATES, BOUND_STATES>::from_diagonal(&State::from_fn(|i, _| match i {
        0..MOTION => 1.0,
        _ => {
            let sd = settings.start_sd[i - MOTION] / settings.scale[i - MOTION];
            sd * sd
        }
    }));
    for sample in noise_free {
        let ([d1, d2], [th1, th2]) = (sample.motion.joint_rate_rad_s, sample.motion.joint_angle_rad);
        let motion = [sample.motion.omega0_z_rad_s, th1, th2, d1, d2];
        let x = State::from_fn(|i, _| {
            if i < MOTION { motion[i] } else { settings.start[i - MOTION] / settings.scale[i - MOTION] }
        });
        let (by_state, by_wrench) = jacobians(settings, &x, &Five::from(sample.wrench))?;
        let f = by_state.fixed_rows::<BOUND_STATES>(0);
        let h = by_state.fixed_rows::<MEASURED>(BOUND_STATES);
        let g = by_wrench.fixed_rows::<BOUND_STATES>(0);
        let d = by_wrench.fixed_rows::<MEASURED>(BOUND_STATES);
        let innovation = h * covariance * h.transpose() + d * wrench_noise * d.transpose() + noise;
        let cross = f * covariance * h.transpose() + g * wrench_noise * d.transpose();
        let gain = innovation.cholesky()?.solve(&cross.transpose()).transpose();
        let next = f * covariance * f.transpose() + g * wrench_noise * g.transpose() - gain * cross.transpose();
        covariance = (next + next.transpose()) * 0.5;
    }
    let block = covariance.fixed_view::<8, 8>(MOTION, MOTION);
    let positive = block.into_owned().cholesky().is_some();
    positive.then(|| SMatrix::from_fn(|i, j| block[(i, j)] * settings.scale[i] * settings.scale[j]))
}
