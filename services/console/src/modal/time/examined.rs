//! The channels of a time record on one clock, as the examination leaves them, and what was done
//! about each finding.

use super::choose;
use crate::Failure;
use crate::modal::Arguments;
use crate::modal::preparation::prepared;
use channels::Channel;
use examination::even_record::{EvenRecord, Treatment};
use modal::operational::{Evidence, Known, Operational, settings};
use modal::record::Record;
use modal::{Config, RejectedPole, Rejection};

/// The channels asked for on one clock.
pub(in crate::modal) struct Examined {
    pub names: Vec<String>,
    pub unit: String,
    pub even: EvenRecord,
    /// What is identified: the even record without trends, at a lower rate.
    pub record: Record,
    pub notes: Vec<String>,
}

impl Examined {
    /// Settings of the identification.
    pub fn config(&self, arguments: &Arguments) -> Config {
        let lowered = self.record.sample_rate_hz / self.even.rate_hz;
        let mut config = settings(&self.record, self.even.logged_rate_hz.map(|logged_hz| logged_hz * lowered));
        config.selection.order_max = *arguments.orders.end();
        config
    }

    pub fn known(&self) -> Known<'_> {
        Known { delays_s: &self.even.delays_s, clipped: self.even.is_clipped() }
    }
}

/// The response channels within the times asked for, on one clock, prepared as asked for.
///
/// # Errors
/// [`Failure::Input`] where nothing is left, and of [`prepared`].
pub(in crate::modal) fn examined(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Examined, Failure> {
    let mut examined = on_one_clock(arguments, set)?;
    let (record, notes) = prepared(arguments, &examined.names, examined.record)?;
    examined.record = record;
    examined.notes.extend(notes);
    Ok(examined)
}

fn on_one_clock(arguments: &Arguments, set: &recording::SeriesSet) -> Result<Examined, Failure> {
    let inside = |t: &f64| arguments.from.is_none_or(|from| *t >= from) && arguments.to.is_none_or(|to| *t <= to);
    let wanted = |name: &String| arguments.channels.is_empty() || arguments.channels.contains(name);
    let cut = |channel: &Channel| {
        let rows: Vec<usize> = (0..channel.time_s.len()).filter(|row| inside(&channel.time_s[*row])).collect();
        let of = |values: &[f64]| rows.iter().map(|row| values[*row]).collect();
        Channel { time_s: of(&channel.time_s), value: of(&channel.value), ..channel.clone() }
    };
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

pub(in crate::modal) fn record_in_words(examined: &Examined) -> String {
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
pub(in crate::modal) fn treatments(examined: &mut Examined, found: &Operational) -> Vec<Treatment> {
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

/// Whole windows between rows that are not complete.
pub(in crate::modal) fn in_segments(record: &Record) -> Record {
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
