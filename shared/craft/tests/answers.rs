//! How what an arc misses travels, and how it joins the plant.

use craft::missing::{Answer, Missing, Unusable, answer, sample};
use craft::parameters::Parameters;
use dynamics::description::Plant;
use telemetry::{DIAGNOSED_MAX, Diagnosis, DiagnosisVerdict};

const STUDY_CASE: &str = include_str!("../../../deploy/plants/study_case.toml");

fn plant(text: &str) -> Plant {
    plant_file::parse("plant", text).unwrap().plant
}

fn coulomb(stands_in_for: Option<usize>) -> Missing {
    Missing {
        kind: "joint_coulomb".into(),
        site: "joint:elbow".parse().unwrap(),
        stands_in_for,
        probability: 0.9,
        significance: 40.0,
        values: vec![("force".into(), 0.08, 0.002)],
    }
}

fn answered(effects: Vec<Missing>) -> (Answer, Plant, Parameters) {
    let plant = plant(STUDY_CASE);
    let parameters = Parameters::of_plant(&plant).unwrap();
    let theta = parameters.unknowns.iter().map(|unknown| unknown.prior).collect();
    (Answer { arc: 2, generation: 0, verdict: DiagnosisVerdict::Named, theta, effects }, plant, parameters)
}

#[test]
fn an_answer_comes_back_from_its_sample_and_one_of_another_plant_is_refused() {
    let bias = Missing { kind: "joint_torque_bias".into(), values: Vec::new(), ..coulomb(Some(0)) };
    let (said, plant, parameters) = answered(vec![coulomb(None), bias]);
    let travels = sample(&said, &plant, &parameters);
    assert_eq!(answer(&travels, &plant, &parameters), Ok(said));
    let other = Parameters { hash: parameters.hash ^ 1, ..parameters.clone() };
    assert_eq!(answer(&travels, &plant, &other), Err(Unusable::OtherBuild));
    assert_eq!(answer(&Diagnosis { arc: 1, ..travels }, &plant, &parameters), Err(Unusable::Damaged));
    let elsewhere = Diagnosis { site: [99; DIAGNOSED_MAX], ..travels }.sealed();
    assert_eq!(answer(&elsewhere, &plant, &parameters), Err(Unusable::Unknown));
}

#[test]
fn the_augmented_plant_carries_what_is_missing_with_a_wide_prior_and_no_rival() {
    let bias = Missing { kind: "joint_torque_bias".into(), ..coulomb(Some(0)) };
    let (said, plant, parameters) = answered(vec![coulomb(None), bias]);
    let augmented = Parameters::of_plant(&said.augmented(&plant).unwrap()).unwrap();
    assert_eq!(augmented.len(), parameters.len() + 1);
    let is_new = |name: &&str| !parameters.unknowns.iter().any(|unknown| unknown.name == **name);
    let new = augmented.unknowns.iter().find(|unknown| is_new(&unknown.name.as_str())).unwrap();
    assert!(new.name.contains("joint:elbow") && new.prior == 0.08 && new.sigma > 1.0, "{new:?}");
    let (nothing, ..) = answered(Vec::new());
    assert_eq!(nothing.augmented(&plant), None);
}

#[test]
fn the_law_that_was_fitted_is_the_law_that_is_tried_with_wide_priors_of_what_was_estimated() {
    let stribeck = Missing {
        kind: "joint_stribeck".into(),
        values: vec![
            ("force".into(), 0.07, 0.001),
            ("stribeck_rate".into(), 0.3, 0.02),
            ("smooth_rate".into(), 4e-4, f64::NAN),
        ],
        ..coulomb(None)
    };
    let (said, plant, parameters) = answered(vec![stribeck]);
    let said = answer(&sample(&said, &plant, &parameters), &plant, &parameters).unwrap();
    let augmented = said.augmented(&plant).unwrap();
    let of = |name: &str| {
        let own = augmented.effects.iter().find(|used| used.kind == "joint_stribeck").unwrap();
        own.values.iter().find(|(own, _)| own == name).map(|(_, quantity)| (quantity.value, quantity.sigma)).unwrap()
    };
    // thirty times the amplitude, the catalogue's share of a width, and the factor of five within
    // which the search knows the rate of the sign
    assert_eq!(of("force"), (0.07, Some(30.0 * 0.07)));
    assert_eq!(of("stribeck_rate"), (0.3, Some(0.7 * 0.3)));
    assert_eq!(of("smooth_rate"), (4e-4, Some(4.0 * 4e-4)));
}

#[test]
fn an_amplitude_within_its_deviation_of_zero_is_as_uncertain_as_that_and_a_component_that_was_kept_is_known() {
    let values = vec![("force_x".into(), 0.001, 0.02), ("force_y".into(), 0.0, f64::NAN)];
    let torque = Missing { kind: "constant_force".into(), site: "body:hub".parse().unwrap(), values, ..coulomb(None) };
    let (_, plant, _) = answered(Vec::new());
    let used = torque.as_effect(&plant).unwrap();
    let sigmas: Vec<Option<f64>> = used.values.iter().map(|(_, quantity)| quantity.sigma).collect();
    assert_eq!(sigmas, [Some(30.0 * 0.02), None]);
}

#[test]
fn a_sign_that_turns_as_slowly_as_is_plausible_keeps_its_rate() {
    let (_, plant, _) = answered(Vec::new());
    let sigma = |rate: f64| {
        let values = vec![("force".into(), 0.08, 0.002), ("smooth_rate".into(), rate, f64::NAN)];
        Missing { values, ..coulomb(None) }.as_effect(&plant).unwrap().values[1].1.sigma
    };
    assert_eq!((sigma(0.01), sigma(0.1)), (Some(0.04), None));
}
