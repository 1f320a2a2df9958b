//! Columns of times behind the first: clocks of the columns that follow them, where a file puts
//! channels of different rates side by side.

use super::clock;
use super::names::heading;
use super::origin::Origin;
use super::plan::{Clock, Kind, Planned, Seen};
use crate::error::RecordingError;
use crate::series::SeriesSet;
use crate::{Imported, series};
use channels::Channel;

/// Fewest numbers that show a clock.
const NUMBERS_MIN: usize = 4;
/// Share of its rate by which a clock differs from another.
const RATE_SHARE: f64 = 1e-2;

/// A clock of some of the columns.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SecondClock {
    /// Channel that it was read as.
    name: String,
    /// Names of the channels that follow it up to the next clock.
    channels: Vec<String>,
}

/// The clocks among the channels to be: columns of rising times whose steps are not those of the
/// clock of the rows.
pub(crate) fn of(all: &[Seen], first: &Clock, planned: &[Planned]) -> Vec<SecondClock> {
    let Clock::Number { at, unit } = first else { return Vec::new() };
    let Some(own) = step(&all[*at].sample).map(|step| unit.to_si(step)) else { return Vec::new() };
    let is_clock = |of: &Planned| {
        let seen = &all[of.at];
        let differs = step(&seen.sample).is_some_and(|step| (of.unit.to_si(step) / own - 1.0).abs() > RATE_SHARE);
        of.at > *at
            && of.unit.si == "s"
            && seen.kind == Kind::Number
            && is_named(&heading(&seen.header).name)
            && differs
    };
    let clocks: Vec<usize> = (0..planned.len()).filter(|k| is_clock(&planned[*k])).collect();
    let end = |k: usize| clocks.get(k + 1).copied().unwrap_or(planned.len());
    let names = |k: usize, clock: usize| planned[clock + 1..end(k)].iter().map(|of| of.name.clone()).collect();
    let each = clocks.iter().enumerate();
    each.map(|(k, clock)| SecondClock { name: planned[*clock].name.clone(), channels: names(k, *clock) })
        .filter(|second| !second.channels.is_empty())
        .collect()
}

/// Whether a name is one of a clock, but for a number at its end.
fn is_named(name: &str) -> bool {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '_' | ' ' | '.'));
    clock::rank(stem).is_some() || clock::has_word(stem)
}

/// Step of numbers that rise throughout.
fn step(numbers: &[f64]) -> Option<f64> {
    let rises = numbers.is_sorted_by(|before, after| before < after) && numbers.len() >= NUMBERS_MIN;
    rises.then(|| (numbers[numbers.len() - 1] - numbers[0]) / (numbers.len() - 1) as f64)
}

impl SecondClock {
    /// The recording in which the channels behind this clock have its times.
    ///
    /// # Errors
    /// As of [`series`].
    pub fn given(&self, imported: Imported) -> Result<Imported, RecordingError> {
        let mut set = match imported {
            Imported::Table(_) | Imported::Series(_) => series(imported)?,
            other => return Ok(other),
        };
        let Some(clock) = self.times(&set) else {
            set.notes.push(format!("`{}` is called as a clock is, but its times do not rise: a channel", self.name));
            return Ok(Imported::Series(set));
        };
        for channel in set.recording.channels.iter_mut().filter(|channel| self.channels.contains(&channel.name)) {
            *channel = on_clock(channel, &clock);
        }
        set.recording.channels.retain(|channel| channel.name != self.name);
        set.notes.push(format!("`{}` is the clock of {}", self.name, self.channels.join(", ")));
        Ok(Imported::Series(set))
    }

    /// The times of the clock at those of the rows, counted from where the rows count.
    fn times(&self, set: &SeriesSet) -> Option<Channel> {
        let mut clock = set.recording.channel_named(&self.name)?.clone();
        let seconds = crate::units::unit_named("s")?;
        let origin_s = Origin::of(seconds, *clock.value.first()?).second;
        if origin_s != 0 {
            clock.value.iter_mut().for_each(|time| *time -= set.origin_s as f64);
        }
        clock.value.is_sorted_by(|before, after| before < after).then_some(clock)
    }
}

/// The samples of a channel at the times that another clock has in the same rows.
fn on_clock(channel: &Channel, clock: &Channel) -> Channel {
    let mut own = Channel { time_s: Vec::new(), value: Vec::new(), ..channel.clone() };
    let mut at = 0;
    for (row_s, value) in channel.time_s.iter().zip(&channel.value) {
        while clock.time_s.get(at).is_some_and(|time| time < row_s) {
            at += 1;
        }
        if clock.time_s.get(at) == Some(row_s) {
            own.time_s.push(clock.value[at]);
            own.value.push(*value);
        }
    }
    own
}
