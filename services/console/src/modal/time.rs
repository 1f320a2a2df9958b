//! Modes of a time record.

use super::preparation::{Prepared, prepared};
use super::{Arguments, FoundMode, Outcome, Structure, SweepPole, Synthesis};
use crate::{Failure, recordings};
use modal::advice::{Advice, advice, pulse_nulling};
use modal::c64;
use modal::drift::{self, Drift, PartOfRecord};
use modal::gram::output_gram;
use modal::maximum_likelihood::{MlError, Model, explained, modelled};
use modal::methods::{Estimate, estimates};
use modal::model_order::fit_of_any_order;
use modal::po_moesp::po_moesp;
use modal::record::Record;
use modal::ssi_cov::{Pole, Realisation, realise};
use modal::{
    Config, ModalError, ModalIdentifier, OnsetGate, RejectedPole, Rejection, Selection, ShapeScale, StabilityCriteria,
};
use recording::{Imported, Table};
use report::Stability;
use std::ops::Range;

/// Modes that are tried at most where the number is found by likelihood: half the orders, and this.
const MODES_MAX: usize = 12;
/// Block rows of the sweep shown.
pub(super) const BLOCK_ROWS: usize = 40;
pub(super) const OUTPUT_ONLY: &str =
    "modes of all that moves together: under a controller those of the closed loop, not of the structure alone";
const INPUT_KNOWN: &str =
    "modes of the structure between input and sensors; a controller that commands the input is no part of them";

/// Response channels, input and times of one record.
pub(super) struct Chosen {
    pub names: Vec<String>,
    pub unit: String,
    pub record: Record,
    pub start_s: f64,
    pub gaps: Vec<usize>,
    pub notes: Vec<String>,
}

pub(super) fn outcome(arguments: &Arguments, imported: Imported) -> Result<Outcome, Failure> {
    let set = recording::series(imported).map_err(Failure::input)?;
    let chosen = choose(arguments, &set)?;
    if arguments.input.is_some() { by_likelihood(arguments, chosen) } else { by_flight(arguments, chosen) }
}

/// The columns asked for, as one table of one rate.
pub(super) fn choose(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Chosen, Failure> {
    let known: Vec<&str> = set.recording.channels.iter().map(|channel| channel.name.as_str()).collect();
    for name in arguments.channels.iter().chain(&arguments.input) {
        if !known.contains(&name.as_str()) {
            let near = recordings::nearest(name, known.iter().copied());
            let near = near.map_or(String::new(), |near| format!(" (is it '{near}'?)"));
            return Err(Failure::Input(miette::miette!(
                help = format!("the channels are {}", known.join(", ")),
                "no channel '{name}'{near}"
            )));
        }
    }
    let wanted = |name: &String| {
        let listed = arguments.channels.is_empty() || arguments.channels.contains(name);
        (listed && arguments.input.as_ref() != Some(name)) || arguments.input.as_ref() == Some(name)
    };
    let mut used = set.clone();
    used.recording.channels.retain(|channel| wanted(&channel.name));
    let table = used.table().map_err(Failure::input)?;
    let is_input = |k: &usize| arguments.input.as_ref() == Some(&table.columns[*k].name);
    let responses: Vec<usize> = (0..table.columns.len()).filter(|k| !is_input(k)).collect();
    let input: Vec<usize> = (0..table.columns.len()).filter(is_input).collect();
    let inside = |t: &f64| arguments.from.is_none_or(|from| *t >= from) && arguments.to.is_none_or(|to| *t <= to);
    let rows: Vec<usize> = (0..table.time_s.len()).filter(|row| inside(&table.time_s[*row])).collect();
    if responses.is_empty() || rows.is_empty() {
        return Err(Failure::Input(miette::miette!(
            help = "check --channels, --input, --from and --to",
            "nothing is left of the recording: {} response channels, {} rows",
            responses.len(),
            rows.len()
        )));
    }
    let values = |columns: &[usize]| -> Vec<f64> {
        rows.iter().flat_map(|row| columns.iter().map(|k| table.columns[*k].values[*row])).collect()
    };
    let rate_hz = 1.0 / table.timing.interval_s;
    let first = rows[0];
    let gaps: Vec<usize> = table.timing.gaps.iter().filter_map(|gap| (gap.after_row + 1).checked_sub(first)).collect();
    let gaps: Vec<usize> = gaps.into_iter().filter(|row| *row > 0 && *row < rows.len()).collect();
    let record = Record::of_outputs(rate_hz, responses.len(), values(&responses));
    let record = if input.is_empty() { record } else { record.with_input(1, values(&input)) };
    let Prepared { record, gaps, notes: prepared } = prepared(arguments, record, gaps)?;
    Ok(Chosen {
        names: responses.iter().map(|k| table.columns[*k].name.clone()).collect(),
        unit: table.columns[responses[0]].unit.into(),
        record,
        start_s: table.time_s[first],
        gaps,
        notes: notes(&table).into_iter().chain(prepared).collect(),
    })
}

fn notes(table: &Table) -> Vec<String> {
    table.notes.iter().cloned().chain(table.timing.repairs()).collect()
}

/// Advice, and the drifts that stand out.
fn in_words(advice: &[Advice], drift: &[Drift]) -> Vec<String> {
    let drifts = drift.iter().filter(|drift| drift.stands_out()).map(ToString::to_string);
    advice.iter().map(ToString::to_string).chain(drifts).collect()
}

pub(super) fn record_in_words(chosen: &Chosen) -> String {
    let Chosen { names, record, .. } = chosen;
    format!(
        "{} channel{}, {} samples at {:.4} Hz",
        names.len(),
        if names.len() == 1 { "" } else { "s" },
        record.samples(),
        record.sample_rate_hz
    )
}

/// The identifier that flies on some rows, segments at gaps and where the record jumps.
pub(super) fn fly(
    arguments: &Arguments,
    chosen: &Chosen,
    rows: Range<usize>,
    shapes: Option<ShapeScale>,
) -> Result<Selection, ModalError> {
    let record = &chosen.record;
    let mut config = Config::new(record.channels, record.sample_rate_hz);
    config.selection.order_max = *arguments.orders.end();
    config.selection.shape_deviations = shapes;
    let (mut identifier, mut gate) = (ModalIdentifier::new(config), OnsetGate::default());
    for k in rows {
        if chosen.gaps.contains(&k) {
            gate.end_segment(&mut identifier);
            identifier.open_segment();
        }
        gate.push(&record.outputs[k * record.channels..(k + 1) * record.channels], &mut identifier);
    }
    gate.end_segment(&mut identifier);
    identifier.identify_with_reasons()
}

/// Output only: the identifier that flies.
fn by_flight(arguments: &Arguments, chosen: Chosen) -> Result<Outcome, Failure> {
    let record = &chosen.record;
    let Selection { modes, rejected } = found(arguments, &chosen)?;
    let middle = record.samples() / 2;
    let of_part = |rows: Range<usize>| -> Vec<Estimate> {
        fly(arguments, &chosen, rows, None)
            .map(|found| found.modes.iter().map(Estimate::from).collect())
            .unwrap_or_default()
    };
    let drift = drift::between(&of_part(0..middle), &of_part(middle..record.samples()));
    let found: Vec<Estimate> = modes.iter().map(Estimate::from).collect();
    let slowest_hz = found.first().map_or(0.0, |mode| mode.frequency_hz);
    let parts: Vec<PartOfRecord> = drift::parts_of(record, slowest_hz)
        .into_iter()
        .map(|over| drift::part(record, &over, of_part(over.clone())))
        .collect();
    let tracks = drift::tracks(&found, &parts);
    let record_s = record.samples() as f64 / record.sample_rate_hz;
    let sweep = realise(&output_gram(record, BLOCK_ROWS), *arguments.orders.end())
        .map(|realisation| sweep(&realisation, arguments, record.sample_rate_hz))
        .unwrap_or_default();
    Ok(Outcome {
        method: if arguments.structural.select.is_empty() {
            "covariance-driven stochastic subspace at four rates, orders selected automatically"
        } else {
            "covariance-driven stochastic subspace, poles selected by hand (--select)"
        },
        kind: OUTPUT_ONLY,
        deviations: "first-order propagation of the sampled covariances, validated by coverage",
        record: record_in_words(&chosen),
        modes: found.iter().map(found_mode).collect(),
        rejected: reasons(&rejected),
        sweep,
        spectrum: Some(super::page::density_of(record)),
        synthesis: correlation(&chosen, &found),
        advice: in_words(&advice(&found, record_s, None), &drift),
        drift,
        tracks,
        structure: Structure::of_record(arguments, record, &chosen.gaps),
        channels: chosen.names,
        notes: chosen.notes,
    })
}

/// The modes of the whole record, or the poles that were picked.
fn found(arguments: &Arguments, chosen: &Chosen) -> Result<Selection, Failure> {
    let picks = &arguments.structural.select;
    if !picks.is_empty() {
        return super::hand::selected(picks, &chosen.record, &chosen.gaps, BLOCK_ROWS);
    }
    fly(arguments, chosen, 0..chosen.record.samples(), Some(ShapeScale::Largest))
        .map_err(|error| Failure::Input(miette::miette!(help = "give a longer record, or other channels", "{error}")))
}

/// The correlation function of the channel of highest variance, and the decays at the poles found
/// that come nearest to it: under white excitation it is a free decay, and so is that of a free
/// decay.
fn correlation(chosen: &Chosen, found: &[Estimate]) -> Option<Synthesis> {
    const LAGS_MAX: usize = 2000;
    let record = &chosen.record;
    let slowest_hz = found.first()?.frequency_hz;
    // Ten periods of the slowest mode, a tenth of the record, as far as they can be drawn.
    let lags = ((10.0 * record.sample_rate_hz / slowest_hz) as usize).min(record.samples() / 10).min(LAGS_MAX);
    let loudest = loudest(record);
    let y: Vec<f64> = record.outputs.iter().skip(loudest).step_by(record.channels).copied().collect();
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    // No product reaches over a gap.
    let ends: Vec<usize> = chosen.gaps.iter().copied().chain([y.len()]).collect();
    let starts = std::iter::once(0).chain(chosen.gaps.iter().copied());
    let stretches: Vec<&[f64]> = starts.zip(&ends).map(|(start, end)| &y[start..*end]).collect();
    let products = |stretch: &[f64], lag: usize| -> f64 {
        stretch.iter().skip(lag).zip(stretch).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let at = |lag: usize| stretches.iter().map(|stretch| products(stretch, lag)).sum::<f64>() / y.len() as f64;
    // Lag 0 holds the noise of the sensor.
    let measured: Vec<f64> = (1..lags).map(at).collect();
    if measured.len() < 4 * found.len() + 2 {
        return None;
    }
    let poles: Vec<c64> = found
        .iter()
        .map(|mode| {
            let omega = core::f64::consts::TAU * mode.frequency_hz;
            let damped = (1.0 - mode.damping_ratio * mode.damping_ratio).max(0.0).sqrt();
            c64::new(-mode.damping_ratio, damped) * omega
        })
        .collect();
    let decays = Record::of_outputs(record.sample_rate_hz, 1, measured.clone());
    Some(Synthesis {
        channel: format!("correlation of {}", chosen.names[loudest]),
        unit: if chosen.unit == "-" { "-".into() } else { format!("({})^2", chosen.unit) },
        x: (1..lags).map(|lag| lag as f64 / record.sample_rate_hz).collect(),
        over_frequency: false,
        modelled: explained(&decays, Model::FREE, &poles).swap_remove(0),
        measured,
    })
}

/// Known input: maximum likelihood, the number of modes by likelihood.
fn by_likelihood(arguments: &Arguments, chosen: Chosen) -> Result<Outcome, Failure> {
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
        spectrum: Some(super::page::density_of(record)),
        synthesis: Some(synthesis),
        advice: in_words(&said, &drift),
        drift,
        tracks,
        structure: Structure::of_record(arguments, record, &chosen.gaps),
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

fn loudest(record: &Record) -> usize {
    let power = |c: usize| record.outputs.iter().skip(c).step_by(record.channels).map(|y| y * y).sum::<f64>();
    (0..record.channels).max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap_or(0)
}

fn found_mode(estimate: &Estimate) -> FoundMode {
    FoundMode {
        frequency_hz: estimate.frequency_hz,
        frequency_sd: estimate.deviation.map(|d| d.frequency_hz),
        damping: Some(estimate.damping_ratio),
        damping_sd: estimate.deviation.map(|d| d.damping_ratio),
        shape: estimate.mode_shape.clone(),
        shape_sd: estimate.shape_deviation.clone(),
        phase_collinearity: Some(estimate.phase_collinearity),
    }
}

/// All poles of the orders asked for, each compared with those of the order before.
fn sweep(realisation: &Realisation, arguments: &Arguments, rate_hz: f64) -> Vec<SweepPole> {
    let criteria = StabilityCriteria::default();
    let (mut all, mut before): (Vec<SweepPole>, Vec<Pole>) = (Vec::new(), Vec::new());
    for order in arguments.orders.clone().take_while(|order| *order <= realisation.order_max()) {
        let band = (0.0, 0.5 * rate_hz);
        let mut poles = realisation.poles(order, rate_hz);
        poles.retain(|pole| criteria.hard_rejection(pole, band).is_none());
        let stability = |pole: &Pole| before.iter().map(|old| criteria.agreement(pole, old)).max().unwrap_or(0);
        all.extend(poles.iter().map(|pole| SweepPole {
            order,
            frequency_hz: pole.frequency_hz,
            damping_ratio: pole.damping_ratio,
            stability: match stability(pole) {
                0 => Stability::New,
                1 => Stability::Frequency,
                2 => Stability::FrequencyAndDamping,
                _ => Stability::All,
            },
        }));
        before = poles;
    }
    all
}

/// How many poles fell to each reason.
fn reasons(rejected: &[RejectedPole]) -> Vec<(String, usize)> {
    let mut counts = std::collections::BTreeMap::new();
    for pole in rejected {
        *counts.entry(reason(&pole.reason)).or_insert(0) += 1;
    }
    counts.into_iter().map(|(reason, count)| (reason.to_string(), count)).collect()
}

fn reason(rejection: &Rejection) -> &'static str {
    match rejection {
        Rejection::NotOscillating => "real pole, no oscillation",
        Rejection::OutOfBand { .. } => "outside the band",
        Rejection::DampingNotPositive { .. } => "damping not positive",
        Rejection::DampingAboveLimit { .. } => "damping above the limit",
        Rejection::NotStable { .. } => "repeats over too few orders",
        Rejection::ModelsNoise { .. } => "appears only above an order that leaves white noise",
        Rejection::NotResolved { .. } => "not resolved from its own uncertainty",
        Rejection::PhaseNotCollinear { .. } => "shape scattered over the complex plane",
        Rejection::BetterElsewhere { .. } => "the same mode is better known at another rate",
    }
}
