//! Steps of integration that the fastest rate of a plant allows.

use crate::problem::{Problem, Timeline};
use dynamics::description::{EffectUse, Plant, SensorKind};
use dynamics::dual::Dual;
use dynamics::effect::{Family, Role, apply_structures, values};
use dynamics::system::{System, Workspace, spectral_radius};

/// Product of step and fastest rate that a step of integration keeps to, and the one beyond which a
/// variant takes finer steps: Runge–Kutta is off by (ω h)⁵/120 of the amplitude a step, 9e-5 and
/// 3e-4.
const STEP_RATE: f64 = 0.4;
const STEP_RATE_MAX: f64 = 0.5;
/// Finest subdivision of a step for a stiff variant.
const FINER_MAX: usize = 8;

/// Parts that each of the timeline's steps of a run is taken in, and whether they resolve the
/// fastest rate.
pub(super) fn finer(
    (problem, run): (&Problem, usize),
    (plant, system, x0): (&Plant, &System, &[f64]),
    timeline: &Timeline,
) -> (usize, bool) {
    let mut visited = visited(problem, run, system, x0);
    visited.extend(in_contact(plant, system, x0));
    let inputs = system.inputs().len().min(timeline.rows.len());
    let fastest = fastest_rate(system, &visited, &timeline.rows[..inputs]);
    let longest = timeline.events.iter().map(|event| event.step_s).fold(0.0, f64::max);
    let stiff = fastest * longest;
    let parts = libm::ceil(stiff / STEP_RATE_MAX) as usize;
    (parts.clamp(1, FINER_MAX), parts <= FINER_MAX)
}

/// The initial state, and as the encoders' least and largest readings have it: a spring may be
/// stiffer there.
fn visited(problem: &Problem, run: usize, system: &System, x0: &[f64]) -> Vec<Vec<f64>> {
    let mut states = vec![x0.to_vec()];
    for largest in [false, true] {
        let mut x = x0.to_vec();
        for (sensor, samples) in problem.plant.sensors.iter().zip(&problem.runs[run].samples) {
            let SensorKind::Encoder { joint } = &sensor.kind else { continue };
            let name = format!("joint:{joint}");
            let place = system.states().iter().position(|state| state.name == name);
            let values = samples.value.iter().copied().filter(|value| value.is_finite());
            let end =
                if largest { values.fold(f64::NEG_INFINITY, f64::max) } else { values.fold(f64::INFINITY, f64::min) };
            if let Some(place) = place.filter(|_| end.is_finite()) {
                x[place] = end;
            }
        }
        if !states.contains(&x) {
            states.push(x);
        }
    }
    states
}

/// The initial state pressed against either flank of each clearance, as far again as it is wide.
fn in_contact(plant: &Plant, system: &System, x0: &[f64]) -> Vec<Vec<f64>> {
    let is_clearance = |used: &EffectUse| {
        let effect = plant.catalogue.effect(&used.kind);
        effect.is_some_and(|effect| effect.family == Family::Clearance)
    };
    if !plant.effects.iter().any(is_clearance) {
        return Vec::new();
    }
    let mut built = plant.clone();
    if apply_structures(&mut built).is_err() {
        return Vec::new();
    }
    let gap = |used: &EffectUse| {
        let effect = plant.catalogue.effect(&used.kind).filter(|effect| effect.family == Family::Clearance)?;
        let place = effect.parameters.iter().position(|parameter| parameter.role == Role::Width)?;
        let name = format!("joint:{}", used.site.name);
        let state = system.states().iter().position(|state| state.name == name)?;
        Some((state, values(effect, used).ok()?[place]))
    };
    let gaps = built.effects.iter().filter_map(gap);
    let pressed = |(state, width): (usize, f64)| {
        [-2.0, 2.0].map(|side| {
            let mut x = x0.to_vec();
            x[state] += side * width;
            x
        })
    };
    gaps.flat_map(pressed).collect()
}

/// Largest spectral radius at `states`, also at rest, where friction is steepest.
fn fastest_rate(system: &System, states: &[Vec<f64>], u: &[f64]) -> f64 {
    let mut ws = Workspace::<Dual>::new(system);
    let mut fastest = 0.0f64;
    for x in states.iter().filter(|x| !x.is_empty()) {
        let mut still = x.clone();
        for (x, state) in still.iter_mut().zip(system.states()) {
            if state.name.ends_with(".rate") {
                *x = 0.0;
            }
        }
        for x in [x, &still] {
            fastest = fastest.max(spectral_radius(system.linearise(&mut ws, 0.0, x, u).a));
        }
    }
    fastest
}

/// Longest step of integration for `plant` in its initial state.
pub(crate) fn step_s(system: &System, x0: &[f64]) -> f64 {
    let rate = fastest_rate(system, &[x0.to_vec()], &vec![0.0; system.inputs().len()]);
    if rate > 0.0 { STEP_RATE / rate } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use crate::filter::Propagator;
    use crate::fit::EstimationSession;
    use crate::synthetic::{plant, problem, recording, with_effect};

    #[test]
    fn the_steps_of_a_gap_in_which_a_motion_begins_are_those_of_its_flanks() {
        let nominal = plant("drive_rig");
        let problem = problem(&nominal, recording(&nominal, 3, 0.5));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let finer = |contact_rate: f64| {
            let values = [("half_gap", 1e-4), ("contact_rate", contact_rate)];
            let truth = with_effect(&nominal, "joint_backlash", "joint:drive", &values);
            Propagator::new(&problem, 0, &truth, &session.timelines[0]).unwrap().finer()
        };
        let longest = session.timelines[0].events.iter().map(|event| event.step_s).fold(0.0, f64::max);
        assert_eq!(finer(0.1 / longest), 1);
        assert!((4..=6).contains(&finer(2.0 / longest)), "{}", finer(2.0 / longest));
    }
}
