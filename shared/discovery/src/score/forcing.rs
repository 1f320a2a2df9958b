//! Effect of a small change of the equations on the innovations, without another pass of the
//! nonlinear filter.
//!
//! Along the filtered trajectory a change of the plant pushes the state by Δ over each interval and
//! the readings by δ. With the stored transitions Φ, rows H and frozen gains K of [`Linear`] the
//! rest is linear:
//!
//! ```text
//! δν_k = −(H d + δ_k),   d ← d + K δν,   d ← Φ d + Δ_k,
//! Δ_k ≈ h/2 (Φ (f̃ − f)(x_k⁺) + (f̃ − f)(x_{k+1}⁻))            trapezoid; error (ω h)²/12 of Δ
//! ```
//!
//! Exact to first order in the amplitude. Where an interval takes several steps of integration Δ is
//! the difference of two flows.

use super::kinetic::Kinetic;
use identification::filter::{Linear, Propagator};
use identification::problem::Timeline;

/// Pushes of the state (`tangent` numbers per event, over the interval behind it) and of the
/// readings (per sample).
#[derive(Clone, Debug)]
pub struct Sources {
    pub state: Vec<f64>,
    pub reading: Vec<f64>,
}

impl Sources {
    /// Neither the state nor a reading feels anything.
    pub fn is_silent(&self) -> bool {
        [&self.state, &self.reading].into_iter().flatten().all(|source| *source == 0.0)
    }
}

/// The propagators differ in parameter values alone: same states, same lags, same commands.
pub fn comparable(base: &Propagator<'_>, other: &Propagator<'_>) -> bool {
    base.layout == other.layout
        && base.same_lags(other)
        && base.x0 == other.x0
        && !other.filters_inputs()
        && !base.filters_inputs()
        && base.system.states().iter().zip(other.system.states()).all(|(a, b)| a.name == b.name)
        && base.system.states().len() == other.system.states().len()
}

/// The plant along the filtered trajectory of one run: evaluated once, it serves every change of
/// it.
pub struct Course<'a> {
    pub base: Propagator<'a>,
    linear: &'a Linear,
    /// Per event `x'` as its stretch begins and as it ends; where it takes several steps the end of
    /// the flow instead of the first.
    begin: Vec<f64>,
    end: Vec<f64>,
    /// Per sample.
    reading: Vec<f64>,
    pub(super) kinetic: Kinetic,
}

impl<'a> Course<'a> {
    /// Evaluates `base` along the trajectory of `linear`. Cost: two evaluations of the equations
    /// for each event.
    pub fn new(linear: &'a Linear, mut base: Propagator<'a>) -> Self {
        let (x, events) = (base.x0.len(), base.timeline.events.len());
        let mut reading = vec![0.0; base.timeline.value.len()];
        let (mut begin, mut end) = (vec![0.0; events * x], vec![0.0; events * x]);
        let mut mean = MeanBegin::new(linear, x);
        for k in 0..events {
            let event = base.timeline.events[k];
            mean.read(linear, &mut base, k, &mut reading[event.first..event.first + event.count]);
            mean.keep(linear, &base, k);
            if k + 1 < events {
                let own = k * x..(k + 1) * x;
                motion(linear, &mut base, k, (&mut begin[own.clone()], &mut end[own]));
            }
        }
        let kinetic = Kinetic::new(linear, &mut base);
        Self { base, linear, begin, end, reading, kinetic }
    }

    /// Sources of `other`, of the same run; `every`: only each such multiple of events. A change of
    /// `readings_alone` moves no state.
    pub fn sources(&self, other: &mut Propagator<'_>, readings_alone: bool, every: usize) -> Sources {
        let (linear, timeline) = (self.linear, self.base.timeline);
        let (n, x, m) = (linear.layout.tangent, self.base.x0.len(), linear.layout.noise_inputs.len());
        let events = timeline.events.len();
        let mut out = Sources { state: vec![0.0; events * n], reading: vec![0.0; timeline.value.len()] };
        let mut mean = MeanBegin::new(linear, x);
        let zeros = |n: usize| vec![0.0; n];
        let (mut begin, mut end, mut pushed) = (zeros(x), zeros(x), [zeros(n), zeros(n)]);
        for k in 0..events {
            let event = timeline.events[k];
            let is_wanted = k % every == 0;
            if is_wanted {
                let samples = event.first..event.first + event.count;
                let (theirs, ours) = (&mut out.reading[samples.clone()], &self.reading[samples]);
                mean.read(linear, other, k, theirs);
                theirs.iter_mut().zip(ours).for_each(|(theirs, ours)| *theirs -= ours);
            }
            mean.keep(linear, other, k);
            if !is_wanted || k + 1 == events || n == 0 || readings_alone {
                continue;
            }
            motion(linear, other, k, (&mut begin, &mut end));
            let push = &mut out.state[k * n..(k + 1) * n];
            let ours = [&self.begin[k * x..(k + 1) * x], &self.end[k * x..(k + 1) * x]];
            if event.steps > 1 {
                self.base.system.difference(ours[0], &begin, push);
                continue;
            }
            let states = [&linear.updated[k * x..(k + 1) * x], &linear.states[(k + 1) * x..(k + 2) * x]];
            for ((theirs, pushed), (ours, state)) in
                [&mut begin, &mut end].into_iter().zip(&mut pushed).zip(ours.into_iter().zip(states))
            {
                for (theirs, (ours, x)) in theirs.iter_mut().zip(ours.iter().zip(state)) {
                    *theirs = x + 0.5 * event.step_s * (*theirs - ours);
                }
                self.base.system.difference(state, theirs, pushed);
            }
            let transition = linear.transition[k * n * (n + m)..].chunks_exact(n + m);
            for ((push, row), end) in push.iter_mut().zip(transition).zip(&pushed[1]) {
                *push = row.iter().zip(&pushed[0]).map(|(f, d)| f * d).sum::<f64>() + end;
            }
        }
        out
    }
}

/// `x'` of `propagator` along the trajectory as the stretch behind event `k` begins and as it ends,
/// or the end of its flow.
fn motion(linear: &Linear, propagator: &mut Propagator<'_>, k: usize, (begin, end): (&mut [f64], &mut [f64])) {
    let (x, m) = (begin.len(), linear.layout.noise_inputs.len());
    let (after, held) = (&linear.updated[k * x..(k + 1) * x], &linear.held_updated[k * m..(k + 1) * m]);
    if propagator.timeline.events[k].steps > 1 {
        begin.copy_from_slice(after);
        propagator.flow(k, begin, held);
    } else {
        propagator.slope(k, false, after, held, begin);
        propagator.slope(k, true, &linear.states[(k + 1) * x..(k + 2) * x], held, end);
    }
}

/// Where the present mean began: state and row of inputs.
struct MeanBegin {
    x: Vec<f64>,
    row: usize,
}

impl MeanBegin {
    fn new(linear: &Linear, x: usize) -> Self {
        Self { x: linear.states[..x].to_vec(), row: 0 }
    }

    /// Readings of `propagator` along the trajectory at event `k`.
    fn read(&self, linear: &Linear, propagator: &mut Propagator<'_>, k: usize, out: &mut [f64]) {
        let (x, m) = (self.x.len(), linear.layout.noise_inputs.len());
        let (state, held) = (&linear.states[k * x..(k + 1) * x], &linear.held[k * m..(k + 1) * m]);
        propagator.read(k, state, held, (&self.x, self.row), out);
    }

    fn keep(&mut self, linear: &Linear, propagator: &Propagator<'_>, k: usize) {
        let (event, x) = (propagator.timeline.events[k], self.x.len());
        if event.begins_mean {
            self.x.copy_from_slice(&linear.updated[k * x..(k + 1) * x]);
            self.row = event.row;
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
    use crate::synthetic::{plant, problem, recording};
    use identification::fit::{EstimationSession, LinearisedProblem};

    /// Relative distance of the forced change from that of a full pass at a small amplitude.
    fn apart(name: &str, duration_s: f64, kind: &str, site: &str, values: &[(&str, f64)]) -> f64 {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&nominal, 3, duration_s));
        let session = EstimationSession::new(&problem, 1).unwrap();
        let theta = session.prior();
        let linearised = LinearisedProblem::new(&session, &nominal, &theta, &session.noise).unwrap();
        let mut with = nominal.clone();
        with.add_effect(kind, &site.parse().unwrap(), values).unwrap();
        let timeline = &session.timelines[0];
        let propagator = |plant: &dynamics::description::Plant| {
            Propagator::new(&problem, 0, &problem.instance(plant, &theta, 0), timeline).unwrap()
        };
        let (base, mut other) = (propagator(&nominal), propagator(&with));
        assert!(comparable(&base, &other));
        let linear = &linearised.linears[0];
        let forced = respond(linear, timeline, &Course::new(linear, base).sources(&mut other, false, 1));
        let full = session.innovations(&with, &theta, &linearised.linears, &|_| true).unwrap();
        let change: Vec<f64> = full.iter().zip(&linearised.nu).map(|(a, b)| a - b).collect();
        let distance: f64 = forced.iter().zip(&change).map(|(a, b)| (a - b) * (a - b)).sum();
        (distance / change.iter().map(|c| c * c).sum::<f64>()).sqrt()
    }

    #[test]
    fn forcing_is_what_a_pass_of_the_changed_plant_shows() {
        // the remainder is the trapezoid's (ω h)²/12 and the amplitude's second order
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
