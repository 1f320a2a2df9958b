//! Columns of laws that hide a part, and of laws that are not in proportion to their size.

use super::*;
use crate::score::{Instants, Lines, candidates};
use crate::synthetic::{plant as deployed, problem, recording};

/// The points of `kinds` that do something, one after the other and each alone; and how many
/// there are.
fn points(name: &str, duration_s: f64, kinds: &[&str]) -> (Vec<String>, Vec<String>, usize) {
    let nominal = deployed(name);
    let problem = problem(&nominal, recording(&nominal, 3, duration_s));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let theta = session.prior();
    let linearised = LinearisedProblem::new(&session, &nominal, &theta, &session.noise).unwrap();
    let jumps = (&Lines::default(), &[][..], &Instants::default());
    let mut list = candidates(&problem, &nominal, (&linearised.linears, &session.timelines), jumps, &[]);
    // off the body's axes a mode answers rotation, too
    let is_on_axis =
        |candidate: &Candidate| candidate.inner.iter().all(|(name, value)| !name.starts_with("lever") || *value == 0.0);
    list.retain(|candidate| kinds.contains(&candidate.effect.kind) && is_on_axis(candidate));
    let of = |list: &[Candidate]| columns((&session, &linearised), &nominal, &theta, list);
    let reported = |c: Column| format!("{:?} {:?}", c.candidate, c.candidate.directions);
    let alone = list.iter().flat_map(|candidate| of(core::slice::from_ref(candidate)));
    (of(&list).into_iter().map(reported).collect(), alone.map(reported).collect(), list.len())
}

#[test]
fn a_direction_without_response_at_the_softest_point_has_none_at_any_frequency() {
    let appendages = ["appendage_left_out", "appendage_rotation_left_out"];
    // about a fixed axis through its centre of mass a disc excites rotations and no
    // translations
    let (together, alone, asked) = points("drive_rig", 1.0, &appendages);
    assert!(!alone.is_empty() && alone.len() < asked, "{} of {asked}", alone.len());
    assert_eq!(together, alone);
    for (name, duration_s) in [("hub_appendage", 4.0), ("tank_planar", 30.0)] {
        let kinds = [&appendages[..], &["mode_left_out", "slosh_second_mode"]].concat();
        let (together, alone, _) = points(name, duration_s, &kinds);
        assert!(!alone.is_empty());
        assert_eq!(together, alone, "{name}");
    }
}

/// The columns of one law, and the work for each of its points and directions.
struct Taken {
    columns: Vec<Column>,
    work_each: f64,
}

/// A law on a second of the drive.
fn of_the_drive(kind: &str) -> Taken {
    let nominal = deployed("drive_rig");
    let problem = problem(&nominal, recording(&nominal, 3, 1.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let theta = session.prior();
    let linearised = LinearisedProblem::new(&session, &nominal, &theta, &session.noise).unwrap();
    let jumps = (&Lines::default(), &[][..], &Instants::default());
    let list = candidates(&problem, &nominal, (&linearised.linears, &session.timelines), jumps, &[]);
    let own: Vec<Candidate> = list.into_iter().filter(|candidate| candidate.effect.kind == kind).collect();
    let before = session.work.spent();
    let columns = columns((&session, &linearised), &nominal, &theta, &own);
    let directions: usize = own.iter().map(|candidate| candidate.directions.len()).sum();
    Taken { columns, work_each: (session.work.spent() - before) / directions as f64 }
}

#[test]
fn a_gap_is_looked_at_at_several_sizes_and_a_gear_softly_besides_the_given_ones() {
    let of = |kind: &str| of_the_drive(kind).columns;
    let gaps: Vec<f64> = of("joint_backlash").iter().map(|column| column.step).collect();
    let is_scaled = |own: &[f64]| own.len() == 3 && own[1] == 4.0 * own[0] && own[2] == 16.0 * own[0];
    assert!(!gaps.is_empty() && gaps.chunks(3).all(is_scaled), "{gaps:?}");
    let gears = of("joint_flexibility");
    let soft = gears.iter().filter(|column| column.candidate.at.is_none()).count();
    assert!(soft > 0 && soft < gears.len(), "{soft} of {}", gears.len());
}

/// A force at the centre of mass of a disc whose axis is fixed: no amplitude of it moves anything.
#[test]
fn a_law_that_forces_nothing_takes_no_passes() {
    let [silent, felt] = ["force_pulse", "torque_pulse"].map(of_the_drive);
    assert!(silent.columns.is_empty() && !felt.columns.is_empty());
    let [for_nothing, for_something] = [silent.work_each, felt.work_each];
    assert!(for_nothing < 3.0 * for_something, "{for_nothing:e} {for_something:e}");
}
