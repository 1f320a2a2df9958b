use super::*;
use crate::synthetic::{plant, problem, recording};
use nalgebra::DMatrix;

/// `N = Σ h h'` of whitened sensitivities (n × n), per prior standard deviations.
fn information(session: &EstimationSession<'_>, linearised: &LinearisedProblem) -> DMatrix<f64> {
    let theta = session.prior();
    let normal = linearised.normal(session, &theta, &session.noise, &[]).unwrap();
    let n = theta.len();
    normal.matrix.view((0, 0), (n, n)) - DMatrix::identity(n, n)
}

/// Central differences of the innovations of passes with frozen gains.
fn by_differences(session: &EstimationSession<'_>, linearised: &LinearisedProblem, step: f64) -> Vec<Vec<f64>> {
    let (plant, theta) = (&session.problem.plant, session.prior());
    let column = |i: usize| {
        let at = |by: f64| {
            let mut moved = theta.clone();
            moved[i] += by * session.problem.unknowns[i].sigma;
            session.innovations(plant, &moved, &linearised.linears, &|_| true).unwrap()
        };
        at(-step).iter().zip(at(step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
    };
    (0..theta.len()).map(column).collect()
}

/// Largest distance of entries of the unknowns `of`, relative to what they and the priors know.
fn apart(a: &DMatrix<f64>, b: &DMatrix<f64>, of: &[usize]) -> f64 {
    let scale = |i: usize, j: usize| ((1.0 + b[(i, i)]) * (1.0 + b[(j, j)])).sqrt();
    let pairs = of.iter().flat_map(|i| of.iter().map(|j| (*i, *j)));
    pairs.map(|(i, j)| (a[(i, j)] - b[(i, j)]).abs() / scale(i, j)).fold(0.0, f64::max)
}

/// Largest distance of the information along the trajectory from that of differences of passes.
fn off(nominal: &Plant, duration_s: f64) -> f64 {
    let problem = problem(nominal, recording(nominal, 7, duration_s));
    let session = EstimationSession { along: true, ..EstimationSession::new(&problem, 1).unwrap() };
    let mut linearised = LinearisedProblem::new(&session, nominal, &session.prior(), &session.noise).unwrap();
    let covered = linearised.run_along(&session, nominal, &session.prior(), 0);
    assert!(covered.iter().all(Option::is_some));
    linearised.take_jacobian(&session, nominal, &session.prior());
    let along = information(&session, &linearised);
    linearised.jacobian = by_differences(&session, &linearised, 1e-3);
    // where a command switches at the instant of a reading, nothing is smooth about a clock
    let smooth = |i: &usize| !problem.unknowns[*i].name.contains("clock");
    let of: Vec<usize> = (0..problem.unknowns.len()).filter(smooth).collect();
    apart(&along, &information(&session, &linearised), &of)
}

#[test]
fn information_along_the_trajectory_is_that_of_differences_of_passes() {
    // what a step of integration leaves of the slope of a frequency, 5 (ω h)⁴/120: 7e-5 at the second
    // mode of the panel; where arms swing, slopes change within an interval, too
    for (name, duration_s, tolerance) in [("study_case", 2.3, 1.4e-4), ("double_pendulum", 2.0, 1e-3)] {
        let found = off(&plant(name), duration_s);
        assert!(found < tolerance, "{name}: {found:e}");
    }
}

#[test]
fn readings_of_instants_off_their_stamps_say_what_differences_of_passes_say() {
    let mut nominal = plant("study_case");
    // a lag that is read between readings of others takes in a line
    nominal.sensors.iter_mut().for_each(|sensor| sensor.low_pass_hz = None);
    for clock_s in [-4e-3, 4e-3] {
        nominal.set_parameter("imu.clock_offset", clock_s).unwrap();
        let found = off(&nominal, 2.3);
        assert!(found < 1.8e-4, "{clock_s}: {found:e}");
    }
}

#[test]
fn a_plant_with_a_law_takes_a_pass_for_each_number() {
    let sharp = [("force", 0.02), ("smooth_rate", 5e-4)];
    let with = crate::synthetic::with_effect(&plant("double_pendulum"), "joint_coulomb", "joint:pivot_2", &sharp);
    let problem = problem(&with, recording(&with, 3, 1.0));
    let passes = EstimationSession::new(&problem, 1).unwrap();
    let session = EstimationSession { along: true, ..passes.clone() };
    let columns = |session: &EstimationSession<'_>| {
        let theta = session.prior();
        let mut linearised = LinearisedProblem::new(session, &with, &theta, &session.noise).unwrap();
        linearised.take_jacobian(session, &with, &theta);
        linearised.jacobian
    };
    assert_eq!(columns(&session), columns(&passes));
}

#[test]
fn an_accelerometer_with_a_clock_of_its_own_is_predicted_across_the_switch_of_a_thruster() {
    let mut nominal = plant("study_case");
    nominal.set_parameter("imu.clock_offset", -4e-3).unwrap();
    let problem = problem(&nominal, recording(&nominal, 11, 2.3));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
    let mut columns = [linearised.nu.clone()];
    linearised.whiten(&session, &session.noise, &mut columns).unwrap();
    let largest = columns[0].iter().map(|r| r.abs()).fold(0.0, f64::max);
    // of 3 000 normal numbers one in a thousand recordings is beyond
    assert!(largest < 5.2, "{largest}");
}
