use super::*;
use crate::fit::fit;
use crate::synthetic::{off_priors, plant, recording};
use dynamics::description::Plant;
use dynamics::system::{System, Workspace};

fn arc(name: &str, plant: &Plant, seed: u64, truth: &Plant) -> Arc {
    let problem = Problem::new(plant, &[recording(truth, seed, 4.0)], &[]).unwrap();
    Arc { name: name.to_owned(), problem }
}

fn vehicle(arcs: &[Arc]) -> Vehicle<'_> {
    Vehicle::new(arcs, 1, Shared::new(Work::of(f64::INFINITY))).unwrap()
}

#[test]
fn messages_of_two_arcs_say_what_one_fit_of_both_recordings_says() {
    let nominal = plant("oscillator");
    let truth = off_priors(&nominal, 21);
    let arcs = [arc("a", &nominal, 31, &truth), arc("b", &nominal, 32, &truth)];
    let vehicle = vehicle(&arcs);
    let found = identify(&vehicle, &mut |_, _| {}).unwrap();
    assert!(found.converged);

    let both = [31, 32].map(|seed| recording(&truth, seed, 4.0));
    let problem = Problem::new(&nominal, &both, &[]).unwrap();
    let session = EstimationSession::new(&problem, 1).unwrap();
    let fitted = fit(&session, &nominal, &session.prior(), &session.noise, 8).unwrap();
    for (k, unknown) in vehicle.unknowns.iter().enumerate() {
        let name = unknown.name.replace("@a", "@1").replace("@b", "@2");
        let i = problem.unknowns.iter().position(|other| other.name == name).unwrap();
        // each ends within a tenth of a sigma of the maximum; their steps stop apart by less
        let apart = (found.theta[k] - fitted.theta[i]) / fitted.sigma[i];
        assert!(apart.abs() < 0.05, "{name}: {apart} sigma apart");
        assert!(
            (found.sigma[k] / fitted.sigma[i] - 1.0).abs() < 0.01,
            "{name}: {} {}",
            found.sigma[k],
            fitted.sigma[i]
        );
    }
}

#[test]
fn an_arc_of_the_same_vehicle_agrees_and_one_of_another_contradicts() {
    let nominal = plant("oscillator");
    let truth = off_priors(&nominal, 41);
    let own = identify(&vehicle(&[arc("a", &nominal, 51, &truth), arc("b", &nominal, 52, &truth)]), &mut |_, _| {});
    for agreement in own.unwrap().agreement {
        let agreement = agreement.unwrap();
        // once in a thousand runs of one vehicle
        assert!(agreement.p > 1e-3 && agreement.freedom > 0, "{agreement:?}");
    }
    let other = off_priors(&nominal, 42);
    let mixed = identify(&vehicle(&[arc("a", &nominal, 51, &truth), arc("b", &nominal, 52, &other)]), &mut |_, _| {});
    assert!(mixed.unwrap().agreement.iter().all(|agreement| agreement.unwrap().p < 1e-6));
}

#[test]
fn an_arc_that_was_not_fitted_is_predicted_to_its_noise() {
    let nominal = plant("oscillator");
    let truth = off_priors(&nominal, 61);
    let arcs = [arc("a", &nominal, 71, &truth), arc("b", &nominal, 72, &truth)];
    let vehicle = vehicle(&arcs);
    let found = identify(&vehicle, &mut |_, _| {}).unwrap();
    let rows: usize = arcs[0].problem.samples();
    let chi2 = predict(&vehicle, &found, &arc("c", &nominal, 73, &truth)).unwrap();
    // four standard deviations of a mean square
    assert!((chi2 - 1.0).abs() < 4.0 * (2.0 / rows as f64).sqrt(), "{chi2}");
    let off = predict(&vehicle, &found, &arc("c", &nominal, 73, &off_priors(&nominal, 62))).unwrap();
    assert!(off > 1.2 * chi2, "{off}");
}

#[test]
fn a_number_with_two_priors_is_refused_with_both() {
    let nominal = plant("oscillator");
    let mut other = nominal.clone();
    let mut changed = String::new();
    other.visit_quantities(&mut |name, _, quantity| {
        if changed.is_empty() && quantity.sigma.is_some() && quantity.scope == Scope::Shared {
            quantity.value *= 1.01;
            name.clone_into(&mut changed);
        }
    });
    let arcs = [arc("first", &nominal, 1, &nominal), arc("second", &other, 2, &nominal)];
    let error = Vehicle::new(&arcs, 1, Shared::new(Work::of(f64::INFINITY))).err().unwrap();
    let text = error.to_string();
    assert!([changed.as_str(), "first", "second", "±"].iter().all(|word| text.contains(word)), "{text}");
}

/// Masses and moments moved along what the motion cannot tell: 0.8 kg from the hub to the second
/// link, and whatever keeps the base values.
fn moved_along_the_gauge(plant: &Plant) -> Plant {
    let mut moved = plant.clone();
    let of = |name: &str| plant.bodies.iter().position(|body| body.name == name).unwrap();
    let (hub, one, two) = (of("hub"), of("link_1"), of("link_2"));
    let more_kg = 0.8;
    let shoulder = plant.bodies[one].joint.position_m.map(|q| q.value);
    let elbow = plant.bodies[two].joint.position_m.map(|q| q.value);
    let mut keep = |body: usize, mass_kg: f64, carried_kg: f64, at: [f64; 3]| {
        let own = &plant.bodies[body];
        let com = own.com_m.map(|q| q.value);
        let second = own.inertia_com_kg_m2[2].value + own.mass_kg.value * (com[0] * com[0] + com[1] * com[1])
            - carried_kg * (at[0] * at[0] + at[1] * at[1]);
        let new = &mut moved.bodies[body];
        let mut squared = 0.0;
        for axis in 0..2 {
            let first = own.mass_kg.value * com[axis] - carried_kg * at[axis];
            new.com_m[axis].value = first / mass_kg;
            squared += first * first / mass_kg;
        }
        new.mass_kg.value = mass_kg;
        new.inertia_com_kg_m2[2].value = second - squared;
    };
    let mass = |body: usize| plant.bodies[body].mass_kg.value;
    keep(two, mass(two) + more_kg, 0.0, [0.0; 3]);
    keep(one, mass(one), more_kg, elbow);
    keep(hub, mass(hub) - more_kg, more_kg, shoulder);
    moved
}

#[test]
fn plants_of_equal_base_values_move_alike_and_of_others_do_not() {
    let nominal = plant("study_case");
    let moved = moved_along_the_gauge(&nominal);
    let values = |plant: &Plant| plant.planar_base_values();
    assert_eq!(values(&nominal).len(), 35);
    for (a, b) in values(&nominal).iter().zip(&values(&moved)) {
        assert!((a.value - b.value).abs() < 1e-12 * a.value.abs().max(1.0), "{}: {} {}", a.name, a.value, b.value);
    }
    assert!((nominal.bodies[1].com_m[0].value - moved.bodies[1].com_m[0].value).abs() > 0.01);
    let (a, b) = (derivative(&nominal), derivative(&moved));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9 * a.abs().max(1e-3)), "{a:?} {b:?}");
    let mut heavier = moved.clone();
    heavier.bodies[1].com_m[0].value += 1e-3;
    let c = derivative(&heavier);
    assert!(a.iter().zip(&c).any(|(a, c)| (a - c).abs() > 1e-6 * a.abs().max(1e-3)));
}

/// Of the state, where everything moves and every input acts.
fn derivative(plant: &Plant) -> Vec<f64> {
    let system = System::new(plant).unwrap();
    let wave = |k: usize| 0.3 * (1.7 * k as f64 + 0.4).sin();
    let x: Vec<f64> = (0..system.states().len()).map(wave).collect();
    let u: Vec<f64> = (0..system.inputs().len()).map(|k| wave(k + 3)).collect();
    let mut x_dot = vec![0.0; x.len()];
    system.derivative(&mut Workspace::new(&system), 0.0, &x, &u, &mut x_dot);
    x_dot
}
