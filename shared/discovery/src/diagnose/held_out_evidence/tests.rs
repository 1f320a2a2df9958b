use super::*;
use crate::synthetic::{plant, recording};

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
