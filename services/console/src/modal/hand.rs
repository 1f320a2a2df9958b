//! Poles of the sweep that were picked by hand (`--select`).

use super::preparation::between_gaps;
use crate::Failure;
use modal::hand_selection::by_hand;
use modal::record::Record;
use modal::{Mode, Selection};

/// How well a frequency is read from a diagram, in parts of its axis.
const READING: f64 = 0.01;

/// The poles nearest to the picks over so many block rows, in order of frequency; none is rejected.
///
/// # Errors
/// [`Failure::Input`] where the record is too short or flat, for an order without oscillations, and
/// for a pick without a pole.
pub(super) fn selected(
    picks: &[(usize, f64)],
    record: &Record,
    gaps: &[usize],
    block_rows: usize,
) -> Result<Selection, Failure> {
    let wrong = |what: String, cure: &str| Failure::Input(miette::miette!(help = cure.to_string(), "{what}"));
    let found = by_hand(&between_gaps(record.clone(), gaps), block_rows, picks)
        .map_err(|error| wrong(format!("--select: {error}"), "give a longer record, or lower orders"))?;
    if let Some(at) = found.iter().position(Option::is_none) {
        let (order, hz) = picks[at];
        return Err(wrong(
            format!("--select {order}:{hz}: the sweep has no oscillation of order {order}"),
            "pick an order that the stabilisation diagram shows (--out DIR draws it)",
        ));
    }
    let mut modes: Vec<Mode> = found.into_iter().flatten().collect();
    let tolerance_hz = READING * 0.5 * record.sample_rate_hz;
    let is_missed = |(mode, (_, hz)): &(&Mode, &(usize, f64))| {
        (mode.frequency_hz - hz).abs() > tolerance_hz.max(mode.damping_ratio * mode.frequency_hz)
    };
    if let Some((mode, (order, hz))) = modes.iter().zip(picks).find(is_missed) {
        return Err(wrong(
            format!(
                "--select {order}:{hz}: order {order} has no pole there; the nearest is at {:.4} Hz",
                mode.frequency_hz
            ),
            "pick a pole that the stabilisation diagram shows (--out DIR draws it)",
        ));
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(Selection { modes, rejected: Vec::new() })
}
