use super::*;
use crate::diagnose::{Diagnosis, Verdict, diagnose};
use crate::synthetic::{plant, problem, recording, with_effect};
use plant::description::Plant;

const STEP: [(&str, f64); 3] = [("step", 3e-3), ("begin", 0.437), ("duration", 0.171)];

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
fn what_another_recording_refuses_beside_the_others_leaves_and_they_stay() {
    let nominal = plant("drive_rig");
    let physics = rubbing(&nominal);
    let once = with_effect(&physics, "sensor_step", "sensor:rate", &STEP);
    let found = asked(&nominal, &once, &physics);
    assert_eq!(standing(&found, "joint_coulomb"), Some(Status::Confirmed), "{}", found.reason);
    assert_eq!(standing(&found, "sensor_step"), Some(Status::Refused), "{}", found.reason);
    assert!(matches!(found.verdict, Verdict::Named | Verdict::NotSeparable), "{}", found.reason);
    let written = found.augmented_plant.expect("something is confirmed");
    assert!(written.contains("joint_coulomb") && !written.contains("sensor_step"), "{written}");
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
fn what_held_out_data_do_not_decide_keeps_its_name_and_stays_out_of_the_model() {
    let nominal = plant("drive_rig");
    let physics = rubbing(&nominal);
    let both = with_effect(&physics, "sensor_step", "sensor:rate", &STEP);
    // the other recording ends before the step begins
    let other = problem(&nominal, recording(&both, 62, 0.43));
    let options = Options { threads: 2, held_out: Some(other), ..Options::default() };
    let found = diagnose(&problem(&nominal, recording(&both, 61, 1.0)), &options, &mut |_, _| {});
    assert_eq!(standing(&found, "joint_coulomb"), Some(Status::Confirmed), "{}", found.reason);
    assert_eq!(standing(&found, "sensor_step"), Some(Status::Unconfirmed), "{}", found.reason);
    let written = found.augmented_plant.expect("something is confirmed");
    assert!(written.contains("joint_coulomb") && !written.contains("sensor_step"), "{written}");
}

fn heard(behind: f64, loglik: f64, friction: (f64, f64)) -> Heard {
    Heard { behind, loglik, numbers: vec![("pivot.friction".to_owned(), friction.0, friction.1)] }
}

#[test]
fn both_recordings_count_alike_in_what_is_behind() {
    let (own, rival) = (heard(0.0, 100.0, (1.0, 0.1)), heard(3.0, 102.5, (1.0, 0.1)));
    // 3 here, −2 · 2.5 there
    assert_eq!(rival.behind(&own), -2.0);
    assert_eq!(own.behind(&rival), 2.0);
}
