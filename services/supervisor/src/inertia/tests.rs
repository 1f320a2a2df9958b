//! Two statements side by side: when they agree, which is doubted, and when they are not compared.

use super::*;
use crate::specimen::closing;
use crate::validation::{Need, validate};
use telemetry::{Domain, Sample};

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

fn modal(inertia: f64, sigma: f64) -> ModalEstimate {
    ModalEstimate {
        estimate: Estimate { count: 4, ..closing(Domain::Modal) },
        hub_inertia_kg_m2: inertia,
        hub_inertia_sigma_kg_m2: sigma,
        ..ModalEstimate::zeroed_at(0)
    }
}

/// Parameters of equal relative error that weigh `inertia` in the posture, each with its part of
/// `sigma`.
fn inertial(inertia: f64, sigma: f64) -> InertialEstimate {
    let mut estimate = Estimate { count: 8, ..closing(Domain::Inertial) };
    let nominal = [110.7, 105.7, 48.2, 44.1, 44.1, 18.9, 18.9, 39.6];
    let unit = MomentumSample { omega0_z_rad_s: 1.0, joint_angle_rad: POSTURE, ..MomentumSample::default() };
    let y: SVector<f64, 8> = momentum_regressor(&unit);
    let whole: f64 = (0..8).map(|i| y[i] * nominal[i]).sum();
    for i in 0..8 {
        estimate.values[i] = nominal[i] * inertia / whole;
        let part = sigma / (8.0_f64.sqrt() * y[i].abs());
        estimate.covariance[i][i] = part * part;
    }
    InertialEstimate { estimate, ..InertialEstimate::zeroed_at(0) }
}

type Pair = (ModalEstimate, InertialEstimate);

fn said(known: Option<&AppendageKnown>, (modal, inertial): Pair) -> Option<InertiaComparison> {
    both(known, [AnyEstimate::Modal(&modal), AnyEstimate::Inertial(&inertial)])
}

fn both(known: Option<&AppendageKnown>, estimates: [AnyEstimate<'_>; 2]) -> Option<InertiaComparison> {
    let mut inertias = Inertias::default();
    let mut last = None;
    for (k, estimate) in estimates.into_iter().enumerate() {
        let judged = judged(estimate.common());
        let compared = inertias.take(estimate, &judged, known);
        assert!(k > 0 || compared.is_none(), "one estimate is not compared");
        last = compared;
    }
    last
}

fn judged(estimate: &Estimate) -> Verdict {
    validate(estimate, Err(Reason::NoHeldOutData), &Need::default(), 100, 1_000_000_000)
}

fn outcome(known: &AppendageKnown, pair: Pair) -> (InertiaAgreement, DoubtBasis) {
    let said = said(Some(known), pair).unwrap();
    (InertiaAgreement::from_code(said.agreement).unwrap(), DoubtBasis::from_code(said.doubt_basis).unwrap())
}

#[test]
fn estimates_within_three_joint_sigmas_agree_in_either_order_and_the_joint_z_is_said() {
    // Sigmas 0.3 and 0.4 join to 0.5.
    for swapped in [false, true] {
        let (a, b) = (modal(INERTIA + 1.4, 0.3), inertial(INERTIA, 0.4));
        let mut order = [AnyEstimate::Modal(&a), AnyEstimate::Inertial(&b)];
        if swapped {
            order.reverse();
        }
        let said = both(Some(&one_body(0.0)), order).unwrap();
        assert_eq!(said.agreement, InertiaAgreement::Agree.code());
        assert!((said.z - 2.8).abs() < 1e-9 && (said.difference_sigma_kg_m2 - 0.5).abs() < 1e-9, "{said:?}");
    }
    let beyond = outcome(&one_body(0.0), (modal(INERTIA + 1.6, 0.3), inertial(INERTIA, 0.4)));
    assert_ne!(beyond.0, InertiaAgreement::Agree);
}

#[test]
fn what_the_sensor_sheet_allows_counts_in_the_joint_sigma() {
    let mut believed = inertial(INERTIA, 0.4);
    believed.consider_sigma_kg_m2[0] = 1.0; // a1 stands alone in the inertia, with the weight one
    let said = said(Some(&one_body(0.0)), (modal(INERTIA + 1.6, 0.3), believed)).unwrap();
    assert!((said.difference_sigma_kg_m2 - 1.25_f64.sqrt()).abs() < 1e-9, "{said:?}");
    assert_eq!(said.agreement, InertiaAgreement::Agree.code());
}

#[test]
fn of_two_that_disagree_the_one_that_fails_its_own_tests_is_doubted_even_against_the_stated_inertia() {
    let coloured = |estimate: &mut Estimate| estimate.block_z[2] = 9.0;
    let (right, wrong) = (INERTIA, INERTIA * 1.05);
    let known = one_body(0.01);
    let mut pair = (modal(right, 0.1), inertial(wrong, 0.1));
    coloured(&mut pair.0.estimate);
    assert_eq!(outcome(&known, pair), (InertiaAgreement::ModalDoubted, DoubtBasis::OwnTests));
    let mut pair = (modal(wrong, 0.1), inertial(right, 0.1));
    coloured(&mut pair.1.estimate);
    assert_eq!(outcome(&known, pair), (InertiaAgreement::InertialDoubted, DoubtBasis::OwnTests));
}

#[test]
fn a_model_that_was_not_tested_is_not_blamed_for_failing_tests() {
    let mut pair = (modal(INERTIA, 0.1), inertial(INERTIA * 1.05, 0.1));
    (pair.0.estimate.nis_mean, pair.0.estimate.nis_count) = (0.0, 0.0);
    assert_eq!(outcome(&one_body(0.0), pair), (InertiaAgreement::Undecided, DoubtBasis::None));
    // What is stated decides as it does between two that passed.
    assert_eq!(outcome(&one_body(0.01), pair), (InertiaAgreement::InertialDoubted, DoubtBasis::StatedInertia));
    // Parameters that no body has are against it all the same.
    pair.0.estimate.consistent = 0;
    assert_eq!(outcome(&one_body(0.0), pair), (InertiaAgreement::ModalDoubted, DoubtBasis::OwnTests));
}

#[test]
fn a_systematic_sigma_that_is_not_known_is_not_taken_for_zero() {
    let mut unsettled = inertial(INERTIA, 0.4);
    unsettled.consider_sigma_kg_m2[..8].fill(f64::NAN);
    assert_eq!(outcome(&one_body(0.0), (modal(INERTIA, 0.3), unsettled)).0, InertiaAgreement::NotFound);
}

#[test]
fn of_two_that_pass_their_own_tests_the_one_that_the_stated_inertia_contradicts_is_doubted() {
    // A momentum mis-stated by 5 %, then a coupling wrong by 2.5 %; the sheet knows the inertia to
    // 1 %.
    let known = one_body(0.01);
    let (right, wrong) = (INERTIA, INERTIA * 1.05);
    let by_sheet = |agreement| (agreement, DoubtBasis::StatedInertia);
    let momentum_off = outcome(&known, (modal(right, 0.1), inertial(wrong, 0.1)));
    assert_eq!(momentum_off, by_sheet(InertiaAgreement::InertialDoubted));
    let coupling_off = outcome(&known, (modal(wrong, 0.1), inertial(right, 0.1)));
    assert_eq!(coupling_off, by_sheet(InertiaAgreement::ModalDoubted));
}

#[test]
fn without_a_third_statement_that_tells_them_apart_nothing_is_blamed() {
    let two = || (modal(INERTIA, 0.1), inertial(INERTIA * 1.05, 0.1));
    for (sheet, why) in [(0.0, "none is stated"), (0.05, "it bears both out")] {
        assert_eq!(outcome(&one_body(sheet), two()), (InertiaAgreement::Undecided, DoubtBasis::None), "{why}");
    }
    let both_off = (modal(INERTIA * 1.1, 0.1), inertial(INERTIA * 1.05, 0.1));
    assert_eq!(outcome(&one_body(0.001), both_off).0, InertiaAgreement::Undecided);
}

#[test]
fn separate_bodies_are_not_compared_and_that_is_said() {
    let two = || (modal(INERTIA, 0.1), inertial(1.5 * INERTIA, 0.1));
    let elsewhere = AppendageKnown { arm_angle_rad: None, ..one_body(0.0) };
    assert_eq!(outcome(&elsewhere, two()).0, InertiaAgreement::SeparateBodies);
    let said_of_two = said(Some(&elsewhere), two()).unwrap();
    assert!(said_of_two.z.is_nan() && said_of_two.difference_sigma_kg_m2.is_nan(), "{said_of_two:?}");
    // Nothing is known of an appendage: nothing is said, also not that the bodies are two.
    assert_eq!(said(None, two()), None);
}

#[test]
fn an_inertia_that_was_not_found_is_not_compared() {
    let known = one_body(0.01);
    let mut no_modes = (modal(INERTIA, 0.1), inertial(INERTIA, 0.1));
    no_modes.0.estimate.status = 3;
    let mut no_momentum = (modal(INERTIA, 0.1), inertial(INERTIA, 0.1));
    no_momentum.1.estimate.status = 3;
    for pair in [no_modes, no_momentum, (modal(0.0, 0.0), inertial(INERTIA, 0.1))] {
        assert_eq!(outcome(&known, pair).0, InertiaAgreement::NotFound);
    }
}

#[test]
fn a_mated_arm_is_another_body_and_does_not_take_the_place_of_the_free_one() {
    let mut mated = inertial(3.0 * INERTIA, 0.1);
    (mated.estimate.phase, mated.estimate.count) = (Phase::Mated.code(), 9);
    let mut inertias = Inertias::default();
    let said = inertias.take(AnyEstimate::Inertial(&mated), &judged(&mated.estimate), Some(&one_body(0.01)));
    assert_eq!(said, None);
    assert_eq!(inertias, Inertias::default());
}
