//! What a small change of the equations does to the innovations, without another pass of the nonlinear filter.
//!
//! Along the filtered trajectory a change of the plant pushes the state by Δ over each interval and the readings by δ. With the stored
//! transitions Φ, rows H and frozen gains K of [`Linear`] the rest is linear:
//!
//! ```text
//! δν_k = −(H d + δ_k),   d ← d + K δν,   d ← Φ d + Δ_k,
//! Δ_k ≈ h/2 (Φ (f̃ − f)(x_k⁺) + (f̃ − f)(x_{k+1}⁻))            trapezoid; error (ω h)²/12 of Δ
//! ```
//!
//! Exact to first order in the amplitude. Where an interval takes several steps of integration Δ is the difference of two flows.

use crate::filter::{Linear, Machine};
use crate::problem::Timeline;

/// Pushes of the state (`tangent` numbers per event, over the interval behind it) and of the readings (per sample).
#[derive(Clone, Debug)]
pub struct Sources {
    pub state: Vec<f64>,
    pub reading: Vec<f64>,
}

/// The machines differ in numbers alone: same states, same lags, same commands.
pub fn comparable(base: &Machine<'_>, other: &Machine<'_>) -> bool {
    base.layout == other.layout
        && base.same_lags(other)
        && base.x0 == other.x0
        && !other.filters_inputs()
        && !base.filters_inputs()
        && base.system.states().iter().zip(other.system.states()).all(|(a, b)| a.name == b.name)
        && base.system.states().len() == other.system.states().len()
}

/// Sources of `other` against `base`, both machines of the run that `linear` belongs to; `every`: only each so-manieth event.
pub fn sources(linear: &Linear, base: &mut Machine<'_>, other: &mut Machine<'_>, every: usize) -> Sources {
    let timeline = base.timeline;
    let (n, x, m) = (linear.layout.tangent, base.x0.len(), linear.layout.noise_inputs.len());
    let events = timeline.events.len();
    let mut out = Sources { state: vec![0.0; events * n], reading: vec![0.0; timeline.value.len()] };
    let widest = timeline.events.iter().map(|event| event.count).max().unwrap_or(0).max(linear.layout.lag_of.len());
    let mut scratch = Scratch::new(x, n, widest);
    let mut clone = (linear.states[..x].to_vec(), 0);
    for k in (0..events).step_by(every) {
        let event = timeline.events[k];
        let before = &linear.states[k * x..(k + 1) * x];
        if event.count > 0 {
            let held = &linear.held[k * m..(k + 1) * m];
            base.read(k, before, held, (&clone.0, clone.1), &mut scratch.ours);
            other.read(k, before, held, (&clone.0, clone.1), &mut scratch.theirs);
            for slot in 0..event.count {
                out.reading[event.first + slot] = scratch.theirs[slot] - scratch.ours[slot];
            }
        }
        let after = &linear.updated[k * x..(k + 1) * x];
        if event.begins_mean {
            clone.0.copy_from_slice(after);
            clone.1 = event.row;
        }
        if k + 1 < events && n > 0 {
            let held = &linear.held_updated[k * m..(k + 1) * m];
            let push = &mut out.state[k * n..(k + 1) * n];
            if event.steps > 1 {
                scratch.flows(base, other, k, (after, held), push);
            } else {
                let next = &linear.states[(k + 1) * x..(k + 2) * x];
                let transition = &linear.transition[k * n * (n + m)..(k + 1) * n * (n + m)];
                scratch.trapezoid((base, other), k, (after, next, held), (transition, n + m), push);
            }
        }
    }
    out
}

struct Scratch {
    ours: Vec<f64>,
    theirs: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    begin: Vec<f64>,
    end: Vec<f64>,
}

impl Scratch {
    fn new(x: usize, n: usize, widest: usize) -> Self {
        let zeros = |n: usize| vec![0.0; n];
        Self { ours: zeros(widest), theirs: zeros(widest), a: zeros(x), b: zeros(x), begin: zeros(n), end: zeros(n) }
    }

    fn flows(
        &mut self,
        base: &mut Machine<'_>,
        other: &mut Machine<'_>,
        k: usize,
        (from, held): (&[f64], &[f64]),
        push: &mut [f64],
    ) {
        self.a.copy_from_slice(from);
        self.b.copy_from_slice(from);
        base.flow(k, &mut self.a, held);
        other.flow(k, &mut self.b, held);
        base.system.difference(&self.a, &self.b, push);
    }

    fn trapezoid(
        &mut self,
        (base, other): (&mut Machine<'_>, &mut Machine<'_>),
        k: usize,
        (from, to, held): (&[f64], &[f64], &[f64]),
        (transition, row): (&[f64], usize),
        push: &mut [f64],
    ) {
        let half = 0.5 * base.timeline.events[k].step_s;
        for (state, end, out) in [(from, false, 0), (to, true, 1)] {
            base.slope(k, end, state, held, &mut self.a);
            other.slope(k, end, state, held, &mut self.b);
            for (b, (a, x)) in self.b.iter_mut().zip(self.a.iter().zip(state)) {
                *b = x + half * (*b - a);
            }
            let out = if out == 0 { &mut self.begin } else { &mut self.end };
            base.system.difference(state, &self.b, out);
        }
        for (i, push) in push.iter_mut().enumerate() {
            let carried: f64 = transition[i * row..].iter().zip(&self.begin).map(|(f, d)| f * d).sum();
            *push = carried + self.end[i];
        }
    }
}

/// Change of the frozen filter's innovations under `sources`.
pub fn respond(linear: &Linear, timeline: &Timeline, sources: &Sources) -> Vec<f64> {
    let layout = &linear.layout;
    let (n, m, c, s) = (layout.tangent, layout.noise_inputs.len(), layout.clone, layout.len());
    let (row_len, len) = (n + m + c, n + m);
    let mut change = vec![0.0; timeline.value.len()];
    let (mut d, mut next) = (vec![0.0; s], vec![0.0; n]);
    for (k, event) in timeline.events.iter().enumerate() {
        for i in 0..m {
            if event.reset >> layout.noise_inputs[i].min(63) & 1 == 1 {
                d[n + i] = 0.0;
            }
        }
        if event.count > 0 {
            for slot in 0..event.count {
                let sample = event.first + slot;
                let row = &linear.measurement[sample * row_len..(sample + 1) * row_len];
                let direct: f64 = sources.reading[sample]
                    + row[..len].iter().zip(&d).map(|(h, d)| h * d).sum::<f64>()
                    + row[len..].iter().zip(&d[layout.clone_at()..]).map(|(h, d)| h * d).sum::<f64>();
                let felt = match layout.lag_of[timeline.channel[sample]] {
                    None => direct,
                    Some(place) => {
                        let at = layout.lags_at() + place;
                        d[at] = linear.decay[sample] * d[at] + (1.0 - linear.decay[sample]) * direct;
                        d[at]
                    }
                };
                change[sample] = -felt;
            }
            let gain = &linear.frozen.gain[linear.frozen.first[k]..];
            let felt = &change[event.first..event.first + event.count];
            for (i, d) in d.iter_mut().enumerate().take(linear.frozen.rows) {
                *d += gain[i * event.count..].iter().zip(felt).map(|(g, f)| g * f).sum::<f64>();
            }
        }
        if event.begins_mean && c > 0 {
            for i in 0..n {
                d[layout.clone_at() + i] = d[i];
            }
        }
        if k + 1 < timeline.events.len() {
            let transition = &linear.transition[k * n * len..(k + 1) * n * len];
            for (i, next) in next.iter_mut().enumerate() {
                let carried: f64 = transition[i * len..(i + 1) * len].iter().zip(&d).map(|(f, d)| f * d).sum();
                *next = carried + sources.state[k * n + i];
            }
            d[..n].copy_from_slice(&next);
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Board, Engine};
    use crate::synthetic::{plant, problem, recording};

    /// Relative distance of the forced change from that of a full pass at a small amplitude.
    fn apart(name: &str, duration_s: f64, kind: &str, site: &str, values: &[(&str, f64)]) -> f64 {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&nominal, 3, duration_s));
        let engine = Engine::new(&problem, 1).unwrap();
        let theta = engine.prior();
        let board = Board::new(&engine, &nominal, &theta, &engine.noise).unwrap();
        let mut with = nominal.clone();
        with.add_effect(kind, &site.parse().unwrap(), values).unwrap();
        let timeline = &engine.timelines[0];
        let machine = |plant: &plant::description::Plant| {
            Machine::new(&problem, 0, &problem.instance(plant, &theta, 0), timeline).unwrap()
        };
        let (mut base, mut other) = (machine(&nominal), machine(&with));
        assert!(comparable(&base, &other));
        let linear = &board.linears[0];
        let forced = respond(linear, timeline, &sources(linear, &mut base, &mut other, 1));
        let full = engine.innovations(&with, &theta, &board.linears, &|_| true).unwrap();
        let change: Vec<f64> = full.iter().zip(&board.nu).map(|(a, b)| a - b).collect();
        let distance: f64 = forced.iter().zip(&change).map(|(a, b)| (a - b) * (a - b)).sum();
        (distance / change.iter().map(|c| c * c).sum::<f64>()).sqrt()
    }

    #[test]
    fn forcing_is_what_a_pass_of_the_changed_plant_shows() {
        // what is left is the trapezoid's (ω h)²/12 and the amplitude's second order
        let viscous = apart("pendulum", 8.0, "joint_quadratic_damping", "joint:pivot", &[("damping", 1e-6)]);
        assert!(viscous < 0.02, "{viscous}");
        let stiffness = apart("pendulum", 8.0, "joint_cubic_stiffness", "joint:pivot", &[("stiffness", 1e-6)]);
        assert!(stiffness < 0.02, "{stiffness}");
        let scale = apart("drive_rig", 1.0, "sensor_scale", "sensor:rate", &[("error", 1e-6)]);
        assert!(scale < 0.02, "{scale}");
        let mass = apart("oscillator", 1.0, "mass_error", "body:carriage", &[("error", 1e-6)]);
        assert!(mass < 0.02, "{mass}");
    }
}
