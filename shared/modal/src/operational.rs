//! Modes of a whole record without inputs, as it is: with samples missing, tones of machines, and
//! channels that are late.
//!
//! A complete record goes through the identifier that flies, behind the gate that finds jumps. In a
//! stationary one gaps up to the windows are filled (`short_gaps`); with many others it goes
//! through covariances of pairs ([`crate::pairs`]). In a stationary record tones are found and
//! taken out ([`crate::tones`]), and the modes identified from the rest.

mod beside_tones;

use crate::identifier::{Config, ModalError, ModalIdentifier, Wanted, select_by_pairs};
use crate::mac::{modal_phase_collinearity, normalised};
use crate::onset::OnsetGate;
use crate::pairs::{PairCovariances, covariances};
use crate::record::Record;
use crate::selection::{Mode, Selection};
use crate::short_gaps;
use crate::stabilisation::{RejectedPole, Rejection};
use crate::tones::{Tone, ToneSearch, powers};
use faer::c64;

/// Share of the record that windows may lose at its gaps before pairs are the better evidence.
const LOST_SHARE_MAX: f64 = 0.05;
/// Parts whose power tells a decay from a stationary record.
const PARTS: usize = 12;
/// Falling parts that a stationary record does not show: eight in order by chance, 1/8!, 2e-5.
const FALLING_PARTS: usize = 8;
/// Parts this near to the lowest are its floor.
const FLOOR_RATIO: f64 = 1.5;
/// Part of the first power that is left of a decay that is faster than eight parts, and parts that
/// it falls in: of a stationary record the parts hold several independent envelopes each.
const FALL_SHARE: f64 = 0.1;
const FAST_FALLS: usize = 3;
/// Damping of a mode of complex shape in its deviations: shapes of noise are complex, and four
/// deviations by chance in a hundred tracks are 3e-3.
const COMPLEX_SIGNIFICANCE: f64 = 4.0;

/// Power of a combination of modes over that of the weakest of them: the third harmonic of a sine
/// whose largest 10 % of samples are clipped has 1e-3.
const COMBINATION_POWER: f64 = 0.02;

/// How the covariances were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Windows without a break.
    Windows,
    /// Pairs of samples that exist.
    Pairs,
}

/// Modes and tones of a record.
#[derive(Clone, Debug)]
pub struct Operational {
    pub modes: Vec<Mode>,
    pub tones: Vec<Tone>,
    pub rejected: Vec<RejectedPole>,
    pub evidence: Evidence,
    /// The record moves freely or is struck: neither pairs nor tones are sought.
    pub transient: bool,
    /// Samples that were missing in gaps and are filled from those beside them.
    pub filled: usize,
    /// Samples as they were identified, where that is not as they are in the record: without tones,
    /// with gaps filled.
    pub rest: Option<Vec<f64>>,
}

/// Windows of 2i rows that a record read below the rate of its file holds at least. Its modes lie
/// high in the band and forget within a few rows: longer windows see noise of their covariances.
const WINDOWS_MIN: usize = 60;
/// Fewest block rows: two channels then still carry ten modes.
const BLOCK_ROWS_MIN: usize = 10;

/// Settings of the identifier in flight. A record that is read below the rate at which it was
/// logged is looked at over the time that i rows take there: its structure is no slower for it, and
/// its halved rates look further. Rows enough for the largest order remain.
#[must_use]
pub fn settings(record: &Record, logged_rate_hz: Option<f64>) -> Config {
    let mut config = Config::new(record.channels, record.sample_rate_hz);
    if let Some(logged_hz) = logged_rate_hz {
        let of_one_look = libm::round(config.block_rows as f64 * record.sample_rate_hz / logged_hz) as usize;
        let fitting = of_one_look.min(record.samples() / (2 * WINDOWS_MIN));
        let fewest = BLOCK_ROWS_MIN.max(config.selection.order_max / record.channels + 1);
        config.block_rows = fitting.clamp(fewest, config.block_rows.max(fewest));
    }
    config
}

/// What the examination knows of a record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'a> {
    /// Per channel, how late it is; none when empty.
    pub delays_s: &'a [f64],
    /// Samples stand at a limit.
    pub clipped: bool,
}

/// Modes of `record` (its outputs, NaN where no sample exists), the settings those of the
/// identifier.
///
/// # Errors
/// [`ModalError`] when the record is too short or flat.
pub fn identify(record: &Record, known: Known<'_>, config: &Config) -> Result<Operational, ModalError> {
    let (shifted, left_s) = in_step(record, known.delays_s);
    let values = shifted.as_ref().unwrap_or(&record.outputs);
    let transient = is_transient(values, record.channels);
    let filled = if transient { None } else { short_gaps::filled(values, record.channels) };
    let unknown = filled.as_ref().map_or(0.0, |filled| filled.unknown);
    let (values, filled) = filled.as_ref().map_or((values, 0), |filled| (&filled.values, filled.count));
    let evidence = if transient { Evidence::Windows } else { evidence(values, config) };
    let identified = |values: &[f64]| {
        let accumulated = Accumulated::new(values, evidence, config);
        with_complex_shapes(&accumulated, config, &left_s)
    };
    let mut selection = identified(values)?;
    let mut found = Operational {
        modes: Vec::new(),
        tones: Vec::new(),
        rejected: Vec::new(),
        evidence,
        transient,
        filled,
        rest: None,
    };
    if !transient {
        let mut search = ToneSearch::new(values, record.channels, record.sample_rate_hz);
        selection = beside_tones::identified(&mut search, selection, identified)?;
        if !search.tones.is_empty() {
            found.rest = Some(search.rest().to_vec());
        }
        found.tones = search.tones;
    }
    if found.rest.is_none() && filled > 0 {
        found.rest = Some(values.clone());
    }
    if known.clipped {
        let rest = found.rest.as_deref().unwrap_or(values);
        without_combinations(&mut selection, rest, config);
    }
    (found.modes, found.rejected) = (selection.modes, selection.rejected);
    found.modes.iter_mut().for_each(|mode| widen(mode, unknown));
    Ok(found)
}

/// Deviations of a record of which the part `unknown` is borrowed from the rest.
fn widen(mode: &mut Mode, unknown: f64) {
    let factor = 1.0 / (1.0 - unknown).sqrt();
    mode.sigma_frequency_hz *= factor;
    mode.sigma_damping *= factor;
    mode.shape_deviation.iter_mut().for_each(|sd| *sd *= factor);
}

/// Rejects the modes that stronger motion makes by clipping.
fn without_combinations(selection: &mut Selection, values: &[f64], config: &Config) {
    let sources = sources(selection);
    let powers = powers(values, config.channels, config.sample_rate_hz, &sources);
    let combined: Vec<bool> = selection
        .modes
        .iter()
        .enumerate()
        .map(|(k, mode)| is_combination(mode, powers[k], &sources, &powers))
        .collect();
    let mut is = combined.iter();
    for mode in selection.modes.extract_if(.., |_| is.next() == Some(&true)) {
        selection.rejected.push(rejected(&mode, Rejection::Combination));
    }
}

/// Frequency and damping of all that may move strongly: the modes, in their order, and poles apart
/// from them that the record is too short to resolve.
fn sources(selection: &Selection) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = selection.modes.iter().map(|mode| (mode.frequency_hz, mode.damping_ratio)).collect();
    for pole in selection.rejected.iter().filter(|pole| matches!(pole.reason, Rejection::NotResolved { .. })) {
        let (f, zeta) = (pole.frequency_hz, pole.damping_ratio);
        if all.iter().all(|other| (other.0 - f).abs() > 2.0 * (zeta * f + other.0 * other.1)) {
            all.push((f, zeta));
        }
    }
    all
}

/// Clipping is odd: of motion at f₁, f₂, f₃ it makes motion at `|f₁ ± f₂ ± f₃|`, of three times the
/// bandwidth, and weaker than any of them ([`COMBINATION_POWER`]).
fn is_combination(mode: &Mode, power: f64, sources: &[(f64, f64)], powers: &[f64]) -> bool {
    let stronger: Vec<(f64, f64)> = sources
        .iter()
        .zip(powers)
        .filter(|(_, other)| power < COMBINATION_POWER * **other)
        .map(|(of, _)| *of)
        .collect();
    let near = |f: f64, widths: f64| (mode.frequency_hz - f.abs()).abs() < widths + 3.0 * mode.sigma_frequency_hz;
    stronger.iter().enumerate().any(|(i, a)| {
        stronger.iter().enumerate().skip(i).any(|(_, b)| {
            stronger.iter().any(|c| {
                let widths = a.0 * a.1 + b.0 * b.1 + c.0 * c.1;
                [a.0 + b.0 + c.0, a.0 + b.0 - c.0, a.0 - b.0 + c.0].iter().any(|f| near(*f, widths))
            })
        })
    })
}

fn rejected(mode: &Mode, reason: Rejection) -> RejectedPole {
    let Mode { decimation, order, frequency_hz, damping_ratio, .. } = *mode;
    RejectedPole { decimation, order, frequency_hz, damping_ratio, reason }
}

/// Late channels moved ahead by whole samples, and what is left of each delay; `None`: no delay.
fn in_step(record: &Record, delays_s: &[f64]) -> (Option<Vec<f64>>, Vec<f64>) {
    let l = record.channels;
    let steps: Vec<isize> = delays_s.iter().map(|d| libm::round(d * record.sample_rate_hz) as isize).collect();
    let left_s = delays_s.iter().zip(&steps).map(|(d, n)| d - *n as f64 / record.sample_rate_hz).collect();
    if steps.iter().all(|n| *n == 0) {
        return (None, left_s);
    }
    let (ahead, behind) = (steps.iter().max().map_or(0, |n| *n.max(&0)), steps.iter().min().map_or(0, |n| *n.min(&0)));
    let rows = 0.max(record.samples() as isize - ahead + behind);
    let sample = |t: isize, c: usize| record.outputs[(t + steps[c]) as usize * l + c];
    let values = (0..rows).flat_map(|t| (0..l).map(move |c| (t - behind, c))).map(|(t, c)| sample(t, c)).collect();
    (Some(values), left_s)
}

/// Covariances of samples, from which modes are selected by any settings of the selection.
enum Accumulated {
    Windows(Box<ModalIdentifier>),
    Pairs(Vec<PairCovariances>, u64),
}

impl Accumulated {
    fn new(values: &[f64], evidence: Evidence, config: &Config) -> Self {
        match evidence {
            Evidence::Pairs => Self::Pairs(
                covariances(values, config.channels, config.block_rows, config.halvings),
                (values.len() / config.channels) as u64,
            ),
            Evidence::Windows => {
                let (mut identifier, mut gate) =
                    (ModalIdentifier::new(config.clone()).deferred(), OnsetGate::default());
                values.chunks_exact(config.channels).for_each(|row| gate.push(row, &mut identifier));
                gate.end_segment(&mut identifier);
                Self::Windows(Box::new(identifier))
            }
        }
    }

    fn select(&self, config: &Config, wanted: Wanted<'_>) -> Result<Vec<Selection>, ModalError> {
        match self {
            Self::Pairs(rates, rows) => select_by_pairs(rates, *rows, config, wanted),
            Self::Windows(identifier) => identifier.select(config, wanted),
        }
    }
}

/// Modes of a part of a record (samples, NaN where none exists) by the evidence of the whole, at
/// the rates at which the whole has `modes`.
///
/// # Errors
/// [`ModalError`] when the part is too short or flat.
pub fn selection_like(
    modes: &[Mode],
    values: &[f64],
    evidence: Evidence,
    config: &Config,
) -> Result<Selection, ModalError> {
    let mut decimations: Vec<usize> = modes.iter().map(|mode| mode.decimation).collect();
    decimations.sort_unstable();
    decimations.dedup();
    let Some(slowest) = decimations.last() else { return Ok(Selection::default()) };
    let config = Config { halvings: slowest.ilog2() as usize, ..config.clone() };
    let wanted = Wanted { collinearities_min: &[config.selection.phase_collinearity_min], decimations: &decimations };
    let mut selections = Accumulated::new(values, evidence, &config).select(&config, wanted)?;
    Ok(selections.pop().unwrap_or_default())
}

/// Pairs where windows would lose more than [`LOST_SHARE_MAX`] of the record.
fn evidence(values: &[f64], config: &Config) -> Evidence {
    let broken: Vec<bool> =
        values.chunks_exact(config.channels).map(|row| row.iter().any(|y| !y.is_finite())).collect();
    let gaps =
        broken.windows(2).filter(|pair| pair[1] && !pair[0]).count() + usize::from(broken.first() == Some(&true));
    // Of the slowest rate, a window and a filter that fills again.
    let lost = gaps * ((2 * config.block_rows) << config.halvings);
    if lost as f64 > LOST_SHARE_MAX * broken.len() as f64 { Evidence::Pairs } else { Evidence::Windows }
}

/// The power falls from part to part: [`FALLING_PARTS`] in order behind the strongest, which no
/// part before comes near, until a floor.
fn is_transient(values: &[f64], channels: usize) -> bool {
    let rows = values.len() / channels;
    if rows < 4 * PARTS {
        return true;
    }
    let means: Vec<f64> = (0..channels)
        .map(|c| {
            let existing = values.iter().skip(c).step_by(channels).filter(|y| y.is_finite());
            let (n, sum) = existing.fold((0.0, 0.0), |(n, sum), y| (n + 1.0, sum + y));
            if n > 0.0 { sum / n } else { 0.0 }
        })
        .collect();
    let power = |part: usize| {
        let (from, to) = (part * rows / PARTS, (part + 1) * rows / PARTS);
        let mut squares = vec![0.0; channels];
        let mut counts = vec![0.0; channels];
        for row in values[from * channels..to * channels].chunks_exact(channels) {
            for (c, y) in row.iter().enumerate().filter(|(_, y)| y.is_finite()) {
                squares[c] += (y - means[c]) * (y - means[c]);
                counts[c] += 1.0;
            }
        }
        squares.iter().zip(&counts).map(|(s, n)| if *n > 0.0 { s / n } else { 0.0 }).sum::<f64>()
    };
    let powers: Vec<f64> = (0..PARTS).map(power).collect();
    let largest = (0..PARTS).max_by(|a, b| powers[*a].total_cmp(&powers[*b])).unwrap_or(0);
    let floor = powers.iter().copied().fold(f64::INFINITY, f64::min);
    let quiet_before = powers[..largest].iter().all(|p| *p < 0.1 * powers[largest]);
    let behind = || powers[largest..].windows(2);
    let falls = behind().take_while(|pair| pair[1] < pair[0] || pair[1] < FLOOR_RATIO * floor).count();
    let to_the_end = largest + falls + 1 == PARTS;
    // Parts near the floor fall by chance; above it none does eight times.
    let above = behind().take_while(|pair| pair[1] < pair[0] && pair[0] > FLOOR_RATIO * floor).count();
    let falls_far = floor < FALL_SHARE * powers[largest] && falls >= FAST_FALLS;
    quiet_before && to_the_end && (above + 1 >= FALLING_PARTS || falls_far)
}

/// Shapes in step, and modes whose shape is complex for no delay, when they are otherwise resolved.
fn with_complex_shapes(accumulated: &Accumulated, config: &Config, left_s: &[f64]) -> Result<Selection, ModalError> {
    let wanted = Wanted { collinearities_min: &[config.selection.phase_collinearity_min, 0.0], decimations: &[] };
    let mut selections = accumulated.select(config, wanted)?.into_iter();
    let (mut selection, all) = (selections.next().unwrap_or_default(), selections.next().unwrap_or_default());
    let scattered = |pole: &RejectedPole| matches!(pole.reason, Rejection::PhaseNotCollinear { .. });
    if selection.rejected.iter().any(scattered) {
        let known = selection.modes.clone();
        let near = |mode: &Mode, other: &Mode| {
            (mode.frequency_hz - other.frequency_hz).abs() < 2.0 * other.damping_ratio * other.frequency_hz
        };
        selection.modes.extend(all.modes.into_iter().filter(|mode| {
            mode.sigma_damping * COMPLEX_SIGNIFICANCE < mode.damping_ratio
                && mode.orders_found >= 2 * config.selection.orders_needed
                && mode.phase_collinearity < config.selection.phase_collinearity_min
                && !known.iter().any(|other| near(mode, other))
        }));
        selection.modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    }
    for mode in selection.modes.iter_mut().filter(|_| !left_s.is_empty()) {
        let omega = core::f64::consts::TAU * mode.frequency_hz;
        let turned = mode.mode_shape.iter().zip(left_s).map(|(psi, delay_s)| {
            let (sine, cosine) = libm::sincos(omega * delay_s);
            *psi * c64::new(cosine, sine)
        });
        mode.mode_shape = normalised(turned);
        mode.phase_collinearity = modal_phase_collinearity(&mode.mode_shape);
    }
    Ok(selection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;

    #[test]
    fn a_steady_record_whose_first_part_is_the_strongest_is_no_decay() {
        let mut noise = Noise::new(7);
        let tone = |t: usize| if t < 100 { 1.1 } else { 1.0 } * libm::sin(0.7 * t as f64);
        let steady: Vec<f64> = (0..1200).map(|t| tone(t) + 0.05 * noise.normal()).collect();
        assert!(!is_transient(&steady, 1));
        let decay: Vec<f64> = (0..1200)
            .map(|t| libm::exp(-0.01 * t as f64) * libm::sin(0.7 * t as f64) + 0.01 * noise.normal())
            .collect();
        assert!(is_transient(&decay, 1));
    }
}
