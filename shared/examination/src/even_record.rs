//! Channels as one record on an even clock, with every defect found and dealt with: rows
//! that are missing, values that are held, channels that are late, samples that are clipped.
//!
//! - Stamps: the clock of all stamps together ([`EvenClock`]); a row at which a channel has no
//!   sample is NaN for it.
//! - Held values: where all channels are held, the record is read at the rate of the fastest; a
//!   channel that is slower than the record has samples at its fresh rows only.
//! - Late channels: their delays are reported, for the reader of phases.

use crate::clipping::clipped;
use crate::delay::delays;
use crate::held::{Held, held};
use channels::{Channel, EvenClock};
use estimation::quantiles::median;

/// Rows of the grid per stamp at most: beyond, the stamps are of no common clock.
const ROWS_PER_STAMP_MAX: usize = 20;
/// Rows between values of channels that are held together: rounding of a ratio to a thousandth.
const SAME_RATE: f64 = 1e-2;

/// A record on an even clock.
#[derive(Clone, Debug)]
pub struct EvenRecord {
    pub rate_hz: f64,
    /// Time of the first row.
    pub start_s: f64,
    /// Row by row, NaN where a channel has no sample.
    pub values: Vec<f64>,
    pub channels: usize,
    /// Per channel, against the majority of those of its unit; zero where none is reported.
    pub delays_s: Vec<f64>,
    /// Rate of the file where the record is read at a lower one: what lies above half of
    /// [`Self::rate_hz`] is folded.
    pub logged_rate_hz: Option<f64>,
    pub treatments: Vec<Treatment>,
}

/// A finding and what was done about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Treatment {
    /// As the examination calls it.
    pub check: &'static str,
    pub channel: String,
    pub value: f64,
    pub unit: &'static str,
    pub did: String,
}

impl EvenRecord {
    /// The record of channels in SI; `None` where their stamps have no common even clock.
    #[must_use]
    pub fn of(channels: &[&Channel]) -> Option<Self> {
        let (clock, mut columns) = on_one_clock(channels)?;
        let mut record = Self {
            rate_hz: 1.0 / clock.interval_s,
            start_s: clock.start_s,
            values: Vec::new(),
            channels: channels.len(),
            delays_s: vec![0.0; channels.len()],
            logged_rate_hz: None,
            treatments: Vec::new(),
        };
        record.note_missing(&columns);
        record.note_constant(channels, &columns);
        record.note_clipped(channels, &columns);
        let steps: Vec<Option<Held>> = columns.iter().map(|column| held(column)).collect();
        record.at_fresh_rows(channels, &mut columns, &steps);
        record.find_delays(channels, &columns, &steps);
        let rows = columns.first().map_or(0, Vec::len);
        record.values = (0..rows).flat_map(|t| columns.iter().map(move |column| column[t])).collect();
        Some(record)
    }

    /// Rows of the record.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.channels
    }

    /// Whether samples of a channel stand at a limit.
    #[must_use]
    pub fn is_clipped(&self) -> bool {
        self.treatments.iter().any(|treatment| treatment.check == "saturation")
    }

    fn note_missing(&mut self, columns: &[Vec<f64>]) {
        let cells: usize = columns.iter().map(Vec::len).sum();
        let absent = columns.iter().flatten().filter(|y| !y.is_finite()).count();
        if absent > 0 {
            let percent = 100.0 * absent as f64 / cells as f64;
            self.treat("missing", "", percent, "%", format!("{percent:.3} % of the samples are missing"));
        }
    }

    fn note_constant(&mut self, channels: &[&Channel], columns: &[Vec<f64>]) {
        for (channel, column) in channels.iter().zip(columns) {
            let mut present = column.iter().filter(|y| y.is_finite());
            if let Some(first) = present.next().filter(|first| present.all(|y| y == *first)) {
                self.treat(
                    "constant",
                    &channel.name,
                    *first,
                    "si",
                    "moves in no mode: its part of every shape is zero".into(),
                );
            }
        }
    }

    fn note_clipped(&mut self, channels: &[&Channel], columns: &[Vec<f64>]) {
        let named = channels.iter().zip(columns);
        self.treatments.extend(named.filter_map(|(channel, column)| at_a_limit(&channel.name, column)));
    }

    fn treat(&mut self, check: &'static str, channel: &str, value: f64, unit: &'static str, did: String) {
        self.treatments.push(Treatment { check, channel: channel.into(), value, unit, did });
    }

    /// Keeps fresh values only; a lower rate where no channel is as fast as the rows.
    fn at_fresh_rows(&mut self, channels: &[&Channel], columns: &mut [Vec<f64>], steps: &[Option<Held>]) {
        let ratio = |step: &Option<Held>| step.as_ref().map_or(1.0, |held| held.rows_per_value);
        let fastest = steps.iter().map(ratio).fold(f64::INFINITY, f64::min);
        let logged_hz = self.rate_hz;
        for (channel, step) in channels.iter().zip(steps) {
            if let Some(held) = step {
                let rate_hz = logged_hz / held.rows_per_value;
                let as_rest = (held.rows_per_value / fastest - 1.0).abs() < SAME_RATE;
                let did = if as_rest {
                    format!("read at the {rate_hz:.6} Hz at which its values change, logged at {logged_hz:.6} Hz")
                } else {
                    format!("only its fresh values are used, {rate_hz:.6} Hz beside {:.6} Hz", logged_hz / fastest)
                };
                self.treat("held", &channel.name, rate_hz, "Hz", did);
            }
        }
        if fastest <= 1.0 {
            for (column, held) in columns.iter_mut().zip(steps).filter_map(|(c, h)| h.as_ref().map(|h| (c, h))) {
                let fresh = values_of(column, &held.fresh_rows);
                column.fill(f64::NAN);
                fresh.iter().zip(&held.fresh_rows).for_each(|(y, row)| column[*row] = *y);
            }
            return;
        }
        let Some(clock) = steps.iter().position(|step| (ratio(step) / fastest - 1.0).abs() < 1e-9) else { return };
        let rows = steps[clock].as_ref().map_or(&[][..], |held| &held.fresh_rows).to_vec();
        let Some(first) = rows.first() else { return };
        self.start_s += *first as f64 / logged_hz;
        self.rate_hz = logged_hz / fastest;
        self.logged_rate_hz = Some(logged_hz);
        for ((column, step), late_s) in columns.iter_mut().zip(steps).zip(&mut self.delays_s) {
            let Some(held) = step else { continue };
            let fresh = values_of(column, &held.fresh_rows);
            // A fresh value belongs to the last row of the clock that is not behind it.
            let mut read = vec![f64::NAN; rows.len()];
            let mut ahead = Vec::new();
            for (y, row) in fresh.iter().zip(&held.fresh_rows) {
                let Some(j) = rows.partition_point(|fast| fast <= row).checked_sub(1) else { continue };
                read[j] = *y;
                ahead.push((row - rows[j]) as f64 / logged_hz);
            }
            // Its value is younger than the row it stands in.
            *late_s = if ahead.is_empty() { 0.0 } else { -median(&mut ahead) };
            *column = read;
        }
    }

    fn find_delays(&mut self, channels: &[&Channel], columns: &[Vec<f64>], steps: &[Option<Held>]) {
        let whole = |k: &usize| self.logged_rate_hz.is_some() || steps[*k].is_none();
        let mut left: Vec<usize> = (0..channels.len()).filter(whole).collect();
        while let Some(first) = left.first().copied() {
            let (of_unit, others): (Vec<usize>, Vec<usize>) =
                left.iter().partition(|k| channels[**k].unit == channels[first].unit);
            left = others;
            let filled: Vec<Vec<f64>> = of_unit.iter().map(|k| without_holes(&columns[*k])).collect();
            let views: Vec<&[f64]> = filled.iter().map(Vec::as_slice).collect();
            for (k, found) in of_unit.iter().zip(delays(&views, 1.0 / self.rate_hz)) {
                if let Some(found) = found {
                    self.delays_s[*k] = found.delay_s;
                    let did = format!(
                        "{:.4} ± {:.4} s behind the others: taken out of the shapes",
                        found.delay_s, found.sigma_s
                    );
                    self.treat("delay", &channels[*k].name, found.delay_s, "s", did);
                }
            }
        }
    }
}

/// The finding that samples of a channel stand at a limit.
#[must_use]
pub fn at_a_limit(name: &str, column: &[f64]) -> Option<Treatment> {
    let found = clipped(column)?;
    let did = format!(
        "{:.2} % of the samples stand at {:.6}: used as they are, which adds noise and harmonics",
        100.0 * found.share,
        found.level
    );
    Some(Treatment { check: "saturation", channel: name.into(), value: found.level, unit: "si", did })
}

/// Of each fresh row, the first value that exists until the next.
fn values_of(column: &[f64], fresh_rows: &[usize]) -> Vec<f64> {
    let ends = fresh_rows.iter().skip(1).copied().chain([column.len()]);
    let value = |(from, to): (&usize, usize)| column[*from..to].iter().copied().find(|y| y.is_finite());
    fresh_rows.iter().zip(ends).map(|pair| value(pair).unwrap_or(f64::NAN)).collect()
}

/// Straight lines over what is missing; level at the ends.
#[must_use]
pub fn without_holes(column: &[f64]) -> Vec<f64> {
    let mut filled = column.to_vec();
    let present: Vec<usize> = (0..column.len()).filter(|t| column[*t].is_finite()).collect();
    let (Some(first), Some(last)) = (present.first(), present.last()) else { return vec![0.0; column.len()] };
    filled[..*first].fill(column[*first]);
    filled[*last..].fill(column[*last]);
    for pair in present.windows(2).filter(|pair| pair[1] > pair[0] + 1) {
        let (a, b) = (column[pair[0]], column[pair[1]]);
        let share = |place: usize| (place + 1) as f64 / (pair[1] - pair[0]) as f64;
        let hole = filled[pair[0] + 1..pair[1]].iter_mut().enumerate();
        hole.for_each(|(place, y)| *y = a + (b - a) * share(place));
    }
    filled
}

/// The clock of all stamps and every channel at its rows.
fn on_one_clock(channels: &[&Channel]) -> Option<(EvenClock, Vec<Vec<f64>>)> {
    let mut stamps: Vec<f64> = channels.first()?.time_s.clone();
    if channels.iter().any(|channel| channel.time_s != stamps) {
        stamps = channels.iter().flat_map(|channel| channel.time_s.iter().copied()).collect();
        stamps.sort_by(f64::total_cmp);
        stamps.dedup();
    }
    let clock = EvenClock::of(&stamps)?;
    let rows = clock.rows.last()? + 1;
    if rows > ROWS_PER_STAMP_MAX * stamps.len() {
        return None;
    }
    let column = |channel: &&Channel| {
        let mut column = vec![f64::NAN; rows];
        let mut at = 0;
        for (time, value) in channel.time_s.iter().zip(&channel.value) {
            while stamps[at] < *time {
                at += 1;
            }
            column[clock.rows[at]] = *value;
        }
        column
    };
    let columns = channels.iter().map(column).collect();
    Some((clock, columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Two modes, seen at three places.
    fn motion(rows: usize) -> Vec<Vec<f64>> {
        let mut noise = Noise::new(3);
        let mut columns = vec![Vec::new(); 3];
        let mut states = [[0.0; 2]; 2];
        for _ in 0..rows {
            for (state, turn) in states.iter_mut().zip([0.2_f64, 0.6]) {
                let next = 1.98 * turn.cos() * state[0] - 0.9801 * state[1] + noise.normal();
                *state = [next, state[0]];
            }
            let shapes = [[1.0, 0.5], [-0.6, 0.9], [0.8, -0.7]];
            for (column, shape) in columns.iter_mut().zip(shapes) {
                column.push(shape[0] * states[0][0] + shape[1] * states[1][0] + 0.05 * noise.normal());
            }
        }
        columns
    }

    fn channel(k: usize, values: &[f64], kept: impl Fn(usize) -> bool) -> Channel {
        let rows: Vec<usize> = (0..values.len()).filter(|t| kept(*t)).collect();
        let time = rows.iter().map(|t| *t as f64 / 50.0).collect();
        Channel::new(&format!("a{k}"), "m/s^2", time, rows.iter().map(|t| values[*t]).collect())
    }

    #[test]
    fn a_row_that_is_missing_is_a_row_without_values() {
        let columns = motion(4000);
        let channels: Vec<Channel> = columns.iter().enumerate().map(|(k, c)| channel(k, c, |t| t % 10 != 3)).collect();
        let record = EvenRecord::of(&channels.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(record.rows(), 4000);
        assert!((record.rate_hz - 50.0).abs() < 1e-6);
        for (t, y) in columns[1].iter().enumerate() {
            let value = record.values[3 * t + 1];
            assert!(if t % 10 == 3 { value.is_nan() } else { value == *y });
        }
        assert_eq!(record.treatments.iter().filter(|t| t.check == "missing").count(), 1);
    }

    #[test]
    fn a_record_whose_values_stand_seven_times_is_read_at_a_seventh_of_its_rate() {
        let columns = motion(7000);
        let held: Vec<Vec<f64>> = columns.iter().map(|c| (0..7000).map(|t| c[t - t % 7]).collect()).collect();
        let channels: Vec<Channel> = held.iter().enumerate().map(|(k, c)| channel(k, c, |_| true)).collect();
        let record = EvenRecord::of(&channels.iter().collect::<Vec<_>>()).unwrap();
        assert!((record.rate_hz - 50.0 / 7.0).abs() < 1e-3);
        assert!(record.logged_rate_hz.is_some() && record.values.iter().all(|y| y.is_finite()));
        assert_eq!(record.values[3], columns[0][14], "the second fresh value follows the first");
    }

    #[test]
    fn a_slower_channel_has_samples_at_its_fresh_rows_and_the_others_at_all() {
        let mut columns = motion(4000);
        columns[1] = (0..4000).map(|t| columns[1][t - t % 4]).collect();
        let channels: Vec<Channel> = columns.iter().enumerate().map(|(k, c)| channel(k, c, |_| true)).collect();
        let record = EvenRecord::of(&channels.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!(record.rows(), 4000);
        let fresh = (0..4000).filter(|t| record.values[3 * t + 1].is_finite()).count();
        assert!((995..=1000).contains(&fresh), "{fresh}");
        assert!((0..4000).all(|t| record.values[3 * t].is_finite() && record.values[3 * t + 2].is_finite()));
    }
}
