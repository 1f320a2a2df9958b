//! Trials of one kind of defect, and their figures.

use super::defects::{Defect, DefectiveRecord, record};
use super::generator::Generator;
use super::structure::{Structure, TrueMode};
use channels::Channel;
use core::f64::consts::TAU;
use examination::even_record::EvenRecord;
use modal::Mode;
use modal::operational::{Known, Operational, identify, settings};
use modal::record::Record;
use recording::{Column, Imported, SeriesSet, Table};
use serde::Serialize;

/// `2πζfT` of an identifiable mode.
const FORGETTING_MIN: f64 = 20.0;
/// Part of the update rate up to which modes are identifiable.
const USABLE_BAND: f64 = 0.4;
/// A tone is named if its mean frequency is within this share.
const TONE_SHARE: f64 = 0.005;
/// Errors in units of the deviation up to which a mode beside a tone is right.
const RIGHT_SIGMA: f64 = 3.5;

/// Figures of one kind of defect; a share of none, and its JSON null, where there is nothing of
/// which it could be one.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    pub defect: &'static str,
    pub trials: u32,
    /// Records that were refused.
    pub failed: u32,
    /// Identifiable modes.
    pub modes: u32,
    pub missed_percent: Option<f64>,
    /// Modes reported that do not exist, relative to the identifiable ones.
    pub invented_percent: Option<f64>,
    pub frequency_rms_z: Option<f64>,
    pub damping_rms_z: Option<f64>,
    pub frequency_coverage_percent: Option<f64>,
    pub damping_coverage_percent: Option<f64>,
    pub tones: u32,
    pub tones_named_percent: Option<f64>,
    /// Tones reported that do not exist.
    pub tones_invented: u32,
    /// Identifiable modes beside a tone that are right, or said to be hidden.
    pub beside_right_percent: Option<f64>,
    /// Identifiable modes beside a tone.
    pub beside: u32,
    /// What each trial got wrong, in their order.
    pub failures: Vec<Failure>,
}

/// What one trial got wrong.
#[derive(Clone, Debug, Serialize)]
pub struct Failure {
    pub trial: u32,
    pub what: Fault,
    /// Of the true mode or tone, or of the invented one \[Hz\].
    pub frequency_hz: f64,
    /// Of the mode, unless it is a tone.
    pub damping_ratio: Option<f64>,
    /// Errors of frequency and damping in deviations.
    pub z: Option<[f64; 2]>,
}

/// A kind of failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    Missed,
    Invented,
    /// Found, with an error beyond [`RIGHT_SIGMA`].
    Wrong,
    ToneMissed,
    ToneInvented,
}

/// Sums of the trials.
#[derive(Default)]
struct Sums {
    missed: u32,
    invented: u32,
    frequency_z: Vec<f64>,
    damping_z: Vec<f64>,
    named: u32,
    beside: u32,
    beside_right: u32,
}

/// The figures of so many records with one defect; the same seed gives the same records.
#[must_use]
pub fn figures(defect: Defect, trials: u32, seed: u64) -> Figures {
    let mut figures = Figures { defect: defect.name(), trials, ..Figures::default() };
    let mut sums = Sums::default();
    for trial in 0..trials {
        let mut random = Generator::new(seed.wrapping_mul(0x1_0001).wrapping_add(u64::from(trial)));
        let structure = Structure::draw(&mut random);
        let recorded = record(&structure, defect, &mut random);
        match read(&recorded) {
            Some(found) => judge((trial, &structure), &recorded, &found, &mut figures, &mut sums),
            None => figures.failed += 1,
        }
    }
    let percent = |part: u32, whole: u32| (whole > 0).then(|| 100.0 * f64::from(part) / f64::from(whole));
    figures.missed_percent = percent(sums.missed, figures.modes);
    figures.invented_percent = percent(sums.invented, figures.modes);
    figures.tones_named_percent = percent(sums.named, figures.tones);
    figures.beside = sums.beside;
    figures.beside_right_percent = percent(sums.beside_right, sums.beside);
    (figures.frequency_rms_z, figures.frequency_coverage_percent) = honesty(&sums.frequency_z);
    (figures.damping_rms_z, figures.damping_coverage_percent) = honesty(&sums.damping_z);
    figures
}

/// Root mean square, and percent within 1.96.
fn honesty(z: &[f64]) -> (Option<f64>, Option<f64>) {
    let mean = |of: &dyn Fn(&f64) -> f64| (!z.is_empty()).then(|| z.iter().map(of).sum::<f64>() / z.len() as f64);
    let held = mean(&|z| if z.abs() < 1.96 { 100.0 } else { 0.0 });
    (mean(&|z| z * z).map(f64::sqrt), held)
}

/// What a user gets of such a file: intake, examination, identification.
fn read(recorded: &DefectiveRecord) -> Option<Operational> {
    let set = series(recorded)?;
    let channels: Vec<&Channel> = set.recording.channels.iter().collect();
    let even = EvenRecord::of(&channels)?;
    let record = Record::of_outputs(even.rate_hz, even.channels, even.values.clone());
    let known = Known { delays_s: &even.delays_s, clipped: even.is_clipped() };
    identify(&record, known, &settings(&record, even.logged_rate_hz)).ok()
}

fn series(recorded: &DefectiveRecord) -> Option<SeriesSet> {
    let name = |k: usize| format!("a{k}");
    if recorded.columns.iter().flatten().all(|y| y.is_finite()) {
        let columns = recorded.columns.iter().enumerate();
        let columns = columns.map(|(k, column)| Column::si(&name(k), "m/s^2", column.clone())).collect();
        let table = Table::from_columns("drawn", recorded.time_s.clone(), columns).ok()?;
        return recording::series(Imported::Table(table)).ok();
    }
    let mut set = SeriesSet::new("drawn");
    for (k, column) in recorded.columns.iter().enumerate() {
        let present: Vec<usize> = (0..column.len()).filter(|t| column[*t].is_finite()).collect();
        let time = present.iter().map(|t| recorded.time_s[*t]).collect();
        set.push(Channel::new(&name(k), "m/s^2", time, present.iter().map(|t| column[*t]).collect()), "m/s^2");
    }
    Some(set)
}

fn judge(
    (trial, structure): (u32, &Structure),
    recorded: &DefectiveRecord,
    found: &Operational,
    figures: &mut Figures,
    sums: &mut Sums,
) {
    // Stamps of another clock: all frequencies with it.
    let scale = if structure.sample_rate_hz < recorded.update_rate_hz {
        recorded.update_rate_hz / structure.sample_rate_hz
    } else {
        1.0
    };
    let mut fail = |what, frequency_hz, damping_ratio, z| {
        figures.failures.push(Failure { trial, what, frequency_hz, damping_ratio, z });
    };
    let mut left: Vec<&Mode> = found.modes.iter().collect();
    for (k, truth) in structure.modes.iter().enumerate() {
        let f = truth.frequency_hz * scale;
        let shown = folded(f, recorded.update_rate_hz);
        let apart = |mode: &Mode| (mode.frequency_hz - shown).abs();
        let near = |mode: &Mode| apart(mode) < (0.01 + truth.damping_ratio) * f;
        let best =
            (0..left.len()).filter(|i| near(left[*i])).min_by(|a, b| apart(left[*a]).total_cmp(&apart(left[*b])));
        let mode = best.map(|i| left.remove(i));
        let z = mode.map(|mode| {
            let f_z = (mode.frequency_hz - f) / mode.sigma_frequency_hz;
            [f_z, (mode.damping_ratio - truth.damping_ratio) / mode.sigma_damping]
        });
        let right = z.is_some_and(|z| z.iter().all(|z| z.abs() < RIGHT_SIGMA));
        let hidden = found.tones.iter().any(|tone| (tone.frequency_hz - f).abs() < tone.hides_hz);
        if !is_identifiable(truth, structure, recorded) {
            continue;
        }
        if recorded.beside_mode == Some(k) {
            sums.beside += 1;
            sums.beside_right += u32::from(right || hidden);
        }
        figures.modes += 1;
        match z {
            Some([f_z, damping_z]) => {
                sums.frequency_z.push(f_z);
                sums.damping_z.push(damping_z);
            }
            None => sums.missed += u32::from(!hidden),
        }
        if !right && (z.is_some() || !hidden) {
            let what = if z.is_some() { Fault::Wrong } else { Fault::Missed };
            fail(what, f, Some(truth.damping_ratio), z);
        }
    }
    sums.invented += left.len() as u32;
    left.iter().for_each(|mode| fail(Fault::Invented, mode.frequency_hz, Some(mode.damping_ratio), None));
    let mut named = vec![false; found.tones.len()];
    for tone_hz in &recorded.tones_hz {
        figures.tones += 1;
        let near = |k: &usize| (found.tones[*k].frequency_hz / tone_hz - 1.0).abs() < TONE_SHARE && !named[*k];
        if let Some(k) = (0..named.len()).find(near) {
            named[k] = true;
            sums.named += 1;
        } else {
            fail(Fault::ToneMissed, *tone_hz, None, None);
        }
    }
    for (tone, _) in found.tones.iter().zip(&named).filter(|(_, named)| !**named) {
        fail(Fault::ToneInvented, tone.frequency_hz, None, None);
    }
    figures.tones_invented += named.iter().filter(|named| !**named).count() as u32;
}

fn is_identifiable(truth: &TrueMode, structure: &Structure, recorded: &DefectiveRecord) -> bool {
    let present = recorded.columns[0].iter().filter(|y| y.is_finite()).count() as f64;
    let seconds = present / structure.sample_rate_hz;
    let rate_hz = structure.sample_rate_hz.min(recorded.update_rate_hz);
    let band = |mode: &TrueMode| mode.damping_ratio * mode.frequency_hz;
    // Where they show: above half the rate a mode folds onto others.
    let apart = |other: &TrueMode| (folded(other.frequency_hz, rate_hz) - folded(truth.frequency_hz, rate_hz)).abs();
    let overlaps = |other: &TrueMode| !core::ptr::eq(other, truth) && apart(other) < band(other) + band(truth);
    TAU * band(truth) * seconds >= FORGETTING_MIN
        && truth.frequency_hz < USABLE_BAND * rate_hz
        && !structure.modes.iter().any(overlaps)
}

/// Where a frequency shows that is read at a rate.
fn folded(frequency_hz: f64, rate_hz: f64) -> f64 {
    (frequency_hz - rate_hz * libm::round(frequency_hz / rate_hz)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The larger rms z.
    fn rms(found: &Figures) -> f64 {
        found.frequency_rms_z.unwrap().max(found.damping_rms_z.unwrap())
    }

    #[test]
    fn a_mode_onto_which_another_folds_is_not_identifiable() {
        let of = |update_rate_hz: f64| {
            let mode = |frequency_hz: f64, damping_ratio: f64| TrueMode {
                frequency_hz,
                damping_ratio,
                shape: vec![1.0],
                rms: 1.0,
            };
            let modes = vec![mode(3.58, 0.006), mode(13.6, 0.016)];
            let structure = Structure { sample_rate_hz: 50.0, samples: 12_000, channels: 1, modes, sensor_noise: 0.01 };
            let recorded = DefectiveRecord {
                time_s: Vec::new(),
                columns: vec![vec![0.0; 12_000]],
                tones_hz: Vec::new(),
                update_rate_hz,
                beside_mode: None,
            };
            [0, 1].map(|k| is_identifiable(&structure.modes[k], &structure, &recorded))
        };
        assert_eq!(of(50.0), [true, true]);
        // At 10 Hz it shows at 3.6 Hz, with a half-power width of 0.4 Hz; at 9 Hz at 4.4 Hz.
        assert_eq!(of(10.0), [false, false]);
        assert_eq!(of(9.0), [true, false]);
    }

    #[test]
    fn modes_of_held_samples_are_found_at_the_rate_of_the_sensor() {
        let found = figures(Defect::Held, 13, 733_003);
        // One of sixteen is missed; four were, with the block rows of a fast record.
        let missed = found.missed_percent.unwrap();
        assert!(found.failed == 0 && missed < 7.0 && found.invented_percent == Some(0.0), "{found:?}");
        assert!(rms(&found) < 1.5, "{found:?}");
        assert_eq!((found.tones_named_percent, found.beside_right_percent), (None, None));
    }

    /// A slice of the campaign: enough to see a kind that breaks, too few for its figures.
    #[test]
    fn records_with_defects_give_the_modes_of_the_structure() {
        for defect in
            [Defect::MissingRows, Defect::MissingPackets, Defect::SlowChannel, Defect::LateChannel, Defect::Tone]
        {
            let found = figures(defect, 2, 17);
            assert_eq!(found.failed, 0, "{found:?}");
            assert!(found.missed_percent == Some(0.0) && found.invented_percent == Some(0.0), "{found:?}");
            assert!(rms(&found) < 2.5, "{found:?}");
            assert!(found.tones_named_percent.is_none_or(|percent| percent == 100.0), "{found:?}");
        }
    }
}
