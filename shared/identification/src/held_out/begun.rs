//! A plant as it begins a recording.

use super::Predictor;
use super::free_run::initial_state;
use crate::fit::{EstimationSession, fit};
use crate::problem::{Problem, is_start};
use channels::Recording;
use dynamics::description::{Initial, Plant, Scope};

/// Relinearisations of the numbers of the recording.
const OWN_ROUNDS: usize = 3;

/// `plant` with its numbers of single recordings fitted to `recording`, all others as they are, and
/// with the state that the free run of the first stretch begins in. `None` where the recording does
/// not tell it (no sensor of the plant is in it), or the plant has segments or does not survive it.
///
/// Cost: a fit of the recording's own parameters.
pub fn begun(plant: &Plant, recording: &Recording, threads: usize) -> Option<Plant> {
    if !plant.segments.is_empty() {
        return None;
    }
    let mut known = plant.clone();
    known.visit_quantities(&mut |name, _, quantity| {
        if quantity.scope == Scope::Shared && !is_start(name) {
            quantity.sigma = None;
        }
    });
    let problem = Problem::new(&known, std::slice::from_ref(recording), &[]).ok()?;
    let session = EstimationSession::new(&problem, threads).ok()?;
    let prior = session.prior();
    let own = |prior: &[f64]| fit(&session, &known, prior, &session.noise, OWN_ROUNDS).ok();
    let theta = if prior.is_empty() { prior } else { own(&prior)?.theta };
    let predictor = Predictor { plant: &known, theta: &theta, noise: &session.noise };
    let (system, x0) = initial_state(&session, predictor, 0)?;
    let mut begun = problem.instance(plant, &theta, 0);
    let mut values = system.initial_values(&x0);
    // what is prescribed begins as it is stated
    let stated = plant.initial.values.iter().filter(|own| values.iter().all(|new| new.coordinate != own.coordinate));
    values.extend(stated.cloned().collect::<Vec<_>>());
    begun.initial = Initial { values, ..Initial::default() };
    Some(begun)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, recording};

    #[test]
    fn a_plant_begins_where_the_recording_does() {
        for name in ["pendulum", "tank_planar"] {
            let nominal = plant(name);
            let mut truth = nominal.clone();
            truth.initial.values.iter_mut().for_each(|value| value.position.value += 0.1);
            let found = begun(&nominal, &recording(&truth, 3, 20.0), 1).unwrap();
            for value in &truth.initial.values {
                let own = found.initial.values.iter().find(|own| own.coordinate == value.coordinate).unwrap();
                let off = own.position.value - value.position.value;
                assert!(off.abs() < 0.02, "{name}: {} {off}", value.coordinate);
            }
        }
    }
}
