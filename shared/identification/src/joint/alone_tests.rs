use super::*;
use crate::synthetic::{off_priors, plant, recording};
use nalgebra::DVector;

fn arc(name: &str, plant: &Plant, seed: u64, truth: &Plant) -> Arc {
    Arc { name: name.to_owned(), problem: Problem::new(plant, &[recording(truth, seed, 4.0)], &[]).unwrap() }
}

fn vehicle(arcs: &[Arc]) -> Vehicle<'_> {
    Vehicle::new(arcs, 1, Shared::new(Work::of(f64::INFINITY))).unwrap()
}

/// An oscillator whose damping belongs to each recording alone.
fn with_an_own_number() -> Plant {
    let mut nominal = plant("oscillator");
    let mut owned = 0;
    nominal.visit_quantities(&mut |_, _, quantity| {
        if owned == 0 && quantity.sigma.is_some() && quantity.scope == Scope::Shared {
            quantity.scope = Scope::PerRecording;
            owned += 1;
        }
    });
    assert_eq!(owned, 1);
    nominal
}

/// The message of `arc` alone at its priors, its own unknowns eliminated, with its `d`.
fn eliminated(arc: &Arc) -> (Message, Message, DVector<f64>) {
    let alone = [arc.clone()];
    let vehicle = vehicle(&alone);
    let whole = vehicle.message(0, &vehicle.prior()).unwrap();
    let own: Vec<bool> = vehicle.unknowns.iter().map(|unknown| unknown.own.is_some()).collect();
    let d = DVector::zeros(own.len());
    let message = whole.eliminated(&own, &d).unwrap().message;
    (whole, message, DVector::zeros(own.iter().filter(|own| !**own).count()))
}

#[test]
fn messages_without_what_arcs_have_alone_fold_to_the_marginal_of_those_with_it() {
    let nominal = with_an_own_number();
    let truth = off_priors(&nominal, 21);
    let arcs = [arc("a", &nominal, 31, &truth), arc("b", &nominal, 32, &truth)];
    let both = vehicle(&arcs);
    let prior = both.prior();
    let whole: Vec<Message> = (0..2).map(|arc| both.message(arc, &prior).unwrap()).collect();
    let d = DVector::zeros(prior.len());
    let joint = Knowledge::of_priors(prior.len()).with(&whole, &d).unwrap();
    let shared: Vec<usize> = (0..prior.len()).filter(|i| both.unknowns[*i].own.is_none()).collect();
    assert!(shared.len() < prior.len());

    let parts: Vec<Message> = arcs.iter().map(|arc| eliminated(arc).1).collect();
    let folded = Knowledge::of_priors(shared.len()).with(&parts, &DVector::zeros(shared.len())).unwrap();
    let (marginal, own) = (joint.covariance().unwrap(), folded.covariance().unwrap());
    for (i, at) in shared.iter().enumerate() {
        let sigma = marginal[(*at, *at)].sqrt();
        // rounding of two Cholesky factorisations of some ten rows
        assert!((folded.mean[i] - joint.mean[*at]).abs() < 1e-9 * sigma.max(joint.mean[*at].abs()));
        assert!((own[(i, i)].sqrt() / sigma - 1.0).abs() < 1e-9);
    }
}

#[test]
fn an_eliminated_unknown_costs_its_prior_and_the_misfit_keeps_its_expectation() {
    let nominal = with_an_own_number();
    let arc = arc("a", &nominal, 33, &nominal);
    let (whole, message, _) = eliminated(&arc);
    // at the true values: the rows of a whitened record, four standard deviations
    let rows = message.rows as f64;
    assert!((message.chi2 / rows - 1.0).abs() < 4.0 * (2.0 / rows).sqrt());
    assert!(message.chi2 <= whole.chi2 && message.log_determinant > whole.log_determinant);
}

#[test]
fn the_shared_unknowns_of_a_plant_are_those_of_its_arcs_in_their_order() {
    for nominal in [with_an_own_number(), plant("study_case")] {
        let listed: Vec<String> = shared_unknowns(&nominal).into_iter().map(|unknown| unknown.name).collect();
        let arcs = [arc("a", &nominal, 34, &nominal)];
        let of_arc = vehicle(&arcs).unknowns.into_iter().filter(|unknown| unknown.own.is_none());
        assert_eq!(listed, of_arc.map(|unknown| unknown.name).collect::<Vec<_>>());
    }
}

#[test]
fn the_block_that_an_arc_contradicts_is_the_one_that_differs() {
    let nominal = plant("oscillator");
    let truth = off_priors(&nominal, 41);
    let mut other = truth.clone();
    let unknowns = shared_unknowns(&nominal);
    let (heaviest, _) = unknowns.iter().enumerate().next().unwrap();
    let moved = &unknowns[heaviest];
    let value = truth.parameters().into_iter().find(|p| p.name == moved.name).unwrap().value;
    other.set_parameter(&moved.name, value + 0.5 * moved.sigma).unwrap();
    let p = |second: &Plant, seed: u64| {
        let arcs = [arc("a", &nominal, seed, &truth), arc("b", &nominal, seed + 1, second)];
        let both = vehicle(&arcs);
        let found = identify(&both, &mut |_, _| {}).unwrap();
        let theta = found.theta;
        let d = DVector::from_fn(theta.len(), |i, _| (theta[i] - both.unknowns[i].prior) / both.unknowns[i].sigma);
        let others = Knowledge::of_priors(theta.len()).with([&found.messages[1]], &d).unwrap();
        Agreement::of_block(&found.messages[0], &others, &d, &[heaviest]).unwrap()
    };
    let same = p(&truth, 51);
    // once in a thousand pairs of arcs of one vehicle
    assert!(same.p > 1e-3, "{same:?}");
    let different = p(&other, 53);
    assert!(different.p < 1e-3 && different.freedom == 1, "{different:?}");
}

/// `plant` with every number of the oscillator's spring `sigmas` prior deviations off.
fn stiffer(nominal: &Plant, sigmas: f64) -> Plant {
    let mut plant = nominal.clone();
    let spring = shared_unknowns(nominal).into_iter().find(|unknown| unknown.name.contains("stiffness")).unwrap();
    plant.set_parameter(&spring.name, spring.prior + sigmas * spring.sigma).unwrap();
    plant
}

#[test]
fn an_estimate_that_contradicts_what_was_known_and_explains_more_is_kept() {
    let nominal = plant("oscillator");
    let alone = [arc("a", &nominal, 61, &stiffer(&nominal, 5.0))];
    let vehicle = vehicle(&alone);
    let mut theta = vehicle.prior();
    let spring = vehicle.unknowns.iter().position(|unknown| unknown.name.contains("stiffness")).unwrap();
    theta[spring] += 5.0 * vehicle.unknowns[spring].sigma;
    let message = vehicle.message(0, &theta).unwrap();
    let (moved, _) = vehicle.restarted(0, &Knowledge::of_priors(theta.len()), (theta.clone(), message));
    let unknown = &vehicle.unknowns[spring];
    let spring = (moved[spring] - unknown.prior) / unknown.sigma;
    assert!((spring - 5.0).abs() < 0.2, "{spring}");
}
