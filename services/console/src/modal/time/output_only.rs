//! Modes of a time record from its outputs alone, as the record is: examined first, then the
//! identifier that flies, with missing samples and tones dealt with.

use super::examined::{Examined, examined, in_segments, record_in_words, treatments};
use super::{BLOCK_ROWS, OUTPUT_ONLY, found_mode, in_words, loudest, reasons, sweep};
use crate::Failure;
use crate::modal::as_it_is::{AsItIs, Nature};
use crate::modal::{Arguments, FoundMode, Outcome, Structure, Synthesis, hand, page};
use examination::even_record::{Treatment, without_holes};
use modal::advice::advice;
use modal::c64;
use modal::drift::{self, PartOfRecord};
use modal::gram::output_gram;
use modal::maximum_likelihood::{Model, explained};
use modal::methods::Estimate;
use modal::operational::{Evidence, Operational, identify, selection_like};
use modal::pairs::covariances;
use modal::record::Record;
use modal::ssi_cov::realise;
use modal::tones::Tone;
use modal::{Config, Mode, Selection, ShapeScale};
use std::ops::Range;

pub(super) fn outcome(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Outcome, Failure> {
    let mut examined = examined(arguments, set)?;
    let mut config = examined.config(arguments);
    config.selection.shape_deviations = Some(ShapeScale::Largest);
    let mut found = identify(&examined.record, examined.known(), &config).map_err(|error| {
        Failure::Input(miette::miette!(help = "give a longer record, or other channels", "{error}"))
    })?;
    // What is left when the tones are taken out; later channels stay where they are there.
    let rest = found.rest.clone().unwrap_or_else(|| examined.record.outputs.clone());
    let rest = Record::of_outputs(examined.record.sample_rate_hz, examined.record.channels, rest);
    let picks = &arguments.structural.select;
    let identified = found.modes.clone();
    if !picks.is_empty() {
        let (complete, gaps) = complete_rows(&rest);
        Selection { modes: found.modes, rejected: found.rejected } =
            hand::selected(picks, &complete, &gaps, BLOCK_ROWS)?;
    }
    config.selection.shape_deviations = None;
    let estimates: Vec<Estimate> = found.modes.iter().map(Estimate::from).collect();
    let of_part = |rows: Range<usize>| -> Vec<Estimate> {
        let part = &rest.outputs[rows.start * rest.channels..rows.end * rest.channels];
        let selection = selection_like(&identified, part, found.evidence, &config);
        selection.map(|found| found.modes.iter().map(Estimate::from).collect()).unwrap_or_default()
    };
    let middle = rest.samples() / 2;
    let drift = drift::between(&of_part(0..middle), &of_part(middle..rest.samples()));
    let whole = filled(&rest);
    let slowest_hz = estimates.first().map_or(0.0, |mode| mode.frequency_hz);
    let parts: Vec<PartOfRecord> = drift::parts_of(&whole, slowest_hz)
        .into_iter()
        .map(|over| drift::part(&whole, &over, of_part(over.clone())))
        .collect();
    let tracks = drift::tracks(&estimates, &parts);
    let record_s = rest.samples() as f64 / rest.sample_rate_hz;
    let gram = match found.evidence {
        Evidence::Windows => output_gram(&in_segments(&rest), BLOCK_ROWS),
        Evidence::Pairs => covariances(&rest.outputs, rest.channels, BLOCK_ROWS, 0)[0].gram(),
    };
    let sweep = realise(&gram, *arguments.orders.end())
        .map(|realisation| sweep(&realisation, arguments, rest.sample_rate_hz))
        .unwrap_or_default();
    let treatments = treatments(&mut examined, &found);
    let rejected = reasons(&found.rejected);
    let mut said = in_words(&advice(&estimates, record_s, None), &drift);
    if found.modes.is_empty() && !rejected.is_empty() {
        said.push(left_out(&rejected));
    }
    let (modes, as_it_is) = in_order(&found, &examined, treatments);
    Ok(Outcome {
        as_it_is,
        verdict: None,
        method: if picks.is_empty() {
            "covariance-driven stochastic subspace at four rates, orders selected automatically"
        } else {
            "covariance-driven stochastic subspace, poles selected by hand (--select)"
        },
        kind: OUTPUT_ONLY,
        deviations: match found.evidence {
            Evidence::Windows => "first-order propagation of the sampled covariances, validated by coverage",
            Evidence::Pairs => "spread over blocks of the record, propagated to first order, validated by coverage",
        },
        record: record_in_words(&examined),
        modes,
        rejected,
        sweep,
        spectrum: Some(page::density_of(&filled(&examined.record))),
        synthesis: correlation(&examined, &rest, &estimates),
        advice: said,
        drift,
        tracks,
        structure: Structure::of_record(arguments, &complete_rows(&rest).0, &complete_rows(&rest).1),
        channels: examined.names,
        notes: examined.notes,
    })
}

fn left_out(rejected: &[(String, usize)]) -> String {
    let reasons: Vec<String> = rejected.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
    format!("poles left out: {}", reasons.join(", "))
}

/// Modes and tones in order of frequency, and what each is.
fn in_order(found: &Operational, examined: &Examined, treatments: Vec<Treatment>) -> (Vec<FoundMode>, AsItIs) {
    let of_mode = |mode: &Mode| {
        let complex = mode.phase_collinearity < Config::new(1, 1.0).selection.phase_collinearity_min;
        let folded = examined
            .even
            .logged_rate_hz
            .map_or(Vec::new(), |logged| unfolded(mode.frequency_hz, examined.even.rate_hz, 0.5 * logged));
        let half_width_hz = mode.damping_ratio * mode.frequency_hz;
        let on_it = |tone: &&Tone| (tone.frequency_hz - mode.frequency_hz).abs() < half_width_hz;
        let tones_hz = found.tones.iter().filter(on_it).map(|tone| tone.frequency_hz).collect();
        (found_mode(&Estimate::from(mode)), Nature::Mode { complex, folded, tones_hz })
    };
    let mut all: Vec<(FoundMode, Nature)> = found.modes.iter().map(of_mode).collect();
    all.extend(found.tones.iter().map(|tone| (tone_as_found(tone), Nature::Tone { wander_hz: tone.wander_hz })));
    all.sort_by(|a, b| a.0.frequency_hz.total_cmp(&b.0.frequency_hz));
    let (modes, natures) = all.into_iter().unzip();
    (modes, AsItIs { natures, treatments })
}

fn tone_as_found(tone: &Tone) -> FoundMode {
    let largest =
        tone.amplitude.iter().copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm_sqr() > a.norm_sqr() { b } else { a });
    FoundMode {
        frequency_hz: tone.frequency_hz,
        frequency_sd: Some(tone.sigma_frequency_hz),
        damping: None,
        damping_sd: None,
        shape: if largest.norm_sqr() > 0.0 { tone.amplitude.iter().map(|a| a / largest).collect() } else { Vec::new() },
        ..FoundMode::default()
    }
}

/// Frequencies up to `highest_hz` that show at `frequency_hz` when read at `rate_hz`.
fn unfolded(frequency_hz: f64, rate_hz: f64, highest_hz: f64) -> Vec<f64> {
    let images = (1..).flat_map(|k| [f64::from(k) * rate_hz - frequency_hz, f64::from(k) * rate_hz + frequency_hz]);
    images.take_while(|f| *f < highest_hz).collect()
}

/// The rows with every value, and where rows are missing between them (the first row behind).
fn complete_rows(record: &Record) -> (Record, Vec<usize>) {
    let (mut rows, mut gaps, mut broken) = (Vec::new(), Vec::new(), false);
    for row in record.outputs.chunks_exact(record.channels) {
        if row.iter().any(|y| !y.is_finite()) {
            broken = true;
            continue;
        }
        if broken && !rows.is_empty() {
            gaps.push(rows.len() / record.channels);
        }
        broken = false;
        rows.extend_from_slice(row);
    }
    (Record::of_outputs(record.sample_rate_hz, record.channels, rows), gaps)
}

/// Straight lines over what is missing, for figures.
fn filled(record: &Record) -> Record {
    let mut filled = record.clone();
    for c in 0..record.channels {
        let column: Vec<f64> = record.outputs.iter().skip(c).step_by(record.channels).copied().collect();
        for (t, y) in without_holes(&column).into_iter().enumerate() {
            filled.outputs[t * record.channels + c] = y;
        }
    }
    filled
}

/// The correlation function of the channel of highest variance, and the decays at the poles found
/// that come nearest to it: under white excitation it is a free decay, and so is that of a free
/// decay.
fn correlation(examined: &Examined, record: &Record, found: &[Estimate]) -> Option<Synthesis> {
    const LAGS_MAX: usize = 2000;
    let slowest_hz = found.first()?.frequency_hz;
    // Ten periods of the slowest mode, a tenth of the record, as far as they can be drawn.
    let lags = ((10.0 * record.sample_rate_hz / slowest_hz) as usize).min(record.samples() / 10).min(LAGS_MAX);
    let loudest = loudest(&filled(record));
    let mut y: Vec<f64> = record.outputs.iter().skip(loudest).step_by(record.channels).copied().collect();
    let present = y.iter().filter(|y| y.is_finite()).count();
    let mean = y.iter().filter(|y| y.is_finite()).sum::<f64>() / present as f64;
    let mask: Vec<f64> = y.iter().map(|y| f64::from(u8::from(y.is_finite()))).collect();
    y.iter_mut().for_each(|y| *y = if y.is_finite() { *y - mean } else { 0.0 });
    let sum = |x: &[f64], lag: usize| x.iter().skip(lag).zip(x).map(|(a, b)| a * b).sum::<f64>();
    // Of all samples the sum over the record, as ever; of some, in the measure of their pairs.
    let share = |lag: usize| sum(&mask, lag) / (y.len() - lag) as f64;
    let at = |lag: usize| sum(&y, lag) / y.len() as f64 / share(lag).max(f64::MIN_POSITIVE);
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
        channel: format!("correlation of {}", examined.names[loudest]),
        unit: if examined.unit == "-" { "-".into() } else { format!("({})^2", examined.unit) },
        x: (1..lags).map(|lag| lag as f64 / record.sample_rate_hz).collect(),
        over_frequency: false,
        modelled: explained(&decays, Model::FREE, &poles).swap_remove(0),
        measured,
    })
}
