//! Diagnoses by evidence.

use super::*;
use crate::diagnose::Verdict;
use crate::synthetic::{coloured, plant, recording};
use channels::Recording;
use dynamics::description::Plant;

fn diagnosed(nominal: &Plant, recorded: Recording, held_out: Option<Recording>) -> Diagnosis {
    let problem = |recorded: Recording| Problem::new(nominal, &[recorded], &[]).unwrap();
    let options = Options { held_out: held_out.map(&problem), ..Options::default() };
    diagnose(&problem(recorded), &options, &mut |_, _| {})
}

#[test]
fn a_complete_plant_lacks_nothing() {
    let nominal = plant("pendulum");
    let found = diagnosed(&nominal, recording(&nominal, 5, 5.0), Some(recording(&nominal, 6, 4.0)));
    assert_eq!(found.verdict, Verdict::None, "{}", found.reason);
    assert!(found.effects.is_empty() && !found.detection_limits.is_empty());
}

#[test]
fn noise_that_remembers_is_noise_and_no_physics() {
    let nominal = plant("pendulum");
    let found = diagnosed(&nominal, coloured(&nominal, 5, 5.0, 0.8), None);
    assert_eq!(found.verdict, Verdict::NoiseModel, "{}", found.reason);
    assert!(found.effects.is_empty());
}
