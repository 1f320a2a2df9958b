//! One run of one plant variant: flow between events, readings at events, the pass with frozen gains.

use super::attitude::{Attitude, attitudes};
use super::{Layout, equip, tangent_names};
use crate::problem::{Problem, Timeline};
use crate::work::{of_evaluations, of_whitening};
use dynamics::description::{Plant, Reading, Sensor, SensorKind};
use dynamics::dual::Dual;
use dynamics::lags::{FilterKind, Gate, Lag, LagState};
use dynamics::system::{FilterPlace, System, Workspace, spectral_radius};

/// Product of step and fastest rate that a step of integration keeps to, and the one beyond which a variant takes finer steps.
const STEP_RATE: f64 = 0.4;
const STEP_RATE_MAX: f64 = 0.5;
/// Finest subdivision of a step for a stiff variant.
const FINER_MAX: usize = 8;

/// Frozen gains of one run: per event rows of z times columns of samples, one after the other, and their first places.
#[derive(Clone, Debug, Default)]
pub struct Frozen {
    pub rows: usize,
    pub gain: Vec<f64>,
    /// Of each event.
    pub first: Vec<usize>,
}

/// A compiled plant with the timeline of one run.
pub struct Machine<'a> {
    pub system: System,
    pub timeline: &'a Timeline,
    pub layout: Layout,
    pub x0: Vec<f64>,
    ws: Workspace<f64>,
    /// Inputs after delays and lags; empty: the timeline's.
    rows: Vec<f64>,
    /// Change of every input from the beginning of an event's stretch to its end, about the row; empty: none.
    tilts: Vec<f64>,
    pub(super) finer: usize,
    pub(super) sensors: Vec<Channel>,
    any_mean: bool,
    any_shifted: bool,
    slopes: [Vec<f64>; 4],
    stage: Vec<f64>,
    u: Vec<f64>,
    u_end: Vec<f64>,
    y: Vec<f64>,
    x_at: Vec<f64>,
    x_begin: Vec<f64>,
    /// Rotation vectors among the sensors.
    attitudes: Vec<Attitude>,
    /// Of the equations of motion, so far.
    evaluations: usize,
}

pub(super) struct Channel {
    pub(super) mean: bool,
    /// Stamp = (1 + skew) t + offset; delay on top.
    offset_s: f64,
    skew: f64,
    delay_s: f64,
    delay_is_unknown: bool,
    pub(super) lag: Option<Lag>,
}

/// What the pass carries from event to event.
#[derive(Clone, Debug)]
pub struct Mean {
    pub x: Vec<f64>,
    pub w: Vec<f64>,
    pub clone: Vec<f64>,
    pub clone_row: usize,
    pub lag: Vec<LagState>,
    /// Last reading before the lag, and whether there was one.
    pub lag_input: Vec<f64>,
    pub lag_started: Vec<bool>,
    pub lag_time_s: Vec<f64>,
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

impl<'a> Machine<'a> {
    /// Machine of `plant` (not yet equipped) for run `run`.
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
        let visited = visited(problem, run, &system, &x0);
        let fastest = fastest_rate(&system, &visited, &timeline.rows[..m.min(timeline.rows.len())]);
        let longest = timeline.events.iter().map(|event| event.step_s).fold(0.0, f64::max);
        let stiff = fastest * longest;
        let finer = if stiff > STEP_RATE_MAX { (libm::ceil(stiff / STEP_RATE_MAX) as usize).min(FINER_MAX) } else { 1 };
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
            tilts,
            any_mean,
            any_shifted,
            sensors,
            slopes: [zeros(n), zeros(n), zeros(n), zeros(n)],
            stage: zeros(n),
            u: zeros(m),
            u_end: zeros(m),
            y: zeros(p),
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

    /// Steps of integration for each of the timeline's.
    pub fn finer(&self) -> usize {
        self.finer
    }

    /// Work that this machine has done.
    pub fn work(&self) -> f64 {
        of_evaluations(self.evaluations, &self.system)
    }

    /// Work of the recursion of gains beside it.
    pub fn recursion_work(&self) -> f64 {
        let (n, m, z) = (self.layout.tangent, self.layout.noise_inputs.len(), self.layout.len());
        of_whitening([n, m, z], [self.timeline.events.len(), self.timeline.value.len()], 1)
    }

    pub fn start(&self) -> Mean {
        let channels = self.sensors.len();
        Mean {
            x: self.x0.clone(),
            w: vec![0.0; self.layout.noise_inputs.len()],
            clone: self.x0.clone(),
            clone_row: 0,
            lag: vec![LagState::default(); channels],
            lag_input: vec![0.0; channels],
            lag_started: vec![false; channels],
            lag_time_s: vec![0.0; channels],
        }
    }

    /// The run begins elsewhere than at the mean of the prior.
    pub fn begin(&mut self, change: &[f64]) {
        let mean = self.x0.clone();
        self.system.retract(&mean, change, &mut self.x0);
    }

    /// The run begins where the pass of `linear` began and, where the states are the same, is integrated in the same steps; `map` gives
    /// the place of its numbers in a change of state here.
    pub fn begin_as(&mut self, linear: &super::Linear, map: &[usize]) {
        if self.layout == linear.layout {
            // another division of a step is a jump that no derivative may see
            self.finer = linear.finer;
        }
        let mut change = vec![0.0; self.layout.tangent];
        linear.start.iter().zip(map).for_each(|(start, at)| change[*at] = *start);
        self.begin(&change);
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

    /// Input `input` as event `k` begins its stretch, or as it ends it, past the plant's own delays and lags; of an input that is held between
    /// events its mean.
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
    pub fn same_lags(&self, other: &Machine<'_>) -> bool {
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
        self.runge_kutta(t, h, x, moving);
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

    /// Beginning and length [s] of a part of the stretch behind event `k`, and the inputs that change during it.
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

    /// State in the middle of the step that was taken last, which began in `x`; to third order in its length `h`.
    pub(super) fn middle(&self, x: &[f64], h: f64, out: &mut [f64]) {
        for (out, (x, slope)) in out.iter_mut().zip(x.iter().zip(&self.slopes[1])) {
            *out = x + 0.5 * h * slope;
        }
    }

    /// One step.
    fn runge_kutta(&mut self, t: f64, h: f64, x: &mut [f64], moving: Option<Moving<'_>>) {
        self.evaluations += 4;
        for k in 0..4 {
            let share = [0.0, 0.5, 0.5, 1.0][k];
            if let Some(moving) = moving {
                self.interpolate(moving.row, moving.from + share * moving.span, moving.w);
            }
            if k == 0 {
                self.stage.copy_from_slice(x);
            } else {
                let slope = &self.slopes[k - 1];
                for (stage, (x, slope)) in self.stage.iter_mut().zip(x.iter().zip(slope)) {
                    *stage = x + share * h * slope;
                }
            }
            let Self { system, ws, stage, u, slopes, .. } = self;
            system.derivative(ws, t + share * h, stage, u, &mut slopes[k]);
        }
        let [a, b, c, d] = &self.slopes;
        for (i, x) in x.iter_mut().enumerate() {
            *x += (a[i] + 2.0 * (b[i] + c[i]) + d[i]) * (h / 6.0);
        }
        self.system.normalise(x);
    }

    /// Inputs at a share of a step from its three rows (parabola), or at a share of an event's stretch from its row and tilt.
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

    /// Readings of the samples of event `k` before lags, into `out` (one per sample). `clone` is the state at the beginning of means.
    pub fn read(&mut self, k: usize, x: &[f64], w: &[f64], clone: (&[f64], usize), out: &mut [f64]) {
        let event = self.timeline.events[k];
        if event.count == 0 {
            return;
        }
        let samples = event.first..event.first + event.count;
        let channels = &self.timeline.channel[samples.clone()];
        if channels.iter().any(|c| !self.sensors[*c].mean) {
            self.load(event.row, w);
            let Self { system, ws, u, y, .. } = self;
            system.read(ws, event.t_s, x, u, y);
            for (out, channel) in out.iter_mut().zip(&self.timeline.channel[samples.clone()]) {
                *out = self.y[*channel];
            }
        }
        for (slot, sample) in samples.enumerate() {
            let channel = self.timeline.channel[sample];
            let behind = if self.any_shifted { self.behind(sample, channel) } else { 0.0 };
            if self.tells_nothing(k, channel) {
                out[slot] = self.timeline.value[sample];
            } else if self.sensors[channel].mean {
                out[slot] = self.read_mean(k, sample, behind, x, w, clone);
            } else if behind != 0.0 {
                out[slot] = self.read_at(k, channel, behind, behind > 0.0, x, w);
            }
        }
        for attitude in &self.attitudes {
            attitude.turn(self.timeline, &event, out);
        }
    }

    /// The sample is about an instant before the recording, where nobody knows what acted: the first of a channel whose delay is unknown,
    /// whatever that is, or known to reach there.
    fn tells_nothing(&self, k: usize, channel: usize) -> bool {
        let sensor = &self.sensors[channel];
        let reaches = sensor.delay_s > self.timeline.shift_s[channel] + 1e-6 * self.timeline.period_s;
        k == 0 && (sensor.delay_is_unknown || reaches)
    }

    /// By how much the instant that the sample is about lies before its event [s].
    pub(super) fn behind(&self, sample: usize, channel: usize) -> f64 {
        let sensor = &self.sensors[channel];
        let stamp = self.timeline.stamp_s[sample];
        let truth = (stamp - sensor.offset_s) / (1.0 + sensor.skew);
        stamp - truth + sensor.delay_s - self.timeline.shift_s[channel]
    }

    /// Reading of an instant that lies `behind` event `k`; `before`: under what acted until the event, else under what acts from it on.
    pub(super) fn read_at(&mut self, k: usize, channel: usize, behind: f64, before: bool, x: &[f64], w: &[f64]) -> f64 {
        let event = self.timeline.events[k];
        let at = if before && k > 0 { k - 1 } else { k };
        let row = if self.timeline.moving { event.row } else { self.timeline.events[at].row };
        self.load(row, w);
        let mut moved = core::mem::take(&mut self.x_at);
        moved.copy_from_slice(x);
        if behind != 0.0 {
            // as finely as the flow
            let step_s = self.timeline.events[at].step_s / self.finer as f64;
            let steps = if step_s > 0.0 { libm::ceil(behind.abs() / step_s).max(1.0) } else { 1.0 };
            for step in 0..steps as usize {
                self.runge_kutta(event.t_s - behind * step as f64 / steps, -behind / steps, &mut moved, None);
            }
        }
        let Self { system, ws, u, y, .. } = self;
        system.read(ws, event.t_s - behind, &moved, u, y);
        self.x_at = moved;
        self.y[channel]
    }

    fn read_mean(&mut self, k: usize, sample: usize, behind: f64, x: &[f64], w: &[f64], clone: (&[f64], usize)) -> f64 {
        let event = self.timeline.events[k];
        let (channel, dt) = (self.timeline.channel[sample], self.timeline.interval_s[sample]);
        let (mut end, mut begin) = (core::mem::take(&mut self.x_at), core::mem::take(&mut self.x_begin));
        end.copy_from_slice(x);
        begin.copy_from_slice(clone.0);
        self.load(event.row, w);
        self.u_end.copy_from_slice(&self.u);
        self.load(clone.1, w);
        if behind != 0.0 {
            self.runge_kutta(event.t_s, -behind, &mut end, None);
            self.runge_kutta(event.t_s - dt, -behind, &mut begin, None);
        }
        let Self { system, ws, u, u_end, y, .. } = self;
        system.read_mean(ws, event.t_s - dt - behind, dt, &begin, u, &end, u_end, y);
        (self.x_at, self.x_begin) = (end, begin);
        self.y[channel]
    }

    /// `z ← z ⊕ change` for the parts that the pass carries.
    pub fn correct(&mut self, mean: &mut Mean, change: &[f64]) {
        let n = self.layout.tangent;
        self.stage.copy_from_slice(&mean.x);
        self.system.retract(&self.stage, &change[..n], &mut mean.x);
        for (w, change) in mean.w.iter_mut().zip(&change[n..]) {
            *w += change;
        }
        for (channel, lag) in self.layout.lag_of.iter().enumerate() {
            if let Some(lag) = lag {
                mean.lag[channel].output += change[self.layout.lags_at() + lag];
            }
        }
        if self.layout.clone > 0 {
            let at = self.layout.clone_at();
            self.stage.copy_from_slice(&mean.clone);
            self.system.retract(&self.stage, &change[at..at + n], &mut mean.clone);
        }
    }

    /// Draws noise anew where the event says so, before its readings.
    pub fn renew(&self, k: usize, mean: &mut Mean) {
        let reset = self.timeline.events[k].reset;
        for (w, input) in mean.w.iter_mut().zip(&self.layout.noise_inputs) {
            if reset >> input.min(&63) & 1 == 1 {
                *w = 0.0;
            }
        }
    }

    /// Keeps the state at the beginning of a mean, after the update of its event.
    pub fn begin_mean(&self, k: usize, mean: &mut Mean) {
        if self.any_mean && self.timeline.events[k].begins_mean {
            mean.clone.copy_from_slice(&mean.x);
            mean.clone_row = self.timeline.events[k].row;
        }
    }

    /// Innovations `y − ŷ` of the whole run with frozen gains. `map[i]` is the place in this machine's z of entry i of the gains' z.
    /// Returns false where the state ran away.
    pub fn pass(&mut self, frozen: &Frozen, map: &[usize], nu: &mut [f64]) -> bool {
        let mut mean = self.start();
        let mut change = vec![0.0; self.layout.len()];
        let mut predicted = vec![0.0; self.sensors.len()];
        let events = self.timeline.events.len();
        for k in 0..events {
            let event = self.timeline.events[k];
            self.renew(k, &mut mean);
            if event.count > 0 {
                self.predict(k, &mut mean, &mut predicted);
                let gain = &frozen.gain[frozen.first[k]..];
                change.fill(0.0);
                for slot in 0..event.count {
                    let innovation = self.timeline.value[event.first + slot] - predicted[slot];
                    nu[event.first + slot] = innovation;
                    for (row, at) in map.iter().enumerate() {
                        change[*at] += gain[row * event.count + slot] * innovation;
                    }
                }
                if !change.iter().all(|c| c.abs() < 1e12) {
                    return false;
                }
                self.correct(&mut mean, &change);
            }
            self.begin_mean(k, &mut mean);
            if k + 1 < events {
                let mut x = core::mem::take(&mut mean.x);
                self.flow(k, &mut x, &mean.w);
                mean.x = x;
            }
        }
        mean.x.iter().all(|x| x.is_finite())
    }

    /// Place of each entry of the frozen z of `linear` in this machine's, by name; `None` where one is missing.
    pub fn map_names(&self, linear: &super::Linear) -> Option<Vec<usize>> {
        let ours = tangent_names(&self.system);
        let place = |name: &String| ours.iter().position(|(own, _)| own == name);
        let tangent: Vec<usize> = linear.names.iter().map(place).collect::<Option<_>>()?;
        let mut map = tangent.clone();
        for name in &linear.input_names {
            let found = self.layout.noise_inputs.iter().position(|i| self.system.inputs()[*i].name == *name)?;
            map.push(self.layout.noise_at() + found);
        }
        for (channel, lag) in linear.layout.lag_of.iter().enumerate() {
            if lag.is_some() {
                map.push(self.layout.lags_at() + self.layout.lag_of[channel]?);
            }
        }
        if linear.layout.clone > 0 {
            map.extend(tangent.iter().map(|at| self.layout.clone_at() + at));
        }
        Some(map)
    }
}

impl Channel {
    fn shifted(&self, shift_s: f64) -> bool {
        self.offset_s != 0.0 || self.skew != 0.0 || self.delay_s != 0.0 || shift_s != 0.0
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

fn channel(plant: &Plant, system: &System, sensor: &Sensor, index: usize) -> Channel {
    let own = || system.filters().iter().filter(|filter| filter.place == FilterPlace::Output(index));
    let source = sensor.source.as_ref().and_then(|name| plant.sources.iter().find(|source| source.name == *name));
    // two lags of first order in series act as one of the sum, to second order
    let time_constants = own().filter_map(|filter| match filter.kind {
        FilterKind::FirstOrder { time_constant_s } => Some(time_constant_s),
        _ => None,
    });
    let low_pass = sensor.low_pass_hz.map_or(0.0, |f| 1.0 / (core::f64::consts::TAU * f.value));
    let total = low_pass + time_constants.sum::<f64>();
    Channel {
        mean: sensor.reading == Reading::Mean,
        offset_s: source.map_or(0.0, |source| source.clock_offset_s.value),
        skew: source.map_or(0.0, |source| source.clock_skew.value),
        delay_s: sensor.delay_s.value + own().map(|filter| filter.kind.delay_s()).sum::<f64>(),
        delay_is_unknown: sensor.delay_s.sigma.is_some() || own().any(|f| matches!(f.kind, FilterKind::Delay { .. })),
        lag: Lag::new(FilterKind::FirstOrder { time_constant_s: total }),
    }
}

/// The initial state, and as the encoders' least and largest readings have it: a spring may be stiffer there.
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

/// Rows of inputs past the delays and lags that effects put on commands, and their tilts; those of the timeline where `rows` are empty.
/// Empty where there is neither.
fn filtered_rows(system: &System, timeline: &Timeline, mut rows: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    let inputs = timeline.inputs;
    let mut tilts = Vec::new();
    for filter in system.filters() {
        let FilterPlace::Input(input) = filter.place else { continue };
        if rows.is_empty() {
            rows.clone_from(&timeline.rows);
        }
        if tilts.is_empty() && !timeline.moving {
            tilts = vec![0.0; rows.len()];
        }
        let held: Vec<f64> = timeline.events.iter().map(|event| rows[event.row * inputs + input]).collect();
        let acting = acting(&filter.kind, timeline, &held);
        for (event, [mean, tilt]) in timeline.events.iter().zip(acting) {
            let stages = if timeline.moving { 2 * event.steps + 1 } else { 1 };
            for row in event.row..event.row + stages {
                rows[row * inputs + input] = mean;
            }
            if !timeline.moving {
                // what a filter before this one left, to first order
                tilts[event.row * inputs + input] += tilt;
            }
        }
    }
    (rows, tilts)
}

/// Parts of an interval whose means give its first moment.
const PARTS: usize = 16;

/// Mean, and change of the straight line of the same first moment, of what acts over each interval between events when `held` is
/// commanded: rates and positions at its end are those of what acts, not of its mean alone. Readings that feel the command
/// itself are told the mean.
fn acting(kind: &FilterKind, timeline: &Timeline, held: &[f64]) -> Vec<[f64; 2]> {
    let length = |k: usize| timeline.events[k].step_s * timeline.events[k].steps as f64;
    let delay_s = kind.delay_s();
    if delay_s > 0.0 {
        let integral = Integral::new(timeline, held);
        let parts = |k: usize| {
            let (begin, h) = (timeline.events[k].t_s - delay_s, length(k) / PARTS as f64);
            let marks: [f64; PARTS + 1] = core::array::from_fn(|i| integral.at(begin + i as f64 * h));
            line(core::array::from_fn(|i| (marks[i + 1] - marks[i]) / h))
        };
        return (0..held.len()).map(parts).collect();
    }
    if let Some(gate) = Gate::new(*kind) {
        let mut memory = 0.0;
        let pass = |(event, u): (&crate::problem::Event, &f64)| [gate.pass(&mut memory, event.t_s, *u), 0.0];
        return timeline.events.iter().zip(held).map(pass).collect();
    }
    let Some(lag) = Lag::new(*kind) else { return held.iter().map(|u| [*u, 0.0]).collect() };
    let mut state = LagState::default();
    let mut parts = |k: usize| line(core::array::from_fn(|_| lag.hold(&mut state, held[k], length(k) / PARTS as f64)));
    (0..held.len()).map(&mut parts).collect()
}

/// Mean and change of the straight line with the mean and first moment of equal parts with these means.
fn line(parts: [f64; PARTS]) -> [f64; 2] {
    let n = PARTS as f64;
    let place = |i: usize| (i as f64 + 0.5) / n - 0.5;
    let moment: f64 = (0..PARTS).map(|i| parts[i] * place(i)).sum::<f64>() / n;
    [parts.iter().sum::<f64>() / n, 12.0 * moment / (1.0 - 1.0 / (n * n))]
}

/// Running integral of a held signal.
struct Integral<'t> {
    timeline: &'t Timeline,
    held: &'t [f64],
    sum: Vec<f64>,
}

impl<'t> Integral<'t> {
    fn new(timeline: &'t Timeline, held: &'t [f64]) -> Self {
        let mut sum = vec![0.0; held.len()];
        for k in 1..held.len() {
            sum[k] = sum[k - 1] + held[k - 1] * (timeline.events[k].t_s - timeline.events[k - 1].t_s);
        }
        Self { timeline, held, sum }
    }

    fn at(&self, t_s: f64) -> f64 {
        let after = self.timeline.events.partition_point(|event| event.t_s <= t_s);
        if after == 0 {
            0.0
        } else {
            self.sum[after - 1] + self.held[after - 1] * (t_s - self.timeline.events[after - 1].t_s)
        }
    }
}
