//! Recordings of any length within the limit of the work.

use super::*;
use crate::evidence::diagnose;
use crate::synthetic::{off_priors, plant, problem, recording, with_effect};
use identification::work::Watch;

/// A diagnosis costs as much whatever the length of a recording beyond what the limit pays for; it
/// says that the rest was left out.
#[test]
fn a_recording_longer_than_the_limit_pays_for_is_diagnosed_by_its_beginning() {
    let nominal = plant("pendulum");
    let truth = with_effect(&nominal, "joint_coulomb", "joint:pivot", &[("force", 0.05)]);
    let of = |duration_s: f64| problem(&nominal, recording(&truth, 5, duration_s));
    let longs = [of(30.0), of(60.0)];
    // four seconds
    let work_max = 4.0 / 30.0 * DIAGNOSIS_ROUNDS * EstimationSession::new(&longs[0], 1).unwrap().round_work();
    let spent = longs.each_ref().map(|long| {
        let watch = Watch::default();
        let options = Options { work_max, fit_work_min: 0.0, watch: watch.clone(), ..Options::default() };
        let found = diagnose(long, &options, &mut |_, _| {});
        let is_said = |note: &String| note.starts_with(LIMIT_NOTE) && note.contains("all but the first");
        assert!(found.notes.iter().any(is_said), "{:?}", found.notes);
        watch.counted()
    });
    // what every diagnosis computes once (a screening, maps, limits) is beyond the limit here
    assert!(spent.iter().all(|spent| *spent < 5.0 * work_max), "{spent:?} of {work_max:e}");
    assert!((spent[1] / spent[0] - 1.0).abs() < 0.3, "{spent:?}");
}

/// The part that was examined is silent about friction that acts behind it.
#[test]
fn nothing_found_in_a_small_part_of_a_recording_is_no_answer_about_it() {
    let of = |verdict: Verdict| Diagnosis { verdict, ..Diagnosis::cannot_decide(String::new()) };
    let after = |verdict: Verdict, part_s: f64| nothing_in_a_part(of(verdict), part_s, 20.0);
    for verdict in [Verdict::None, Verdict::NoiseModel] {
        let found = after(verdict, 0.37);
        assert!(found.verdict == Verdict::CannotDecide && found.reason.contains("0.370 of 20.000 s"), "{found:?}");
        assert_eq!(after(verdict, 5.0).verdict, verdict);
    }
    assert_eq!(after(Verdict::Named, 0.37).verdict, Verdict::Named);
}

#[test]
fn a_recording_that_the_limit_pays_for_is_taken_whole() {
    let nominal = plant("pendulum");
    let short = problem(&nominal, recording(&nominal, 5, 2.0));
    assert!(paid_share(&short, Options::default().work_max) > 10.0);
    assert!(cut(&short, &Options::default(), &|_| 1.0).is_none());
}

/// A nominal fit without room to end is no start of a search.
#[test]
fn a_nominal_fit_that_the_work_cuts_decides_nothing_and_says_what_helps() {
    let nominal = plant("drive_rig");
    let short = problem(&nominal, recording(&off_priors(&nominal, 5), 5, 2.0));
    let session = EstimationSession::counted(&short, 1, Arc::new(Work::of(1.0))).unwrap();
    assert_eq!(super::nominal(&session, &Options::default()).err().as_deref(), Some(NOMINAL_UNFINISHED));
}

#[test]
fn where_a_refused_plant_has_ended_is_a_start_and_no_prior() {
    let plant = plant("pendulum");
    let short = problem(&plant, recording(&off_priors(&plant, 7), 7, 3.0));
    let session = EstimationSession::new(&short, 1).unwrap();
    let at = |k: f64| short.unknowns.iter().map(|own| (own.name.clone(), own.prior + k * own.sigma)).collect();
    let ended = |at| super::nominal(&session, &Options { refused_at: Some(at), ..Options::default() }).unwrap();
    let (near, far) = (ended(at(0.0)), ended(at(1.0)));
    for ((near, far), sigma) in near.theta.iter().zip(&far.theta).zip(&near.sigma) {
        assert!((near - far).abs() < 0.1 * sigma, "{near} {far} {sigma}");
    }
}
