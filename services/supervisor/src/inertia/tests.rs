//! Two statements side by side: when they agree, which is doubted, and when they are not compared.

use super::*;
use crate::specimen::closing;
use crate::validation::{Need, validate};
use telemetry::PARAMETERS_MAX;

const POSTURE: [f64; 2] = [0.6, -1.1];
const INERTIA: f64 = 177.5;

/// One body; the sheet's inertia with a relative sigma of `sheet`.
fn one_body(sheet: f64) -> AppendageKnown {
    AppendageKnown {
        inertia_kg_m2: INERTIA,
        inertia_relative_sd: sheet,
        coupling_sqrt_kg_m: [10.2, 2.1],
        coupling_relative_sd: 0.0,
        locked: [[1.0, 0.005], [6.3, 0.008]],
        arm_angle_rad: Some(POSTURE),
    }
}

fn modal(inertia: f64, sigma: f64) -> Estimate {
    let mut estimate = closing(Domain::Modal);
    estimate.count = 4;
    (estimate.auxiliary[HUB_INERTIA_AT], estimate.auxiliary[HUB_INERTIA_SIGMA_AT]) = (inertia, sigma);
    estimate
}

/// Parameters of equal relative error that weigh `inertia` in the posture, each with its part of `sigma`.
fn inertial(inertia: f64, sigma: f64) -> Estimate {
    let mut estimate = closing(Domain::Inertial);
    estimate.count = 8;
    let nominal = [110.7, 105.7, 48.2, 44.1, 44.1, 18.9, 18.9, 39.6];
    let unit = MomentumSample { omega0_z_rad_s: 1.0, joint_angle_rad: POSTURE, ..MomentumSample::default() };
    let y: SVector<f64, 8> = momentum_regressor(&unit);
    let whole: f64 = (0..8).map(|i| y[i] * nominal[i]).sum();
    for i in 0..8 {
        estimate.values[i] = nominal[i] * inertia / whole;
        let part = sigma / (8.0_f64.sqrt() * y[i].abs());
        estimate.covariance[i][i] = part * part;
    }
    estimate
}

fn said(known: Option<&AppendageKnown>, estimates: [Estimate; 2]) -> Option<Verdict> {
    let mut inertias = Inertias::default();
    let mut last = None;
    for (k, estimate) in estimates.iter().enumerate() {
        let judged = validate(estimate, Err(Reason::NoHeldOutData), &Need::default(), 100, 1_000_000_000);
        let compared = inertias.take(estimate, &judged, known);
        assert!(k > 0 || compared.is_none(), "one estimate is not compared");
        last = compared;
    }
    last
}

fn outcome(known: &AppendageKnown, estimates: [Estimate; 2]) -> (Reason, u16) {
    let verdict = said(Some(known), estimates).unwrap();
    (Reason::from_code(verdict.reason).unwrap(), verdict.parameter)
}

#[test]
fn estimates_within_three_joint_sigmas_agree_in_either_order_and_the_joint_z_is_said() {
    // Sigmas 0.3 and 0.4 join to 0.5.
    for swapped in [false, true] {
        let (a, b) = (modal(INERTIA + 1.4, 0.3), inertial(INERTIA, 0.4));
        let verdict = said(Some(&one_body(0.0)), if swapped { [b, a] } else { [a, b] }).unwrap();
        assert_eq!(verdict.reason, Reason::InertiaAgrees.code());
        assert!((verdict.measured - 2.8).abs() < 1e-9 && (verdict.held_out_count - 0.5).abs() < 1e-9, "{verdict:?}");
    }
    assert_ne!(outcome(&one_body(0.0), [modal(INERTIA + 1.6, 0.3), inertial(INERTIA, 0.4)]).0, Reason::InertiaAgrees);
}

#[test]
fn what_the_sensor_sheet_allows_counts_in_the_joint_sigma() {
    let mut believed = inertial(INERTIA, 0.4);
    believed.auxiliary[0] = 1.0; // a1 stands alone in the inertia, with the weight one
    let verdict = said(Some(&one_body(0.0)), [modal(INERTIA + 1.6, 0.3), believed]).unwrap();
    assert!((verdict.held_out_count - 1.25_f64.sqrt()).abs() < 1e-9, "{verdict:?}");
    assert_eq!(verdict.reason, Reason::InertiaAgrees.code());
}

#[test]
fn of_two_that_disagree_the_one_that_fails_its_own_tests_is_doubted_even_against_the_stated_inertia() {
    let coloured = |mut estimate: Estimate| {
        estimate.block_z[2] = 9.0;
        estimate
    };
    let (right, wrong) = (INERTIA, INERTIA * 1.05);
    let known = one_body(0.01);
    assert_eq!(outcome(&known, [coloured(modal(right, 0.1)), inertial(wrong, 0.1)]), (Reason::InertiaModalDoubted, 0));
    assert_eq!(
        outcome(&known, [modal(wrong, 0.1), coloured(inertial(right, 0.1))]),
        (Reason::InertiaInertialDoubted, 0)
    );
}

#[test]
fn a_model_that_was_not_tested_is_not_blamed_for_failing_tests() {
    let untested = |mut estimate: Estimate| {
        (estimate.nis_mean, estimate.nis_count) = (0.0, 0.0);
        estimate
    };
    let pair = || [untested(modal(INERTIA, 0.1)), inertial(INERTIA * 1.05, 0.1)];
    assert_eq!(outcome(&one_body(0.0), pair()), (Reason::InertiaUndecided, u16::MAX));
    // What is stated decides as it does between two that passed.
    assert_eq!(outcome(&one_body(0.01), pair()), (Reason::InertiaInertialDoubted, 1));
    // Parameters that no body has are against it all the same.
    let [mut nobody, passed] = pair();
    nobody.consistent = 0;
    assert_eq!(outcome(&one_body(0.0), [nobody, passed]), (Reason::InertiaModalDoubted, 0));
}

#[test]
fn a_systematic_sigma_that_is_not_known_is_not_taken_for_zero() {
    let mut unsettled = inertial(INERTIA, 0.4);
    unsettled.auxiliary[..8].fill(f64::NAN);
    assert_eq!(outcome(&one_body(0.0), [modal(INERTIA, 0.3), unsettled]).0, Reason::InertiaNotFound);
}

#[test]
fn of_two_that_pass_their_own_tests_the_one_that_the_stated_inertia_contradicts_is_doubted() {
    // A momentum mis-stated by 5 %, then a coupling wrong by 2.5 %; the sheet knows the inertia to 1 %.
    let known = one_body(0.01);
    let (right, wrong) = (INERTIA, INERTIA * 1.05);
    assert_eq!(outcome(&known, [modal(right, 0.1), inertial(wrong, 0.1)]), (Reason::InertiaInertialDoubted, 1));
    assert_eq!(outcome(&known, [modal(wrong, 0.1), inertial(right, 0.1)]), (Reason::InertiaModalDoubted, 1));
}

#[test]
fn without_a_third_statement_that_tells_them_apart_nothing_is_blamed() {
    let two = || [modal(INERTIA, 0.1), inertial(INERTIA * 1.05, 0.1)];
    for (sheet, why) in [(0.0, "none is stated"), (0.05, "it bears both out")] {
        assert_eq!(outcome(&one_body(sheet), two()), (Reason::InertiaUndecided, u16::MAX), "{why}");
    }
    let both_off = [modal(INERTIA * 1.1, 0.1), inertial(INERTIA * 1.05, 0.1)];
    assert_eq!(outcome(&one_body(0.001), both_off).0, Reason::InertiaUndecided);
}

#[test]
fn separate_bodies_are_not_compared_and_that_is_said() {
    let two = || [modal(INERTIA, 0.1), inertial(1.5 * INERTIA, 0.1)];
    let elsewhere = AppendageKnown { arm_angle_rad: None, ..one_body(0.0) };
    assert_eq!(outcome(&elsewhere, two()).0, Reason::SeparateBodies);
    // Nothing is known of an appendage: nothing is said, also not that the bodies are two.
    assert_eq!(said(None, two()), None);
}

#[test]
fn an_inertia_that_was_not_found_is_not_compared() {
    let none = |mut estimate: Estimate| {
        estimate.status = 3;
        estimate
    };
    let known = one_body(0.01);
    for pair in [
        [none(modal(INERTIA, 0.1)), inertial(INERTIA, 0.1)],
        [modal(INERTIA, 0.1), none(inertial(INERTIA, 0.1))],
        [modal(0.0, 0.0), inertial(INERTIA, 0.1)],
    ] {
        assert_eq!(outcome(&known, pair).0, Reason::InertiaNotFound);
    }
    // Six modes: the places of the inertia are those of the sixth mode.
    let mut six = modal(INERTIA, 0.1);
    six.count = PARAMETERS_MAX as u16;
    assert_eq!(outcome(&known, [six, inertial(INERTIA, 0.1)]).0, Reason::InertiaNotFound);
}

#[test]
fn a_mated_arm_is_another_body_and_does_not_take_the_place_of_the_free_one() {
    let mut mated = inertial(3.0 * INERTIA, 0.1);
    (mated.phase, mated.count) = (Phase::Mated.code(), 9);
    let judged = validate(&mated, Err(Reason::NoHeldOutData), &Need::default(), 100, 0);
    let mut inertias = Inertias::default();
    assert_eq!(inertias.take(&mated, &judged, Some(&one_body(0.01))), None);
    assert_eq!(inertias, Inertias::default());
}
