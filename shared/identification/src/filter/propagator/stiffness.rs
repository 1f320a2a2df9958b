//! Steps of integration that the fastest rate of a plant allows.

use crate::problem::{Problem, Timeline};
use dynamics::description::SensorKind;
use dynamics::dual::Dual;
use dynamics::system::{System, Workspace, spectral_radius};

/// Product of step and fastest rate that a step of integration keeps to, and the one beyond which a
/// variant takes finer steps: Runge–Kutta is off by (ω h)⁵/120 of the amplitude a step, 9e-5 and
/// 3e-4.
const STEP_RATE: f64 = 0.4;
const STEP_RATE_MAX: f64 = 0.5;
/// Finest subdivision of a step for a stiff variant.
const FINER_MAX: usize = 8;

/// Parts that each of the timeline's steps of a run is taken in.
pub(super) fn finer((problem, run): (&Problem, usize), (system, x0): (&System, &[f64]), timeline: &Timeline) -> usize {
    let visited = visited(problem, run, system, x0);
    let inputs = system.inputs().len().min(timeline.rows.len());
    let fastest = fastest_rate(system, &visited, &timeline.rows[..inputs]);
    let longest = timeline.events.iter().map(|event| event.step_s).fold(0.0, f64::max);
    let stiff = fastest * longest;
    if stiff > STEP_RATE_MAX { (libm::ceil(stiff / STEP_RATE_MAX) as usize).min(FINER_MAX) } else { 1 }
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
