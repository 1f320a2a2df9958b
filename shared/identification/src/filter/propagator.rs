//! One run of one plant variant: flow between events, readings at events, the pass with frozen
//! gains.

use super::attitude::{Attitude, attitudes};
use super::{Layout, equip};
use crate::problem::{Problem, Timeline};
use crate::work::{of_evaluations, of_products, of_whitening};
use channel::{Channel, channel};
use dynamics::description::Plant;
use dynamics::system::{RungeKutta, System, Workspace};
use filtered_inputs::filtered_rows;
use stiffness::finer;

mod channel;
mod filtered_inputs;
mod lagged;
mod pass;
mod places;
mod point;
mod readings;
mod stiffness;

pub use pass::Mean;
pub use point::Point;
pub(crate) use stiffness::step_s;

/// A compiled plant with the timeline of one run.
pub struct Propagator<'a> {
    pub system: System,
    pub timeline: &'a Timeline,
    pub layout: Layout,
    pub x0: Vec<f64>,
    ws: Workspace<f64>,
    /// Inputs after delays and lags; empty: the timeline's.
    rows: Vec<f64>,
    /// Change of every input from the beginning of an event's stretch to its end, about the row;
    /// empty: none.
    tilts: Vec<f64>,
    pub(super) finer: usize,
    is_resolved: bool,
    sensors: Vec<Channel>,
    any_mean: bool,
    any_shifted: bool,
    integrator: RungeKutta,
    stage: Vec<f64>,
    u: Vec<f64>,
    u_end: Vec<f64>,
    y: Vec<f64>,
    /// Readings half an interval before an event, and right before it.
    y_middle: Vec<f64>,
    y_to: Vec<f64>,
    x_at: Vec<f64>,
    x_begin: Vec<f64>,
    /// Rotation vectors among the sensors.
    attitudes: Vec<Attitude>,
    /// Of the equations of motion, so far.
    evaluations: usize,
}

/// Inputs that change during a step.
#[derive(Clone, Copy)]
pub(super) struct Moving<'w> {
    /// First of the three rows of the step, or the row of the event.
    row: usize,
    /// Share of the step (of the event's stretch) already done, and what this step does.
    from: f64,
    span: f64,
    w: &'w [f64],
}

impl<'a> Propagator<'a> {
    /// Propagator of `plant` (not yet equipped) for run `run`.
    ///
    /// # Errors
    /// The plant cannot be compiled or its initial state names what does not exist.
    pub fn new(problem: &Problem, run: usize, plant: &Plant, timeline: &'a Timeline) -> Result<Self, String> {
        let equipped = equip(plant);
        let system = System::new(&equipped).map_err(|error| error.to_string())?;
        let initial = &problem.runs[run].initial;
        let x0 = initial_state(&system, plant, initial)?;
        let sensors: Vec<Channel> =
            equipped.sensors.iter().enumerate().map(|(i, s)| channel(&equipped, &system, s, i)).collect();
        let mut layout = Layout { tangent: system.tangent_len(), ..Layout::default() };
        let command = |u: &dynamics::system::InputName| u.role == dynamics::system::InputRole::Command;
        layout.noise_inputs = (0..system.inputs().len()).filter(|i| command(&system.inputs()[*i])).collect();
        for sensor in &sensors {
            layout.lag_of.push(sensor.lag.as_ref().map(|_| layout.lags));
            layout.lags += usize::from(sensor.lag.is_some());
        }
        let any_mean = sensors.iter().any(|sensor| sensor.mean);
        layout.clone = if any_mean { layout.tangent } else { 0 };
        layout.colour_of = vec![None; sensors.len()];
        let (n, m, p) = (system.states().len(), system.inputs().len(), sensors.len());
        let (finer, is_resolved) = finer((problem, run), (&equipped, &system, &x0), timeline);
        let rows = timeline.rows_of(problem, &problem.runs[run], &equipped, &system).unwrap_or_default();
        let (rows, tilts) = filtered_rows(&system, timeline, rows);
        let zeros = |n: usize| vec![0.0; n];
        let any_shifted = sensors.iter().zip(&timeline.shift_s).any(|(s, shift)| s.shifted(*shift));
        Ok(Self {
            ws: Workspace::new(&system),
            timeline,
            layout,
            x0,
            rows,
            finer,
            is_resolved,
            tilts,
            any_mean,
            any_shifted,
            sensors,
            integrator: RungeKutta::new(n),
            stage: zeros(n),
            u: zeros(m),
            u_end: zeros(m),
            y: zeros(p),
            y_middle: zeros(p),
            y_to: zeros(p),
            x_at: zeros(n),
            x_begin: zeros(n),
            attitudes: attitudes(&equipped),
            evaluations: 0,
            system,
        })
    }

    /// Work of a pass with frozen gains that is still to be done.
    pub fn pass_work(&self) -> f64 {
        let parts: usize = self.timeline.events.iter().map(|event| event.steps).sum::<usize>() * self.finer;
        of_evaluations(4 * parts, &self.system)
    }

    /// Work of a linear model of the run, of `unknowns` passes beside it, and of their products; a
    /// transition costs a third of its flows.
    pub fn round_work(&self, unknowns: usize) -> f64 {
        let (n, m, z) = (self.layout.tangent, self.layout.noise_inputs.len(), self.layout.len());
        let (events, samples) = (self.timeline.events.len(), self.timeline.value.len());
        let flows = (n + m + self.layout.clone + 1).div_ceil(3) + unknowns + 1;
        let white = of_whitening([n, m, z], [events, samples], unknowns + 1) + of_products(samples, unknowns + 1);
        flows as f64 * self.pass_work() + self.recursion_work() + white
    }

    /// Its steps are short against its fastest rate.
    pub fn is_resolved(&self) -> bool {
        self.is_resolved
    }

    /// Steps of integration for each of the timeline's.
    pub fn finer(&self) -> usize {
        self.finer
    }

    /// Work that this propagator has done.
    pub fn work(&self) -> f64 {
        of_evaluations(self.evaluations, &self.system)
    }

    /// Work of the recursion of gains beside it.
    pub fn recursion_work(&self) -> f64 {
        let (n, m, z) = (self.layout.tangent, self.layout.noise_inputs.len(), self.layout.len());
        of_whitening([n, m, z], [self.timeline.events.len(), self.timeline.value.len()], 1)
    }

    /// The run begins elsewhere than at the mean of the prior.
    pub fn begin(&mut self, change: &[f64]) {
        let mean = self.x0.clone();
        self.system.retract(&mean, change, &mut self.x0);
    }

    /// How far each number of a change of state goes from the start under the commands alone.
    pub fn reach(&mut self) -> Vec<f64> {
        let (w, start) = (vec![0.0; self.layout.noise_inputs.len()], self.x0.clone());
        let (mut x, mut change) = (start.clone(), vec![0.0; self.layout.tangent]);
        let mut reach = vec![0.0f64; self.layout.tangent];
        for k in 0..self.timeline.events.len().saturating_sub(1) {
            self.flow(k, &mut x, &w);
            self.system.difference(&start, &x, &mut change);
            reach.iter_mut().zip(&change).for_each(|(reach, change)| *reach = reach.max(change.abs()));
        }
        reach
    }

    /// Input `input` as event `k` begins its stretch, or as it ends it, past the plant's own delays
    /// and lags; of an input that is held between events its mean.
    pub fn acting(&self, k: usize, end: bool, input: usize) -> f64 {
        let event = self.timeline.events[k];
        let moved = if end && self.timeline.moving { 2 * event.steps } else { 0 };
        self.row(event.row + moved)[input]
    }

    fn row(&self, index: usize) -> &[f64] {
        let rows = if self.rows.is_empty() { &self.timeline.rows } else { &self.rows };
        let inputs = self.timeline.inputs;
        &rows[index * inputs..(index + 1) * inputs]
    }

    fn load(&mut self, index: usize, w: &[f64]) {
        let inputs = self.timeline.inputs;
        let rows = if self.rows.is_empty() { &self.timeline.rows } else { &self.rows };
        self.u.copy_from_slice(&rows[index * inputs..(index + 1) * inputs]);
        for (input, w) in self.layout.noise_inputs.iter().zip(w) {
            self.u[*input] += w;
        }
    }

    /// `x'` in state `x` as event `k` begins its stretch, or as it ends it.
    pub fn slope(&mut self, k: usize, end: bool, x: &[f64], w: &[f64], out: &mut [f64]) {
        let event = self.timeline.events[k];
        let row = event.row + if end && self.timeline.moving { 2 * event.steps } else { 0 };
        self.load(row, w);
        let t_s = if end { event.t_s + event.step_s * event.steps as f64 } else { event.t_s };
        self.evaluations += 1;
        let Self { system, ws, u, .. } = self;
        system.derivative(ws, t_s, x, u, out);
    }

    /// Every channel lags as it does in `other`.
    pub fn same_lags(&self, other: &Propagator<'_>) -> bool {
        self.sensors.iter().zip(&other.sensors).all(|(a, b)| a.lag == b.lag)
    }

    /// Commands of this plant are filtered on their way.
    pub fn filters_inputs(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Moves `x` from event `k` to the next.
    pub fn flow(&mut self, k: usize, x: &mut [f64], w: &[f64]) {
        (0..self.parts(k)).for_each(|part| self.advance(k, part, x, w));
    }

    /// Steps of integration behind event `k`.
    pub(super) fn parts(&self, k: usize) -> usize {
        self.timeline.events[k].steps * self.finer
    }

    /// Moves `x` over one part of the stretch behind event `k`.
    pub(super) fn advance(&mut self, k: usize, part: usize, x: &mut [f64], w: &[f64]) {
        let (t, h, moving) = self.part(k, part, w);
        if moving.is_none() {
            self.load(self.timeline.events[k].row, w);
        }
        self.integrate(t, h, x, moving);
    }

    /// `x'` in state `x` in the middle of a part.
    pub(super) fn slope_within(&mut self, k: usize, part: usize, x: &[f64], w: &[f64], out: &mut [f64]) {
        let (t, h, moving) = self.part(k, part, w);
        match moving {
            Some(moving) => self.interpolate(moving.row, moving.from + 0.5 * moving.span, w),
            None => self.load(self.timeline.events[k].row, w),
        }
        self.evaluations += 1;
        let Self { system, ws, u, .. } = self;
        system.derivative(ws, t + 0.5 * h, x, u, out);
    }

    /// Beginning and length \[s\] of a part of the stretch behind event `k`, and the inputs that
    /// change during it.
    pub(super) fn part<'w>(&self, k: usize, part: usize, w: &'w [f64]) -> (f64, f64, Option<Moving<'w>>) {
        let event = self.timeline.events[k];
        let (step, within, parts) = (part / self.finer, part % self.finer, self.finer as f64);
        let h = event.step_s / parts;
        let t = event.t_s + step as f64 * event.step_s + within as f64 * h;
        let from = within as f64 / parts;
        let moving = if !self.timeline.moving && self.tilts.is_empty() {
            None
        } else if self.timeline.moving {
            Some(Moving { row: event.row + 2 * step, from, span: 1.0 / parts, w })
        } else {
            let steps = event.steps as f64;
            Some(Moving { row: event.row, from: (step as f64 + from) / steps, span: 1.0 / (steps * parts), w })
        };
        (t, h, moving)
    }

    /// State in the middle of the step that was taken last, which began in `x`; to third order in
    /// its length `h`.
    pub(super) fn middle(&self, x: &[f64], h: f64, out: &mut [f64]) {
        self.integrator.middle(x, h, out);
    }

    /// One step.
    fn integrate(&mut self, t: f64, h: f64, x: &mut [f64], moving: Option<Moving<'_>>) {
        self.evaluations += 4;
        let mut integrator = std::mem::take(&mut self.integrator);
        integrator.step(h, x, |share, stage, x_dot| {
            if let Some(moving) = moving {
                self.interpolate(moving.row, moving.from + share * moving.span, moving.w);
            }
            let Self { system, ws, u, .. } = self;
            system.derivative(ws, t + share * h, stage, u, x_dot);
        });
        self.integrator = integrator;
        self.system.normalise(x);
    }

    /// Inputs at a share of a step from its three rows (parabola), or at a share of an event's
    /// stretch from its row and tilt.
    fn interpolate(&mut self, row: usize, share: f64, w: &[f64]) {
        let weights = [(1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0)];
        let inputs = self.timeline.inputs;
        for i in 0..inputs {
            self.u[i] = if self.timeline.moving {
                (0..3).map(|k| weights[k] * self.row(row + k)[i]).sum()
            } else {
                self.row(row)[i] + (share - 0.5) * self.tilts[row * inputs + i]
            };
        }
        for (input, w) in self.layout.noise_inputs.iter().zip(w) {
            self.u[*input] += w;
        }
    }
}

fn initial_state(system: &System, plant: &Plant, initial: &dynamics::description::Initial) -> Result<Vec<f64>, String> {
    let mut initial = initial.clone();
    let prescribed = |coordinate: &str| {
        plant.actuators.iter().any(|a| match &a.kind {
            dynamics::description::ActuatorKind::PrescribedJoint { joint, .. } => {
                coordinate == format!("joint:{joint}")
            }
            _ => false,
        })
    };
    initial.values.retain(|value| !prescribed(&value.coordinate));
    system.initial_state(&initial, &|_| None).map_err(|error| error.to_string())
}
