//! Channels of a recording found by the plant's names, units checked, cut into runs.

use super::angles::turned;
use super::gaps::parted;
use super::inputs::drive;
use super::{ProblemError, Run, Samples};
use channels::{Channel, Recording, same_unit};
use dynamics::description::{Actuator, Initial, Plant, Sensor};
use dynamics::system::System;

/// Runs of one recording: one a segment of the plant that lies in it, else the whole.
pub(super) fn runs(
    plant: &Plant,
    recording: &Recording,
    index: usize,
    map: &[(String, String)],
    notes: &mut Vec<String>,
) -> Result<Vec<Run>, ProblemError> {
    if let Some(error) = unmet(plant, recording, map).into_iter().next() {
        return Err(error);
    }
    let sensors: Vec<Option<&Channel>> = plant.sensors.iter().map(|s| find(recording, &s.name, map)).collect();
    let absent = plant.sensors.iter().zip(&sensors).filter(|(_, channel)| channel.is_none());
    notes.extend(absent.map(|(s, _)| format!("recording '{}' has no channel for sensor '{}'", recording.name, s.name)));
    let states = System::new(plant).map_or(0, |system| system.tangent_len());
    let mut found = Vec::new();
    for (begin_s, end_s, segment, initial) in spans(plant, recording, &sensors, map) {
        let drives = (plant.actuators.iter())
            .map(|a| drive(plant, a, find(recording, &a.name, map), &recording.name, (begin_s, end_s)))
            .collect::<Result<Vec<_>, _>>()?;
        let mut samples = Vec::with_capacity(sensors.len());
        for (sensor, channel) in plant.sensors.iter().zip(&sensors) {
            let mut cut = channel.map_or_else(Samples::default, |channel| cut(channel, begin_s, end_s));
            if let Some(note) = turned(plant, sensor, &initial, &mut cut.value) {
                notes.push(format!("recording '{}': {note}", recording.name));
            }
            samples.push(cut);
        }
        if samples.iter().all(|samples| samples.value.is_empty()) {
            // a segment that the recording does not hold
            continue;
        }
        let run = Run { recording: index, segment, begin_s, end_s, initial, drives, samples, is_rest: false };
        let (parts, note) = parted(run, states);
        notes.extend(note.map(|note| format!("recording '{}': {note}", recording.name)));
        found.extend(parts);
    }
    if found.is_empty() {
        let begin_s = plant.segments.first().map_or(f64::NEG_INFINITY, |segment| segment.begin_s.value);
        let end_s = plant.segments.last().and_then(|segment| segment.end_s).map_or(f64::INFINITY, |end| end.value);
        let channel = sensors.iter().flatten().next().map_or(String::new(), |channel| channel.name.clone());
        return Err(ProblemError::Empty { recording: recording.name.clone(), channel, begin_s, end_s });
    }
    Ok(found)
}

/// Every name and unit in which plant and recording do not meet: sensors first, in the order of the
/// plant.
pub(super) fn unmet(plant: &Plant, recording: &Recording, map: &[(String, String)]) -> Vec<ProblemError> {
    let absent = |s: &Sensor| find(recording, &s.name, map).is_none();
    if plant.sensors.iter().all(absent) {
        let name = plant.sensors.first().map_or("", |sensor| &sensor.name);
        return vec![missing(plant, recording, name, "a sensor", map)];
    }
    let sensors = plant.sensors.iter().filter_map(|sensor| match find(recording, &sensor.name, map) {
        Some(channel) => check_unit(recording, channel, plant.sensor_unit(sensor)).err(),
        // another spelling is no missing channel
        None => nearest(plant, &sensor.name, recording, map)
            .map(|_| missing(plant, recording, &sensor.name, "a sensor", map)),
    });
    sensors.chain(plant.actuators.iter().filter_map(|actuator| unmet_input(plant, recording, actuator, map))).collect()
}

/// Why nothing is known of what one actuator did, if so.
fn unmet_input(
    plant: &Plant,
    recording: &Recording,
    actuator: &Actuator,
    map: &[(String, String)],
) -> Option<ProblemError> {
    if let Some(channel) = find(recording, &actuator.name, map) {
        return check_unit(recording, channel, plant.actuator_unit(actuator)).err();
    }
    let controlled = plant.controllers.iter().any(|c| c.actuator == actuator.name);
    let alike = nearest(plant, &actuator.name, recording, map).is_some();
    if controlled && !alike {
        return Some(ProblemError::UnknownInput { actuator: actuator.name.clone() });
    }
    let required = controlled || (actuator.recorded && actuator.command.is_empty());
    required.then(|| missing(plant, recording, &actuator.name, "an actuator", map))
}

fn missing(
    plant: &Plant,
    recording: &Recording,
    channel: &str,
    what: &'static str,
    map: &[(String, String)],
) -> ProblemError {
    let nearest = nearest(plant, channel, recording, map);
    ProblemError::MissingChannel { recording: recording.name.clone(), channel: channel.to_owned(), what, nearest }
}

/// What the recording calls `name`.
fn theirs<'m>(name: &'m str, map: &'m [(String, String)]) -> &'m str {
    map.iter().find(|(ours, _)| ours == name).map_or(name, |(_, theirs)| theirs)
}

fn find<'r>(recording: &'r Recording, name: &str, map: &[(String, String)]) -> Option<&'r Channel> {
    let wanted = theirs(name, map);
    recording.channels.iter().find(|channel| channel.name == wanted)
}

/// Begin, end, segment and initial state of every run.
pub(super) fn spans(
    plant: &Plant,
    recording: &Recording,
    sensors: &[Option<&Channel>],
    map: &[(String, String)],
) -> Vec<(f64, f64, Option<usize>, Initial)> {
    let stamps =
        || sensors.iter().flatten().flat_map(|channel| channel.finite().into_iter().map(|i| channel.time_s[i]));
    let first = stamps().fold(f64::INFINITY, f64::min);
    let last = stamps().fold(f64::NEG_INFINITY, f64::max);
    let inputs = plant.actuators.iter().filter_map(|actuator| find(recording, &actuator.name, map));
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

pub(super) fn check_unit(recording: &Recording, channel: &Channel, expected: &str) -> Result<(), ProblemError> {
    if channel.unit.is_empty() || channel.unit == "1" || same_unit(&channel.unit, expected) {
        return Ok(());
    }
    Err(ProblemError::Unit {
        recording: recording.name.clone(),
        channel: channel.name.clone(),
        got: channel.unit.clone(),
        expected: expected.to_owned(),
    })
}

/// Of the channels that are nothing else of the plant, the one whose name shares most pairs of
/// letters (Dice), if half of them.
fn nearest(plant: &Plant, name: &str, recording: &Recording, map: &[(String, String)]) -> Option<String> {
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
    let known = plant.sensors.iter().map(|s| &s.name).chain(plant.actuators.iter().map(|a| &a.name));
    let taken: Vec<&str> = known.map(|name| theirs(name, map)).collect();
    let left = recording.channels.iter().filter(|channel| !taken.contains(&channel.name.as_str()));
    let best = left.map(|c| (score(&c.name), &c.name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= 0.5).then(|| best.1.clone())
}
