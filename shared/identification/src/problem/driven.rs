//! A plant that does again what a recording says was commanded.
//!
//! Inputs are those of the estimator: a recorded command holds from its stamp on and is zero before
//! the first, a recorded motion is a smoothing spline broken at its kinks. Recorded commands are
//! what acted: no controller and no range changes them. Nothing is drawn at random: a prediction
//! has no noise.

use super::inputs::{Course, Drive, drive};
use super::smooth::SmoothMotion;
use super::{ProblemError, matching};
use channels::Recording;
use dynamics::description::{Actuator, Noise, Plant, Quantity, Segment, Signal, SignalKind};

/// Commands closer than this share of a control period need a shorter one.
const SHORTER: f64 = 0.99;

/// A plant with the inputs of a recording.
#[derive(Clone, Debug)]
pub struct Driven {
    pub plant: Plant,
    /// End of the recording \[s\], by its own clock.
    pub end_s: f64,
    /// Actuators that a recording should hold and this one does not: they keep their own command.
    pub own_command: Vec<String>,
}

/// `plant` as the commands of `recording` drive it, from its own initial state at the beginning of
/// the recording.
///
/// # Errors
/// [`ProblemError::Unit`] and [`ProblemError::Empty`] of a recorded command,
/// [`ProblemError::NoRecording`] where no sensor of the plant has a sample.
pub fn driven(plant: &Plant, recording: &Recording) -> Result<Driven, ProblemError> {
    let (begin_s, last_s) = span_s(plant, recording).ok_or(ProblemError::NoRecording)?;
    let mut driven = quiet(plant);
    let mut own_command = Vec::new();
    let mut interval_s = f64::INFINITY;
    for (actuator, described) in driven.actuators.iter_mut().zip(&plant.actuators) {
        let Some(channel) = recording.channel_named(&described.name) else {
            own_command.extend(described.recorded.then(|| described.name.clone()));
            continue;
        };
        matching::check_unit(recording, channel, plant.actuator_unit(described))?;
        match drive(plant, described, Some(channel), &recording.name, (begin_s, last_s))? {
            Drive::Held { time_s, value } => {
                interval_s = interval_s.min(channel.interval_s().unwrap_or(f64::INFINITY));
                replace(actuator, vec![held(time_s, value, begin_s)]);
            }
            Drive::Motion { course: Course::Recorded(motion), .. } => replace(actuator, moved(&motion)),
            Drive::Motion { .. } | Drive::Signal(_) => {}
        }
        open(&mut driven.controllers, &described.name);
    }
    follow(&mut driven, interval_s);
    if driven.segments.is_empty() && begin_s != 0.0 {
        let begin_s = Quantity::known(begin_s);
        let initial = driven.initial.clone();
        driven.segments = vec![Segment { name: "recording".into(), begin_s, end_s: None, initial }];
    }
    // the last stamp is the beginning of the last period
    let end_s = last_s + 0.5 * driven.simulation.period_s;
    Ok(Driven { plant: driven, end_s, own_command })
}

/// Begin and end of what the estimator takes from the recording \[s\].
fn span_s(plant: &Plant, recording: &Recording) -> Option<(f64, f64)> {
    let sensors: Vec<_> = plant.sensors.iter().map(|sensor| recording.channel_named(&sensor.name)).collect();
    let spans = matching::spans(plant, recording, &sensors, &[]);
    let ends = (spans.first()?.0, spans.last()?.1);
    (ends.0.is_finite() && ends.1.is_finite()).then_some(ends)
}

/// The plant without noise, quantisation and jitter.
fn quiet(plant: &Plant) -> Plant {
    let zero = Quantity::known(0.0);
    let mut quiet = plant.clone();
    quiet.simulation.jitter_s = 0.0;
    quiet.actuators.iter_mut().for_each(|actuator| actuator.noise = zero);
    for sensor in &mut quiet.sensors {
        (sensor.noise, sensor.resolution) = (Noise::PerSample(zero), zero);
    }
    quiet
}

fn replace(actuator: &mut Actuator, command: Vec<Signal>) {
    (actuator.command, actuator.range) = (command, None);
}

/// Holds each value from its stamp on; zero before the first.
fn held(mut time_s: Vec<f64>, mut value: Vec<f64>, begin_s: f64) -> Signal {
    if time_s[0] > begin_s {
        time_s.insert(0, begin_s);
        value.insert(0, 0.0);
    }
    let zero = Quantity::known(0.0);
    Signal { kind: SignalKind::Table { time_s, value, smooth: false }, begin_s: zero, end_s: None }
}

/// The motion as one table for each stretch between kinks, where a natural spline ends.
fn moved(motion: &SmoothMotion) -> Vec<Signal> {
    let (time_s, value) = motion.knots();
    let mut edges: Vec<usize> = vec![0];
    edges.extend_from_slice(motion.kinks());
    edges.push(time_s.len() - 1);
    let stretch = |(k, pair): (usize, &[usize])| {
        let [from, to] = [pair[0], pair[1]];
        let begin_s = time_s[from];
        let kind = SignalKind::Table {
            time_s: time_s[from..=to].iter().map(|t| t - begin_s).collect(),
            value: value[from..=to].to_vec(),
            smooth: true,
        };
        // behind the last stretch the motion rests
        let end_s = (k + 2 < edges.len()).then(|| Quantity::known(time_s[to]));
        Signal { kind, begin_s: Quantity::known(begin_s), end_s }
    };
    edges.windows(2).enumerate().map(stretch).collect()
}

/// Cuts the loops of an actuator; what they say of the start stays.
fn open(controllers: &mut [dynamics::description::Controller], actuator: &str) {
    let zero = Quantity::known(0.0);
    for controller in controllers.iter_mut().filter(|controller| controller.actuator == actuator) {
        (controller.kp, controller.ki, controller.kd, controller.feed_forward) = (zero, zero, zero, zero);
    }
}

/// Periods as short as the commands are; sensors are read when they would be.
fn follow(plant: &mut Plant, interval_s: f64) {
    let period_s = plant.simulation.period_s;
    if interval_s.is_nan() || interval_s <= 0.0 || interval_s >= SHORTER * period_s {
        return;
    }
    for sensor in &mut plant.sensors {
        sensor.period_s.get_or_insert(Quantity::known(period_s));
    }
    plant.simulation.period_s = interval_s;
    plant.simulation.step_s = plant.simulation.step_s.min(interval_s);
}

#[cfg(test)]
mod tests;
