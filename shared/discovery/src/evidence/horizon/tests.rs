//! Whether a distance is more than noise.

use super::*;
use crate::noise::Noise;
use crate::synthetic::{plant, problem, recording};
use identification::fit::LinearisedProblem;

const SAMPLES: usize = 2000;

/// How many of 200 draws are taken for more than noise of which a share is driven.
fn felt(driven: f64, draw: impl Fn(Vec<f64>) -> Vec<f64>) -> usize {
    (0..200).filter(|seed| exceeds_noise(&draw(Noise::new(*seed).series(SAMPLES, 1.0)), driven, WORSE)).count()
}

/// Sums of `white`, begun again every `window` samples, each in its own standard deviations.
fn runs(white: &[f64], window: usize) -> Vec<f64> {
    let mut sum = 0.0;
    let walk = |(k, step): (usize, &f64)| {
        sum = if k % window == 0 { *step } else { sum + step };
        sum / ((k % window + 1) as f64).sqrt()
    };
    white.iter().enumerate().map(walk).collect()
}

#[test]
fn a_distance_that_disturbances_alone_drive_is_no_misfit_however_long_the_window() {
    for window in [1, 25, 250, SAMPLES] {
        let many = felt(1.0, |white| runs(&white, window));
        // one in twenty, and what the correlations' own error adds
        assert!(many <= 24, "{many} of 200 in windows of {window}");
    }
}

#[test]
fn noise_of_readings_that_remembers_is_no_misfit() {
    let coloured = |white: Vec<f64>| {
        let mut v = 0.0;
        let next = |r: &f64| {
            v = 0.9 * v + (1.0 - 0.81_f64).sqrt() * r;
            v
        };
        white.iter().map(next).collect()
    };
    assert!(felt(1.0, coloured) <= 24);
    // as white noise it is taken for a misfit three times as often as it may be
    assert!(felt(0.0, coloured) > 30);
}

#[test]
fn a_misfit_of_a_tenth_of_the_variance_of_white_noise_is_felt() {
    assert!(felt(1.0, |white| white.iter().map(|r| 1.1 * r).collect()) > 190);
    assert!(felt(0.0, |white| white.iter().map(|r| r + 0.4).collect()) > 190);
}

/// Distances of the plant with a parameter moved, run anew, beside the columns that say so to first
/// order.
#[test]
fn what_a_parameter_gives_a_distance_is_what_the_plant_gives_that_has_it_moved() {
    let plant = plant("pendulum");
    let problem = problem(&plant, recording(&plant, 5, 6.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let theta = session.prior();
    let at = |theta: &[f64]| LinearisedProblem::new(&session, &plant, theta, &session.noise).unwrap();
    let mut linearised = at(&theta);
    linearised.take_jacobian(&session, &plant, &theta);
    let of = |own: &LinearisedProblem| Horizons::new(&session, &own.linears, &session.noise, &session.noise).unwrap();
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        let share = 0.01;
        let column: Vec<f64> = linearised.jacobian[k].iter().map(|c| share * c).collect();
        let before = of(&linearised);
        let after = before.clone().with_parameters(&session, &linearised.linears, &session.noise, &[column]).unwrap();
        let mut moved = theta.clone();
        moved[k] += share * unknown.sigma;
        let again = of(&at(&moved));
        for ((before, after), again) in before.lengths.iter().zip(&after.lengths).zip(&again.lengths) {
            let sum = |squares: &mut dyn Iterator<Item = f64>| squares.filter(|square| square.is_finite()).sum::<f64>();
            let said = sum(&mut after.variance.iter().zip(&before.variance).map(|(after, before)| after - before));
            let run = sum(&mut again.residual.iter().zip(&before.residual).map(|(b, a)| (b - a) * (b - a)));
            assert!((said / run - 1.0).abs() < 0.1, "{} over {} s: {said} {run}", unknown.name, before.window_s);
        }
    }
}

/// One channel over one window, of distances whose variance grows as that of a sum of white noise.
fn drifting(residual: Vec<f64>) -> Horizons {
    let samples = (0..residual.len()).map(|k| Sample { site: 0, t_s: 0.1 * k as f64 }).collect();
    let variance = (1..=residual.len()).map(|k| k as f64).collect();
    let duration_s = 0.1 * residual.len() as f64;
    let lengths = vec![Length { window: residual.len(), window_s: duration_s, residual, variance }];
    let (sites, spread, white) = (vec!["angle".to_owned()], vec![1.0], vec![0.0]);
    Horizons { samples, sites, spread, white, lengths, block_s: 2.0, duration_s }
}

#[test]
fn a_drift_that_noise_explains_makes_no_model_worse_and_one_that_it_does_not_explain_does() {
    let worse = |size: f64| {
        let is_worse = |seed: u64| {
            let walk: Vec<f64> = Noise::new(seed)
                .series(SAMPLES, 1.0)
                .iter()
                .scan(0.0, |sum, step| {
                    *sum += step;
                    Some(*sum)
                })
                .collect();
            let of = |size: f64| drifting(walk.iter().map(|own| size * own).collect());
            of(size).beside(&of(0.5 * size)).unwrap().sites[0].is_worse
        };
        (0..40).filter(|seed| is_worse(*seed)).count()
    };
    let (explained, unexplained) = (worse(1.0), worse(30.0));
    assert!(explained <= 4 && unexplained >= 30, "{explained} {unexplained}");
}
