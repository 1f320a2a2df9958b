//! A clock of numbers beside a column of dates: both tell how long the rows last.

use crate::error::RecordingError;
use crate::intake::Intake;
use crate::intake::names::heading;
use crate::intake::plan::{Clock, Kind, Plan, Seen, Source};
use crate::text::number::number;
use crate::text::printable;
use crate::text::seen::Layout;
use crate::text::stamps::Stamp;

/// Part of their span by which clocks of one recording may differ: no clock is 10 % off.
const RATE_ERROR_MAX: f64 = 0.1;

/// Holds the clock of the plan, where its unit was not said by the user, against dates beside it.
///
/// # Errors
/// The rows that were seen last otherwise by the dates than by the clock, and not for their
/// rounding: the unit of the clock is another one than its name says.
pub(super) fn agree(
    source: &Source<'_>,
    columns: &[Seen],
    layout: &Layout,
    plan: &Plan,
    intake: &Intake,
) -> Result<(), RecordingError> {
    let Clock::Number { at, unit } = &plan.clock else { return Ok(()) };
    let is_date = |(_, column): &(usize, &Seen)| matches!(column.kind, Kind::Stamp(form) if form.has_day());
    let dated = columns.iter().enumerate().find(is_date).filter(|_| intake.time_column.is_none());
    let Some((beside, Kind::Stamp(form))) = dated.map(|(beside, column)| (beside, column.kind)) else { return Ok(()) };
    let both = layout.rows.iter().filter_map(|row| {
        let time_s = unit.to_si(number(row.get(*at)?, layout.dialect.signs)?);
        Some((time_s, form.read(row.get(beside)?)?))
    });
    let both: Vec<(f64, Stamp)> = both.collect();
    let (Some(first), Some(last)) = (both.first(), both.last()) else { return Ok(()) };
    let (by_clock_s, by_dates_s) = (last.0 - first.0, last.1.since_s(first.1.day) - first.1.since_s(first.1.day));
    if by_dates_s <= 0.0 || (by_clock_s - by_dates_s).abs() <= rounding_s(&both) + RATE_ERROR_MAX * by_dates_s {
        return Ok(());
    }
    let [clock, dates] = [*at, beside].map(|at| printable(&heading(&columns[at].header).name));
    Err(RecordingError::BadClock {
        place: source.place(*at, &columns[*at].header),
        found: format!(
            "the first {} rows last {by_clock_s:.4} s by `{clock}` and {by_dates_s:.4} s by `{dates}`",
            both.len()
        ),
        cure: format!(
            "say which is the clock: --time-column '{dates}', or --time-column '{clock}:UNIT' with the unit of its numbers"
        ),
    })
}

/// The least step between dates that differ: what they are rounded to.
fn rounding_s(both: &[(f64, Stamp)]) -> f64 {
    let day = both[0].1.day;
    let steps = both.windows(2).map(|pair| (pair[1].1.since_s(day) - pair[0].1.since_s(day)).abs());
    steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min)
}
