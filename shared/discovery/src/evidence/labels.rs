//! Channel labels in doubt: the recordings as labelled against the recordings with the labels
//! corrected, each diagnosed to its end, in the same nats.
//!
//! ```text
//! odds = p(D | corrected) |∂y'/∂y| / p(D | as labelled) · π^k        k mistakes, π of each
//! ```
//!
//! A reading that is divided by f has the density of its quotient over |f|: a factor that makes
//! everything small explains nothing. Noise that the plant states of a command is divided as the
//! command is. What the plant's parameters can take up, or physics that is missing explains, has
//! the same evidence on both sides, and the label keeps its prior: it is left as it is.

use super::decide::{LABEL_ODDS, LEVEL};
use super::diagnose;
use crate::diagnose::{Diagnosis, Options, Phase, Verdict};
use crate::mislabelled::{Mislabelled, Mistake};
use channels::Recording;
use dynamics::description::Plant;
use identification::problem::Problem;

/// `plant` with the noise of its commands as the corrected command has it.
#[must_use]
pub fn with_noise_of(plant: &Plant, labels: &[Mislabelled]) -> Plant {
    let mut plant = plant.clone();
    for label in labels {
        let Mistake::Factor(factor, _) = label.mistake else { continue };
        let own = plant.actuators.iter_mut().filter(|actuator| label.channels.contains(&actuator.name));
        own.for_each(|actuator| actuator.noise.value /= factor.abs());
    }
    plant
}

/// `ln |∂y'/∂y|` of all readings of `recording` that `label` corrects.
#[must_use]
pub fn log_jacobian(recording: &Recording, plant: &Plant, label: &Mislabelled) -> f64 {
    let Mistake::Factor(factor, _) = label.mistake else { return 0.0 };
    let is_read = |name: &str| plant.sensors.iter().any(|sensor| sensor.name == name);
    let own = recording.channels.iter().filter(|channel| label.channels.contains(&channel.name));
    let readings: usize = own.filter(|channel| is_read(&channel.name)).map(|channel| channel.value.len()).sum();
    -(readings as f64) * libm::log(factor.abs())
}

/// Labels that are wrong with this probability are corrected.
#[must_use]
pub fn is_wrong(probability: f64) -> bool {
    probability >= LEVEL
}

/// The diagnosis of recordings as labelled, or with `mistakes` of their labels corrected, whichever
/// has the evidence, and the probability that the labels are wrong; `log_jacobian` is that of all
/// readings. They are left where it stays below the level.
///
/// Cost: that of two diagnoses, each within half the work.
pub fn diagnose_beside_labels(
    (problem, options): (&Problem, &Options),
    (corrected, corrected_options): (&Problem, &Options),
    (mistakes, log_jacobian): (usize, f64),
    progress: &mut dyn FnMut(Phase, f64),
) -> (Diagnosis, f64) {
    let half = |options: &Options| Options { work_max: 0.5 * options.work_max, ..options.clone() };
    let own = diagnose(problem, &half(options), progress);
    let other = diagnose(corrected, &half(corrected_options), progress);
    let log_odds = match (own.total_evidence, other.total_evidence) {
        (Some((a, readings)), Some((b, same))) if readings == same => {
            b + log_jacobian - a + mistakes as f64 * libm::log(LABEL_ODDS)
        }
        (_, Some(_)) if own.verdict == Verdict::CannotDecide => f64::INFINITY,
        _ => f64::NEG_INFINITY,
    };
    let probability = 1.0 / (1.0 + libm::exp(-log_odds));
    if is_wrong(probability) { (other, probability) } else { (own, probability) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, recording};
    use identification::work::QUICK_WORK;

    fn compared(nominal: &Plant, read: &Recording, label: &Mislabelled) -> (Diagnosis, f64) {
        let corrected_plant = with_noise_of(nominal, core::slice::from_ref(label));
        let problem = |plant: &Plant, own: Recording| Problem::new(plant, &[own], &[]).unwrap();
        let (as_read, other) = (problem(nominal, read.clone()), problem(&corrected_plant, label.cured(read)));
        let options = Options { work_max: QUICK_WORK, ..Options::default() };
        let log_jacobian = log_jacobian(read, nominal, label);
        diagnose_beside_labels((&as_read, &options), (&other, &options), (1, log_jacobian), &mut |_, _| {})
    }

    fn factor(read: &Recording, channel: &str, factor: f64) -> Mislabelled {
        let mistake = Mistake::Factor(factor, "as the test has it");
        Mislabelled {
            recording: read.name.clone(),
            channels: vec![channel.to_owned()],
            mistake,
            instead: Vec::new(),
            before: f64::NAN,
            after: f64::NAN,
        }
    }

    #[test]
    fn a_turned_sign_is_found_and_a_right_channel_is_left_as_it_is() {
        let nominal = plant("oscillator");
        let right = recording(&nominal, 5, 3.0);
        let turned = |name: &str| {
            let mut turned = right.clone();
            let channel = turned.channels.iter_mut().find(|channel| channel.name == name).unwrap();
            channel.value.iter_mut().for_each(|value| *value = -*value);
            turned
        };
        let (found, wrong) = compared(&nominal, &turned("acceleration"), &factor(&right, "acceleration", -1.0));
        assert!(wrong > 0.99 && found.verdict == Verdict::None, "{wrong} {}", found.reason);
        let (_, wrong) = compared(&nominal, &right, &factor(&right, "acceleration", -1.0));
        assert!(wrong < 0.01, "{wrong}");
        // a command of a thousandth leaves everything to a disturbance
        let (_, wrong) = compared(&nominal, &right, &factor(&right, "shaker", 1e3));
        assert!(wrong < 0.01, "{wrong}");
    }
}
