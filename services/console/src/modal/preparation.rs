//! The record before identification: trends out, a lower rate (`--detrend`, `--decimate`).

use super::Arguments;
use super::structural_arguments::{Decimation, Detrend};
use crate::Failure;
use modal::decimation::PASS_BAND;
use modal::low_rate::{Trend, decimated, detrended};
use modal::record::Record;

/// A rate is reached where the quotient is this near to a whole number.
const WHOLE: f64 = 1e-6;
/// Part of a channel's samples that the filter of a lower rate leaves at least: of what gaps take
/// is no more than half.
const LEFT_SHARE_MIN: f64 = 0.5;

/// A record (NaN where no sample exists) as the arguments ask for it, and what was done to it.
///
/// # Errors
/// [`Failure::Input`] for a rate that is no whole part of the record's, and where the filter leaves
/// too little of a channel.
pub(super) fn prepared(
    arguments: &Arguments,
    names: &[String],
    mut record: Record,
) -> Result<(Record, Vec<String>), Failure> {
    let asked = &arguments.structural;
    let mut notes = Vec::new();
    let trend = match asked.detrend {
        Detrend::Mean => Some((Trend::Mean, "the mean")),
        Detrend::Linear => Some((Trend::Linear, "a line of least squares")),
        Detrend::None => None,
    };
    if let Some((trend, what)) = trend {
        record = detrended(record, trend);
        notes.push(format!("{what} was taken out of every channel (--detrend)"));
    }
    if let Some(decimation) = asked.decimate {
        let factor = factor(decimation, record.sample_rate_hz)?;
        record = at_lower_rate(names, &record, factor)?;
        let (rate, edge) = (record.sample_rate_hz, PASS_BAND * record.sample_rate_hz);
        notes.push(format!(
            "decimated by {factor} to {rate:.6} Hz: pass band to {edge:.4} Hz, 70 dB above {:.4} Hz",
            1.5 * edge
        ));
    }
    Ok((record, notes))
}

fn at_lower_rate(names: &[String], record: &Record, factor: usize) -> Result<Record, Failure> {
    let refused = |what: String, help: &'static str| Failure::Input(miette::miette!(help = help, "{what}"));
    let lower = decimated(record, factor).ok_or_else(|| {
        let what = format!("decimation by {factor} leaves nothing: the filter is longer than the record");
        refused(what, "give a longer record or a smaller --decimate")
    })?;
    for (c, name) in names.iter().enumerate() {
        let present = |record: &Record| {
            let column = record.outputs.iter().skip(c).step_by(record.channels);
            column.filter(|y| y.is_finite()).count() as f64
        };
        let left = present(&lower) * factor as f64 / present(record);
        if left < LEFT_SHARE_MIN {
            let what = format!(
                "decimation by {factor} leaves {:.0} % of {name}: its filter needs samples without a gap",
                100.0 * left
            );
            return Err(refused(
                what,
                "leave out --decimate: modes are sought at lower rates anyway; or leave out the channel with --channels",
            ));
        }
    }
    Ok(lower)
}

/// The same samples as stretches without a gap.
pub(super) fn between_gaps(record: Record, gaps: &[usize]) -> Record {
    let starts = std::iter::once(0).chain(gaps.iter().copied());
    let ends = gaps.iter().copied().chain([record.samples()]);
    let segments = starts.zip(ends).map(|(start, end)| start..end).collect();
    record.with_segments(segments)
}

fn factor(decimation: Decimation, rate_hz: f64) -> Result<usize, Failure> {
    let wanted = match decimation {
        Decimation::Factor(factor) => return Ok(factor),
        Decimation::RateHz(wanted) => wanted,
    };
    let factor = (rate_hz / wanted).round();
    if factor >= 1.0 && (rate_hz / wanted / factor - 1.0).abs() < WHOLE {
        return Ok(factor as usize);
    }
    let near = [(rate_hz / wanted).floor().max(1.0), (rate_hz / wanted).ceil().max(1.0)];
    let rates = near.map(|factor| format!("--decimate {factor} ({:.6} Hz)", rate_hz / factor));
    Err(Failure::Input(miette::miette!(
        help = format!("give a whole factor: {}", rates.join(" or ")),
        "{wanted} Hz is no whole part of the record's {rate_hz:.6} Hz"
    )))
}
