//! When an arc refuses a model at once, and how what it misses travels and joins the plant.

use craft::message::Received;
use craft::missing::{Answer, Missing, Unusable, answer, sample};
use craft::parameters::Parameters;
use craft::refusal::unexplained;
use dynamics::description::Plant;
use identification::joint::Message;
use nalgebra::{DMatrix, DVector};
use telemetry::{DIAGNOSED_MAX, Diagnosis, DiagnosisVerdict};

const OSCILLATOR: &str = include_str!("../../../deploy/plants/oscillator.toml");
const STUDY_CASE: &str = include_str!("../../../deploy/plants/study_case.toml");

fn plant(text: &str) -> Plant {
    plant_file::parse("plant", text).unwrap().plant
}

const ROWS: usize = 4000;
const LOOKS: usize = 7;

/// An arc `off` posterior sigmas from its optimum in every parameter, where it keeps
/// `chi2_per_row`.
fn arc(arc: usize, off: f64, chi2_per_row: f64) -> Received {
    let parameters = Parameters::of_plant(&plant(OSCILLATOR)).unwrap();
    let n = parameters.len();
    Received {
        arc,
        theta: parameters.unknowns.iter().map(|unknown| unknown.prior).collect(),
        message: Message {
            information: 100.0 * DMatrix::identity(n, n),
            gradient: DVector::from_element(n, 10.0 * off),
            chi2: chi2_per_row * ROWS as f64 + n as f64 * off * off,
            log_determinant: 0.0,
            rows: ROWS,
        },
    }
}

#[test]
fn what_a_step_can_take_is_no_reason_to_refuse() {
    // far off, and all of the excess is promised to the step
    assert_eq!(unexplained(&[arc(0, 80.0, 1.0), arc(1, 0.0, 1.02)], 0, LOOKS), None);
    assert_eq!(unexplained(&[arc(0, 80.0, 1.0)], 2, LOOKS), None);
}

#[test]
fn an_excess_that_no_step_takes_is_refused_at_once_and_the_worst_arc_is_named() {
    let found = unexplained(&[arc(0, 1.0, 1.3), arc(1, 1.0, 2.0), arc(2, 1.0, 1.0)], 0, LOOKS).unwrap();
    assert_eq!(found.arc, 1);
    assert!((found.chi2_per_row - 2.0).abs() < 1e-6 && found.p < 1e-100, "{found:?}");
}

#[test]
fn far_from_the_optimum_an_arc_is_refused_once_steps_were_taken() {
    // the step takes more than it leaves: the linear model is not trusted before
    let far = [arc(0, 80.0, 1.3)];
    assert_eq!((unexplained(&far, 0, LOOKS), unexplained(&far, 1, LOOKS)), (None, None));
    assert_eq!(unexplained(&far, 2, LOOKS).map(|found| found.arc), Some(0));
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
