//! The record before identification: trends out, a lower rate (`--detrend`, `--decimate`).

use super::Arguments;
use super::structural_arguments::{Decimation, Detrend};
use crate::Failure;
use modal::decimation::PASS_BAND;
use modal::low_rate::{Trend, decimated, detrended};
use modal::record::Record;

/// A rate is reached where the quotient is this near to a whole number.
const WHOLE: f64 = 1e-6;

/// A record between gaps (the first rows behind them), and what was done to it.
pub(super) struct Prepared {
    pub record: Record,
    pub gaps: Vec<usize>,
    pub notes: Vec<String>,
}

/// # Errors
/// [`Failure::Input`] for a rate that is no whole part of the record's, and where the filter is
/// longer than every stretch without a gap.
pub(super) fn prepared(arguments: &Arguments, record: Record, gaps: Vec<usize>) -> Result<Prepared, Failure> {
    let asked = &arguments.structural;
    let mut notes = Vec::new();
    if asked.detrend == Detrend::None && asked.decimate.is_none() {
        return Ok(Prepared { record, gaps, notes });
    }
    let mut record = between_gaps(record, &gaps);
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
        record = decimated(&record, factor).ok_or_else(|| {
            Failure::Input(miette::miette!(
                help = "give a longer record or a smaller --decimate",
                "decimation by {factor} leaves nothing: the filter is longer than every stretch without a gap"
            ))
        })?;
        let (rate, edge) = (record.sample_rate_hz, PASS_BAND * record.sample_rate_hz);
        notes.push(format!(
            "decimated by {factor} to {rate:.6} Hz: pass band to {edge:.4} Hz, 70 dB above {:.4} Hz",
            1.5 * edge
        ));
    }
    let gaps = record.segments.iter().skip(1).map(|segment| segment.start).collect();
    let whole = 0..record.samples();
    Ok(Prepared { record: record.with_segments(vec![whole]), gaps, notes })
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
