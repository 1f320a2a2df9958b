//! Channels of a recording found by the plant's names, units checked, cut into runs.

use super::inputs::drive;
use super::{ProblemError, Run, Samples};
use crate::series::{Channel, Recording};
use plant::description::{Initial, Plant};

/// Runs of one recording: one a segment of the plant that lies in it, else the whole.
pub(super) fn runs(
    plant: &Plant,
    recording: &Recording,
    index: usize,
    map: &[(String, String)],
    notes: &mut Vec<String>,
) -> Result<Vec<Run>, ProblemError> {
    let mut found = Vec::new();
    let sensors: Vec<Option<&Channel>> = plant.sensors.iter().map(|s| find(recording, &s.name, map)).collect();
    if sensors.iter().all(Option::is_none) {
        let name = plant.sensors.first().map_or("", |sensor| &sensor.name);
        return Err(missing(recording, name, "a sensor"));
    }
    for (sensor, channel) in plant.sensors.iter().zip(&sensors) {
        let Some(channel) = channel else {
            notes.push(format!("recording '{}' has no channel for sensor '{}'", recording.name, sensor.name));
            if let Some(near) = nearest(&sensor.name, recording) {
                return Err(ProblemError::MissingChannel {
                    recording: recording.name.clone(),
                    channel: sensor.name.clone(),
                    what: "a sensor",
                    nearest: Some(near),
                });
            }
            continue;
        };
        check_unit(recording, channel, plant.sensor_unit(sensor))?;
    }
    for (begin_s, end_s, segment, initial) in spans(plant, recording, &sensors) {
        let mut drives = Vec::with_capacity(plant.actuators.len());
        for actuator in &plant.actuators {
            let channel = find(recording, &actuator.name, map);
            if let Some(channel) = channel {
                check_unit(recording, channel, plant.actuator_unit(actuator))?;
            }
            if channel.is_none() && actuator.recorded && actuator.command.is_empty() {
                return Err(missing(recording, &actuator.name, "an actuator"));
            }
            if channel.is_none() && plant.controllers.iter().any(|c| c.actuator == actuator.name) {
                return Err(ProblemError::UnknownInput { actuator: actuator.name.clone() });
            }
            drives.push(drive(plant, actuator, channel, &recording.name, (begin_s, end_s))?);
        }
        let cut = |channel: &Option<&Channel>| channel.map_or_else(Samples::default, |c| cut(c, begin_s, end_s));
        let samples: Vec<Samples> = sensors.iter().map(cut).collect();
        found.push(Run { recording: index, segment, begin_s, end_s, initial, drives, samples });
    }
    Ok(found)
}

fn missing(recording: &Recording, channel: &str, what: &'static str) -> ProblemError {
    let near = nearest(channel, recording);
    ProblemError::MissingChannel { recording: recording.name.clone(), channel: channel.to_owned(), what, nearest: near }
}

fn find<'r>(recording: &'r Recording, name: &str, map: &[(String, String)]) -> Option<&'r Channel> {
    let wanted = map.iter().find(|(ours, _)| ours == name).map_or(name, |(_, theirs)| theirs);
    recording.channels.iter().find(|channel| channel.name == wanted)
}

/// Begin, end, segment and initial state of every run.
fn spans(
    plant: &Plant,
    recording: &Recording,
    sensors: &[Option<&Channel>],
) -> Vec<(f64, f64, Option<usize>, Initial)> {
    let stamps =
        || sensors.iter().flatten().flat_map(|channel| channel.finite().into_iter().map(|i| channel.time_s[i]));
    let first = stamps().fold(f64::INFINITY, f64::min);
    let last = stamps().fold(f64::NEG_INFINITY, f64::max);
    let inputs = recording.channels.iter().filter(|c| plant.actuators.iter().any(|a| a.name == c.name));
    let begin = inputs.filter_map(|c| c.time_s.first()).fold(first, |a, b| if *b < a && a - b < 1.0 { *b } else { a });
    if plant.segments.is_empty() {
        return vec![(begin, last, None, plant.initial.clone())];
    }
    let mut spans = Vec::new();
    for (index, segment) in plant.segments.iter().enumerate() {
        let next = plant.segments.get(index + 1).map_or(last + 1e-9, |next| next.begin_s.value);
        let end = segment.end_s.map_or(next, |end| end.value).min(last + 1e-9);
        if end > segment.begin_s.value {
            spans.push((segment.begin_s.value, end, Some(index), segment.initial.clone()));
        }
    }
    spans
}

/// Finite samples in `[begin, end]` with increasing stamps.
fn cut(channel: &Channel, begin_s: f64, end_s: f64) -> Samples {
    let mut samples = Samples::default();
    for i in channel.finite() {
        let t = channel.time_s[i];
        let in_order = samples.time_s.last().is_none_or(|last| t > *last);
        if t >= begin_s && t <= end_s && in_order {
            samples.time_s.push(t);
            samples.value.push(channel.value[i]);
        }
    }
    samples
}

fn check_unit(recording: &Recording, channel: &Channel, expected: &str) -> Result<(), ProblemError> {
    let plain = |unit: &str| -> String {
        unit.chars().filter(|c| !c.is_whitespace() && !"*·()".contains(*c)).collect::<String>().replace("s^2", "s2")
    };
    if channel.unit.is_empty() || channel.unit == "1" || plain(&channel.unit) == plain(expected) {
        return Ok(());
    }
    Err(ProblemError::Unit {
        recording: recording.name.clone(),
        channel: channel.name.clone(),
        got: channel.unit.clone(),
        expected: expected.to_owned(),
    })
}

/// The channel whose name shares most pairs of letters (Dice), if half of them.
fn nearest(name: &str, recording: &Recording) -> Option<String> {
    let pairs = |word: &str| -> Vec<(char, char)> {
        let letters: Vec<char> = word.to_lowercase().chars().collect();
        letters.windows(2).map(|w| (w[0], w[1])).collect()
    };
    let ours = pairs(name);
    let score = |word: &str| {
        let theirs = pairs(word);
        let common = ours.iter().filter(|pair| theirs.contains(pair)).count();
        2.0 * common as f64 / (ours.len() + theirs.len()).max(1) as f64
    };
    let best = recording.channels.iter().map(|c| (score(&c.name), &c.name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= 0.5).then(|| best.1.clone())
}
