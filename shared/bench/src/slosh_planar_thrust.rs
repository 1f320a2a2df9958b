//! Slosh in the plane under thrusters that were calibrated, not known: their scales and delays are
//! estimated with the tank.
//!
//! A scale believed wrongly moves mass, stiffness and damping by twice as much. The estimate of a
//! burst (`slosh_calibration`), mean and covariance, is a prior beside the record, so that the
//! covariance of the seven numbers holds what is left of the calibration's error:
//!
//! ```text
//! χ²(θ, s, δ) = χ²_record(θ, s, δ) + [s − ŝ, δ − δ̂]' C⁻¹ [s − ŝ, δ − δ̂]     per thruster, along x and along y
//! ```

use nalgebra::{Matrix2, SVector, Vector2};

use crate::slosh_calibration::ThrustCalibration;
use crate::slosh_planar::PlanarHub;
use crate::slosh_planar_fit::{ITERATIONS_MAX, PlanarCraft, PlanarPrior, fit_with};
use crate::slosh_planar_id::{GATE_Z, PlanarAnswer, PlanarSearch, SPRINGS, identify_springs, springs};
use crate::slosh_planar_record::{PlanarError, PlanarRecord, PlanarThrust};

/// `[ms, kx, ky, cx, cy, bx, by]`, scale and delay of the thruster along x, and of that along y.
pub const SPRINGS_AND_THRUST: usize = SPRINGS + 4;
/// Steps of the sensitivities: of a scale, of a delay in seconds.
const THRUST_SCALES: [f64; 2] = [1.0, 0.1];
/// Least step of a place.
const PLACE_SCALE_M: f64 = 0.3;

/// A slosh mass on springs under thrusters with scale and delay.
pub fn springs_and_thrust(hub: PlanarHub, theta: &SVector<f64, SPRINGS_AND_THRUST>) -> Option<PlanarCraft<1>> {
    let craft = springs(hub, &theta.fixed_rows::<SPRINGS>(0).into_owned())?;
    let thrust = PlanarThrust {
        scale: Vector2::new(theta[SPRINGS], theta[SPRINGS + 2]),
        delay_s: Vector2::new(theta[SPRINGS + 1], theta[SPRINGS + 3]),
    };
    Some(PlanarCraft { thrust, ..craft })
}

/// What a calibration along x and one along y say before the record. `None` for one without
/// information.
pub fn calibrated(calibrations: &[ThrustCalibration; 2]) -> Option<PlanarPrior<SPRINGS_AND_THRUST>> {
    let mut prior = PlanarPrior::<SPRINGS_AND_THRUST>::none();
    for (axis, calibration) in calibrations.iter().enumerate() {
        let place = SPRINGS + 2 * axis;
        (prior.mean[place], prior.mean[place + 1]) = (1.0 + calibration.scale_error, calibration.delay_s);
        let covariance = Matrix2::new(
            calibration.scale_sigma * calibration.scale_sigma,
            calibration.scale_delay_covariance_s,
            calibration.scale_delay_covariance_s,
            calibration.delay_sigma_s * calibration.delay_sigma_s,
        );
        prior.information.fixed_view_mut::<2, 2>(place, place).copy_from(&covariance.try_inverse()?);
    }
    Some(prior)
}

/// Steps of the sensitivities about `theta`; a place may be zero.
pub fn scale_of(theta: &SVector<f64, SPRINGS_AND_THRUST>) -> SVector<f64, SPRINGS_AND_THRUST> {
    let mut scale = theta.abs();
    for place in [5, 6] {
        scale[place] = scale[place].max(PLACE_SCALE_M);
    }
    scale.fixed_rows_mut::<2>(SPRINGS).copy_from_slice(&THRUST_SCALES);
    scale.fixed_rows_mut::<2>(SPRINGS + 2).copy_from_slice(&THRUST_SCALES);
    scale
}

/// The seven numbers of a slosh mass on two springs and what its thrusters do, jointly, from the
/// record and a calibration of each thruster. Cost: that of [`identify_springs`] and a dozen walks
/// of the record per iteration.
///
/// # Errors
/// [`PlanarError::DelayedSums`] for sums of samples with edges of a command within: its delay is
/// estimated; [`PlanarError`] when no start could be followed.
pub fn identify_springs_and_thrust(
    record: &PlanarRecord<'_>,
    hub: PlanarHub,
    search: &PlanarSearch,
    calibrations: &[ThrustCalibration; 2],
) -> Result<PlanarAnswer<SPRINGS_AND_THRUST>, PlanarError> {
    let prior = calibrated(calibrations).ok_or(PlanarError::NotObserved)?;
    let thrust = PlanarThrust {
        scale: Vector2::from(calibrations.map(|one| 1.0 + one.scale_error)),
        delay_s: Vector2::from(calibrations.map(|one| one.delay_s)),
    };
    // Whatever the calibrations say, delays beside theirs are tried.
    PlanarThrust { delay_s: Vector2::repeat(record.interval_s), ..thrust }.check(record)?;
    let believed = identify_springs(record, hub, thrust, search)?;
    let mut start = prior.mean;
    start.fixed_rows_mut::<SPRINGS>(0).copy_from(&believed.estimate.theta);
    let craft = |theta: &SVector<f64, SPRINGS_AND_THRUST>| springs_and_thrust(hub, theta);
    let estimate = fit_with(record, &craft, (&start, &scale_of(&start)), &prior, ITERATIONS_MAX)?;
    let is_explained = estimate.is_converged && estimate.z_score().abs() < GATE_Z;
    Ok(PlanarAnswer { estimate, is_explained, starts: believed.starts })
}
