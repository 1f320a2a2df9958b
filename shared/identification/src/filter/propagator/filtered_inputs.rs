//! Inputs past the delays, lags and gates that effects put on commands.

use crate::problem::{Event, Timeline};
use dynamics::lags::{FilterKind, Gate, Lag, LagState};
use dynamics::system::{FilterPlace, System};

/// Rows of inputs past the delays and lags that effects put on commands, and their tilts; those of
/// the timeline where `rows` are empty. Empty where there is neither.
pub(super) fn filtered_rows(system: &System, timeline: &Timeline, mut rows: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
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

/// Mean, and change of the straight line of the same first moment, of what acts over each interval
/// between events when `held` is commanded: rates and positions at its end are those of what acts,
/// not of its mean alone. Readings that feel the command itself receive the mean.
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
        let pass = |(event, u): (&Event, &f64)| [gate.pass(&mut memory, event.t_s, *u), 0.0];
        return timeline.events.iter().zip(held).map(pass).collect();
    }
    let Some(lag) = Lag::new(*kind) else { return held.iter().map(|u| [*u, 0.0]).collect() };
    let mut state = LagState::default();
    let mut parts = |k: usize| line(core::array::from_fn(|_| lag.hold(&mut state, held[k], length(k) / PARTS as f64)));
    (0..held.len()).map(&mut parts).collect()
}

/// Mean and change of the straight line with the mean and first moment of equal parts with these
/// means.
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
