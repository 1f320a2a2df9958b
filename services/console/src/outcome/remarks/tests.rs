use super::super::{FoundNumber, ParameterRow, parameter_json};
use super::*;
use physics::mated::OFF_AXIS_SIGMAS;
use telemetry::{Domain, Sample};

const H_NMS: f64 = 68.0;
/// Of noise alone.
const NOISE: f64 = 0.5;
/// Of an arm that holds 150 kg off the axis of link 2.
const ALPHA: [f64; 9] = [304.162, 529.887, 755.776, 246.645, 246.645, 288.091, 257.035, 570.753, -32.516];

fn known(h_cm_sigma_nms: f64, prior_relative_sd: Option<f64>) -> ArmKnown {
    ArmKnown {
        h_cm_nms: H_NMS,
        h_cm_sigma_nms,
        prior: ALPHA.to_vec(),
        gyro_arw_deg_sqrt_h: 0.09,
        joint_rate_sigma_rad_s: 1e-4,
        joint_angle_sigma_rad: 1.25e-5,
        joint_torque_sigma_nm: None,
        joint_torque_scale_sigma: 0.0,
        prior_relative_sd,
        sheet: SheetSigmas { gyro_scale: 3e-5, ..SheetSigmas::default() },
        chaser: None,
        target: None,
    }
}

/// With the covariance of noise and of the momentum's common scale, the sheet's part zero.
fn mated(known: &ArmKnown) -> InertialEstimate {
    let mut sample = InertialEstimate::zeroed_at(0);
    let estimate = &mut sample.estimate;
    (estimate.domain, estimate.phase, estimate.count) = (Domain::Inertial.code(), Phase::Mated.code(), 9);
    estimate.values[..9].copy_from_slice(&ALPHA);
    let scale = known.h_cm_sigma_nms / known.h_cm_nms;
    for (i, a) in ALPHA.iter().enumerate() {
        ALPHA.iter().enumerate().for_each(|(j, b)| estimate.covariance[i][j] = scale * scale * a * b);
        estimate.covariance[i][i] += NOISE * NOISE;
    }
    sample
}

fn shown(known: &ArmKnown, estimate: &InertialEstimate) -> Option<f64> {
    off_axis(known, estimate, OFF_AXIS_AT)
}

#[test]
fn a_large_sigma_of_the_momentum_does_not_hide_a_target_off_the_axis() {
    // by half of the momentum the number alone is two sigmas off
    for h_cm_sigma_nms in [0.0, 0.1 * H_NMS, 0.5 * H_NMS] {
        let known = known(h_cm_sigma_nms, None);
        let sigmas = shown(&known, &mated(&known)).expect("noise alone is left");
        // a part of 264 taken from 0.25 more: rounding
        assert!((sigmas - ALPHA[8] / NOISE).abs() < 1e-9, "{h_cm_sigma_nms}: {sigmas}");
        assert!(sigmas.abs() > OFF_AXIS_SIGMAS);
    }
}

#[test]
fn what_the_sheet_may_have_done_widens_the_sigma_that_a_target_is_shown_by() {
    let known = known(0.0, None);
    let mut estimate = mated(&known);
    estimate.consider_sigma_kg_m2[OFF_AXIS_AT] = 3.0 * NOISE;
    let expected = ALPHA[8] / (NOISE * 10.0_f64.sqrt());
    assert!((shown(&known, &estimate).expect("known") - expected).abs() < 1e-12 * expected.abs());
}

#[test]
fn a_prior_alone_or_a_sheet_whose_part_is_not_known_shows_no_target_and_hides_none() {
    let with_prior = known(0.0, Some(0.01));
    let mut estimate = mated(&with_prior);
    let cases = [
        (Identifiability::Identified, true),
        (Identifiability::PriorKept, false),
        (Identifiability::NotExcited, false),
    ];
    for (found, says) in cases {
        estimate.estimate.identifiability[OFF_AXIS_AT] = found.code();
        assert_eq!(shown(&with_prior, &estimate).is_some(), says, "{found}");
        // where no prior is stated it says nothing
        assert!(shown(&known(0.0, None), &estimate).is_some(), "{found}");
    }
    let without = known(0.0, None);
    let mut estimate = mated(&without);
    estimate.consider_sigma_kg_m2[OFF_AXIS_AT] = f64::NAN;
    assert_eq!(shown(&without, &estimate), None);
}

#[test]
fn only_the_ninth_number_of_the_mated_arm_shows_a_target() {
    let known = known(0.0, None);
    let estimate = mated(&known);
    assert!((0..9).all(|i| off_axis(&known, &estimate, i).is_some() == (i == OFF_AXIS_AT)));
    let mut before = estimate;
    before.estimate.phase = Phase::PreCapture.code();
    assert_eq!(shown(&known, &before), None);
}

#[test]
fn identifiabilities_are_those_of_each_number_and_none_without_a_prior() {
    let mut estimate = InertialEstimate::zeroed_at(0).estimate;
    assert_eq!(identifiability(&estimate, 0), None);
    let codes = [Identifiability::Identified, Identifiability::PriorKept, Identifiability::NotExcited];
    estimate.identifiability[..3].copy_from_slice(&codes.map(Identifiability::code));
    let all = ["identified", "prior kept", "not excited"];
    assert_eq!([0, 1, 2].map(|i| identifiability(&estimate, i).expect("a prior")), all);
    let assumed = known(0.0, Some(0.1));
    assert_eq!([0, 1, 2].map(|i| arm_identifiability(&assumed, &estimate, i).expect("a prior")), all);
    assert_eq!(arm_identifiability(&known(0.0, None), &estimate, 0), None);
}

#[test]
fn what_a_sheet_may_have_done_is_left_out_only_where_it_states_no_error() {
    let stated = known(0.0, None);
    let silent = ArmKnown { sheet: SheetSigmas::default(), ..stated.clone() };
    let mut estimate = mated(&stated);
    for sigma in [0.3, 0.0, f64::NAN] {
        estimate.consider_sigma_kg_m2[2] = sigma;
        let said = consider_sigma(&stated, &estimate, 2).expect("an error is stated");
        assert_eq!(said.to_bits(), sigma.to_bits());
        assert_eq!(consider_sigma(&silent, &estimate, 2), None);
    }
}

#[test]
fn in_json_what_is_not_said_has_no_key_and_what_is_not_known_is_null() {
    let number = FoundNumber {
        name: "a9",
        unit: "kg m^2",
        truth: None,
        value: Some(ALPHA[8]),
        sigma: Some(NOISE),
        paper_error_percent: None,
    };
    let mut row = ParameterRow {
        domain: Domain::Inertial,
        phase: Phase::Mated,
        number,
        complete: None,
        adequate: None,
        accepted: None,
        reason: String::new(),
        dominant_channel: None,
        identifiability: None,
        consider_sigma: None,
        off_axis_sigmas: None,
    };
    let object = parameter_json(&row);
    assert!(
        ["identifiability", "consider_sigma", "off_axis_sigmas"].iter().all(|key| object.get(key).is_none()),
        "{object}"
    );
    (row.identifiability, row.consider_sigma, row.off_axis_sigmas) = (Some("prior kept"), Some(f64::NAN), Some(-7.5));
    let object = parameter_json(&row);
    assert!(object.get("consider_sigma").is_some_and(serde_json::Value::is_null), "{object}");
    assert_eq!((&object["identifiability"], &object["off_axis_sigmas"]), (&"prior kept".into(), &(-7.5).into()));
}
