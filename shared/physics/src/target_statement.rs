//! What a cooperative target states of itself: brought to the grasp point, tested against what was
//! identified, and fused with it.
//!
//! The statement is a prior of four numbers with a covariance. It is taken only if it does not
//! contradict what was identified: the squared difference over the sum of both covariances is χ²
//! with four degrees of freedom; above [`CONFLICT_LIMIT`] one of the two is wrong, and an average
//! of right and wrong is wrong.

use crate::mated::Target;
use crate::target::TargetEstimate;
use nalgebra::{Matrix4, SMatrix, Vector4};

/// χ²(4), 99.9 %.
pub const CONFLICT_LIMIT: f64 = 18.467;

/// Mass, centre of mass and inertia about it in the target's own frame, and where the grasp point
/// lies in that frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statement {
    /// kg, m, m, kg m².
    pub values: Vector4<f64>,
    pub covariance: SMatrix<f64, 4, 4>,
    pub grasp_position_m: [f64; 2],
    /// Direction of the grasp frame's x axis in the target's frame.
    pub grasp_angle_rad: f64,
}

impl Statement {
    /// The same from the grasp point, in the grasp frame: `R(−φ) (c − g)`; mass and inertia about
    /// the centre of mass stay.
    pub fn about_grasp(&self) -> TargetEstimate {
        let (s, c) = libm::sincos(self.grasp_angle_rad);
        let [gx, gy] = self.grasp_position_m;
        #[rustfmt::skip]
        let turn = Matrix4::new(
            1.0, 0.0, 0.0, 0.0,
            0.0,   c,   s, 0.0,
            0.0,  -s,   c, 0.0,
            0.0, 0.0, 0.0, 1.0,
        );
        let v = turn * (self.values - Vector4::new(0.0, gx, gy, 0.0));
        TargetEstimate {
            target: Target { mass_kg: v[0], grasp_to_com_m: [v[1], v[2]], inertia_com_kg_m2: v[3] },
            covariance: turn * self.covariance * turn.transpose(),
            chi_square: 0.0,
            degrees: 0,
        }
    }
}

/// Why two estimates of one target are not fused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FusionError {
    /// They contradict each other at p < 0.001: check the grasp transform, the epoch, the target's
    /// identity.
    Conflict { chi_square: f64 },
    /// A covariance is not positive definite.
    CovarianceNotPositive,
}

/// Both together, with the χ² of their difference.
///
/// # Errors
/// See [`FusionError`].
pub fn fuse(identified: &TargetEstimate, stated: &TargetEstimate) -> Result<(TargetEstimate, f64), FusionError> {
    let difference = stated.values() - identified.values();
    let factor = (identified.covariance + stated.covariance).cholesky().ok_or(FusionError::CovarianceNotPositive)?;
    let chi_square = difference.dot(&factor.solve(&difference));
    let agrees = chi_square <= CONFLICT_LIMIT; // false for NaN
    if !agrees {
        return Err(FusionError::Conflict { chi_square });
    }
    let gain = identified.covariance * factor.inverse();
    let values = identified.values() + gain * difference;
    let target = Target { mass_kg: values[0], grasp_to_com_m: [values[1], values[2]], inertia_com_kg_m2: values[3] };
    let covariance = identified.covariance - gain * identified.covariance;
    let covariance = (covariance + covariance.transpose()) * 0.5;
    Ok((TargetEstimate { target, covariance, ..*identified }, chi_square))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;

    const TARGET: Target = Target { mass_kg: 150.0, inertia_com_kg_m2: 40.0, grasp_to_com_m: [0.60, 0.15] };

    fn estimate(values: Vector4<f64>, sigma: [f64; 4]) -> TargetEstimate {
        let target =
            Target { mass_kg: values[0], grasp_to_com_m: [values[1], values[2]], inertia_com_kg_m2: values[3] };
        let covariance = SMatrix::from_diagonal(&Vector4::from(sigma).map(|sd| sd * sd));
        TargetEstimate { target, covariance, chi_square: 0.0, degrees: 0 }
    }

    fn truth() -> Vector4<f64> {
        estimate(Vector4::zeros(), [1.0; 4]).values() + Vector4::new(150.0, 0.60, 0.15, 40.0)
    }

    const IDENTIFIED_SD: [f64; 4] = [0.4, 6e-4, 3e-4, 0.1];
    const STATED_SD: [f64; 4] = [0.5, 1e-3, 1e-3, 0.2];

    fn drawn(noise: &mut SeededNoise, sd: [f64; 4]) -> TargetEstimate {
        estimate(truth() + Vector4::from(sd).map(|sd| sd * noise.normal()), sd)
    }

    #[test]
    fn honest_statements_are_refused_one_time_in_a_thousand_and_what_is_fused_is_honest() {
        let (mut noise, trials) = (SeededNoise::new(1), 20_000);
        let (mut refused, mut nees) = (0, 0.0);
        for _ in 0..trials {
            match fuse(&drawn(&mut noise, IDENTIFIED_SD), &drawn(&mut noise, STATED_SD)) {
                Ok((fused, _)) => {
                    let error = fused.values() - truth();
                    nees += error.dot(&fused.covariance.cholesky().expect("positive").solve(&error));
                }
                Err(_) => refused += 1,
            }
        }
        assert!((refused - 20_i32).abs() < 18, "{refused}"); // √20 = 4.5, four of them
        assert!((nees / f64::from(trials - refused) - 4.0).abs() < 4.0 * libm::sqrt(8.0 / f64::from(trials)));
    }

    #[test]
    fn a_target_that_is_not_what_it_says_is_refused_with_the_statistic() {
        let identified = estimate(truth(), IDENTIFIED_SD);
        let stated = estimate(truth() + Vector4::new(5.0, 0.0, 0.0, 0.0), STATED_SD);
        let chi_square = 25.0 / (0.16 + 0.25);
        match fuse(&identified, &stated) {
            Err(FusionError::Conflict { chi_square: found }) => assert!((found / chi_square - 1.0).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
        let broken = estimate(Vector4::new(f64::NAN, 0.6, 0.15, 40.0), STATED_SD);
        assert!(fuse(&identified, &broken).is_err());
    }

    #[test]
    fn a_statement_in_the_targets_frame_says_the_same_from_the_grasp_point() {
        // The grasp frame turned by 90° at (2, 1): the centre of mass (1.85, 1.60) is 0.60 along
        // its x axis, 0.15 along its y axis.
        let statement = Statement {
            values: Vector4::new(150.0, 1.85, 1.60, 40.0),
            covariance: SMatrix::from_diagonal(&Vector4::new(0.25, 1e-6, 4e-6, 0.04)),
            grasp_position_m: [2.0, 1.0],
            grasp_angle_rad: core::f64::consts::FRAC_PI_2,
        };
        let found = statement.about_grasp();
        assert!((found.values() - truth()).amax() < 1e-12);
        assert!((found.covariance.diagonal() - Vector4::new(0.25, 4e-6, 1e-6, 0.04)).amax() < 1e-15);
        assert_eq!(found.target.mass_kg, TARGET.mass_kg);
    }
}
