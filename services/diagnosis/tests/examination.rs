//! What is missing, named from the rows of one arc within a stated amount of work.

use craft::missing::Missing;
use craft::parameters::Parameters;
use diagnosis::examination::examined;
use dynamics::description::Plant;
use identification::work::Watch;
use telemetry::DiagnosisVerdict;

fn plant(text: &str) -> Plant {
    plant_file::parse("plant", text).unwrap().plant
}

/// The answer to rows of `plant` with numbers that are off their priors by a third of a standard
/// deviation and with `hidden`, started at the priors.
fn answer(plant: &Plant, hidden: &[(&str, &str, f64)], duration_s: f64) -> (DiagnosisVerdict, Vec<Missing>, Vec<f64>) {
    let mut truth = plant.clone();
    truth.visit_quantities(&mut |_, _, quantity| quantity.value += quantity.sigma.unwrap_or(0.0) / 3.0);
    for (kind, site, force) in hidden {
        truth.add_effect(kind, &site.parse().unwrap(), &[("force", *force)]).unwrap();
    }
    let recording = simulation::record(&truth, 11, duration_s, &mut |_| {}).unwrap();
    let parameters = Parameters::of_plant(plant).unwrap();
    let start: Vec<f64> = parameters.unknowns.iter().map(|unknown| unknown.prior).collect();
    examined(plant, Some(recording), (&parameters, &start), &Watch::default())
}

#[test]
fn friction_that_the_plant_lacks_is_named_with_its_joint_and_size() {
    let pendulum = plant(include_str!("../../../deploy/plants/pendulum.toml"));
    let (verdict, effects, theta) = answer(&pendulum, &[("joint_coulomb", "joint:pivot", 0.05)], 5.0);
    assert_eq!(verdict, DiagnosisVerdict::Named, "{effects:?}");
    let found = &effects[0];
    assert_eq!((found.kind.as_str(), found.site.to_string().as_str()), ("joint_coulomb", "joint:pivot"));
    assert!(found.stands_in_for.is_none() && found.probability > 0.9, "{found:?}");
    let (name, value, sigma) = &found.values[0];
    assert!(name == "force" && (value - 0.05).abs() < 4.0 * sigma, "{found:?}");
    assert!(!theta.is_empty() && theta.iter().all(|value| value.is_finite()));
}

#[test]
fn a_plant_that_is_complete_misses_nothing_and_rows_that_were_lost_decide_nothing() {
    let pendulum = plant(include_str!("../../../deploy/plants/pendulum.toml"));
    let (verdict, effects, _) = answer(&pendulum, &[], 3.0);
    assert_eq!((verdict, effects), (DiagnosisVerdict::Nothing, Vec::new()));
    let parameters = Parameters::of_plant(&pendulum).unwrap();
    let (verdict, effects, theta) = examined(&pendulum, None, (&parameters, &[]), &Watch::default());
    assert_eq!((verdict, effects), (DiagnosisVerdict::CannotDecide, Vec::new()));
    assert!(theta.iter().zip(&parameters.unknowns).all(|(value, unknown)| *value == unknown.prior));
}
