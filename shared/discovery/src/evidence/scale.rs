//! How large an effect may be: the amplitude whose push has the rms of all that drives the record.
//!
//! Along the filtered trajectory every interval changes the rates by Δv, whatever does it:
//! commands, gravity, springs, and what the readings say beyond the plant, which may be all that
//! drives a body that coasts. The innovations' change when these pushes are added through the
//! frozen filter is compared with the effect's column, both in stated standard deviations of the
//! sensors. For an error of a reading it is the channel's own variation that is added. Along an
//! imposed motion nothing is driven: there the readings of loads say what acts.
//!
//! Readings that hardly show a push say nothing of its size: a torque on a ball whose turning no
//! sensor reads could have any. The standard deviation of a law that is a push is limited to the
//! amplitude whose changes of the rates have the size of all those of the record, in the metric of
//! the kinetic energy ([`Kinetic`]).

use super::decide::AMPLITUDE_SCALE;
use crate::score::forcing::{Sources, respond};
use crate::score::kinetic::Kinetic;
use crate::score::{Column, propagator};
use dynamics::description::{Plant, SensorKind, SiteKind};
use identification::filter::Linear;
use identification::fit::{EstimationSession, LinearisedProblem};
use identification::problem::Timeline;

/// Windows of a run over which the readings' part is a mean. In the first one they tell where it
/// began, not what drives it.
const READING_WINDOWS: usize = 20;

/// Sizes of what drives a record: seen by readings [stated standard deviations, over all samples],
/// and in the metric of the kinetic energy [√J].
pub(super) struct Drive {
    motion: f64,
    readings: Vec<f64>,
    push: f64,
}

impl Drive {
    pub(super) fn new(session: &EstimationSession<'_>, linearised: &LinearisedProblem, plant: &Plant) -> Self {
        let size = |sources: &dyn Fn(&Linear, &Timeline) -> Sources| {
            let runs = linearised.linears.iter().zip(session.timelines.iter());
            let squares = runs.map(|(linear, timeline)| {
                let change = respond(linear, timeline, &sources(linear, timeline));
                let own = change.iter().zip(&timeline.channel);
                own.map(|(change, channel)| (change / session.noise.sensor_sigma[*channel]).powi(2)).sum::<f64>()
            });
            squares.sum::<f64>().sqrt()
        };
        let readings = (0..plant.sensors.len()).map(|channel| size(&|linear, own| reading(linear, own, channel)));
        let readings: Vec<f64> = readings.collect();
        let is_imposed = plant.actuators.iter().any(|actuator| actuator.kind.is_imposed());
        let loads = plant.sensors.iter().zip(&readings).filter(|(sensor, _)| is_imposed && is_load(&sensor.kind));
        let motion = loads.fold(size(&driven), |sum: f64, (_, own)| sum.hypot(*own));
        let push = |(run, linear): (usize, &Linear)| {
            let mut base = propagator(session, plant, &linearised.theta, run)?;
            let all = pushes(linear, &session.timelines[run], &rates(linear));
            Some(Kinetic::new(linear, &mut base).square(&all.state))
        };
        let push: Option<f64> = linearised.linears.iter().enumerate().map(push).sum();
        Self { motion, readings, push: push.unwrap_or(0.0).sqrt() }
    }

    /// Prior standard deviation of the amplitude of `column`; `None` where nothing drives or
    /// nothing is felt.
    pub(super) fn scale(&self, session: &EstimationSession<'_>, plant: &Plant, column: &Column) -> Option<f64> {
        let site = &column.candidate.site;
        let channel = plant.sensors.iter().position(|sensor| sensor.name == site.name);
        let channel = channel.filter(|_| site.kind == SiteKind::Sensor);
        let each = column.raw.iter().filter_map(|raw| self.amplitude(session, channel, raw, column.push));
        each.reduce(f64::min)
    }

    /// The same of a law without a candidate: `raw` per its number, an error of the readings of
    /// `channel` or a push of the size `push`.
    pub(super) fn amplitude(
        &self,
        session: &EstimationSession<'_>,
        channel: Option<usize>,
        raw: &[f64],
        push: Option<f64>,
    ) -> Option<f64> {
        let own = channel.map_or(self.motion, |channel| self.readings[channel]);
        let channels = session.timelines.iter().flat_map(|timeline| &timeline.channel);
        let all = raw.iter().zip(channels);
        let felt = all.map(|(c, channel)| (c / session.noise.sensor_sigma[*channel]).powi(2)).sum::<f64>().sqrt();
        let push = push.filter(|push| *push > 0.0 && self.push > 0.0);
        let most = push.map_or(f64::INFINITY, |push| self.push / push);
        let scale = own / felt;
        (scale.is_finite() && scale > 0.0).then_some(AMPLITUDE_SCALE * scale.min(most))
    }
}

/// A sensor of a force or a torque.
fn is_load(kind: &SensorKind) -> bool {
    matches!(kind, SensorKind::JointTorque { .. } | SensorKind::Force { .. } | SensorKind::Torque { .. })
}

/// Places of all rates in a small change of state.
fn rates(linear: &Linear) -> Vec<usize> {
    (0..linear.layout.tangent).filter(|row| linear.names[*row].ends_with(".rate")).collect()
}

/// Every interval's change of the rates that noise inputs move most.
fn driven(linear: &Linear, timeline: &Timeline) -> Sources {
    let (n, m, x) = (linear.layout.tangent, linear.layout.noise_inputs.len(), linear.state_names.len());
    let intervals = (linear.states.len() / x.max(1)).saturating_sub(1);
    let felt = |row: usize, input: usize| {
        (0..intervals).map(|k| linear.transition[k * n * (n + m) + row * (n + m) + n + input].abs()).sum::<f64>()
    };
    let mut rows: Vec<usize> = Vec::new();
    for input in 0..m {
        rows.extend(rates(linear).into_iter().max_by(|a, b| felt(*a, input).total_cmp(&felt(*b, input))));
    }
    rows.sort_unstable();
    rows.dedup();
    // nothing is stated or expected to push: whatever does may push all
    let rows = if rows.is_empty() { rates(linear) } else { rows };
    pushes(linear, timeline, &rows)
}

/// Every interval's change of the rates at `rows`.
fn pushes(linear: &Linear, timeline: &Timeline, rows: &[usize]) -> Sources {
    let (n, x) = (linear.layout.tangent, linear.state_names.len());
    let mut sources = Sources { state: vec![0.0; timeline.events.len() * n], reading: vec![0.0; timeline.value.len()] };
    let intervals = (linear.states.len() / x.max(1)).saturating_sub(1);
    for row in rows.iter().copied() {
        let Some(state) = linear.state_names.iter().position(|name| *name == linear.names[row]) else { continue };
        for k in 0..intervals {
            sources.state[k * n + row] = linear.states[(k + 1) * x + state] - linear.updated[k * x + state];
        }
        // what readings say of one interval is noise
        let window = (intervals / READING_WINDOWS).max(1);
        for first in (window..intervals).step_by(window) {
            let own = first..(first + window).min(intervals);
            let said = own.clone().map(|k| linear.updated[k * x + state] - linear.states[k * x + state]).sum::<f64>();
            let each = said / own.len() as f64;
            own.for_each(|k| sources.state[k * n + row] += each);
        }
    }
    sources
}

/// The variation of one channel.
fn reading(linear: &Linear, timeline: &Timeline, channel: usize) -> Sources {
    let own: Vec<usize> = (0..timeline.value.len()).filter(|sample| timeline.channel[*sample] == channel).collect();
    let mean = own.iter().map(|sample| timeline.value[*sample]).sum::<f64>() / own.len().max(1) as f64;
    let state = vec![0.0; timeline.events.len() * linear.layout.tangent];
    let mut sources = Sources { state, reading: vec![0.0; timeline.value.len()] };
    own.iter().for_each(|sample| sources.reading[*sample] = timeline.value[*sample] - mean);
    sources
}
