//! The instants of a run at which something happens: samples, switches of commands, beginnings of
//! means; and the inputs between.
//!
//! Samples of one instant are one event. Between events what is held acts unchanged; motions are
//! tabulated at the beginning, middle and end of every integration step. Stamps of sources whose
//! clock is off by more than half an interval are moved by whole intervals; the rest is left to the
//! reading.

use super::inputs::Course;
use super::{Drive, Problem, Run};
use dynamics::description::{ActuatorKind, Plant, Prescribed, Reading};
use dynamics::signal::SignalSum;
use dynamics::system::{InputRole, System};

/// One instant.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    pub t_s: f64,
    /// First sample and number of samples.
    pub first: usize,
    pub count: usize,
    /// Bit per input: its noise is drawn anew here.
    pub reset: u64,
    /// Bit per input: it makes no noise until it is drawn anew, a thruster that is shut.
    pub quiet: u64,
    /// A mean begins here.
    pub begins_mean: bool,
    /// To the next event: length of one integration step, their number, first row of inputs.
    pub step_s: f64,
    pub steps: usize,
    pub row: usize,
}

/// Everything about a run that does not depend on parameters.
#[derive(Clone, Debug)]
pub struct Timeline {
    pub events: Vec<Event>,
    /// Per sample: channel, value, stamp, interval before the stamp's successor (of a mean).
    pub channel: Vec<usize>,
    pub value: Vec<f64>,
    pub stamp_s: Vec<f64>,
    pub interval_s: Vec<f64>,
    /// Moves of the stamps of each channel \[s\]: event = stamp − shift (+ interval of a mean).
    pub shift_s: Vec<f64>,
    /// Rows of inputs, `inputs` numbers each.
    pub rows: Vec<f64>,
    pub inputs: usize,
    /// Rows come in triples per step (motions), else one per event.
    pub moving: bool,
    /// Median time between samples of the fastest channel \[s\].
    pub period_s: f64,
}

/// Stamps closer than this are one instant \[s\].
const SAME_S: f64 = 1e-7;

impl Timeline {
    /// Timeline of `run`; `lags_s` is by how much each channel's stamps are behind the truth,
    /// `step_s` the longest integration step, of which each is taken in `parts`.
    pub fn new(plant: &Plant, system: &System, run: &Run, lags_s: &[f64], (step_s, parts): (f64, usize)) -> Self {
        let period_s = fastest(run);
        let shift = |lag: &f64| libm::round(lag / period_s) * period_s;
        let shift_s: Vec<f64> = lags_s.iter().map(shift).collect();
        let mut marks = marks(plant, run, &shift_s);
        marks.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.order().cmp(&b.1.order())));
        let mut timeline = Self {
            events: Vec::new(),
            channel: Vec::new(),
            value: Vec::new(),
            stamp_s: Vec::new(),
            interval_s: Vec::new(),
            shift_s,
            rows: Vec::new(),
            inputs: system.inputs().len(),
            moving: run.drives.iter().any(|drive| matches!(drive, Drive::Motion { .. })),
            period_s,
        };
        timeline.gather(&marks, system, run);
        timeline.tabulate(system, run, (step_s, parts));
        timeline.find_quiet(plant, system);
        timeline
    }

    /// Rows of inputs where numbers of the plant's own commands are unknowns, for `plant` with
    /// other values of them; else `None`. A command acts with its mean over each interval, so that
    /// a step is felt where it begins, not at the next sample.
    pub fn rows_of(&self, problem: &Problem, run: &Run, plant: &Plant, system: &System) -> Option<Vec<f64>> {
        let unknown = |name: &str| {
            let prefix = format!("{name}.command.");
            problem.unknowns.iter().any(|unknown| unknown.parameter.starts_with(&prefix))
        };
        let own = |a: usize| matches!(run.drives.get(a), Some(Drive::Signal(_)));
        let signal = |(a, actuator): (usize, &dynamics::description::Actuator)| {
            let moves = own(a) && unknown(&actuator.name);
            moves.then(|| SignalSum::new(&actuator.command, plant.simulation.duration_s, &actuator.name).ok()).flatten()
        };
        let signals: Vec<Option<SignalSum>> = plant.actuators.iter().enumerate().map(signal).collect();
        if signals.iter().all(Option::is_none) {
            return None;
        }
        let mut rows = self.rows.clone();
        for (k, event) in self.events.iter().enumerate() {
            let end = self.events.get(k + 1).map_or(event.t_s + self.period_s, |next| next.t_s);
            let stages = if self.moving { 2 * event.steps + 1 } else { 1 };
            for (i, input) in system.inputs().iter().enumerate().filter(|(_, u)| u.role == InputRole::Command) {
                let Some(Some(signal)) = signals.get(input.actuator) else { continue };
                let mean = mean(signal, event.t_s, end);
                (event.row..event.row + stages).for_each(|row| rows[row * self.inputs + i] = mean);
            }
        }
        Some(rows)
    }

    fn gather(&mut self, marks: &[(f64, Mark)], system: &System, run: &Run) {
        let held = |actuator: usize| matches!(run.drives.get(actuator), Some(Drive::Held { .. }));
        let any_held = (0..run.drives.len()).any(held);
        let bits = |test: &dyn Fn(usize) -> bool| -> u64 {
            let commands = system.inputs().iter().enumerate().filter(|(_, u)| u.role == InputRole::Command);
            commands.filter(|(_, u)| test(u.actuator)).fold(0, |bits, (i, _)| bits | 1 << i.min(63))
        };
        let others = bits(&|actuator| !held(actuator));
        for (t_s, mark) in marks {
            if self.events.last().is_none_or(|event: &Event| t_s - event.t_s > SAME_S) {
                let first = self.channel.len();
                let event = Event {
                    t_s: *t_s,
                    first,
                    count: 0,
                    reset: 0,
                    quiet: 0,
                    begins_mean: false,
                    step_s: 0.0,
                    steps: 0,
                    row: 0,
                };
                self.events.push(event);
            }
            let event = self.events.last_mut().expect("one was pushed if there was none");
            match mark {
                Mark::Command { actuator } => {
                    event.reset |= bits(&|a| a == *actuator) | others;
                }
                Mark::MeanBegins => event.begins_mean = true,
                Mark::Sample { channel, index, interval_s } => {
                    event.count += 1;
                    if !any_held {
                        event.reset |= others;
                    }
                    self.channel.push(*channel);
                    self.value.push(run.samples[*channel].value[*index]);
                    self.stamp_s.push(run.samples[*channel].time_s[*index]);
                    self.interval_s.push(*interval_s);
                }
            }
        }
    }

    /// A thruster makes noise only while it fires.
    fn find_quiet(&mut self, plant: &Plant, system: &System) {
        let is_thruster = |actuator: usize| matches!(plant.actuators[actuator].kind, ActuatorKind::Thruster { .. });
        let commands = system.inputs().iter().enumerate().filter(|(_, u)| u.role == InputRole::Command);
        let thrusters: Vec<usize> = commands.filter(|(_, u)| is_thruster(u.actuator)).map(|(i, _)| i).collect();
        for event in &mut self.events {
            let shut = thrusters.iter().filter(|i| self.rows[event.row * self.inputs + **i] == 0.0);
            event.quiet = shut.fold(0, |bits, i| bits | 1 << i.min(&63));
        }
    }

    fn tabulate(&mut self, system: &System, run: &Run, (step_s, parts): (f64, usize)) {
        let mut motions = vec![[0.0; 2]; run.drives.len()];
        for (motion, drive) in motions.iter_mut().zip(&run.drives) {
            if let Drive::Motion { from, .. } = drive {
                *motion = *from;
            }
        }
        for k in 0..self.events.len() {
            let begin = self.events[k].t_s;
            let end = self.events.get(k + 1).map_or(begin + self.period_s, |next| next.t_s);
            let steps = parts * libm::ceil((end - begin) / step_s - 1e-9).max(1.0) as usize;
            let h = (end - begin) / steps as f64;
            self.events[k].step_s = h;
            self.events[k].steps = steps;
            self.events[k].row = self.rows.len() / self.inputs.max(1);
            let stages = if self.moving { 2 * steps + 1 } else { 1 };
            for stage in 0..stages {
                let t = begin + 0.5 * h * stage as f64;
                self.push_row(system, run, (begin, end, t), &mut motions, 0.5 * h, stage > 0);
            }
        }
    }

    fn push_row(
        &mut self,
        system: &System,
        run: &Run,
        (begin, end, t): (f64, f64, f64),
        motions: &mut [[f64; 2]],
        h: f64,
        advance: bool,
    ) {
        let first = self.rows.len();
        self.rows.resize(first + self.inputs, 0.0);
        for (i, input) in system.inputs().iter().enumerate() {
            let Some(drive) = run.drives.get(input.actuator) else { continue };
            self.rows[first + i] = match (drive, input.role) {
                (Drive::Motion { course, what, .. }, role) => {
                    let motion = &mut motions[input.actuator];
                    if advance && role == InputRole::Position {
                        move_on(course, *what, motion, t, h);
                    }
                    stated(course, *what, motion, t, role)
                }
                (Drive::Signal(_), _) => drive.held_at(0.5 * (begin + end)),
                (Drive::Held { .. }, _) => drive.held_at(begin),
            };
        }
    }
}

/// Mean of a signal over `[begin, end)`: Simpson's rule, halved where the signal bends or jumps.
fn mean(signal: &SignalSum, begin: f64, end: f64) -> f64 {
    /// An interval halved so often is shorter than a jump is wide.
    const HALVINGS_MAX: u32 = 40;
    /// Part of the values by which the middle may lie off the chord.
    const BEND: f64 = 1e-3;
    fn integral(signal: &SignalSum, (a, at_a): (f64, f64), (b, at_b): (f64, f64), halvings: u32) -> f64 {
        let m = 0.5 * (a + b);
        let at_m = signal.at(m).value;
        let bend = (at_m - 0.5 * (at_a + at_b)).abs();
        if halvings == 0 || bend <= BEND * (at_a.abs() + at_b.abs()) {
            return (b - a) / 6.0 * (at_a + 4.0 * at_m + at_b);
        }
        integral(signal, (a, at_a), (m, at_m), halvings - 1) + integral(signal, (m, at_m), (b, at_b), halvings - 1)
    }
    if end <= begin {
        return signal.at(begin).value;
    }
    let at = |t: f64| (t, signal.at(t).value);
    integral(signal, at(begin), at(end), HALVINGS_MAX) / (end - begin)
}

/// Moves position and rate from `t − h` to `t` by Simpson's rule.
fn move_on(course: &Course, what: Prescribed, motion: &mut [f64; 2], t: f64, h: f64) {
    let at = |share: f64| course.at(t - h + share * h).value;
    match what {
        Prescribed::Position => {}
        Prescribed::Rate => motion[0] += h / 6.0 * (at(0.0) + 4.0 * at(0.5) + at(1.0)),
        Prescribed::Acceleration => {
            motion[0] += h * motion[1] + h * h / 6.0 * (at(0.0) + 2.0 * at(0.5));
            motion[1] += h / 6.0 * (at(0.0) + 4.0 * at(0.5) + at(1.0));
        }
    }
}

fn stated(course: &Course, what: Prescribed, motion: &[f64; 2], t: f64, role: InputRole) -> f64 {
    let at = course.at(t);
    match (what, role) {
        (Prescribed::Position, InputRole::Rate) => at.rate,
        (Prescribed::Position, InputRole::Acceleration) => at.acceleration,
        (Prescribed::Rate, InputRole::Position) => motion[0],
        (Prescribed::Rate, InputRole::Acceleration) => at.rate,
        (Prescribed::Acceleration, InputRole::Position) => motion[0],
        (Prescribed::Acceleration, InputRole::Rate) => motion[1],
        _ => at.value,
    }
}

#[derive(Clone, Copy)]
enum Mark {
    Command { actuator: usize },
    MeanBegins,
    Sample { channel: usize, index: usize, interval_s: f64 },
}

impl Mark {
    const fn order(&self) -> usize {
        match self {
            Self::Command { .. } => 0,
            Self::MeanBegins => 1,
            Self::Sample { channel, .. } => 2 + *channel,
        }
    }
}

fn marks(plant: &Plant, run: &Run, shift_s: &[f64]) -> Vec<(f64, Mark)> {
    let mut marks = vec![(run.begin_s, Mark::Command { actuator: usize::MAX })];
    for (channel, samples) in run.samples.iter().enumerate() {
        let mean = plant.sensors[channel].reading == Reading::Mean;
        let usual = usual_interval(&samples.time_s);
        for (index, stamp) in samples.time_s.iter().enumerate() {
            let t = stamp - shift_s[channel];
            let next = samples.time_s.get(index + 1).map_or(usual, |next| next - stamp);
            let interval_s = if next <= 1.5 * usual { next } else { usual };
            let sample = Mark::Sample { channel, index, interval_s };
            if mean {
                if t >= run.begin_s - SAME_S {
                    marks.push((t, Mark::MeanBegins));
                    marks.push((t + interval_s, sample));
                }
            } else if t >= run.begin_s - SAME_S || shift_s[channel] <= 0.0 {
                // what a stated delay puts before the recording is about unknown inputs
                marks.push((t.max(run.begin_s), sample));
            }
        }
    }
    let last = marks.iter().map(|mark| mark.0).fold(run.begin_s, f64::max);
    for (actuator, drive) in run.drives.iter().enumerate() {
        if let Drive::Held { time_s, .. } = drive {
            let within = time_s.iter().filter(|t| **t >= run.begin_s - SAME_S && **t <= last);
            marks.extend(within.map(|t| (*t, Mark::Command { actuator })));
        }
    }
    marks
}

fn usual_interval(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() { 1.0 } else { estimation::quantiles::median(&mut steps) }
}

fn fastest(run: &Run) -> f64 {
    let each = run.samples.iter().filter(|s| s.time_s.len() > 1).map(|s| usual_interval(&s.time_s));
    let fastest = each.fold(f64::INFINITY, f64::min);
    if fastest.is_finite() { fastest } else { 1.0 }
}
