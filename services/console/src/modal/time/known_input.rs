//! Modes of a time record whose input is known: maximum likelihood.

use super::{BLOCK_ROWS, Chosen, found_mode, in_words, loudest, record_in_words, sweep};
use crate::Failure;
use crate::modal::{Arguments, Outcome, Synthesis, page};
use modal::advice::{advice, pulse_nulling};
use modal::drift;
use modal::maximum_likelihood::{MlError, Model, modelled};
use modal::methods::{Estimate, estimates};
use modal::model_order::fit_of_any_order;
use modal::po_moesp::po_moesp;
use modal::record::Record;

/// Modes that are tried at most where the number is found by likelihood: half the orders, and this.
const MODES_MAX: usize = 12;
const INPUT_KNOWN: &str =
    "modes of the structure between input and sensors; a controller that commands the input is no part of them";

/// Known input: maximum likelihood, the number of modes by likelihood.
pub(super) fn by_likelihood(arguments: &Arguments, chosen: Chosen) -> Result<Outcome, Failure> {
    let record = &chosen.record;
    if let Some(row) = chosen.gaps.first() {
        return Err(Failure::Input(miette::miette!(
            help = "cut the record with --from and --to where it has no gap: the input during a gap is not known",
            "samples are missing behind {:.6} s",
            chosen.start_s + (*row as f64 - 1.0) / record.sample_rate_hz
        )));
    }
    let modes_max = (arguments.orders.end() / 2).clamp(1, MODES_MAX);
    let model = Model { initial_motion: true, bias: true };
    let fit = fit_of_any_order(record, model, modes_max).map_err(|error| {
        let help = match error {
            MlError::RecordTooShort { need, .. } => {
                format!("give a longer record: below {need} samples there is nothing to start from")
            }
            _ => "is the input the one that drives these channels?".into(),
        };
        Failure::Input(miette::miette!(help = help, "{error}"))
    })?;
    let found = estimates(&fit);
    let record_s = record.samples() as f64 / record.sample_rate_hz;
    let mut said = advice(&found, record_s, Some(fit.residual_correlation()));
    if let Some(pulse_s) = pulse_s(record) {
        said.extend(found.iter().filter_map(|estimate: &Estimate| pulse_nulling(estimate.frequency_hz, pulse_s)));
    }
    let drift = drift::of_halves(record, model, &fit.poles);
    let tracks = drift::tracks(&found, &drift::parts_by_likelihood(record, model, &fit.poles));
    let sweep = po_moesp(
        record,
        BLOCK_ROWS.min(record.samples() / (4 * (record.channels + 1))).max(4),
        *arguments.orders.end(),
    )
    .map(|realisation| sweep(&realisation, arguments, record.sample_rate_hz))
    .unwrap_or_default();
    let loudest = loudest(record);
    let synthesis = Synthesis {
        channel: chosen.names[loudest].clone(),
        unit: chosen.unit.clone(),
        x: (0..record.samples()).map(|t| chosen.start_s + t as f64 / record.sample_rate_hz).collect(),
        over_frequency: false,
        measured: record.outputs.iter().skip(loudest).step_by(record.channels).copied().collect(),
        modelled: modelled(record, &fit).swap_remove(loudest),
    };
    Ok(Outcome {
        method: "maximum likelihood by variable projection, input known",
        kind: INPUT_KNOWN,
        deviations: "Fisher information at the variances found",
        record: record_in_words(&chosen),
        modes: found.iter().map(found_mode).collect(),
        rejected: Vec::new(),
        sweep,
        spectrum: Some(page::density_of(record)),
        synthesis: Some(synthesis),
        advice: in_words(&said, &drift),
        drift,
        tracks,
        channels: chosen.names,
        notes: chosen.notes,
    })
}

/// Length of the only stretch in which the input is not at rest, when it is one value there.
fn pulse_s(record: &Record) -> Option<f64> {
    let largest = record.input.iter().fold(0.0, |a: f64, u| a.max(u.abs()));
    let on: Vec<bool> = record.input.iter().map(|u| u.abs() > 0.5 * largest).collect();
    let (first, last) = (on.iter().position(|on| *on)?, on.iter().rposition(|on| *on)?);
    let whole = on[first..=last].iter().all(|on| *on);
    let ends = first < record.samples() / 2 && last + 1 < record.samples();
    (whole && ends && largest > 0.0).then(|| (last + 1 - first) as f64 / record.sample_rate_hz)
}
