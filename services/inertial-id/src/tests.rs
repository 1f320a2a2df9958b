//! Laws of the partition: what a row must say, and what it may leave out.

use super::*;
use estimation::identifiability::Identifiability as Rule;
use physics::free_floating::PlanarArm;
use physics::momentum::predict_base_rate;
use telemetry::Identifiability;

const INTERVAL_S: f64 = 0.01;
const H_NMS: f64 = 68.0;
const ARM: PlanarArm = PlanarArm {
    mass_kg: [400.0, 12.1, 11.7],
    inertia_com_kg_m2: [66.67, 17.27, 14.10],
    base_to_joint_m: [0.99, 0.99],
    joint_to_com_m: [1.9, 1.73],
    com_to_next_m: 0.168,
};

fn partition(h_cm_nms: f64) -> InertialId {
    let truth = ARM.minimal_parameters();
    let known = ArmKnown {
        h_cm_nms,
        h_cm_sigma_nms: 0.0,
        prior: truth.iter().map(|value| 0.55 * value).collect(),
        gyro_arw_deg_sqrt_h: 0.09,
        joint_rate_sigma_rad_s: 1e-4,
        joint_angle_sigma_rad: 1.25e-5,
        joint_torque_sigma_nm: Some(50.0),
        joint_torque_scale_sigma: 0.0,
        prior_relative_sd: None,
        sheet: Default::default(),
        chaser: None,
        target: None,
    };
    InertialId { state: State::default(), free_floating: Some(known), mated: None, replays: false }
}

/// Two joints that swing at six frequencies, the base as momentum demands.
fn rows(seconds: f64) -> Vec<(Imu, Joints)> {
    let truth = ARM.minimal_parameters();
    let row = |k: usize| {
        let t_s = k as f64 * INTERVAL_S;
        let swing = |w: [f64; 3]| {
            let angle: f64 = w.iter().map(|w| 0.5 * (w * t_s).sin()).sum();
            let rate: f64 = w.iter().map(|w| 0.5 * w * (w * t_s).cos()).sum();
            (angle, rate)
        };
        let ((a1, d1), (a2, d2)) = (swing([0.21, 0.43, 0.71]), swing([0.31, 0.57, 0.89]));
        let w0 = predict_base_rate(&truth, H_NMS, [a1, a2], [d1, d2]).expect("true parameters");
        let t_ns = (t_s * 1e9).round() as u64;
        let (mut imu, mut joints) = (Imu::zeroed_at(t_ns), Joints::zeroed_at(t_ns));
        (imu.interval_s, imu.valid, imu.omega_bi_b_rad_s[2]) = (INTERVAL_S, 0b100, w0);
        (joints.count, joints.torque_valid) = (2, 0b11);
        (joints.angle_rad, joints.rate_rad_s) = ([a1, a2, 0.0, 0.0], [d1, d2, 0.0, 0.0]);
        (imu, joints)
    };
    (0..(seconds / INTERVAL_S) as usize).map(row).collect()
}

fn fed(rows: &[(Imu, Joints)]) -> LiveEstimators<8, 13> {
    fed_to(partition(H_NMS), rows)
}

fn fed_to(mut partition: InertialId, rows: &[(Imu, Joints)]) -> LiveEstimators<8, 13> {
    rows.iter().for_each(|(imu, joints)| partition.take_row(imu, joints));
    partition.take_first();
    match partition.state.estimators {
        Some(Estimators::FreeFloating(live)) => live,
        _ => panic!("momentum and prior are stated"),
    }
}

#[test]
fn the_interval_is_that_of_most_rows_and_not_of_the_first() {
    let mut rows = rows(5.0);
    let even = fed(&rows);
    for odd in [0.0, 0.5, f64::NAN] {
        rows[0].0.interval_s = odd;
        assert!(fed(&rows) == even, "{odd}");
    }
    // Of rows without an interval however many: those that have one say it.
    for none in [0.0, f64::NAN, f64::INFINITY] {
        rows[..8].iter_mut().for_each(|(imu, _)| imu.interval_s = none);
        assert!(fed(&rows) == even, "{none}");
    }
    assert_eq!(median([f64::NAN, 0.0, INTERVAL_S].into_iter()), INTERVAL_S);
    assert_eq!(median([f64::NAN].into_iter()), 0.0);
}

#[test]
fn what_the_sheet_may_have_done_is_no_number_until_it_is_known() {
    let no_errors = partition(H_NMS).free_floating.expect("stated");
    let mut partition = partition(H_NMS);
    let mut known = no_errors.clone();
    known.sheet.gyro_bias_rad_s = 5e-5;
    let (mut unknown, mut last) = (0, f64::NAN);
    for (k, (imu, joints)) in rows(60.0).iter().enumerate() {
        partition.take_row(imu, joints);
        let Some(Estimators::FreeFloating(live)) = &partition.state.estimators else { continue };
        if k % 10 != 0 || live.estimate().is_err() {
            continue;
        }
        let (mut with, mut without) = (InertialEstimate::zeroed_at(0), InertialEstimate::zeroed_at(0));
        fill(&mut with, live, &known);
        fill(&mut without, live, &no_errors);
        assert!(without.consider_sigma_kg_m2[..8].iter().all(|sigma| *sigma == 0.0), "a sheet of no errors, row {k}");
        let is_known = live.consider(&sheet(&known)).is_some();
        assert!(
            with.consider_sigma_kg_m2[..8].iter().all(|sigma| if is_known { *sigma > 0.0 } else { sigma.is_nan() }),
            "row {k}"
        );
        unknown += usize::from(!is_known);
        last = with.consider_sigma_kg_m2[0];
    }
    assert!(unknown > 0 && last > 0.0, "{unknown} {last}");
}

#[test]
fn a_record_shorter_than_the_rows_that_wait_is_taken_at_its_end() {
    let mut partition = partition(H_NMS);
    rows(0.05).iter().for_each(|(imu, joints)| partition.take_row(imu, joints));
    assert_eq!(partition.state.rows, 0);
    partition.take_first();
    assert_eq!(partition.state.rows, 5);
}

#[test]
fn torques_that_are_not_measured_are_not_taken_for_zero() {
    let mut rows = rows(40.0);
    assert!(fed(&rows).torque().is_some());
    for valid in [0b00, 0b01, 0b10] {
        rows.iter_mut().for_each(|(_, joints)| joints.torque_valid = valid);
        let live = fed(&rows);
        assert!(live.torque().is_none(), "{valid:b}");
        assert!(live.estimate().is_ok());
    }
}

#[test]
fn what_the_sheet_does_to_the_torques_estimate_is_not_called_zero_unless_the_sheet_states_no_error() {
    let live = fed(&rows(80.0));
    let mut known = partition(H_NMS).free_floating.expect("told");
    let mut sample = InertialEstimate::zeroed_at(0);
    fill_torque(&mut sample, &live, &known);
    assert_eq!(sample.consider_sigma_kg_m2[..8], [0.0; 8]);
    known.sheet.gyro_bias_rad_s = 1e-6;
    fill_torque(&mut sample, &live, &known);
    assert!(sample.consider_sigma_kg_m2[..8].iter().all(|sigma| sigma.is_nan()));
    // eighty seconds of torques find their common scale
    assert_eq!(sample.estimate.identifiability[..8], [Identifiability::Identified.code(); 8]);
}

#[test]
fn a_torques_estimate_is_excited_where_torques_found_the_common_scale_whatever_the_momentum_s_prior() {
    let mut partition = partition(H_NMS);
    let known = partition.free_floating.as_mut().expect("told");
    // a prior that the momentum can hardly better, and torques whose own scale is known to twice
    // that
    known.prior = ARM.minimal_parameters().iter().copied().collect();
    (known.prior_relative_sd, known.joint_torque_scale_sigma) = (Some(0.005), 0.01);
    let known = known.clone();
    let live = fed_to(partition, &rows(40.0));
    let mut sample = InertialEstimate::zeroed_at(0);
    fill_torque(&mut sample, &live, &known);
    assert!(live.torque().is_some());
    assert_eq!(sample.estimate.identifiability[..8], [Identifiability::Identified.code(); 8]);
}

#[test]
fn without_a_momentum_nothing_is_estimated() {
    let mut partition = partition(0.0);
    rows(1.0).iter().for_each(|(imu, joints)| partition.take_row(imu, joints));
    assert!(partition.state.estimators.is_none());
}

#[test]
fn what_the_data_did_to_a_prior_travels_as_the_code_of_its_name() {
    let pairs = [
        (Rule::Identified, Identifiability::Identified),
        (Rule::PriorKept, Identifiability::PriorKept),
        (Rule::NotExcited, Identifiability::NotExcited),
    ];
    pairs.iter().for_each(|(found, name)| assert_eq!(found.code(), name.code(), "{name}"));
}
