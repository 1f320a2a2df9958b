//! Modes of a time record.

pub(super) mod examined;
mod known_input;
mod output_only;

use super::{Arguments, FoundMode, Outcome, SweepPole};
use crate::{Failure, recordings};
use modal::advice::Advice;
use modal::drift::Drift;
use modal::methods::Estimate;
use modal::record::Record;
use modal::ssi_cov::{Pole, Realisation};
use modal::{RejectedPole, Rejection, StabilityCriteria};
use recording::{Imported, Table};
use report::Stability;

/// Block rows of the sweep shown.
pub(super) const BLOCK_ROWS: usize = 40;
pub(super) const OUTPUT_ONLY: &str =
    "modes of all that moves together: under a controller those of the closed loop, not of the structure alone";

/// Response channels, input and times of one record.
pub(super) struct Chosen {
    pub names: Vec<String>,
    pub unit: String,
    pub record: Record,
    pub start_s: f64,
    pub gaps: Vec<usize>,
    /// Of every row.
    pub time_s: Vec<f64>,
    pub notes: Vec<String>,
}

pub(super) fn outcome(arguments: &Arguments, imported: Imported) -> Result<Outcome, Failure> {
    let set = recording::series(imported).map_err(Failure::input)?;
    check_names(arguments, &set)?;
    if arguments.input.is_some() {
        known_input::by_likelihood(arguments, choose(arguments, &set)?)
    } else {
        output_only::outcome(arguments, &set)
    }
}

/// Every channel asked for is there.
fn check_names(arguments: &Arguments, set: &recording::SeriesSet) -> Result<(), Failure> {
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
    Ok(())
}

/// The columns asked for, as one table of one rate.
pub(super) fn choose(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Chosen, Failure> {
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
    Ok(Chosen {
        names: responses.iter().map(|k| table.columns[*k].name.clone()).collect(),
        unit: table.columns[responses[0]].unit.into(),
        record,
        start_s: table.time_s[first],
        gaps,
        time_s: rows.iter().map(|row| table.time_s[*row]).collect(),
        notes: notes(&table),
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
        Rejection::Combination => "a combination of stronger modes by clipping",
        Rejection::NotInModel { .. } => "only in models too small for all modes",
        Rejection::HiddenByTone => "within the band of a tone",
        Rejection::BetterElsewhere { .. } => "the same mode is better known at another rate",
    }
}
