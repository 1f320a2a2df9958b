//! Columns of times beside the clock of the rows: clocks of the columns that follow them, where a
//! file puts channels with clocks of their own side by side, or other clocks of the same rows.

use super::clock::{self, EPOCH_S};
use super::guessed_unit;
use super::names::heading;
use super::plan::{Clock, Kind, Planned, Seen};
use crate::error::RecordingError;
use crate::series::SeriesSet;
use crate::units::Unit;
use crate::{Imported, series};
use channels::Channel;

/// Fewest numbers that show a clock.
const NUMBERS_MIN: usize = 4;

/// A clock of some of the columns.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SecondClock {
    /// Channel that it was read as.
    name: String,
    /// Seconds of one of the channel's numbers.
    seconds: f64,
    /// Names of the channels that follow it up to the next clock; none: it is another clock of the
    /// rows.
    channels: Vec<String>,
}

/// The clocks among the channels to be: columns that are called as clocks are, with rising times.
/// What follows the clock of the rows at once is another clock of the rows.
pub(crate) fn of(all: &[Seen], first: &Clock, planned: &[Planned]) -> Vec<SecondClock> {
    let at = match first {
        Clock::Number { at, .. } | Clock::Steps { at, .. } => *at,
        Clock::Stamps(parts) => parts.iter().map(|(at, _)| *at).max().unwrap_or(0),
        Clock::Rows { .. } => return Vec::new(),
    };
    let clocks: Vec<(usize, Unit)> =
        planned.iter().enumerate().filter_map(|(k, of)| Some((k, unit_of_clock(&all[of.at], of)?))).collect();
    let end = |k: usize| clocks.get(k + 1).map_or(planned.len(), |(next, _)| *next);
    let second = |(k, (place, unit)): (usize, &(usize, Unit))| {
        let of = &planned[*place];
        let is_of_rows = of.at < at || (at + 1..of.at).all(|between| is_clock_or_unused(all, planned, between));
        let followers = if is_of_rows { &[] } else { &planned[place + 1..end(k)] };
        let channels = followers.iter().map(|of| of.name.clone()).collect();
        SecondClock { name: of.name.clone(), seconds: unit.to_si(1.0) / of.unit.to_si(1.0), channels }
    };
    clocks.iter().enumerate().map(second).collect()
}

/// Whether a column is no channel with values of its own.
fn is_clock_or_unused(all: &[Seen], planned: &[Planned], at: usize) -> bool {
    planned.iter().find(|of| of.at == at).is_none_or(|of| unit_of_clock(&all[at], of).is_some())
}

/// The unit of a column that is called as a clock is, and whose numbers rise.
fn unit_of_clock(seen: &Seen, of: &Planned) -> Option<Unit> {
    let name = heading(&seen.header).name;
    let rises = seen.sample.is_sorted_by(|before, after| before < after) && seen.sample.len() >= NUMBERS_MIN;
    if seen.kind != Kind::Number || !rises || !is_named(&name) {
        return None;
    }
    let stated = (of.unit.si == "s").then_some(of.unit);
    let silent = of.unit_in_file.is_empty();
    stated.or_else(|| clock::ending(&name).filter(|_| silent)).or_else(|| {
        let (unit, _) = guessed_unit::guessed(&name, &seen.sample).ok()?;
        silent.then_some(unit)
    })
}

/// Whether a name is one of a clock, but for a number at its end.
fn is_named(name: &str) -> bool {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '_' | ' ' | '.'));
    clock::rank(stem).is_some() || clock::has_word(stem)
}

impl SecondClock {
    /// Follows a channel that gets another name.
    pub fn rename(&mut self, from: &str, to: &str) {
        for name in self.channels.iter_mut().chain([&mut self.name]).filter(|name| *name == from) {
            to.clone_into(name);
        }
    }

    /// The recording in which the channels behind this clock have its times.
    ///
    /// # Errors
    /// As of [`series`].
    pub fn given(&self, imported: Imported) -> Result<Imported, RecordingError> {
        let mut set = match imported {
            Imported::Table(mut table) if self.channels.is_empty() => {
                table.notes.push(self.of_rows());
                return Ok(Imported::Table(table));
            }
            Imported::Table(_) | Imported::Series(_) => series(imported)?,
            other => return Ok(other),
        };
        if self.channels.is_empty() {
            set.notes.push(self.of_rows());
            return Ok(Imported::Series(set));
        }
        let Some(clock) = self.times(&set) else {
            set.notes.push(format!("`{}` is called as a clock is, but its times do not rise: a channel", self.name));
            return Ok(Imported::Series(set));
        };
        if !self.has_zero_of_rows(&clock, &set) {
            set.notes.push(format!(
                "`{0}` counts from another zero than the clock of the rows, which times {1}, too: say --time-column \
                 '{0}' if it is the better one",
                self.name,
                self.channels.join(", ")
            ));
            return Ok(Imported::Series(set));
        }
        let is_same = clock.value.iter().zip(&clock.time_s).all(|(own, row)| (own - row).abs() <= 1e-9 * row.abs());
        for channel in set.recording.channels.iter_mut().filter(|of| !is_same && self.channels.contains(&of.name)) {
            *channel = on_clock(channel, &clock);
        }
        set.recording.channels.retain(|channel| channel.name != self.name);
        set.notes.push(if is_same {
            format!("`{}` repeats the times of the rows: left out", self.name)
        } else {
            format!("`{}` is the clock of {}", self.name, self.channels.join(", "))
        });
        Ok(Imported::Series(set))
    }

    fn of_rows(&self) -> String {
        format!(
            "`{}` is another clock of the rows, not used: --time-column '{}' takes it instead",
            self.name, self.name
        )
    }

    /// The times of the clock \[s\] at those of the rows.
    fn times(&self, set: &SeriesSet) -> Option<Channel> {
        let mut clock = set.recording.channel_named(&self.name)?.clone();
        clock.value.iter_mut().for_each(|time| *time *= self.seconds);
        if is_of_1970(&clock) {
            clock.value.iter_mut().for_each(|time| *time -= set.origin_s as f64);
        }
        clock.value.is_sorted_by(|before, after| before < after).then_some(clock)
    }

    /// Whether the clock counts from where that of the rows does: both from 1970 or neither, and at
    /// times that overlap.
    fn has_zero_of_rows(&self, clock: &Channel, set: &SeriesSet) -> bool {
        let from_1970 = set.recording.channel_named(&self.name).is_some_and(|raw| {
            let raw = raw.value.iter().map(|time| time * self.seconds).collect();
            is_of_1970(&Channel { value: raw, ..clock.clone() })
        });
        let ends = |of: &[f64]| of.first().copied().zip(of.last().copied());
        let overlap =
            ends(&clock.value).zip(ends(&clock.time_s)).is_some_and(|(own, row)| own.0 <= row.1 && row.0 <= own.1);
        from_1970 == (set.origin_s != 0) && overlap
    }
}

/// Whether times \[s\] are those since 1970.
fn is_of_1970(clock: &Channel) -> bool {
    clock.value.first().is_some_and(|first| EPOCH_S.contains(first))
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
