//! Frequency and damping over the parts of a record: constants of a linear structure, clocks of one
//! that is not.
//!
//! A fit of the whole record hides changes along it: damping that grows with amplitude moves the
//! fitted damping by tens of per cent and leaves the residuals almost white. The same record in
//! parts shows it with ten standard deviations, and the sign says what it is. Evidence, not a
//! verdict: wear, temperature and a moving payload drift, too.

use crate::mac::modal_assurance_criterion;
use crate::maximum_likelihood::{Model, fit};
use crate::methods::{Estimate, estimates};
use crate::record::Record;
use faer::c64;
use std::ops::Range;

/// Standard deviations from which a change is reported: two halves, two parameters for each of ten
/// modes, once in a thousand linear records.
pub const WORTH_A_WORD_SIGMA: f64 = 4.0;
/// Shapes less alike than this are not of one mode.
const SAME_SHAPE: f64 = 0.8;

/// A mode in an earlier and in a later part of the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// In the earlier part.
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Later minus earlier.
    pub frequency_change_hz: f64,
    pub damping_change: f64,
    /// Changes in units of their standard deviations.
    pub frequency_z: f64,
    pub damping_z: f64,
}

impl Drift {
    /// Whether the linear, constant model of this mode is in doubt.
    #[must_use]
    pub fn stands_out(&self) -> bool {
        self.frequency_z.abs() > WORTH_A_WORD_SIGMA || self.damping_z.abs() > WORTH_A_WORD_SIGMA
    }
}

impl std::fmt::Display for Drift {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { frequency_hz, damping_ratio, .. } = self;
        let (changed, percent, z, suspect) = if self.damping_z.abs() > self.frequency_z.abs() {
            let suspect = "damping that depends on amplitude, or friction";
            ("damping", 100.0 * self.damping_change / damping_ratio, self.damping_z, suspect)
        } else {
            let suspect = "stiffness that depends on amplitude, or mass or temperature that changes";
            ("frequency", 100.0 * self.frequency_change_hz / frequency_hz, self.frequency_z, suspect)
        };
        write!(
            f,
            "drift: the {changed} of {frequency_hz:.3} Hz changes by {percent:+.2} % from the first half of the record to the second ({:.0} standard deviations); {suspect}",
            z.abs()
        )
    }
}

/// Modes found in two parts, each paired with the nearest of like shape; those without standard
/// deviations are omitted.
#[must_use]
pub fn between(earlier: &[Estimate], later: &[Estimate]) -> Vec<Drift> {
    let of = |before: &Estimate| {
        let after = alike(before, later)?;
        let (a, b) = (before.deviation?, after.deviation?);
        let (frequency_change_hz, damping_change) =
            (after.frequency_hz - before.frequency_hz, after.damping_ratio - before.damping_ratio);
        Some(Drift {
            frequency_hz: before.frequency_hz,
            damping_ratio: before.damping_ratio,
            frequency_change_hz,
            damping_change,
            frequency_z: frequency_change_hz / libm::hypot(a.frequency_hz, b.frequency_hz),
            damping_z: damping_change / libm::hypot(a.damping_ratio, b.damping_ratio),
        })
    };
    earlier.iter().filter_map(of).collect()
}

/// The nearest of like shape, within three half-power widths and the tolerance of the deviations.
fn alike<'a>(mode: &Estimate, among: &'a [Estimate]) -> Option<&'a Estimate> {
    let apart = |other: &&Estimate| (other.frequency_hz - mode.frequency_hz).abs();
    let deviation = |estimate: &Estimate| estimate.deviation.map_or(0.0, |d| d.frequency_hz);
    let width = |other: &&Estimate| {
        3.0 * mode.damping_ratio.max(other.damping_ratio) * mode.frequency_hz
            + WORTH_A_WORD_SIGMA * deviation(mode).hypot(deviation(other))
    };
    let like = |other: &&Estimate| {
        modal_assurance_criterion(&mode.mode_shape, &other.mode_shape) > SAME_SHAPE && apart(other) < width(other)
    };
    among.iter().filter(like).min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

/// Modes of one part of a record.
#[derive(Clone, Debug)]
pub struct PartOfRecord {
    /// Behind the record's first sample.
    pub begin_s: f64,
    pub end_s: f64,
    /// Root mean square over all channels, mean of each removed: how strongly the structure moved,
    /// all modes together.
    pub amplitude: f64,
    pub modes: Vec<Estimate>,
}

/// A mode in one part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    pub begin_s: f64,
    pub end_s: f64,
    pub amplitude: f64,
    pub frequency_hz: f64,
    pub frequency_sd: f64,
    pub damping_ratio: f64,
    pub damping_sd: f64,
}

/// A mode of the whole record with its estimates over the parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub points: Vec<TrackPoint>,
}

/// Periods of the slowest mode that a part holds at least.
const PERIODS_MIN: f64 = 3.0;
/// Parts at most: time and amplitude are told apart by four, and each still knows its modes to
/// twice the whole record's sigma.
const PARTS_MAX: usize = 4;

/// Equal parts of a record worth fitting: four, or fewer where the slowest mode would not turn
/// three times in each; at least two.
#[must_use]
pub fn parts_of(record: &Record, slowest_hz: f64) -> Vec<Range<usize>> {
    let samples = record.samples();
    let periods = samples as f64 / record.sample_rate_hz * slowest_hz;
    let count = ((periods / PERIODS_MIN) as usize).clamp(2, PARTS_MAX);
    (0..count).map(|k| k * samples / count..(k + 1) * samples / count).collect()
}

/// A part with its modes, from any method.
#[must_use]
pub fn part(record: &Record, over: &Range<usize>, modes: Vec<Estimate>) -> PartOfRecord {
    let (l, rows) = (record.channels, record.rows(over));
    let count = over.len().max(1) as f64;
    let power = (0..l).map(|c| {
        let mean = rows.iter().skip(c).step_by(l).sum::<f64>() / count;
        rows.iter().skip(c).step_by(l).map(|y| (y - mean) * (y - mean)).sum::<f64>()
    });
    PartOfRecord {
        begin_s: over.start as f64 / record.sample_rate_hz,
        end_s: over.end as f64 / record.sample_rate_hz,
        amplitude: (power.sum::<f64>() / (count * l as f64)).sqrt(),
        modes,
    }
}

/// Every part of [`parts_of`] by maximum likelihood from the `poles` of the whole; a part that
/// cannot be fitted has no modes.
///
/// Cost: one fit of the record's length in all.
#[must_use]
pub fn parts_by_likelihood(record: &Record, model: Model, poles: &[c64]) -> Vec<PartOfRecord> {
    let slowest_hz = poles.iter().map(|p| p.norm_sqr().sqrt()).fold(f64::INFINITY, f64::min) / core::f64::consts::TAU;
    let fitted = |over: &Range<usize>| {
        let moving = Model { initial_motion: model.initial_motion || over.start > 0, ..model };
        let found = fit(&record.part(over.clone()), moving, poles).ok().filter(|fit| fit.converged);
        part(record, over, found.map(|fit| estimates(&fit)).unwrap_or_default())
    };
    parts_of(record, slowest_hz).iter().map(fitted).collect()
}

/// The modes of the whole through its parts; of parts in which none is like it there is no point.
#[must_use]
pub fn tracks(whole: &[Estimate], parts: &[PartOfRecord]) -> Vec<Track> {
    let track = |mode: &Estimate| Track {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        points: parts.iter().filter_map(|part| point(mode, part)).collect(),
    };
    whole.iter().map(track).filter(|track| track.points.len() > 1).collect()
}

fn point(mode: &Estimate, part: &PartOfRecord) -> Option<TrackPoint> {
    let found = alike(mode, &part.modes)?;
    let deviation = found.deviation?;
    Some(TrackPoint {
        begin_s: part.begin_s,
        end_s: part.end_s,
        amplitude: part.amplitude,
        frequency_hz: found.frequency_hz,
        frequency_sd: deviation.frequency_hz,
        damping_ratio: found.damping_ratio,
        damping_sd: deviation.damping_ratio,
    })
}

/// Drift of the modes at `poles` (of the whole record) between the halves of a record, each fitted
/// by maximum likelihood.
///
/// The second half begins in motion; so does the first unless `model` says otherwise. Empty where a
/// half cannot be fitted.
///
/// Cost: two fits of half the length.
#[must_use]
pub fn of_halves(record: &Record, model: Model, poles: &[c64]) -> Vec<Drift> {
    let middle = record.samples() / 2;
    let of = |part: Range<usize>, model: Model| fit(&record.part(part), model, poles).ok().filter(|fit| fit.converged);
    let moving = Model { initial_motion: true, ..model };
    match (of(0..middle, model), of(middle..record.samples(), moving)) {
        (Some(earlier), Some(later)) => between(&estimates(&earlier), &estimates(&later)),
        _ => Vec::new(),
    }
}
