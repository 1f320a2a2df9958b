//! Steps of integration that the fastest rate of a plant allows.
//!
//! A sign that turns over a small rate (dry friction) is stiff about the zero of that rate alone:
//! steps that come near it are finer, all others as fine as the rest of the plant asks for.

use crate::problem::{Problem, Timeline};
use dynamics::description::{EffectUse, Plant, SensorKind, Site, SiteKind};
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
/// Widths from the zero of a rate from which its sign stands: tanh is one there but for 2e-7.
const TURNED: f64 = 8.0;
/// Changes over a step, at the rate of its beginning, by which a rate may be nearer to its zero
/// than it begins: rates that a step resolves change by half of themselves, e^½ = 1.6.
const REACH: f64 = 2.0;
/// Share of the steps that a sign turns in, for what passes will cost. Chosen, no derivation.
const TURNING_SHARE: f64 = 0.25;

/// Parts that each of the timeline's steps of a run is taken in.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolution {
    /// Where a sign may turn, and elsewhere.
    pub turning: usize,
    pub elsewhere: usize,
    /// Rates over whose zero a sign turns: place in the state, and how near to zero it is felt.
    signs: Vec<(usize, f64)>,
    /// The fastest rate is resolved.
    pub is_resolved: bool,
}

impl Resolution {
    /// Of a run of `plant` in the steps of `timeline`.
    pub(super) fn of(
        (problem, run): (&Problem, usize),
        (plant, system, x0): (&Plant, &System, &[f64]),
        timeline: &Timeline,
    ) -> Self {
        let mut visited = visited(problem, run, system, x0);
        visited.extend(in_contact(plant, system, x0));
        let inputs = system.inputs().len().min(timeline.rows.len());
        let u = &timeline.rows[..inputs];
        let longest = timeline.events.iter().map(|event| event.step_s).fold(0.0, f64::max);
        let parts = |fastest: f64| libm::ceil(fastest * longest / STEP_RATE_MAX) as usize;
        let asked = parts(fastest_rate(system, &visited, u));
        let (turning, is_resolved) = (asked.clamp(1, FINER_MAX), asked <= FINER_MAX);
        let signs = if turning > 1 { signs(plant, system) } else { Vec::new() };
        if signs.is_empty() {
            return Self { turning, elsewhere: turning, signs, is_resolved };
        }
        let elsewhere = parts(spectral(system, &beyond(&visited, &signs), u)).clamp(1, turning);
        Self { turning, elsewhere, signs, is_resolved }
    }

    /// Steps are taken in as many parts wherever they begin.
    pub(super) fn is_even(&self) -> bool {
        self.turning == self.elsewhere
    }

    /// Parts of a step of length `h` that begins in `x` with the rates of change `x_dot`.
    pub(super) fn parts(&self, h: f64, x: &[f64], x_dot: &[f64]) -> usize {
        let turns = |(place, width): &(usize, f64)| x[*place].abs() < width + REACH * h * x_dot[*place].abs();
        if self.signs.iter().any(turns) { self.turning } else { self.elsewhere }
    }

    /// Parts of a step, about, on the mean of a run.
    pub(super) fn mean_parts(&self) -> f64 {
        let (turning, elsewhere) = (self.turning as f64, self.elsewhere as f64);
        elsewhere + TURNING_SHARE * (turning - elsewhere)
    }
}

/// Name of the state that is the rate of a site of one coordinate.
pub fn rate_of(site: &Site) -> String {
    match site.kind {
        SiteKind::Actuator => format!("wheel:{}", site.name),
        _ => format!("{site}.rate"),
    }
}

/// Rates of the state that a sign of one of the plant's effects turns over, and how near to zero.
fn signs(plant: &Plant, system: &System) -> Vec<(usize, f64)> {
    let sign = |used: &EffectUse| {
        let effect = plant.catalogue.effect(&used.kind)?;
        let smoothing = effect.parameters.iter().position(|parameter| parameter.role == Role::Smoothing)?;
        let rate = rate_of(&used.site);
        let place = system.states().iter().position(|state| state.name == rate)?;
        Some((place, TURNED * values(effect, used).ok()?[smoothing]))
    };
    plant.effects.iter().filter_map(sign).collect()
}

/// The same states with all signs turned, either way.
fn beyond(states: &[Vec<f64>], signs: &[(usize, f64)]) -> Vec<Vec<f64>> {
    let turned = |x: &Vec<f64>| {
        [-1.0, 1.0].map(|side| {
            let mut x = x.clone();
            signs.iter().for_each(|(place, width)| x[*place] = side * width);
            x
        })
    };
    states.iter().filter(|x| !x.is_empty()).flat_map(turned).collect()
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
    let still = |x: &Vec<f64>| {
        let mut still = x.clone();
        for (x, state) in still.iter_mut().zip(system.states()) {
            if state.name.ends_with(".rate") {
                *x = 0.0;
            }
        }
        [x.clone(), still]
    };
    let states: Vec<Vec<f64>> = states.iter().filter(|x| !x.is_empty()).flat_map(still).collect();
    spectral(system, &states, u)
}

/// Largest spectral radius at `states`.
fn spectral(system: &System, states: &[Vec<f64>], u: &[f64]) -> f64 {
    let mut ws = Workspace::<Dual>::new(system);
    let mut radius = |x: &Vec<f64>| spectral_radius(system.linearise(&mut ws, 0.0, x, u).a);
    states.iter().map(&mut radius).fold(0.0, f64::max)
}

/// Longest step of integration for `plant` in its initial state.
pub(crate) fn step_s(system: &System, x0: &[f64]) -> f64 {
    let rate = fastest_rate(system, &[x0.to_vec()], &vec![0.0; system.inputs().len()]);
    if rate > 0.0 { STEP_RATE / rate } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::Resolution;
    use crate::filter::Propagator;
    use crate::fit::EstimationSession;
    use crate::synthetic::{plant, problem, recording, with_effect};

    #[test]
    fn steps_are_fine_where_a_sign_turns_alone_and_the_motion_is_that_of_fine_steps() {
        let nominal = plant("drive_rig");
        let problem = problem(&nominal, recording(&nominal, 3, 4.0));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let truth = with_effect(&nominal, "joint_coulomb", "joint:drive", &[("force", 0.3), ("smooth_rate", 1e-3)]);
        let mut local = Propagator::new(&problem, 0, &truth, &session.timelines[0]).unwrap();
        let mut fine = Propagator::new(&problem, 0, &truth, &session.timelines[0]).unwrap();
        let turning = local.finer();
        assert!(turning > 2 && !local.resolution.is_even());
        fine.resolution = Resolution { elsewhere: turning, ..fine.resolution };
        let ([mut x, mut y], w) = ([local.x0.clone(), local.x0.clone()], vec![0.0; local.layout.noise_inputs.len()]);
        let mut apart = 0.0f64;
        for k in 0..session.timelines[0].events.len() - 1 {
            local.flow(k, &mut x, &w);
            fine.flow(k, &mut y, &w);
            apart = x.iter().zip(&y).map(|(x, y)| (x - y).abs()).fold(apart, f64::max);
        }
        let (spent, all) = (local.evaluations, fine.evaluations);
        assert!(2 * spent < all, "{spent} of {all}");
        let size = local.reach().into_iter().fold(0.0, f64::max);
        assert!(size > 0.1 && apart < 1e-6 * size, "{apart} of {size}");
    }

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
