use super::*;
use crate::diagnose::{Diagnosis, Verdict, diagnose};
use crate::synthetic::{plant, problem, recording, with_effect};
use channels::Recording;
use dynamics::description::Plant;

const STEP: [(&str, f64); 3] = [("step", 3e-3), ("begin", 0.437), ("duration", 0.171)];

/// Coulomb friction that one second of the drive shows to about four standard errors [N m].
const FAINT: f64 = 2.5e-3;

/// A drive with Coulomb friction that its plant file lacks.
fn rubbing(nominal: &Plant) -> Plant {
    with_effect(nominal, "joint_coulomb", "joint:drive", &[("force", 5e-3)])
}

fn asked(nominal: &Plant, fitted: &Plant, held_out: &Plant) -> Diagnosis {
    let other = problem(nominal, recording(held_out, 62, 1.0));
    let options = Options { threads: 2, held_out: Some(other), ..Options::default() };
    diagnose(&problem(nominal, recording(fitted, 61, 1.0)), &options, &mut |_, _| {})
}

fn standing(found: &Diagnosis, kind: &str) -> Option<Status> {
    found.effects.iter().find(|effect| effect.kind == kind).map(|effect| effect.status)
}

#[test]
fn an_effect_that_another_recording_rejects_is_removed_and_the_others_stay() {
    let nominal = plant("drive_rig");
    let physics = rubbing(&nominal);
    let once = with_effect(&physics, "sensor_step", "sensor:rate", &STEP);
    let found = asked(&nominal, &once, &physics);
    assert_eq!(standing(&found, "joint_coulomb"), Some(Status::Confirmed), "{}", found.reason);
    assert_eq!(standing(&found, "sensor_step"), Some(Status::Rejected), "{}", found.reason);
    assert!(matches!(found.verdict, Verdict::Named | Verdict::NotSeparable), "{}", found.reason);
    let written = found.augmented_plant.expect("something is confirmed");
    assert!(written.contains("joint_coulomb") && !written.contains("sensor_step"), "{written}");
}

#[test]
fn an_effect_that_another_recording_should_have_shown_and_does_not_is_rejected() {
    let nominal = plant("drive_rig");
    let sounds = |amplitude: f64| {
        with_effect(&nominal, "sensor_tone", "sensor:rate", &[("amplitude", amplitude), ("frequency", 29.0)])
    };
    let fitted = problem(&nominal, recording(&sounds(2e-3), 61, 1.0));
    let asked = |held_out: Recording| {
        let options = Options { threads: 2, held_out: Some(problem(&nominal, held_out)), ..Options::default() };
        diagnose(&fitted, &options, &mut |_, _| {})
    };
    // with half of it frozen parameters gain nothing and lose nothing
    let found = asked(recording(&sounds(1e-3), 62, 1.0));
    assert_eq!(standing(&found, "sensor_tone"), Some(Status::Rejected), "{}", found.reason);
    assert!(found.verdict == Verdict::CannotDecide && found.reason.contains("is predicted"), "{}", found.reason);
    assert!(found.augmented_plant.is_none());
    // what is too little to show it is no reason to reject
    let found = asked(recording(&sounds(2e-3), 62, 0.02));
    assert_eq!(standing(&found, "sensor_tone"), Some(Status::Unconfirmed), "{}", found.reason);
}

/// Alone the friction is below the level of one recording.
#[test]
fn a_weak_effect_is_reported_where_another_recording_confirms_it() {
    let nominal = plant("drive_rig");
    let rubs = |force: f64| with_effect(&nominal, "joint_coulomb", "joint:drive", &[("force", force)]);
    let fitted = problem(&nominal, recording(&rubs(FAINT), 61, 1.0));
    let within = |work_max: f64, held_out: Option<&Plant>| {
        let held_out = held_out.map(|plant| problem(&nominal, recording(plant, 62, 2.0)));
        diagnose(&fitted, &Options { threads: 2, held_out, work_max, ..Options::default() }, &mut |_, _| {})
    };
    let asked = |held_out: Option<&Plant>| within(identification::work::NORMAL_WORK, held_out);
    let found = asked(None);
    assert!(found.effects.is_empty(), "{}", found.reason);
    let found = asked(Some(&rubs(FAINT)));
    assert_eq!(standing(&found, "joint_coulomb"), Some(Status::Confirmed), "{:?} {}", found.verdict, found.reason);
    assert!(found.notes.iter().any(|note| note.starts_with("suspected")), "{:?}", found.notes);
    assert!(found.augmented_plant.is_some());
    // an effect that occurs once is rejected
    let found = asked(Some(&nominal));
    assert!(found.effects.is_empty() && found.notes.is_empty(), "{} {:?}", found.reason, found.notes);
    // where there is no room for another search there is none, and that is said
    let found = within(0.0, Some(&rubs(FAINT)));
    let is_said = found.notes.iter().any(|note| note.contains("effects of low significance"));
    assert!(found.effects.is_empty() && is_said, "{} {:?}", found.reason, found.notes);
}

#[test]
fn effects_that_are_in_both_recordings_are_confirmed_each_on_its_own() {
    let nominal = plant("drive_rig");
    let both = with_effect(&rubbing(&nominal), "sensor_step", "sensor:rate", &STEP);
    let found = asked(&nominal, &both, &both);
    for kind in ["joint_coulomb", "sensor_step"] {
        assert_eq!(standing(&found, kind), Some(Status::Confirmed), "{kind}: {}", found.reason);
    }
    let written = found.augmented_plant.expect("something is confirmed");
    assert!(written.contains("joint_coulomb") && written.contains("sensor_step"), "{written}");
}

#[test]
fn an_undecided_effect_is_reported_and_stays_out_of_the_model() {
    let nominal = plant("drive_rig");
    let physics = rubbing(&nominal);
    let late = [("step", 3e-3), ("begin", 0.8), ("duration", 0.171)];
    let both = with_effect(&physics, "sensor_step", "sensor:rate", &late);
    // the other recording ends before the step begins
    let other = problem(&nominal, recording(&both, 62, 0.78));
    let options = Options { threads: 2, held_out: Some(other), ..Options::default() };
    let found = diagnose(&problem(&nominal, recording(&both, 61, 1.0)), &options, &mut |_, _| {});
    assert_eq!(standing(&found, "joint_coulomb"), Some(Status::Confirmed), "{}", found.reason);
    assert_eq!(standing(&found, "sensor_step"), Some(Status::Unconfirmed), "{}", found.reason);
    let written = found.augmented_plant.expect("something is confirmed");
    assert!(written.contains("joint_coulomb") && !written.contains("sensor_step"), "{written}");
}

/// The fitted pendulum, its friction elsewhere and known to one sigma.
fn standing_at(friction: f64, sigma: f64) -> FittedModel {
    let nominal = plant("pendulum");
    let problem = problem(&nominal, recording(&nominal, 1, 0.5));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let mut fit = identification::fit::fit(&session, &nominal, &session.prior(), &session.noise, 1).unwrap();
    let at = problem.unknowns.iter().position(|unknown| unknown.name == "pivot.friction").unwrap();
    (fit.theta[at], fit.sigma[at]) = (friction, sigma);
    let noise = session.noise.clone();
    FittedModel::new(problem.clone(), fit, noise, 0.0)
}

fn friction_sigma(standing: &FittedModel) -> f64 {
    let at = standing.problem.unknowns.iter().position(|unknown| unknown.name == "pivot.friction").unwrap();
    standing.fit.sigma[at]
}

#[test]
fn parameter_uncertainties_include_all_effects_that_remain_possible() {
    let (mut own, rival) = (standing_at(1e-3, 1e-5), standing_at(2e-3, 2e-5));
    let both = [ParameterSet::of(&own, 0.0), ParameterSet::of(&rival, 0.0)];
    // even odds: half of (1e-5)^2 and half of (2e-5)^2 + (1e-3)^2
    widen(&mut own, &both, 0.0);
    let expected = (0.5f64 * (1e-10 + 4e-10 + 1e-6)).sqrt();
    assert!((friction_sigma(&own) - expected).abs() < 1e-12, "{}", friction_sigma(&own));
    // a rival that is excluded says nothing
    let mut own = standing_at(1e-3, 1e-5);
    let far = [ParameterSet::of(&own, 0.0), ParameterSet::of(&rival, RIVAL_SPAN + 1.0)];
    widen(&mut own, &far, 0.0);
    assert_eq!(friction_sigma(&own), 1e-5);
}
