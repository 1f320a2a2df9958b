//! One inertia, two estimates that know nothing of each other: the modes imply it by the appendage's geometry, the momentum by the
//! arm's motion. Where both speak of one body they must agree; where they do not, one is to be doubted.
//!
//! A momentum mis-stated by a per cent scales all of its parameters by as much and passes every test of its own: innovations, NIS,
//! held-out simulation. So does a coupling that is not that of the panel. Side by side they show.
//!
//! **Which to doubt**, in this order: the one that fails its own tests (innovations, NIS, held-out, physical consistency) while the other
//! passes; a model that was not tested does neither. Else the one that the stated inertia contradicts by three sigmas while it bears the other out; else nothing says.

use crate::validation::{NIS_FALSE_ALARM, empty_verdict};
use estimation::consistency::mean_square_band;
use nalgebra::SVector;
use physics::momentum::{MomentumSample, momentum_regressor};
use runtime::scenario::AppendageKnown;
use serde::{Deserialize, Serialize};
use telemetry::{Domain, Estimate, HUB_INERTIA_AT, HUB_INERTIA_SIGMA_AT, MODES_BESIDE_INERTIA, Phase, Reason, Verdict};

/// Joint standard deviations from which two statements disagree.
pub const DISAGREE_SIGMA: f64 = 3.0;
/// Parameters of the arm before capture.
const PARAMETERS: usize = 8;

/// One statement of the inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Stated {
    inertia_kg_m2: f64,
    sigma_kg_m2: f64,
    /// The model behind it passes its own tests; `None`: no innovation was tested, and nothing else is against it.
    sound: Option<bool>,
}

/// An experiment that has ended, with the inertia if it gave one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Ended {
    frame: u64,
    stated: Option<Stated>,
}

/// What decided which to doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Nothing,
    OwnTests,
    StatedInertia,
}

impl By {
    /// As `Verdict::parameter`.
    const fn code(self) -> u16 {
        match self {
            Self::OwnTests => 0,
            Self::StatedInertia => 1,
            Self::Nothing => u16::MAX,
        }
    }
}

/// The two statements of the phase being flown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inertias {
    modal: Option<Ended>,
    inertial: Option<Ended>,
}

impl Inertias {
    /// Takes the closing `estimate` of an experiment and the verdict on it; the comparison when it is the second of the two. Where no appendage
    /// is `known` the modes imply no inertia, and there is nothing to say.
    pub fn take(&mut self, estimate: &Estimate, judged: &Verdict, known: Option<&AppendageKnown>) -> Option<Verdict> {
        let known = known?;
        let phase = Phase::from_code(estimate.phase).filter(|phase| *phase != Phase::Mated)?;
        let sound = sound(estimate, judged);
        let stated = |(inertia_kg_m2, sigma_kg_m2)| Stated { inertia_kg_m2, sigma_kg_m2, sound };
        let posture = known.arm_angle_rad;
        match Domain::from_code(estimate.domain)? {
            Domain::Modal => {
                self.modal = Some(Ended { frame: estimate.frame, stated: of_modes(estimate).map(stated) });
            }
            Domain::Inertial => {
                let found = posture.and_then(|posture| of_momentum(estimate, posture));
                self.inertial = Some(Ended { frame: estimate.frame, stated: found.map(stated) });
            }
            Domain::Slosh => return None,
        }
        let (modal, inertial) = (self.modal?, self.inertial?);
        let mut verdict = empty(phase, judged);
        verdict.estimate_frame = modal.frame.max(inertial.frame);
        match (posture, modal.stated, inertial.stated) {
            (None, ..) => verdict.reason = Reason::SeparateBodies.code(),
            (_, Some(modal), Some(inertial)) => compare(&mut verdict, modal, inertial, sheet(known)),
            _ => verdict.reason = Reason::InertiaNotFound.code(),
        }
        Some(verdict)
    }
}

/// Whether the model passes its own tests; one whose innovations were too few to test has neither passed nor failed by them.
fn sound(estimate: &Estimate, judged: &Verdict) -> Option<bool> {
    let tested = mean_square_band(estimate.nis_count, NIS_FALSE_ALARM).is_some();
    let contradicted = [Reason::HeldOutTooLarge.code(), Reason::NotConsistent.code()].contains(&judged.reason);
    (tested || contradicted).then_some(judged.complete == 1 && !contradicted)
}

/// Inertia and sigma as the mass-property sheet states them.
fn sheet(known: &AppendageKnown) -> Option<(f64, f64)> {
    let sigma = known.inertia_relative_sd * known.inertia_kg_m2;
    (sigma > 0.0).then_some((known.inertia_kg_m2, sigma))
}

fn of_modes(estimate: &Estimate) -> Option<(f64, f64)> {
    let sigma = estimate.auxiliary[HUB_INERTIA_SIGMA_AT];
    let given = estimate.status == 0 && usize::from(estimate.count) <= 2 * MODES_BESIDE_INERTIA && sigma > 0.0;
    given.then_some((estimate.auxiliary[HUB_INERTIA_AT], sigma))
}

/// `J = yᵀ α` of the arm held at `posture`, `y = ∂Y_h/∂w0`. Its variance is `yᵀ P y` and, for what the sensor sheet's systematic errors may
/// do, `(Σ |y_i| s_i)²`: their correlations are not told, and as if all pulled one way is the most they can. `None` where that is not known.
fn of_momentum(estimate: &Estimate, posture: [f64; 2]) -> Option<(f64, f64)> {
    if estimate.status != 0 || usize::from(estimate.count) != PARAMETERS {
        return None;
    }
    let unit = MomentumSample { omega0_z_rad_s: 1.0, joint_angle_rad: posture, ..MomentumSample::default() };
    let y: SVector<f64, PARAMETERS> = momentum_regressor(&unit);
    let (mut inertia, mut variance, mut systematic) = (0.0, 0.0, 0.0);
    for i in 0..PARAMETERS {
        inertia += y[i] * estimate.values[i];
        systematic += y[i].abs() * estimate.auxiliary[i];
        variance += (0..PARAMETERS).map(|j| y[i] * estimate.covariance[i][j] * y[j]).sum::<f64>();
    }
    let sigma = (variance + systematic * systematic).sqrt();
    (inertia > 0.0 && sigma > 0.0 && sigma.is_finite()).then_some((inertia, sigma))
}

/// Nothing compared yet, of the experiment that `judged` speaks of.
fn empty(phase: Phase, judged: &Verdict) -> Verdict {
    let blank = empty_verdict(judged.domain, phase.code(), judged.frame, judged.header.t_meas_ns);
    Verdict { held_out_count: f64::NAN, ..blank }
}

fn compare(verdict: &mut Verdict, modal: Stated, inertial: Stated, sheet: Option<(f64, f64)>) {
    let sigma = modal.sigma_kg_m2.hypot(inertial.sigma_kg_m2);
    let z = (modal.inertia_kg_m2 - inertial.inertia_kg_m2) / sigma;
    (verdict.measured, verdict.limit) = (z, DISAGREE_SIGMA);
    verdict.held_out_rms = modal.inertia_kg_m2;
    verdict.held_out_noise = inertial.inertia_kg_m2;
    verdict.held_out_count = sigma;
    let (reason, by) =
        if z.abs() <= DISAGREE_SIGMA { (Reason::InertiaAgrees, By::Nothing) } else { doubt(modal, inertial, sheet) };
    (verdict.reason, verdict.parameter) = (reason.code(), by.code());
}

fn doubt(modal: Stated, inertial: Stated, sheet: Option<(f64, f64)>) -> (Reason, By) {
    let contradicted = |stated: Stated| {
        sheet.is_some_and(|(inertia, sigma)| {
            (stated.inertia_kg_m2 - inertia).abs() > DISAGREE_SIGMA * sigma.hypot(stated.sigma_kg_m2)
        })
    };
    let blamed = |modal: bool| if modal { Reason::InertiaModalDoubted } else { Reason::InertiaInertialDoubted };
    match ((modal.sound, inertial.sound), (contradicted(modal), contradicted(inertial))) {
        ((Some(false), Some(true)), _) => (blamed(true), By::OwnTests),
        ((Some(true), Some(false)), _) => (blamed(false), By::OwnTests),
        (_, (true, false)) => (blamed(true), By::StatedInertia),
        (_, (false, true)) => (blamed(false), By::StatedInertia),
        _ => (Reason::InertiaUndecided, By::Nothing),
    }
}

/// One sentence with numbers.
pub fn explain(verdict: &Verdict, reason: Reason) -> String {
    let why = match verdict.parameter {
        code if code == By::OwnTests.code() => ", which fails its own tests while the other passes",
        code if code == By::StatedInertia.code() => {
            ", which the stated inertia contradicts while it bears the other out"
        }
        _ => "",
    };
    let text = reason.text();
    if reason == Reason::SeparateBodies || reason == Reason::InertiaNotFound {
        return text.to_string();
    }
    let Verdict { measured, limit, held_out_rms, held_out_noise, held_out_count, .. } = verdict;
    format!(
        "{text}{why}: {held_out_rms:.4} (modes) against {held_out_noise:.4} kg m^2 (momentum), sigma of the difference \
         {held_out_count:.4}, z {measured:+.1} of {limit:.0}"
    )
}

#[cfg(test)]
mod tests;
