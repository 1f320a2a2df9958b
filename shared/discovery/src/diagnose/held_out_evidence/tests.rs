use super::*;
use crate::synthetic::{plant, recording};
use nalgebra::DVector;

/// The pendulum's bias is each recording's own; its bar and its friction are shared.
fn pendulum(recordings: u64) -> Problem {
    let nominal = plant("pendulum");
    let recorded: Vec<_> = (1..=recordings).map(|seed| recording(&nominal, seed, 0.5)).collect();
    Problem::new(&nominal, &recorded, &[]).unwrap()
}

/// All unknowns, so many sigma from their priors.
fn off(problem: &Problem, sigmas: f64) -> Vec<f64> {
    problem.unknowns.iter().map(|unknown| unknown.prior + sigmas * unknown.sigma).collect()
}

fn unknown<'p>(problem: &'p Problem, name: &str) -> &'p Unknown {
    problem.unknowns.iter().find(|unknown| unknown.name == name).unwrap()
}

/// Room below and above the prior [sigma].
fn room(unknown: &Unknown) -> [f64; 2] {
    [(unknown.prior - unknown.low) / unknown.sigma, (unknown.high - unknown.prior) / unknown.sigma]
}

#[track_caller]
fn assert_room(problem: &Problem, name: &str, expected: [f64; 2]) {
    let found = room(unknown(problem, name));
    // rounding of a sum and a difference
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12 * b), "{name}: {found:?}");
}

#[test]
fn own_numbers_stay_within_three_sigma_of_their_priors_where_those_of_the_fitted_recordings_did() {
    let (fitted, other) = (pendulum(2), pendulum(1));
    let (before, after) = (off(&fitted, -1.0), off(&fitted, 2.9));
    let bounded = within_reach(other, &[(&fitted.unknowns, &before), (&fitted.unknowns, &after)]);
    assert_room(&bounded, "angle.bias", [3.0, 3.0]);
}

#[test]
fn they_reach_as_far_as_any_fitted_recordings_did_by_any_of_the_fits_on_either_side() {
    let (fitted, other) = (pendulum(2), pendulum(1));
    let near = off(&fitted, 0.5);
    for (name, sigmas) in [("angle.bias@1", 5.0), ("angle.bias@2", -7.0)] {
        let mut far = near.clone();
        let at = fitted.unknowns.iter().position(|unknown| unknown.name == name).unwrap();
        far[at] = fitted.unknowns[at].prior + sigmas * fitted.unknowns[at].sigma;
        for fits in [[&near, &far], [&far, &near]] {
            let bounded = within_reach(other.clone(), &fits.map(|theta| (&fitted.unknowns[..], &theta[..])));
            assert_room(&bounded, "angle.bias", [f64::abs(sigmas); 2]);
            // another number's distance is not theirs
            assert_room(&bounded, "bar.inertia.zz", [3.0, 3.0]);
        }
    }
}

#[test]
fn what_cannot_be_stays_out_of_reach() {
    let problem = pendulum(1);
    let theta = off(&problem, 9.0);
    let bounded = within_reach(problem.clone(), &[(&problem.unknowns, &theta)]);
    let (before, after) = (unknown(&problem, "pivot.friction"), unknown(&bounded, "pivot.friction"));
    // half of it is one sigma, and below zero no friction is
    assert_eq!((after.low, room(after)[1]), (before.low, 9.0));
    assert!(after.low > 0.0);
}

#[test]
fn shared_parameters_are_known_as_fitted_except_those_that_the_fitted_recordings_did_not_determine() {
    for recordings in [1, 2] {
        let fitted = pendulum(recordings);
        let theta = off(&fitted, 0.5);
        let other = pendulum(1);
        let free = |unseen: &[&str]| {
            let plant = frozen(&fitted.plant, (&fitted.unknowns, &theta), unseen);
            for unknown in fitted.unknowns.iter().filter(|unknown| unknown.name != "pivot.friction") {
                let numbers = plant.parameters();
                let number = numbers.iter().find(|number| number.name == unknown.parameter).unwrap();
                let is_own = unknown.parameter == "angle.bias";
                let expected = if is_own { unknown.prior } else { unknown.prior + 0.5 * unknown.sigma };
                assert_eq!((number.value, number.sigma.is_some()), (expected, is_own), "{}", unknown.name);
            }
            other.with_plant(&plant).unknowns
        };
        let names = |unknowns: &[Unknown]| unknowns.iter().map(|u| u.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&free(&[])), ["angle.bias"]);
        let left = free(&["pivot.friction"]);
        assert_eq!(names(&left), ["pivot.friction", "angle.bias"]);
        // as the plant states it, not as it was fitted
        assert_eq!(left[0], *unknown(&fitted, "pivot.friction"));
    }
}

/// A reading's bias is linear: known to one part in `d`, the gain that it foretells is uncertain to
/// two in `d`.
#[test]
fn the_predicted_gain_is_as_uncertain_as_the_parameters_that_predict_it() {
    let nominal = plant("drive_rig");
    let biased = |bias: f64| crate::synthetic::with_effect(&nominal, "sensor_bias", "sensor:rate", &[("bias", bias)]);
    let (problem, d) = (crate::synthetic::problem(&nominal, recording(&biased(1e-3), 1, 0.5)), 7.0);
    let before = EstimationSession::new(&problem, 1).unwrap();
    let theta = before.prior();
    let augmented = problem.with_plant(&biased(1e-3));
    let after = EstimationSession::like(&before, &augmented).unwrap();
    let noise = before.noise.clone();
    let predictor = |plant| Predictor { plant, theta: &theta, noise: &noise };
    let own = ((&before, predictor(&problem.plant)), (&after, predictor(&augmented.plant)));
    let gain = gain(own.0.0, own.0.1, own.1).unwrap();
    let moved = augmented.with_plant(&biased(1e-3 * (1.0 + 1.0 / d))).plant;
    let sigma = expected_gain_sigma(own.0, own.1, core::slice::from_ref(&moved)).unwrap();
    assert!((sigma - 2.0 / d * gain.expected).abs() < 1e-6 * sigma, "{sigma} of {}", gain.expected);
    // what is off each on its own adds by squares
    let both = expected_gain_sigma(own.0, own.1, &[moved.clone(), moved]).unwrap();
    assert!((both - 2f64.sqrt() * sigma).abs() < 1e-9 * both, "{both}");
    let (least, expected) = (gain.with_expected_gain_sigma(sigma).least, gain.expected * (1.0 - 6.0 / d));
    assert!(gain.expected > 1.0 && (least - expected).abs() < 1e-5 * expected, "{least} of {}", gain.expected);
}

#[test]
fn numbers_are_moved_along_a_root_of_their_covariance_and_stay_within_what_is_possible() {
    let any = unknown(&pendulum(1), "pivot.friction").clone();
    let number = |name: &str, [low, high]: [f64; 2]| Unknown { parameter: name.to_owned(), low, high, ..any.clone() };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let unknowns = [number("effect.1.a", [0.0, 1.1]), number("mass", free), number("effect.1.b", free)];
    let (theta, sigma) = ([1.0, 5.0, 2.0], [0.3, 1.0, 4.0]);
    // widths are those of all local optima, correlations those of the fit
    let covariance = DMatrix::from_row_slice(3, 3, &[4.0, 0.3, -1.6, 0.3, 1.0, 0.1, -1.6, 0.1, 1.0]);
    let off = |theta: &[f64]| -> Vec<DVector<f64>> {
        let moved = along_root(&unknowns, (theta, &sigma), &covariance).unwrap();
        moved.iter().map(|moved| DVector::from_iterator(3, moved.iter().zip(theta).map(|(a, b)| a - b))).collect()
    };
    let spread: DMatrix<f64> = off(&theta).iter().map(|off| off * off.transpose()).sum();
    let expected = DMatrix::from_row_slice(3, 3, &[0.09, 0.0, -0.96, 0.0, 0.0, 0.0, -0.96, 0.0, 16.0]);
    assert!((&spread - &expected).amax() < 1e-12, "{spread}");
    // beside an edge they go the other way, and as far
    let below = off(&[0.1, 5.0, 2.0]);
    let spread: DMatrix<f64> = below.iter().map(|off| off * off.transpose()).sum();
    assert!((&spread - &expected).amax() < 1e-12, "{spread}");
    assert!(below[0][0] > 0.0 && off(&theta)[0][0] < 0.0);
}
