//! The target's parameters at the end of the experiment after capture, and the target's statement
//! of them.

use estimation::weighted_least_squares::Estimate;
use nalgebra::{SMatrix, SVector, Vector4};
use physics::arm_live::LiveEstimators;
use physics::consider::SensorSheet;
use physics::free_floating::PlanarArm;
use physics::mated::Target;
use physics::target::{self, ChaserPrior, Identified, recover};
use physics::target_statement::{FusionError, Statement, fuse};
use plant_file::scenario::{ChaserSheet, TargetStatement};
use serde::{Deserialize, Serialize};
use telemetry::{Sample, TARGET_CONTRADICTED, TARGET_CRC_WRONG, TARGET_NOT_SOLVED, TARGET_REJECTED, TargetEstimate};

/// `TargetEstimate::origin`.
const STATED: u16 = 0;
const IDENTIFIED: u16 = 1;
const FUSED: u16 = 2;

/// A start without weight for the search: of the order of the arm's own links.
const GUESS: Target = Target { mass_kg: 100.0, inertia_com_kg_m2: 60.0, grasp_to_com_m: [0.5, 0.0] };

/// The free arm as it was identified.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Before {
    alpha: SVector<f64, 8>,
    covariance: SMatrix<f64, 8, 8>,
}

impl Before {
    /// `None`: nothing was identified.
    pub fn of(live: &LiveEstimators<8, 13>, sheet: &SensorSheet) -> Option<Self> {
        let Estimate { alpha, covariance } = live.best(sheet)?;
        Some(Self { alpha, covariance })
    }
}

/// The target's statement, if there is one, and the identified target, fused with the statement
/// where they agree.
pub fn samples(
    chaser: &ChaserSheet,
    statement: Option<&TargetStatement>,
    before: Option<&Before>,
    (after, sheet): (&LiveEstimators<9, 14>, &SensorSheet),
) -> impl Iterator<Item = TargetEstimate> {
    let stated = statement.map(stated);
    let identified = before.zip(after.best(sheet)).and_then(|(before, after)| {
        let before = Estimate { alpha: before.alpha, covariance: before.covariance };
        recover(&prior(chaser), &Identified { before, after, flying: None }, &GUESS).ok()
    });
    let result = match (&identified, &stated) {
        (None, _) => TargetEstimate { origin: IDENTIFIED, status: TARGET_NOT_SOLVED, ..TargetEstimate::zeroed_at(0) },
        // what contradicts itself is not weighed against another's word
        (Some(found), _) if found.is_contradicted() => {
            TargetEstimate { status: TARGET_CONTRADICTED, ..sample(IDENTIFIED, found) }
        }
        (Some(found), Some((statement, said))) if statement.status == 0 => match fuse(found, said) {
            Ok((both, chi_square)) => TargetEstimate { chi_square, ..sample(FUSED, &both) },
            Err(FusionError::Conflict { chi_square }) => {
                TargetEstimate { chi_square, status: TARGET_REJECTED, ..sample(IDENTIFIED, found) }
            }
            Err(FusionError::CovarianceNotPositive) => {
                TargetEstimate { status: TARGET_REJECTED, ..sample(IDENTIFIED, found) }
            }
        },
        (Some(found), _) => sample(IDENTIFIED, found),
    };
    stated.map(|(statement, _)| statement).into_iter().chain([result.sealed()])
}

fn sample(origin: u16, found: &target::TargetEstimate) -> TargetEstimate {
    let covariance = core::array::from_fn(|i| core::array::from_fn(|j| found.covariance[(i, j)]));
    TargetEstimate {
        origin,
        values: found.values().into(),
        covariance,
        fit_chi_square: found.chi_square,
        fit_degrees: found.degrees,
        ..TargetEstimate::zeroed_at(0)
    }
}

/// As received, and brought to the grasp point.
fn stated(said: &TargetStatement) -> (TargetEstimate, target::TargetEstimate) {
    let values = Vector4::new(said.mass_kg, said.com_m[0], said.com_m[1], said.inertia_kg_m2);
    let covariance = SMatrix::from_diagonal(&Vector4::from(said.sigma).map(|sd| sd * sd));
    let (grasp_position_m, grasp_angle_rad) = (said.grasp_position_m, said.grasp_angle_rad);
    let about_grasp = Statement { values, covariance, grasp_position_m, grasp_angle_rad }.about_grasp();
    let mut sample = TargetEstimate {
        origin: STATED,
        epoch_ns: (1e9 * said.epoch_s.max(0.0)).round() as u64,
        values: values.into(),
        covariance: core::array::from_fn(|i| core::array::from_fn(|j| covariance[(i, j)])),
        grasp_position_m,
        grasp_angle_rad,
        ..TargetEstimate::zeroed_at(0)
    }
    .sealed();
    if said.crc32.is_some_and(|crc32| crc32 != sample.crc32) {
        sample = TargetEstimate { status: TARGET_CRC_WRONG, ..sample }.sealed();
    }
    (sample, about_grasp)
}

fn prior(chaser: &ChaserSheet) -> ChaserPrior {
    ChaserPrior {
        arm: PlanarArm {
            mass_kg: chaser.mass_kg,
            inertia_com_kg_m2: chaser.inertia_kg_m2,
            base_to_joint_m: chaser.shoulder_m,
            joint_to_com_m: chaser.joint_to_com_m,
            com_to_next_m: chaser.link_1_length_m - chaser.joint_to_com_m[0],
        },
        mass_relative_sd: chaser.mass_relative_sd,
        inertia_relative_sd: chaser.inertia_relative_sd,
        length_sd_m: chaser.length_sd_m,
        link_1_length_sd_m: chaser.link_1_length_sd_m,
        grasp_m: chaser.grasp_m,
        grasp_sd_m: chaser.grasp_sd_m,
    }
}
