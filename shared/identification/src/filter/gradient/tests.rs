use super::*;
use crate::fit::{EstimationSession, LinearisedProblem};
use crate::problem::Problem;
use crate::synthetic::{coloured, plant, problem, recording, with_effect};

/// `−2 ln p` of the readings under one noise, by whitening alone.
fn value(session: &EstimationSession<'_>, linearised: &LinearisedProblem, noise: &NoiseModel) -> f64 {
    let mut columns = [linearised.nu.clone()];
    let log_determinant = linearised.whiten(session, noise, &mut columns).unwrap();
    log_determinant + columns[0].iter().map(|r| r * r).sum::<f64>()
}

fn moved(noise: &NoiseModel, kind: &str, k: usize, by: f64) -> NoiseModel {
    let mut moved = noise.clone();
    match kind {
        "input" => moved.input_sigma[k] *= by.exp(),
        "sensor" => moved.sensor_sigma[k] *= by.exp(),
        "jitter" => moved.jitter_s[k] *= by.exp(),
        _ => moved.pole[k] = (moved.pole[k].atanh() + by).tanh(),
    }
    moved
}

/// Noise off what is stated: some of higher, some of lower variance, every other channel coloured,
/// all with jitter.
fn noises(session: &EstimationSession<'_>) -> [NoiseModel; 2] {
    let mut white = session.noise.clone();
    white.input_sigma.iter_mut().for_each(|sigma| *sigma *= 3.0);
    white.sensor_sigma.iter_mut().enumerate().for_each(|(k, sigma)| *sigma *= [1.4, 0.8][k % 2]);
    for k in 0..white.jitter_s.len() {
        white.jitter_s[k] = 0.05 * session.interval_s(k);
    }
    let mut coloured = white.clone();
    coloured.pole.iter_mut().step_by(2).for_each(|pole| *pole = 0.6);
    [white, coloured]
}

fn is_the_slope_of_the_likelihood(problem: &Problem) {
    let session = EstimationSession::new(problem, 1).unwrap();
    let linearised = LinearisedProblem::new(&session, &problem.plant, &session.prior(), &session.noise).unwrap();
    for noise in noises(&session) {
        let found = gradient(&linearised.linears[0], &session.timelines[0], &noise, &linearised.nu).unwrap();
        assert!((found.value - value(&session, &linearised, &noise)).abs() < 1e-7 * found.value.abs().max(1.0));
        let slopes =
            [("input", &found.input), ("sensor", &found.sensor), ("pole", &found.pole), ("jitter", &found.jitter)];
        for (kind, slopes) in slopes {
            for (k, slope) in slopes.iter().enumerate() {
                // where an initial state is wide the recursion's rounding is felt over smaller
                // steps
                let step = 1e-2;
                let at = |by: f64| value(&session, &linearised, &moved(&noise, kind, k, by));
                let difference = (at(step) - at(-step)) / (2.0 * step);
                let scale = difference.abs().max(slope.second.sqrt()).max(1.0);
                assert!((slope.first - difference).abs() < 5e-3 * scale, "{kind} {k}: {slope:?} {difference}");
            }
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_likelihood_by_differences() {
    let lagged = [("time_constant", 3e-3)];
    let drive = with_effect(&plant("drive_rig"), "sensor_lag", "sensor:rate", &lagged);
    for (nominal, duration_s) in
        [(plant("oscillator"), 2.0), (drive, 1.0), (plant("study_case"), 2.3), (plant("double_pendulum"), 2.0)]
    {
        is_the_slope_of_the_likelihood(&problem(&nominal, recording(&nominal, 3, duration_s)));
    }
}

/// Held upright by its loops: without the filter rounding would grow as the arm falls.
#[test]
fn the_gradient_is_that_of_the_likelihood_where_the_plant_alone_would_fall() {
    let nominal = plant("six_joint_arm");
    let problem = problem(&nominal, recording(&nominal, 3, 30.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
    let noise = &noises(&session)[0];
    let found = gradient(&linearised.linears[0], &session.timelines[0], noise, &linearised.nu).unwrap();
    for (kind, slopes) in [("input", &found.input), ("sensor", &found.sensor)] {
        for (k, slope) in slopes.iter().enumerate() {
            let at = |by: f64| value(&session, &linearised, &moved(noise, kind, k, by));
            let difference = (at(1e-2) - at(-1e-2)) / 2e-2;
            let scale = slope.second.sqrt().max(difference.abs());
            assert!((slope.first - difference).abs() < 5e-3 * scale, "{kind} {k}: {slope:?} {difference}");
        }
    }
}

#[test]
fn the_gradient_of_several_recordings_is_the_sum_of_theirs() {
    let nominal = plant("oscillator");
    let both = [recording(&nominal, 1, 0.5), recording(&nominal, 2, 0.8)];
    let problem = Problem::new(&nominal, &both, &[]).unwrap();
    let session = EstimationSession::new(&problem, 1).unwrap();
    let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
    let (whole, _) = linearised.gradient(&session, (&linearised.nu, &session.prior()), &session.noise).unwrap();
    let (mut value, mut first) = (0.0, 0.0);
    for (run, offset) in session.offsets.iter().enumerate() {
        let own = &linearised.nu[*offset..offset + session.timelines[run].value.len()];
        let part = gradient(&linearised.linears[run], &session.timelines[run], &session.noise, own).unwrap();
        (value, first) = (value + part.value, first + part.sensor[0].first);
    }
    assert!((whole.value - value).abs() < 1e-9 * value.abs() && (whole.sensor[0].first - first).abs() < 1e-9);
    assert_eq!(session.offsets.len(), 2);
}

/// Numbers of the gradient's scatter over recordings: its expected square is twice the expected
/// second derivative.
#[test]
fn slopes_scatter_over_recordings_as_their_second_derivatives_say() {
    let nominal = plant("oscillator");
    let (mut sensor, mut pole, mut own_pole) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let drawn = 40;
    for seed in 1..=drawn {
        let problem = problem(&nominal, recording(&nominal, seed, 2.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
        let found = gradient(&linearised.linears[0], &session.timelines[0], &session.noise, &linearised.nu).unwrap();
        let add = |sum: &mut [f64; 2], slope: &Slope| {
            *sum = [sum[0] + slope.first * slope.first, sum[1] + 2.0 * slope.second];
        };
        add(&mut sensor, &found.sensor[0]);
        add(&mut pole, &found.pole[0]);
        let problem = self::problem(&nominal, coloured(&nominal, seed, 2.0, 0.8));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let noise = NoiseModel { pole: vec![0.8; 2], ..session.noise.clone() };
        let linearised = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
        let found = gradient(&linearised.linears[0], &session.timelines[0], &noise, &linearised.nu).unwrap();
        add(&mut own_pole, &found.pole[1]);
    }
    // chi-squared of 40
    for [square, expected] in [sensor, pole, own_pole] {
        assert!((0.5..1.7).contains(&(square / expected)), "{square} {expected}");
    }
}
