//! Comparison of two independent estimates of one inertia: the modes imply it by the appendage's
//! geometry, the momentum by the arm's motion. Estimates of one body must agree; where they do not,
//! one is to be doubted.
//!
//! A momentum mis-stated by a per cent scales all of its parameters by as much and passes every
//! test of its own: innovations, NIS, held-out simulation. So does a coupling that is not that of
//! the panel. The comparison detects both.
//!
//! **Which to doubt**, in this order: the one that fails its own tests (innovations, NIS, held-out,
//! physical consistency) while the other passes; a model that was not tested does neither. Else the
//! one that the stated inertia contradicts by three sigmas while it confirms the other; else it
//! stays undecided.

use crate::validation::NIS_FALSE_ALARM;
use estimation::consistency::mean_square_band;
use nalgebra::SVector;
use physics::momentum::{MomentumSample, momentum_regressor};
use plant_file::scenario::AppendageKnown;
use serde::{Deserialize, Serialize};
use telemetry::{
    AnyEstimate, DoubtBasis, Estimate, Header, InertiaAgreement, InertiaComparison, InertialEstimate, ModalEstimate,
    Phase, Reason, Verdict,
};

/// Joint standard deviations from which two statements disagree.
pub const DISAGREE_SIGMA: f64 = 3.0;
/// Parameters of the arm before capture.
const PARAMETERS: usize = 8;

/// One statement of the inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Stated {
    inertia_kg_m2: f64,
    sigma_kg_m2: f64,
    /// The model behind it passes its own tests; `None`: no innovation was tested, and no other
    /// test failed.
    sound: Option<bool>,
}

/// An experiment that has ended, with the inertia if it gave one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Ended {
    frame: u64,
    stated: Option<Stated>,
}

/// An inertia about the hub's axis with its standard deviation [kg m²].
type Inertia = (f64, f64);

/// The two statements of the phase being flown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inertias {
    modal: Option<Ended>,
    inertial: Option<Ended>,
}

impl Inertias {
    /// Takes the closing estimate of an experiment and the verdict on it; the comparison when it is
    /// the second of the two. `None` where no appendage is `known`.
    pub fn take(
        &mut self,
        sample: AnyEstimate<'_>,
        judged: &Verdict,
        known: Option<&AppendageKnown>,
    ) -> Option<InertiaComparison> {
        let (known, estimate) = (known?, sample.common());
        let phase = Phase::from_code(estimate.phase).filter(|phase| *phase != Phase::Mated)?;
        let sound = sound(estimate, judged);
        let ended = |found: Option<Inertia>| {
            let stated = found.map(|(inertia_kg_m2, sigma_kg_m2)| Stated { inertia_kg_m2, sigma_kg_m2, sound });
            Some(Ended { frame: estimate.frame, stated })
        };
        let posture = known.arm_angle_rad;
        match sample {
            AnyEstimate::Modal(sample) => self.modal = ended(of_modes(sample)),
            AnyEstimate::Inertial(sample) => {
                self.inertial = ended(posture.and_then(|posture| of_momentum(sample, posture)));
            }
            AnyEstimate::Slosh(_) => return None,
        }
        let (modal, inertial) = (self.modal?, self.inertial?);
        let mut comparison = empty(phase, judged, [modal.frame, inertial.frame]);
        match (posture, modal.stated, inertial.stated) {
            (None, ..) => comparison.agreement = InertiaAgreement::SeparateBodies.code(),
            (_, Some(modal), Some(inertial)) => compare(&mut comparison, modal, inertial, sheet(known)),
            _ => comparison.agreement = InertiaAgreement::NotFound.code(),
        }
        Some(comparison)
    }
}

/// Whether the model passes its own tests; one whose innovations were too few to test has neither
/// passed nor failed by them.
fn sound(estimate: &Estimate, judged: &Verdict) -> Option<bool> {
    let tested = mean_square_band(estimate.nis_count, NIS_FALSE_ALARM).is_some();
    let contradicted = [Reason::HeldOutTooLarge.code(), Reason::NotConsistent.code()].contains(&judged.reason);
    (tested || contradicted).then_some(judged.complete == 1 && !contradicted)
}

/// Inertia and sigma as the mass-property sheet states them.
fn sheet(known: &AppendageKnown) -> Option<Inertia> {
    let sigma = known.inertia_relative_sd * known.inertia_kg_m2;
    (sigma > 0.0).then_some((known.inertia_kg_m2, sigma))
}

fn of_modes(sample: &ModalEstimate) -> Option<Inertia> {
    let (inertia, sigma) = (sample.hub_inertia_kg_m2, sample.hub_inertia_sigma_kg_m2);
    (sample.estimate.status == 0 && sigma > 0.0).then_some((inertia, sigma))
}

/// `J = yᵀ α` of the arm held at `posture`, `y = ∂Y_h/∂w0`. Its variance is `yᵀ P y` and, for the
/// systematic errors that the sensors' data sheet allows, `(Σ |y_i| s_i)²`: their correlations are
/// unknown, and this is the bound for errors of one sign. `None` where they are unknown.
fn of_momentum(sample: &InertialEstimate, posture: [f64; 2]) -> Option<Inertia> {
    let estimate = &sample.estimate;
    if estimate.status != 0 || usize::from(estimate.count) != PARAMETERS {
        return None;
    }
    let unit = MomentumSample { omega0_z_rad_s: 1.0, joint_angle_rad: posture, ..MomentumSample::default() };
    let y: SVector<f64, PARAMETERS> = momentum_regressor(&unit);
    let (mut inertia, mut variance, mut systematic) = (0.0, 0.0, 0.0);
    for i in 0..PARAMETERS {
        inertia += y[i] * estimate.values[i];
        systematic += y[i].abs() * sample.consider_sigma_kg_m2[i];
        variance += (0..PARAMETERS).map(|j| y[i] * estimate.covariance[i][j] * y[j]).sum::<f64>();
    }
    let sigma = (variance + systematic * systematic).sqrt();
    (inertia > 0.0 && sigma > 0.0 && sigma.is_finite()).then_some((inertia, sigma))
}

/// Nothing compared yet, in the frame of the verdict `judged`.
fn empty(phase: Phase, judged: &Verdict, [modal_frame, inertial_frame]: [u64; 2]) -> InertiaComparison {
    InertiaComparison {
        header: Header::at(judged.header.t_meas_ns),
        frame: judged.frame,
        modal_frame,
        inertial_frame,
        phase: phase.code(),
        agreement: InertiaAgreement::NotFound.code(),
        doubt_basis: DoubtBasis::None.code(),
        reserved: 0,
        modal_inertia_kg_m2: f64::NAN,
        inertial_inertia_kg_m2: f64::NAN,
        difference_sigma_kg_m2: f64::NAN,
        z: f64::NAN,
        z_limit: DISAGREE_SIGMA,
    }
}

fn compare(comparison: &mut InertiaComparison, modal: Stated, inertial: Stated, sheet: Option<Inertia>) {
    let sigma = modal.sigma_kg_m2.hypot(inertial.sigma_kg_m2);
    let z = (modal.inertia_kg_m2 - inertial.inertia_kg_m2) / sigma;
    let (agreement, basis) = match z.abs() <= DISAGREE_SIGMA {
        true => (InertiaAgreement::Agree, DoubtBasis::None),
        false => doubt(modal, inertial, sheet),
    };
    (comparison.agreement, comparison.doubt_basis) = (agreement.code(), basis.code());
    comparison.modal_inertia_kg_m2 = modal.inertia_kg_m2;
    comparison.inertial_inertia_kg_m2 = inertial.inertia_kg_m2;
    (comparison.difference_sigma_kg_m2, comparison.z) = (sigma, z);
}

fn doubt(modal: Stated, inertial: Stated, sheet: Option<Inertia>) -> (InertiaAgreement, DoubtBasis) {
    let contradicted = |stated: Stated| {
        sheet.is_some_and(|(inertia, sigma)| {
            (stated.inertia_kg_m2 - inertia).abs() > DISAGREE_SIGMA * sigma.hypot(stated.sigma_kg_m2)
        })
    };
    let (modal_doubted, inertial_doubted) = (InertiaAgreement::ModalDoubted, InertiaAgreement::InertialDoubted);
    match ((modal.sound, inertial.sound), (contradicted(modal), contradicted(inertial))) {
        ((Some(false), Some(true)), _) => (modal_doubted, DoubtBasis::OwnTests),
        ((Some(true), Some(false)), _) => (inertial_doubted, DoubtBasis::OwnTests),
        (_, (true, false)) => (modal_doubted, DoubtBasis::StatedInertia),
        (_, (false, true)) => (inertial_doubted, DoubtBasis::StatedInertia),
        _ => (InertiaAgreement::Undecided, DoubtBasis::None),
    }
}

/// The comparison as one sentence, with both inertias [kg m²] and their difference in sigma, for
/// logs and reports.
pub fn explain(comparison: &InertiaComparison) -> String {
    let Some(agreement) = InertiaAgreement::from_code(comparison.agreement) else {
        return format!("unknown agreement {}", comparison.agreement);
    };
    let text = agreement.text();
    if !agreement.is_comparison() {
        return text.to_string();
    }
    let why = match DoubtBasis::from_code(comparison.doubt_basis) {
        Some(DoubtBasis::OwnTests) => ", which fails its own tests while the other passes",
        Some(DoubtBasis::StatedInertia) => ", which the stated inertia contradicts while it bears the other out",
        _ => "",
    };
    let InertiaComparison { modal_inertia_kg_m2: modal, inertial_inertia_kg_m2: momentum, z, z_limit, .. } = comparison;
    format!(
        "{text}{why}: {modal:.4} (modes) against {momentum:.4} kg m^2 (momentum), sigma of the difference {:.4}, \
         z {z:+.1} of {z_limit:.0}",
        comparison.difference_sigma_kg_m2
    )
}

#[cfg(test)]
mod tests;
