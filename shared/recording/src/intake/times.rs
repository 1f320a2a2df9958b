//! Times of the rows of a dataset in memory.

use super::origin::Origin;
use super::plan::Clock;
use super::stamps::{Form, Stamp, sum};
use crate::dataset::{Axis, RawDataset};
use crate::units::Unit;

/// The clock of a dataset, row by row.
pub(crate) struct Times<'a> {
    dataset: &'a RawDataset,
    clock: &'a Clock,
    origin: Origin,
    start_s: f64,
    /// First day of a clock of stamps.
    day: Option<i64>,
    /// Sum of the steps so far.
    elapsed_s: f64,
}

impl<'a> Times<'a> {
    /// Of the clock that was planned for `dataset`.
    pub fn of(dataset: &'a RawDataset, clock: &'a Clock) -> Self {
        let origin = match clock {
            Clock::Number { at, unit } => {
                let first = dataset.columns[*at].values.iter().copied().find(|value| value.is_finite());
                Origin::of(*unit, first.unwrap_or(0.0))
            }
            _ => Origin::of(Unit::not_stated(), 0.0),
        };
        let start_s = if let Axis::Uniform { start_s, .. } = dataset.axis { start_s } else { 0.0 };
        Times { dataset, clock, origin, start_s, day: None, elapsed_s: 0.0 }
    }

    /// Time of row `i` \[s\], behind those of the rows before; NaN of a row without a time.
    pub fn next(&mut self, i: usize) -> f64 {
        let value = |column: usize| self.dataset.columns[column].values.get(i).copied().unwrap_or(f64::NAN);
        let rest = |column: usize| self.dataset.columns[column].rest.get(i).copied().unwrap_or(0.0);
        match self.clock {
            Clock::Number { at, .. } => self.origin.time_s(value(*at), rest(*at)),
            Clock::Rows { interval_s } => self.start_s + i as f64 * interval_s,
            Clock::Steps { at, unit } => {
                let step_s = unit.to_si(value(*at));
                if i > 0 {
                    self.elapsed_s += if step_s.is_finite() { step_s } else { 0.0 };
                }
                if step_s.is_nan() && i > 0 { f64::NAN } else { self.elapsed_s }
            }
            Clock::Stamps(parts) => {
                let stamp = |(at, form): &(usize, Form)| Some((*form, form.of_value(value(*at), rest(*at))?));
                let stamps: Option<Vec<(Form, Stamp)>> = parts.iter().map(stamp).collect();
                let Some(stamp) = stamps.map(|stamps| sum(stamps.into_iter())) else { return f64::NAN };
                let day = *self.day.get_or_insert(if self.clock.has_day() { stamp.day } else { 0 });
                stamp.since_s(day)
            }
        }
    }

    /// What the times count from \[s since 1970\]; 0: from where the file says.
    pub fn origin_s(&self) -> i64 {
        self.day.map_or(self.origin.second, |day| day * 86_400)
    }
}
