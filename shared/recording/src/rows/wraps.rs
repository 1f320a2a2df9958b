//! Clocks that begin again after their last count: a counter of a few bytes, the second of a day or
//! of a week, the minutes of an hour, a clock of twelve hours.
//!
//! A time that goes back by one period less a usual step goes on; any other begins another
//! recording, or is a mistake. A period that is one of people's, not of a counter, may end where a
//! recording of just that length does: then the time goes back to where it began, and begins again.

use crate::intake::plan::{Clock as Times, Plan};
use crate::intake::stamps::{Clock, Form};

/// Steps before a jump back that show what is usual.
const STEPS: usize = 64;
/// Usual steps that may lie across the end of a period.
const JUMP_STEPS_MAX: f64 = 2.5;

/// After what time a clock begins again.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Period {
    length_s: f64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Of a counter with so many bits, one count being worth this [s].
    Bits(u32, f64),
    /// One of people's.
    Named(&'static str),
    /// The second that was put in before midnight.
    Leap,
}

/// What a clock has begun again.
#[derive(Clone, Debug, Default)]
pub(super) struct Wraps {
    periods: Vec<Period>,
    found: Option<Period>,
    first_line: u64,
    count: u64,
    shift_s: f64,
}

impl Wraps {
    /// Of the clock of a plan.
    pub fn of(plan: &Plan) -> Self {
        let named = |(length_s, name)| Period { length_s, kind: Kind::Named(name) };
        let (day, week) = ((86_400.0, "a day"), (604_800.0, "a week"));
        let (hour, half) = ((3600.0, "an hour"), (43_200.0, "half a day"));
        let periods = match &plan.clock {
            Times::Rows { .. } | Times::Steps { .. } => Vec::new(),
            Times::Number { unit, .. } => {
                let bits = [8, 16, 24, 32].map(|bits| of_bits(bits, unit.to_si(1.0)));
                bits.into_iter().chain([hour, day, week].map(named)).collect()
            }
            Times::Stamps(parts) => match parts[..] {
                [(_, Form::Time(Clock::Minutes))] => vec![named(hour)],
                [(_, Form::Time(_))] => vec![named(half)],
                [(_, Form::Hex(ns))] => [8, 16, 24, 32].map(|bits| of_bits(bits, ns as f64 * 1e-9)).into(),
                _ => vec![Period { length_s: 1.0, kind: Kind::Leap }],
            },
        };
        Wraps { periods, ..Wraps::default() }
    }

    /// What is to be added to a time behind `times`, which are those of one recording.
    pub fn shift_s(&mut self, line: u64, value: f64, times: &[f64]) -> f64 {
        let Some(last) = times.last().copied() else { return self.begin() };
        let time = value + self.shift_s;
        if time >= last || self.periods.is_empty() {
            return self.shift_s;
        }
        let usual_s = usual_step(times);
        let of_this = |period: &Period| period.fits(value, (time, last), usual_s, times[0]);
        let known = self.found.filter(|period| time + period.length_s > last);
        match known.or_else(|| self.periods.iter().copied().find(of_this)) {
            Some(period) => {
                if self.found.is_none() {
                    self.first_line = line;
                }
                self.found = Some(period).filter(|period| period.kind != Kind::Leap);
                self.count += 1;
                self.shift_s += period.length_s;
                self.shift_s
            }
            None => self.begin(),
        }
    }

    /// Another recording, or a mistake: nothing is known of its clock.
    fn begin(&mut self) -> f64 {
        self.found = None;
        self.shift_s = 0.0;
        0.0
    }

    /// Says what was made of the clock.
    pub fn note(&self) -> Option<String> {
        let line = self.first_line;
        let often = if self.count == 1 { String::new() } else { format!(", {} times", self.count) };
        let reason = match self.found.map(|period| period.kind) {
            _ if self.count == 0 => return None,
            Some(Kind::Bits(bits, _)) => format!("after 2^{bits} counts"),
            Some(Kind::Named(name)) => format!("after {name}"),
            Some(Kind::Leap) | None => "at a leap second or after a full period".into(),
        };
        Some(format!("the clock begins again {reason} (line {line}{often}): it is counted on, the recording is one"))
    }
}

fn of_bits(bits: u32, count_s: f64) -> Period {
    Period { length_s: count_s * f64::from(bits).exp2(), kind: Kind::Bits(bits, count_s) }
}

impl Period {
    /// Whether `time` behind `last` is the next of a clock that begins again after this period;
    /// `value` is the time as the file has it, `first` that with which the recording began.
    fn fits(&self, value: f64, (time, last): (f64, f64), usual_s: f64, first: f64) -> bool {
        let step = time + self.length_s - last;
        if usual_s <= 0.0 || step <= 1e-3 * usual_s || step > JUMP_STEPS_MAX * usual_s {
            return false;
        }
        match self.kind {
            Kind::Bits(_, count_s) => is_whole(value / count_s) && value >= 0.0 && value < self.length_s,
            Kind::Named(_) => (value - first).abs() > JUMP_STEPS_MAX * usual_s,
            Kind::Leap => last.rem_euclid(86_400.0) < 1.0 && time.rem_euclid(86_400.0) <= JUMP_STEPS_MAX * usual_s,
        }
    }
}

fn is_whole(count: f64) -> bool {
    (count - count.round()).abs() < 1e-6
}

/// The median of the last steps that go on.
fn usual_step(times: &[f64]) -> f64 {
    let from = times.len().saturating_sub(STEPS + 1);
    let mut steps: Vec<f64> = times[from..].windows(2).map(|pair| pair[1] - pair[0]).filter(|s| *s > 0.0).collect();
    steps.sort_unstable_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}
