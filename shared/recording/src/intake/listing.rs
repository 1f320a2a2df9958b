//! What a file holds, before anything is chosen.

use super::Intake;
use super::plan::Clock;
use super::times::Times;
use crate::dataset::{Axis, RawDataset};
use crate::series::SeriesSet;
use crate::spectrum::Spectrum;
use crate::units::unit_named;
use channels::Channel;

/// A channel of a dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedChannel {
    /// Name in the file.
    pub name: String,
    /// Unit in the file; `None` where it states none.
    pub unit: Option<String>,
    /// Samples that are there.
    pub samples: usize,
    /// Median rate \[Hz\], where the clock is known.
    pub rate_hz: Option<f64>,
    /// Time of the first sample \[s\], where the clock is known.
    pub start_s: Option<f64>,
    /// Time of the last sample \[s\].
    pub end_s: Option<f64>,
}

/// A dataset of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedDataset {
    /// Name for `--dataset`; empty where the file holds one without a name.
    pub name: String,
    /// Its channels.
    pub channels: Vec<ListedChannel>,
    /// What keeps it from being read, or what was left out.
    pub notes: Vec<String>,
}

impl ListedDataset {
    pub(crate) fn of_series(name: &str, set: &SeriesSet) -> Self {
        let channel = |channel: &Channel| {
            let unit = set.unit_in_file(channel);
            ListedChannel {
                name: channel.name.clone(),
                unit: unit_named(unit).map(|_| unit.to_owned()).filter(|unit| !unit.is_empty()),
                samples: channel.value.len(),
                rate_hz: channel.rate_hz(),
                start_s: channel.time_s.first().map(|time| time + set.origin_s as f64),
                end_s: channel.time_s.last().map(|time| time + set.origin_s as f64),
            }
        };
        let channels = set.recording.channels.iter().map(channel).collect();
        ListedDataset { name: name.into(), channels, notes: set.notes.clone() }
    }

    pub(crate) fn of_spectrum(name: &str, spectrum: &Spectrum) -> Self {
        let channel = |column: &crate::Column| ListedChannel {
            name: column.name.clone(),
            unit: Some(column.unit_in_file.clone()).filter(|unit| !unit.is_empty()),
            samples: column.values.len(),
            rate_hz: None,
            start_s: None,
            end_s: None,
        };
        let channels = spectrum.columns.iter().map(channel).collect();
        ListedDataset { name: name.into(), channels, notes: spectrum.notes.clone() }
    }

    pub(crate) fn of_raw(file: &str, dataset: &RawDataset, intake: &Intake) -> Self {
        let plan = super::join::planned(file, dataset, intake);
        let mut times = plan.as_ref().ok().map(|plan| Times::of(dataset, &plan.clock));
        let rows = 0..dataset.rows();
        let all: Vec<f64> = times.as_mut().map_or_else(Vec::new, |times| rows.map(|i| times.next(i)).collect());
        let origin_s = times.map_or(0.0, |times| times.origin_s() as f64);
        let time = |i: usize| all.get(i).map(|time| time + origin_s);
        let clock = match plan.as_ref().map(|plan| &plan.clock) {
            Ok(Clock::Number { at, .. } | Clock::Steps { at, .. }) => Some(*at),
            _ => match dataset.axis {
                Axis::Time(at) | Axis::Frequency(at) => Some(at),
                _ => None,
            },
        };
        let channel = |column: &crate::RawColumn| {
            let times: Vec<f64> = (0..column.values.len())
                .filter(|i| !column.values[*i].is_nan())
                .filter_map(|i| time(i).filter(|t| t.is_finite()))
                .collect();
            let samples = column.values.iter().filter(|value| !value.is_nan()).count();
            let (start_s, end_s) = (times.first().copied(), times.last().copied());
            let of = Channel::new("", "", times, Vec::new());
            let rate_hz = of.rate_hz();
            ListedChannel { name: column.name.clone(), unit: column.unit.clone(), samples, rate_hz, start_s, end_s }
        };
        let columns = dataset.columns.iter().enumerate().filter(|(at, _)| Some(*at) != clock);
        let mut notes = dataset.notes.clone();
        notes.extend(plan.as_ref().err().map(|error| error.without_file(file)));
        ListedDataset {
            name: dataset.name.clone(),
            channels: columns.map(|(_, column)| channel(column)).collect(),
            notes,
        }
    }
}
