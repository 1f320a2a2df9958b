//! Modes of a time record from its outputs alone, as the record is: examined first, then the
//! identifier that flies, with missing samples and tones dealt with.

use super::{BLOCK_ROWS, OUTPUT_ONLY, choose, found_mode, in_words, loudest, reasons, sweep};
use crate::Failure;
use crate::modal::as_it_is::{AsItIs, Nature};
use crate::modal::structural_arguments::Detrend;
use crate::modal::{Arguments, FoundMode, Outcome, Structure, Synthesis, hand, page};
use channels::Channel;
use examination::even_record::{EvenRecord, Treatment, without_holes};
use modal::advice::advice;
use modal::c64;
use modal::drift::{self, PartOfRecord};
use modal::gram::output_gram;
use modal::maximum_likelihood::{Model, explained};
use modal::methods::Estimate;
use modal::operational::{Evidence, Known, Operational, identify, selection_like, settings};
use modal::pairs::covariances;
use modal::record::Record;
use modal::ssi_cov::realise;
use modal::tones::Tone;
use modal::{Config, Mode, RejectedPole, Rejection, Selection, ShapeScale};
use std::ops::Range;

/// The channels asked for on one clock.
struct Examined {
    names: Vec<String>,
    unit: String,
    even: EvenRecord,
    record: Record,
    notes: Vec<String>,
}

pub(super) fn outcome(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Outcome, Failure> {
    let mut examined = examined(arguments, set)?;
    let mut config = settings(&examined.record, examined.even.logged_rate_hz);
    config.selection.order_max = *arguments.orders.end();
    config.selection.shape_deviations = Some(ShapeScale::Largest);
    let known = Known { delays_s: &examined.even.delays_s, clipped: examined.even.is_clipped() };
    let mut found = identify(&examined.record, known, &config).map_err(|error| {
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

/// The response channels within the times asked for, on one clock.
fn examined(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Examined, Failure> {
    let inside = |t: &f64| arguments.from.is_none_or(|from| *t >= from) && arguments.to.is_none_or(|to| *t <= to);
    let wanted = |name: &String| arguments.channels.is_empty() || arguments.channels.contains(name);
    let cut = |channel: &Channel| {
        let rows: Vec<usize> = (0..channel.time_s.len()).filter(|row| inside(&channel.time_s[*row])).collect();
        let of = |values: &[f64]| rows.iter().map(|row| values[*row]).collect();
        Channel { time_s: of(&channel.time_s), value: of(&channel.value), ..channel.clone() }
    };
    if arguments.structural.detrend != Detrend::None || arguments.structural.decimate.is_some() {
        return as_a_table(arguments, set);
    }
    let channels: Vec<Channel> = set.recording.channels.iter().filter(|c| wanted(&c.name)).map(cut).collect();
    let present = channels.iter().all(|channel| !channel.value.is_empty());
    let borrowed: Vec<&Channel> = channels.iter().collect();
    let even = if present { EvenRecord::of(&borrowed) } else { None };
    let Some(even) = even else { return as_a_table(arguments, set) };
    let record = Record::of_outputs(even.rate_hz, even.channels, even.values.clone());
    Ok(Examined {
        names: channels.iter().map(|channel| channel.name.clone()).collect(),
        unit: channels[0].unit.clone(),
        notes: set.notes.iter().filter(|note| !is_about_gaps(note)).cloned().collect(),
        record,
        even,
    })
}

/// Gaps are reported once, by the examination.
fn is_about_gaps(note: &str) -> bool {
    note.contains("reported, not filled") || note.starts_with("not one rate: ")
}

/// A record whose clock is only nearly even: as a table of one rate, its gaps as rows without
/// values.
fn as_a_table(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Examined, Failure> {
    let chosen = choose(arguments, set)?;
    let l = chosen.record.channels;
    let mut values = Vec::with_capacity(chosen.record.outputs.len());
    for (row, sample) in chosen.record.outputs.chunks_exact(l).enumerate() {
        if chosen.gaps.contains(&row) {
            values.extend(std::iter::repeat_n(f64::NAN, l));
        }
        values.extend_from_slice(sample);
    }
    let rate_hz = chosen.record.sample_rate_hz;
    let even = EvenRecord {
        rate_hz,
        start_s: chosen.start_s,
        channels: l,
        delays_s: vec![0.0; l],
        logged_rate_hz: None,
        treatments: Vec::new(),
        values,
    };
    let record = Record::of_outputs(rate_hz, l, even.values.clone());
    Ok(Examined { names: chosen.names, unit: chosen.unit, record, even, notes: chosen.notes })
}

fn record_in_words(examined: &Examined) -> String {
    let Examined { names, record, .. } = examined;
    let rows = record.outputs.chunks_exact(record.channels);
    let present = rows.filter(|row| row.iter().any(|y| y.is_finite())).count();
    format!(
        "{} channel{}, {} samples at {:.4} Hz",
        names.len(),
        if names.len() == 1 { "" } else { "s" },
        present,
        record.sample_rate_hz
    )
}

/// What the examination found, with what was done in the end.
fn treatments(examined: &mut Examined, found: &Operational) -> Vec<Treatment> {
    let mut all = std::mem::take(&mut examined.even.treatments);
    for treatment in all.iter_mut().filter(|treatment| treatment.check == "missing") {
        if found.filled > 0 {
            let said = format!(", {} of them in gaps filled from the samples beside them", found.filled);
            treatment.did.push_str(&said);
        }
        treatment.did.push_str(match (found.evidence, found.transient) {
            (Evidence::Pairs, _) => ": covariances from the pairs that exist",
            (_, true) => ": windows between the gaps, because the motion is no stationary one",
            (Evidence::Windows, false) => ": windows between the gaps",
        });
    }
    if let Some(note) = examined.notes.iter().find(|note| note.starts_with("the stamps are ")) {
        let did = note.clone();
        all.push(Treatment {
            check: "irregular_time",
            channel: String::new(),
            value: examined.even.rate_hz,
            unit: "Hz",
            did,
        });
        examined.notes.retain(|note| !note.starts_with("the stamps are "));
    }
    for tone in &found.tones {
        let did = format!(
            "{}: taken out before the modes were identified; a mode within ±{:.3} Hz of it would be hidden",
            if tone.wander_hz > 0.0 {
                format!("a tone that wanders by ±{:.3} Hz", tone.wander_hz)
            } else {
                "a steady tone".into()
            },
            tone.hides_hz
        );
        all.push(Treatment { check: "tone", channel: String::new(), value: tone.frequency_hz, unit: "Hz", did });
    }
    let by_tone = |pole: &&RejectedPole| matches!(pole.reason, Rejection::HiddenByTone);
    for pole in found.rejected.iter().filter(by_tone) {
        let did = "hidden: what moves there is not told from the tone, and is not reported as a mode".into();
        all.push(Treatment { check: "hidden", channel: String::new(), value: pole.frequency_hz, unit: "Hz", did });
    }
    all
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

/// Whole windows between rows that are not complete.
fn in_segments(record: &Record) -> Record {
    let complete: Vec<bool> =
        record.outputs.chunks_exact(record.channels).map(|row| row.iter().all(|y| y.is_finite())).collect();
    let mut segments = Vec::new();
    let mut start = 0;
    for row in 0..=complete.len() {
        if row == complete.len() || !complete[row] {
            if row > start {
                segments.push(start..row);
            }
            start = row + 1;
        }
    }
    record.clone().with_segments(segments)
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
