//! The numbers that are estimated.

use super::Run;
use dynamics::description::{Plant, Scope};

/// One unknown: a number of the plant in one scope.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Its name, with `@RECORDING` or `@RECORDING.SEGMENT` where it is not shared.
    pub name: String,
    /// The plant's name of the number.
    pub parameter: String,
    pub unit: String,
    pub prior: f64,
    pub sigma: f64,
    pub low: f64,
    pub high: f64,
    pub recording: Option<usize>,
    pub segment: Option<usize>,
}

impl Unknown {
    /// Whether it is shared by all runs, or belongs to the recording and segment of this one.
    pub fn concerns(&self, run: &Run) -> bool {
        self.recording.is_none_or(|r| r == run.recording) && self.segment.is_none_or(|s| Some(s) == run.segment)
    }
}

/// Last words of numbers that cannot be negative.
const NOT_NEGATIVE: [&str; 19] = [
    "mass",
    "inertia",
    "xx",
    "yy",
    "zz",
    "stiffness",
    "friction",
    "damping",
    "frequency",
    "damping_ratio",
    "rotor_inertia",
    "length",
    "resistance",
    "density",
    "low_pass",
    "delay",
    "constant",
    "gear",
    "period",
];

/// A number of the state that a record or a segment begins in.
pub(crate) fn is_start(name: &str) -> bool {
    name.starts_with("initial") || name.starts_with("segment.") || name.ends_with(".initial_speed")
}

/// Unknowns in file order, each scope expanded. Initial values, noise levels, ranges and
/// resolutions are left to the filter.
pub(crate) fn unknowns(plant: &Plant, recordings: usize, runs: &[Run]) -> Vec<Unknown> {
    let mut list = Vec::new();
    let mut segments: Vec<_> = runs.iter().map(|run| (run.recording, run.segment)).collect();
    segments.dedup();
    for parameter in plant.parameters() {
        let Some(sigma) = parameter.sigma else { continue };
        let last = parameter.name.rsplit('.').next().unwrap_or("");
        let skip = is_start(&parameter.name);
        // when a sensor looks is no unknown, when a command comes again may be
        let is_clock = last == "period" && !parameter.name.contains(".command.");
        if skip || is_clock || ["noise", "range", "resolution"].contains(&last) {
            continue;
        }
        let words: Vec<&str> = parameter.name.split('.').collect();
        let positive = words.iter().rev().take(2).any(|word| NOT_NEGATIVE.contains(word)) && parameter.value > 0.0;
        let effect = parameter.name.starts_with("effect.");
        // a part of what cannot vanish stays
        let low = if effect {
            range_of_effect(plant, &parameter.name).0
        } else if positive {
            1e-3 * parameter.value
        } else {
            f64::NEG_INFINITY
        };
        let high = if effect { range_of_effect(plant, &parameter.name).1 } else { f64::INFINITY };
        let unknown = |suffix: String, recording: Option<usize>, segment: Option<usize>| Unknown {
            name: format!("{}{suffix}", parameter.name),
            parameter: parameter.name.clone(),
            unit: parameter.unit.clone(),
            prior: parameter.value,
            sigma,
            low,
            high,
            recording,
            segment,
        };
        match parameter.scope {
            Scope::PerRecording if recordings > 1 => {
                list.extend((0..recordings).map(|r| unknown(format!("@{}", r + 1), Some(r), None)));
            }
            Scope::PerSegment if segments.len() > 1 => {
                let each = segments.iter().map(|(recording, segment)| {
                    let suffix = format!("@{}.{}", recording + 1, segment.map_or(1, |s| s + 1));
                    unknown(suffix, Some(*recording), *segment)
                });
                list.extend(each);
            }
            _ => list.push(unknown(String::new(), None, None)),
        }
    }
    list
}

/// Physical range of `effect.KIND@SITE.PARAMETER`.
fn range_of_effect(plant: &Plant, name: &str) -> (f64, f64) {
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let Some(rest) = name.strip_prefix("effect.") else { return free };
    let Some((kind, _)) = rest.split_once('@') else { return free };
    let last = rest.rsplit('.').next().unwrap_or("");
    let Some(effect) = plant.catalogue.effect(kind) else { return free };
    effect.parameters.iter().find(|p| p.name == last).map_or(free, |p| (p.low, p.high))
}
