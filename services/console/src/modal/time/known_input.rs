//! Modes of a time record whose input is known: maximum likelihood.

use super::{BLOCK_ROWS, Chosen, found_mode, in_words, loudest, record_in_words, sweep};
use crate::Failure;
use crate::modal::as_it_is::AsItIs;
use crate::modal::preparation::prepared;
use crate::modal::{Arguments, FoundMode, Outcome, Structure, Synthesis, Verdict, page};
use examination::even_record::{Treatment, at_a_limit};
use modal::advice::{advice, pulse_nulling};
use modal::drift;
use modal::known_input::{Identified, Noise, identify};
use modal::maximum_likelihood::{MlError, Model, explained};
use modal::methods::{Estimate, estimates};
use modal::po_moesp::po_moesp;
use modal::record::Record;

/// Modes that are tried at most where the number is found by likelihood: half the orders, and this.
const MODES_MAX: usize = 12;
const INPUT_KNOWN: &str =
    "modes of the structure between input and sensors; a controller that commands the input is no part of them";
const CANDIDATES: &str =
    "candidates, not modes: no linear model with this input and white sensor noise explains the record";
/// Deviation of a time from the even clock, in periods, up to which the rows in between are
/// counted.
const OFF_CLOCK_MAX: f64 = 0.3;

/// Known input: maximum likelihood, the number of modes by likelihood.
pub(super) fn by_likelihood(arguments: &Arguments, mut chosen: Chosen) -> Result<Outcome, Failure> {
    let (record, notes) = prepared(arguments, &chosen.names, chosen.record)?;
    chosen.record = record;
    chosen.notes.extend(notes);
    let record = on_even_clock(&chosen)?;
    let modes_max = (arguments.orders.end() / 2).clamp(1, MODES_MAX);
    let answer = identify(&record, Model::FREE, may_accelerate(&chosen.unit), modes_max).map_err(|error| {
        let help = match error {
            MlError::RecordTooShort { need, .. } => {
                format!("give a longer record: below {need} samples there is nothing to start from")
            }
            _ => "is the input the one that drives these channels?".into(),
        };
        Failure::Input(miette::miette!(help = help, "{error}"))
    })?;
    let found = estimates(&answer.fit);
    let record_s = record.samples() as f64 / record.sample_rate_hz;
    let absent = absent_rows(&record);
    // What changes along the record is evidence of a structure that is not linear; under a
    // disturbance in a loop the parts are as wrong as the whole.
    let plain = !answer.feedback || (answer.noise == Noise::OfSensors && answer.adequate);
    let mut said = if answer.adequate { advice(&found, record_s, None) } else { Vec::new() };
    if let Some(pulse_s) = pulse_s(&record).filter(|_| answer.adequate) {
        said.extend(found.iter().filter_map(|estimate: &Estimate| pulse_nulling(estimate.frequency_hz, pulse_s)));
    }
    let model = answer.model;
    let (drift, tracks) = if plain && absent == 0 && answer.lags.is_empty() {
        let parts = drift::parts_by_likelihood(&record, model, &answer.fit.poles);
        (drift::of_halves(&record, model, &answer.fit.poles), drift::tracks(&found, &parts))
    } else {
        (Vec::new(), Vec::new())
    };
    let rows = BLOCK_ROWS.min(record.samples() / (4 * (record.channels + 1))).max(4);
    let sweep = (absent == 0)
        .then(|| po_moesp(&record, rows, *arguments.orders.end()).ok())
        .flatten()
        .map(|realisation| sweep(&realisation, arguments, record.sample_rate_hz))
        .unwrap_or_default();
    let mode = |estimate: &Estimate| match answer.adequate {
        true => found_mode(estimate),
        false => FoundMode { frequency_sd: None, damping_sd: None, ..found_mode(estimate) },
    };
    let treatments = clipped(arguments, &chosen);
    Ok(Outcome {
        method: match answer.noise {
            Noise::OfSensors => "maximum likelihood by variable projection, input known",
            Noise::Innovations => "maximum likelihood of the innovations form, input known",
        },
        kind: if answer.adequate { INPUT_KNOWN } else { CANDIDATES },
        deviations: match (answer.adequate, answer.noise) {
            (false, _) => "not given, for the model does not explain the record",
            (true, Noise::OfSensors) => "Fisher information at the variances found",
            (true, Noise::Innovations) => "Fisher information of the innovations form, gains of the disturbance free",
        },
        record: record_in_words(&chosen),
        modes: found.iter().map(mode).collect(),
        rejected: Vec::new(),
        sweep,
        spectrum: Some(page::density_of(&chosen.record)),
        synthesis: Some(synthesis(&chosen, &record, &answer)),
        advice: verdict_in_words(&chosen, &answer, absent).into_iter().chain(in_words(&said, &drift)).collect(),
        drift,
        tracks,
        structure: Structure::of_record(arguments, &chosen.record, &chosen.gaps),
        channels: chosen.names,
        notes: chosen.notes,
        as_it_is: AsItIs { treatments, ..AsItIs::default() },
        verdict: Some(Verdict { adequate: answer.adequate, residual: answer.residual }),
    })
}

/// What the examination says of limits, of the responses and of the input.
fn clipped(arguments: &Arguments, chosen: &Chosen) -> Vec<Treatment> {
    let column = |values: &[f64], width: usize, k: usize| -> Vec<f64> {
        values.iter().skip(k).step_by(width).copied().collect()
    };
    let record = &chosen.record;
    let responses = chosen.names.iter().enumerate();
    let mut found: Vec<Treatment> =
        responses.filter_map(|(k, name)| at_a_limit(name, &column(&record.outputs, record.channels, k))).collect();
    let input = arguments.input.as_deref().unwrap_or_default();
    found.extend((0..record.inputs).filter_map(|k| at_a_limit(input, &column(&record.input, record.inputs, k))));
    found
}

/// Whether a channel in this unit may answer a force at the same sample: positions and rates
/// cannot.
fn may_accelerate(unit: &str) -> bool {
    const NEVER: [&str; 12] =
        ["rad", "deg", "m", "mm", "um", "rad/s", "deg/s", "m/s", "mm/s", "arcsec", "urad", "mrad"];
    !NEVER.contains(&unit)
}

/// What holds and what does not, first.
fn verdict_in_words(chosen: &Chosen, answer: &Identified, absent: usize) -> Vec<String> {
    let mut said = Vec::new();
    let residual = &answer.residual;
    if !answer.adequate {
        said.push(format!(
            "no output-error model explains the record: its residuals are not white (statistic {:.0} at {:.0} degrees of freedom, correlation from sample to sample {:.2}); a disturbance that is not recorded moves the structure, or dynamics are missing from the model. What is listed are candidates without standard deviations. Record the disturbance, or excite the structure by a larger reference or an input of its own",
            residual.statistic, residual.degrees, residual.lag1
        ));
    }
    if answer.noise == Noise::Innovations {
        said.push("a disturbance that is not recorded moves the structure, too: known input and white sensor noise alone leave correlated residuals, and with the disturbance's response as part of the model they are white".into());
    }
    if answer.feedback && answer.adequate {
        said.push("feedback: the input contains the noise of the measurement; the model takes no input of the same sample, so that noise biases nothing".into());
    }
    if answer.assumes_no_disturbance() {
        let all = answer.if_disturbed.iter().flatten().enumerate();
        let each = all.map(|(k, sd)| {
            format!(
                "{:.4} Hz ± {:.2} % damping ± {:.2} %",
                answer.fit.frequency_hz(k),
                100.0 * sd.0 / answer.fit.frequency_hz(k),
                100.0 * sd.1
            )
        });
        said.push(format!(
            "an assumption: nothing but the recorded input moves the structure. This record can hardly test it; without it the standard deviations would be {}. A larger reference, or an input of its own, would tell",
            each.collect::<Vec<_>>().join("; ")
        ));
    }
    for (name, lag) in chosen.names.iter().zip(&answer.lags).filter(|(_, lag)| **lag != 0) {
        let (late, by) = (if *lag > 0 { "late" } else { "early" }, lag.unsigned_abs());
        let by_s = by as f64 / chosen.record.sample_rate_hz;
        said.push(format!(
            "{name} is {late} by {by} samples ({by_s:.6} s) against the input; it was moved to its place"
        ));
    }
    if absent > 0 {
        said.push(format!(
            "{absent} samples are absent; the likelihood leaves them out, and the input is held over them"
        ));
    }
    said
}

fn absent_rows(record: &Record) -> usize {
    record.outputs.chunks_exact(record.channels).filter(|row| row.iter().any(|y| !y.is_finite())).count()
}

/// The record with a row for every period of the clock: outputs of absent ones are not numbers, and
/// the input is that of both sides, which must be equal.
fn on_even_clock(chosen: &Chosen) -> Result<Record, Failure> {
    let record = &chosen.record;
    if chosen.gaps.is_empty() {
        return Ok(record.clone());
    }
    let (l, m) = (record.channels, record.inputs);
    let (mut outputs, mut input) = (Vec::new(), Vec::new());
    for t in 0..record.samples() {
        let now = &record.input[t * m..(t + 1) * m];
        if chosen.gaps.contains(&t) {
            let before = record.input[(t - 1) * m..t * m].to_vec();
            let periods = (chosen.time_s[t] - chosen.time_s[t - 1]) * record.sample_rate_hz;
            let absent = (periods.round() as usize).saturating_sub(1);
            if before != now || (periods - periods.round()).abs() > OFF_CLOCK_MAX {
                return Err(Failure::Input(miette::miette!(
                    help = "cut the record with --from and --to where it has no gap: the input during a gap is known only if it is held there, equal on both sides, and the clock goes on evenly",
                    "samples are missing behind {:.6} s",
                    chosen.time_s[t - 1]
                )));
            }
            outputs.extend(std::iter::repeat_n(f64::NAN, absent * l));
            (0..absent).for_each(|_| input.extend(&before));
        }
        outputs.extend(&record.outputs[t * l..(t + 1) * l]);
        input.extend(now);
    }
    Ok(Record::of_outputs(record.sample_rate_hz, l, outputs).with_input(m, input))
}

/// The channel of highest variance with what the modes explain of it.
fn synthesis(chosen: &Chosen, record: &Record, answer: &Identified) -> Synthesis {
    let loudest = loudest(&chosen.record);
    let modelled = explained(record, answer.model, &answer.fit.poles).swap_remove(loudest);
    let measured: Vec<f64> = record.outputs.iter().skip(loudest).step_by(record.channels).copied().collect();
    let there: Vec<usize> = (0..record.samples()).filter(|t| measured[*t].is_finite()).collect();
    Synthesis {
        channel: chosen.names[loudest].clone(),
        unit: chosen.unit.clone(),
        x: there.iter().map(|t| chosen.start_s + *t as f64 / record.sample_rate_hz).collect(),
        over_frequency: false,
        measured: there.iter().map(|t| measured[*t]).collect(),
        modelled: there.iter().map(|t| modelled[*t]).collect(),
    }
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
