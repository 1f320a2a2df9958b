use super::*;
use crate::synthetic::{off_priors, plant, problem, recording};
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

/// Largest distance of entries, relative to the root of their diagonals.
fn apart(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    let scale = |i: usize, j: usize| (b[(i, i)] * b[(j, j)]).sqrt();
    let n = a.nrows();
    let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|(i, j)| scale(*i, *j) > 0.0);
    pairs.map(|(i, j)| (a[(i, j)] - b[(i, j)]).abs() / scale(i, j)).fold(0.0, f64::max)
}

fn is_that_of_differences(name: &str, duration_s: f64, tolerance: f64) {
    let nominal = plant(name);
    let problem = problem(&nominal, recording(&off_priors(&nominal, 3), 7, duration_s));
    let session = EstimationSession { along: true, ..EstimationSession::new(&problem, 1).unwrap() };
    let mut linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
    let told = linearised.run_along(&session, &nominal, &session.prior(), 0);
    assert!(told.iter().all(Option::is_some), "{name}");
    linearised.take_jacobian(&session, &nominal, &session.prior());
    let along = information(&session, &linearised);
    linearised.jacobian = by_differences(&session, &linearised, 1e-3);
    let found = apart(&along, &information(&session, &linearised));
    assert!(found < tolerance, "{name}: {found}");
}

#[test]
fn information_along_the_trajectory_is_that_of_differences_of_passes() {
    is_that_of_differences("study_case", 2.3, 1e-5);
}
