use super::*;
use crate::synthetic::{plant, problem, recording};
use dynamics::description::Quantity;
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

/// `name` with a law whose numbers are unknown by half of themselves.
fn with_law(name: &str, (kind, site): (&str, &str), law: &[(&str, f64)]) -> Plant {
    let mut with = crate::synthetic::with_effect(&plant(name), kind, site, law);
    let values = with.effects.iter_mut().flat_map(|own| &mut own.values);
    values.for_each(|(_, value)| *value = Quantity::with_prior(value.value, 0.5 * value.value.abs()));
    with
}

#[test]
fn numbers_of_a_smooth_force_are_known_along_the_trajectory_as_those_of_the_plant() {
    let cubic = [("stiffness", 2.0)];
    let damped = [("damping", 0.02)];
    for (name, law, numbers, duration_s, tolerance) in [
        ("study_case", ("joint_cubic_stiffness", "joint:elbow"), &cubic, 2.3, 1.4e-4),
        ("study_case", ("slosh_quadratic_damping", "tank:fuel"), &damped, 2.3, 1.4e-4),
        ("double_pendulum", ("joint_quadratic_damping", "joint:pivot_2"), &damped, 2.0, 1e-3),
    ] {
        let found = off(&with_law(name, law, numbers), duration_s);
        assert!(found < tolerance, "{name}, {law:?}: {found:e}");
    }
}

#[test]
fn a_craft_with_a_smooth_force_costs_as_one_without() {
    let set = |nominal: &Plant, along: bool| {
        let problem = problem(nominal, recording(nominal, 7, 2.3));
        let session = EstimationSession { along, ..EstimationSession::new(&problem, 1).unwrap() };
        let begun = session.work.spent();
        let mut linearised = LinearisedProblem::new(&session, nominal, &session.prior(), &session.noise).unwrap();
        linearised.take_jacobian(&session, nominal, &session.prior());
        session.work.spent() - begun
    };
    let with = with_law("study_case", ("joint_viscous", "joint:elbow"), &[("damping", 0.1)]);
    let [bare, along, passes] = [set(&plant("study_case"), true), set(&with, true), set(&with, false)];
    assert!(along < 1.1 * bare && along < passes, "{bare:e} {along:e} {passes:e}");
}

/// The linear model and the columns of `with`, in the steps of `nominal`, are those of a pass for
/// each number.
fn takes_passes(nominal: &Plant, with: &Plant) -> bool {
    let bare = problem(nominal, recording(nominal, 3, 1.0));
    let passes = EstimationSession::new(&bare, 1).unwrap();
    let augmented = bare.with_plant(with);
    let passes = EstimationSession::like(&passes, &augmented).unwrap();
    let session = EstimationSession { along: true, ..passes.clone() };
    let of = |session: &EstimationSession<'_>| {
        let theta = session.prior();
        let mut linearised = LinearisedProblem::new(session, with, &theta, &session.noise).unwrap();
        linearised.take_jacobian(session, with, &theta);
        (linearised.nu, linearised.jacobian)
    };
    of(&session) == of(&passes)
}

#[test]
fn a_law_that_turns_meets_a_stop_is_stiff_or_bends_a_reading_takes_a_pass_for_each_number() {
    let nominal = plant("double_pendulum");
    let joint = |kind, law: &[(&str, f64)]| with_law("double_pendulum", (kind, "joint:pivot_2"), law);
    // a sign that turned within an interval was 27 % off, though steps of integration resolved it
    let sign = joint("joint_coulomb", &[("force", 0.02), ("smooth_rate", 5e-4)]);
    let stiff = joint("joint_viscous", &[("damping", 2.0)]);
    let curved = with_law("double_pendulum", ("sensor_quadratic", "sensor:angle_1"), &[("coefficient", 0.01)]);
    let stop = joint("joint_end_stop", &[("stiffness", 1.0), ("lower", -0.2), ("upper", 0.2)]);
    let ripple = joint("joint_gear_ripple", &[("sine", 0.01), ("cosine", 0.0), ("order", 900.0)]);
    for with in [sign, stop, ripple, stiff, curved] {
        assert!(takes_passes(&nominal, &with), "{:?}", with.effects);
    }
    assert!(!takes_passes(&nominal, &joint("joint_viscous", &[("damping", 0.01)])));
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
