//! The target's mass, centre of mass and inertia from what was identified before and after capture.
//!
//! Unknowns: ten numbers of the chaser and four of the target. Data: `α` before capture, `α'`
//! after, BP1B's `π` where it was flown, and what is believed of the chaser beforehand. (α, α')
//! alone leave three directions without trace, one of which is the scale of the masses and touches
//! the target; the mass in π removes it, and the other two are internal to the chaser. Masses and
//! inertias are estimated as logarithms: no step can make a body impossible.
//!
//! A cooperative target's own data are one more prior: `target_statement`.

use crate::free_floating::{Alpha, PlanarArm};
use crate::free_flying::{Pi, parameters};
use crate::mated::{MatedAlpha, Target, mated_parameters};
use estimation::consistency::chi_square_quantile;
use estimation::weighted_least_squares::Estimate;
use nalgebra::{SMatrix, SVector, Vector4};

/// Chaser (m0, m1, m2, I0, I1, I2, r0x, r0y, l1, l2, r1) and target (m, x, y, I).
const UNKNOWNS: usize = 15;
const CHASER: usize = 11;
const STEPS_MAX: usize = 30;
/// A step this small against its sigma has settled.
const SETTLED: f64 = 1e-6;

type Unknowns = SVector<f64, UNKNOWNS>;

/// What is believed of the chaser: sigmas relative for masses and inertias, absolute for lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChaserPrior {
    pub arm: PlanarArm,
    pub mass_relative_sd: [f64; 3],
    pub inertia_relative_sd: [f64; 3],
    /// Shoulder in the base, first and second link's centre of mass.
    pub length_sd_m: f64,
    /// Length of link 1, known from its drawing.
    pub link_1_length_sd_m: f64,
    /// Joint 2 to the grasp point.
    pub grasp_m: f64,
    /// Its sigma: all of it goes into the target's centre of mass along the link, for the arm feels
    /// only their sum.
    pub grasp_sd_m: f64,
}

/// What was identified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identified {
    pub before: Estimate<8>,
    pub after: Estimate<9>,
    /// BP1B about the base's own centre of mass.
    pub flying: Option<Estimate<8>>,
}

/// Mass, centre of mass from the grasp point, inertia, with their covariance (kg, m, m, kg m²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetEstimate {
    pub target: Target,
    pub covariance: SMatrix<f64, 4, 4>,
    /// χ² of all data and priors at the solution.
    pub chi_square: f64,
    /// Its degrees of freedom: data and priors less unknowns; 0 where nothing was fitted.
    pub degrees: u32,
}

/// Why before and after capture give no target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TargetError {
    /// A covariance among the data is not positive definite.
    CovarianceNotPositive,
    /// The Gauss–Newton steps did not settle; `last_step_sigmas` is the largest in units of its
    /// sigma.
    NotConverged { last_step_sigmas: f64 },
}

impl TargetEstimate {
    /// Whether data and priors contradict each other at p < 0.001: one of the estimates, or the
    /// data sheet, is not of this arm.
    pub fn is_contradicted(&self) -> bool {
        let limit = |degrees: u32| chi_square_quantile(0.999, f64::from(degrees));
        self.degrees > 0 && self.chi_square > limit(self.degrees)
    }

    /// Mass \[kg\], centre of mass from the grasp point \[m\], inertia about it [kg m²].
    pub fn values(&self) -> Vector4<f64> {
        let [x, y] = self.target.grasp_to_com_m;
        Vector4::new(self.target.mass_kg, x, y, self.target.inertia_com_kg_m2)
    }
}

fn bodies(unknowns: &Unknowns) -> (PlanarArm, Target) {
    let exp = |i: usize| libm::exp(unknowns[i]);
    let arm = PlanarArm {
        mass_kg: [exp(0), exp(1), exp(2)],
        inertia_com_kg_m2: [exp(3), exp(4), exp(5)],
        base_to_joint_m: [unknowns[6], unknowns[7]],
        joint_to_com_m: [unknowns[8], unknowns[9]],
        com_to_next_m: unknowns[10],
    };
    let grasp_to_com_m = [unknowns[12], unknowns[13]];
    (arm, Target { mass_kg: exp(11), inertia_com_kg_m2: exp(14), grasp_to_com_m })
}

fn unknowns(arm: &PlanarArm, target: &Target) -> Unknowns {
    let ([m0, m1, m2], [i0, i1, i2]) = (arm.mass_kg.map(libm::log), arm.inertia_com_kg_m2.map(libm::log));
    let ([rx, ry], [l1, l2], [x, y]) = (arm.base_to_joint_m, arm.joint_to_com_m, target.grasp_to_com_m);
    let (mass, inertia) = (libm::log(target.mass_kg), libm::log(target.inertia_com_kg_m2));
    Unknowns::from([m0, m1, m2, i0, i1, i2, rx, ry, l1, l2, arm.com_to_next_m, mass, x, y, inertia])
}

/// One set of data: what it should be at the unknowns, its value, its whitening factor.
struct Normal {
    information: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    gradient: Unknowns,
    chi_square: f64,
}

impl Normal {
    fn add<const D: usize>(
        &mut self,
        at: &Unknowns,
        data: &Estimate<D>,
        predict: impl Fn(&Unknowns) -> SVector<f64, D>,
    ) -> Result<(), TargetError> {
        const PARAMETER_STEP: f64 = 1e-6; // rounding 1e-10 relative, truncation 1e-12
        let factor = data.covariance.cholesky().ok_or(TargetError::CovarianceNotPositive)?;
        let residual = data.alpha - predict(at);
        let mut jacobian = SMatrix::<f64, D, UNKNOWNS>::zeros();
        for i in 0..UNKNOWNS {
            let (mut plus, mut minus) = (*at, *at);
            plus[i] += PARAMETER_STEP;
            minus[i] -= PARAMETER_STEP;
            jacobian.set_column(i, &((predict(&plus) - predict(&minus)) / (2.0 * PARAMETER_STEP)));
        }
        let weighted = factor.solve(&jacobian);
        self.information += jacobian.transpose() * weighted;
        self.gradient += weighted.transpose() * residual;
        self.chi_square += residual.dot(&factor.solve(&residual));
        Ok(())
    }
}

/// Gauss–Newton over chaser and target together, started at `guess` (what is seen from outside; it
/// carries no weight).
///
/// # Errors
/// See [`TargetError`].
pub fn recover(prior: &ChaserPrior, identified: &Identified, guess: &Target) -> Result<TargetEstimate, TargetError> {
    let centre = unknowns(&prior.arm, guess);
    let mut at = centre;
    let mut last_step_sigmas = f64::INFINITY;
    for _ in 0..STEPS_MAX {
        let normal = assemble(prior, identified, &centre, &at)?;
        let factor = normal.information.cholesky().ok_or(TargetError::CovarianceNotPositive)?;
        let (step, covariance) = (factor.solve(&normal.gradient), factor.inverse());
        last_step_sigmas = (0..UNKNOWNS).map(|i| step[i].abs() / libm::sqrt(covariance[(i, i)])).fold(0.0, f64::max);
        at += step * (1.0 / (step.rows(CHASER, 4).amax() / 0.5).max(1.0)); // no logarithm moves by more than a half
        if last_step_sigmas < SETTLED {
            let (_, target) = bodies(&at);
            // d mass = mass d log mass
            let scale = Vector4::new(target.mass_kg, 1.0, 1.0, target.inertia_com_kg_m2);
            let block = covariance.fixed_view::<4, 4>(CHASER, CHASER);
            let mut covariance = SMatrix::<f64, 4, 4>::from_fn(|i, j| block[(i, j)] * scale[i] * scale[j]);
            covariance[(1, 1)] += prior.grasp_sd_m * prior.grasp_sd_m;
            let degrees = (CHASER + 8 + 9 + identified.flying.map_or(0, |_| 8) - UNKNOWNS) as u32;
            return Ok(TargetEstimate { target, covariance, chi_square: normal.chi_square, degrees });
        }
    }
    Err(TargetError::NotConverged { last_step_sigmas })
}

fn assemble(
    prior: &ChaserPrior,
    identified: &Identified,
    centre: &Unknowns,
    at: &Unknowns,
) -> Result<Normal, TargetError> {
    let mut normal = Normal { information: SMatrix::zeros(), gradient: Unknowns::zeros(), chi_square: 0.0 };
    for i in 0..CHASER {
        let sd = match i {
            0..3 => prior.mass_relative_sd[i],
            3..6 => prior.inertia_relative_sd[i - 3],
            6..10 => prior.length_sd_m,
            _ => prior.link_1_length_sd_m,
        };
        let weight = 1.0 / (sd * sd);
        // the last number is r1; known is the length l1 + r1
        let row = Unknowns::from_fn(|j, _| f64::from(u8::from(j == i || (i == 10 && j == 8))));
        let residual = row.dot(&(centre - at));
        normal.information += row * row.transpose() * weight;
        normal.gradient += row * (weight * residual);
        normal.chi_square += weight * residual * residual;
    }
    normal.add(at, &identified.before, |x| -> Alpha { bodies(x).0.minimal_parameters() })?;
    normal.add(at, &identified.after, |x| -> MatedAlpha {
        let (arm, target) = bodies(x);
        mated_parameters(&arm, prior.grasp_m, &target)
    })?;
    if let Some(flying) = &identified.flying {
        normal.add(at, flying, |x| -> Pi { parameters(&bodies(x).0, [0.0, 0.0]) })?;
    }
    Ok(normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded_noise::SeededNoise;

    const TARGET: Target = Target { mass_kg: 150.0, inertia_com_kg_m2: 40.0, grasp_to_com_m: [0.60, 0.15] };
    const GUESS: Target = Target { mass_kg: 100.0, inertia_com_kg_m2: 60.0, grasp_to_com_m: [0.5, 0.0] };

    fn prior() -> ChaserPrior {
        ChaserPrior {
            arm: PlanarArm::default(),
            mass_relative_sd: [0.02; 3],
            inertia_relative_sd: [0.3; 3],
            length_sd_m: 0.05,
            link_1_length_sd_m: 1e-4,
            grasp_m: 1.898,
            grasp_sd_m: 0.0,
        }
    }

    /// Independent sigmas of these relative sizes.
    fn exact<const D: usize>(alpha: SVector<f64, D>, relative: f64) -> Estimate<D> {
        let sigma = alpha.map(|value| value.abs().max(1.0) * relative);
        Estimate { alpha, covariance: SMatrix::from_diagonal(&sigma.component_mul(&sigma)) }
    }

    fn identified(arm: &PlanarArm, with_mass: bool) -> Identified {
        Identified {
            before: exact(arm.minimal_parameters(), 1e-4),
            after: exact(mated_parameters(arm, 1.898, &TARGET), 1e-3),
            flying: with_mass.then(|| exact(parameters(arm, [0.0, 0.0]), 3e-4)),
        }
    }

    /// A chaser that is not quite what its data sheet says.
    fn chaser() -> PlanarArm {
        PlanarArm { mass_kg: [404.0, 12.3, 11.6], inertia_com_kg_m2: [70.0, 16.5, 14.9], ..Default::default() }
    }

    #[test]
    fn the_target_is_found_although_the_data_sheet_of_the_chaser_is_wrong() {
        let found = recover(&prior(), &identified(&chaser(), true), &GUESS).expect("converges");
        let error = found.values() - Vector4::new(150.0, 0.60, 0.15, 40.0);
        // Noise-free data: what remains is the pull of the priors, a small part of a sigma.
        for i in 0..4 {
            assert!(error[i].abs() < 0.5 * libm::sqrt(found.covariance[(i, i)]), "{i}: {error}");
        }
    }

    #[test]
    fn data_drawn_from_their_sigmas_have_a_chi_square_of_their_degrees_and_an_estimate_of_another_arm_is_noticed() {
        let (mut noise, trials, mut sum, mut refused) = (SeededNoise::new(1), 400, 0.0, 0);
        let mut drawn = |wrong: f64| {
            // the data sheet is the truth of a chaser off by its sigmas
            let mut arm = PlanarArm::default();
            (0..3).for_each(|i| arm.mass_kg[i] *= libm::exp(0.02 * noise.normal()));
            (0..3).for_each(|i| arm.inertia_com_kg_m2[i] *= libm::exp(0.3 * noise.normal()));
            let mut moved = |length: &mut f64, sd: f64| *length += sd * noise.normal();
            arm.base_to_joint_m.iter_mut().chain(&mut arm.joint_to_com_m).for_each(|length| moved(length, 0.05));
            arm.com_to_next_m = 2.068 - arm.joint_to_com_m[0];
            moved(&mut arm.com_to_next_m, 1e-4);
            let mut data = identified(&arm, true);
            let mut spoil = |value: &mut f64, variance: f64| *value += libm::sqrt(variance) * noise.normal();
            (0..8).for_each(|i| spoil(&mut data.before.alpha[i], data.before.covariance[(i, i)]));
            (0..9).for_each(|i| spoil(&mut data.after.alpha[i], data.after.covariance[(i, i)]));
            let flying = data.flying.as_mut().expect("with mass");
            (0..8).for_each(|i| spoil(&mut flying.alpha[i], flying.covariance[(i, i)]));
            data.before.alpha[1] *= wrong;
            recover(&prior(), &data, &GUESS).expect("converges")
        };
        for _ in 0..trials {
            let found = drawn(1.0);
            sum += found.chi_square / f64::from(found.degrees);
            refused += u32::from(found.is_contradicted());
        }
        let (mean, degrees) = (sum / f64::from(trials), 21.0);
        assert!((mean - 1.0).abs() < 4.0 * libm::sqrt(2.0 / (degrees * f64::from(trials))), "{mean}");
        assert!(refused <= 4, "{refused}"); // 0.4 expected
        assert!(drawn(1.003).is_contradicted()); // thirty sigmas of a2
    }

    #[test]
    fn what_is_not_known_of_the_grasp_goes_into_the_centre_of_mass_along_the_link_and_nowhere_else() {
        let (arm, sd) = (PlanarArm::default(), 2e-3);
        let known = recover(&prior(), &identified(&arm, true), &GUESS).expect("converges");
        let uncertain = recover(&ChaserPrior { grasp_sd_m: sd, ..prior() }, &identified(&arm, true), &GUESS);
        let added = uncertain.expect("converges").covariance - known.covariance;
        // the arm at hand carries the target 2 mm further out than the data sheet says
        let off =
            Identified { after: exact(mated_parameters(&arm, 1.898 + sd, &TARGET), 1e-3), ..identified(&arm, true) };
        let off = recover(&prior(), &off, &GUESS).expect("converges");
        let moved = off.values() - known.values();
        assert!((moved[1] - sd).abs() < 1e-3 * sd, "{moved}"); // the sigmas of `after` are relative: their weights change by 1e-3
        assert!(moved[2].abs() < 1e-2 * sd);
        assert!((added[(1, 1)] - sd * sd).abs() < 1e-12 && added.abs().sum() < 1.001 * sd * sd);
    }

    #[test]
    fn without_an_absolute_mass_the_inertia_stays_and_the_mass_is_as_uncertain_as_the_data_sheet() {
        let with = recover(&prior(), &identified(&chaser(), true), &GUESS).expect("converges");
        let without = recover(&prior(), &identified(&chaser(), false), &GUESS).expect("converges");
        let sigma = |found: &TargetEstimate, i: usize| libm::sqrt(found.covariance[(i, i)]);
        assert!(sigma(&without, 0) > 5.0 * sigma(&with, 0), "{} {}", sigma(&without, 0), sigma(&with, 0));
        assert!(sigma(&without, 3) < 1.5 * sigma(&with, 3), "{} {}", sigma(&without, 3), sigma(&with, 3));
    }
}
