//! Tones of machines in a stationary record: found, distinguished from modes, and taken out.
//!
//! Candidates are the lines of the periodogram that stand above their neighbourhood, and the modes
//! that were identified. `narrow_band` decides on steady lines, one or two together;
//! `constant_envelope` on lines that wander; `modulated` on lines of one shape that are the side
//! bands of one tone. A tone is taken out by least squares on the samples that exist: a steady one
//! as a sinusoid, a wandering one along the phase of its envelope.
//!
//! On a mode `beside_modes` takes the mode out first: by weights of the channels in which its shape
//! has no part.
//!
//! Assumes a stationary record: the envelope of a free decay is deterministic, too. Fails on a mode
//! whose envelope changes fewer than three times within the record, which is a line to it, and on a
//! line in the shape of the mode it lies on that is below a tenth of its power.

mod baseband;
mod beside_modes;
mod constant_envelope;
mod fourier;
mod modulated;
mod narrow_band;
mod spectra;

use baseband::{Present, Samples};
use core::f64::consts::TAU;
use faer::c64;
use fourier::turn;
use narrow_band::{HALF_CELLS, HALF_CELLS_MIN, LINE_CHANCE, NarrowBand};
use spectra::Spectra;

use crate::mac::modal_assurance_criterion;
use crate::selection::Mode;

/// Height of a line above its neighbourhood from which it is a candidate. A line of the power of a
/// mode stands πζfT above the mode's peak; noise passes `(1 + 2 · 10 / 20)^(−10)`, 1e-3 of cells,
/// and is no less likely than what the test of a line accepts.
const CANDIDATE_RATIO: f64 = 10.0;
/// Cells of the neighbourhood, on either side.
const NEIGHBOURS: std::ops::RangeInclusive<usize> = 3..=10;
/// Candidates examined at most, the highest first.
const CANDIDATES_MAX: usize = 40;
/// Probability that a record without lines has one on a mode, in the shapes beside that of the
/// mode.
const LINE_ON_MODE_CHANCE: f64 = 1e-3;
/// Distance of lines that the record does not resolve: the width of the Hann window's peak.
const REMAINDER_CELLS: f64 = 2.0;
/// Horns of a tone that wanders, where it turns, relative to its frequency.
const HORNS: f64 = 0.05;
/// Least assurance criterion of side bands of one tone.
const SIDE_BAND_MAC: f64 = 0.9;
/// Half band of a peak of the smoothed spectrum, relative to its frequency: a wheel that wanders by
/// two percent.
const WANDER_SHARE: f64 = 0.025;
/// Height of such a peak above the median around it.
const WANDER_RATIO: f64 = 8.0;
/// Tones taken out at most.
const TONES_MAX: usize = 32;
/// Half band of the envelope of a mode, in its half widths: holds 96 % of its power.
const ENVELOPE_WIDTHS: f64 = 16.0;
/// Deviation of a width that is counted in an envelope, relative to it: of ten independent values.
const COUNTED_SHARE: f64 = 0.3;
/// Longest envelope that is simulated, in cells of half its band.
const ENVELOPE_CELLS_MAX: usize = 400;

/// A tone.
#[derive(Clone, Debug, PartialEq)]
pub struct Tone {
    /// Mean frequency.
    pub frequency_hz: f64,
    pub sigma_frequency_hz: f64,
    /// How far its frequency wanders from the mean; zero: steady.
    pub wander_hz: f64,
    /// Complex amplitude per channel, in the unit of the samples.
    pub amplitude: Vec<c64>,
    /// Half width of the band in which it hides a mode.
    pub hides_hz: f64,
}

/// A record whose tones are being found.
#[derive(Clone, Debug)]
pub struct ToneSearch {
    samples: Samples,
    refused_hz: Vec<f64>,
    /// What was taken out, tone by tone.
    removed: Vec<Removed>,
    pub tones: Vec<Tone>,
}

/// A line that was taken out.
#[derive(Clone, Debug)]
struct Removed {
    /// Frequency of the tone that it belongs to.
    tone_hz: f64,
    /// Per row.
    phase: Vec<f64>,
    /// Per channel.
    amplitude: Vec<c64>,
}

impl ToneSearch {
    /// Of samples without a trend; NaN where none exists.
    #[must_use]
    pub fn new(values: &[f64], channels: usize, rate_hz: f64) -> Self {
        let samples = Samples::new(values, channels, rate_hz);
        Self { samples, refused_hz: Vec::new(), removed: Vec::new(), tones: Vec::new() }
    }

    /// Samples without means, trends and the tones found so far.
    #[must_use]
    pub fn rest(&self) -> &[f64] {
        &self.samples.values
    }

    /// Finds steady tones and takes them out; how many. `modes_hz` are those that are known.
    pub fn steady(&mut self, modes_hz: &[f64]) -> usize {
        let before = self.tones.len();
        let mut band: Option<(usize, NarrowBand)> = None;
        while self.tones.len() < TONES_MAX {
            let Some((frequency_hz, lines)) = self.next_lines(modes_hz, &mut band) else { break };
            self.take_out(frequency_hz, &lines);
        }
        self.tones.len() - before
    }

    /// The highest candidate that is no mode, and its lines \[Hz\].
    fn next_lines(&mut self, modes_hz: &[f64], band: &mut Option<(usize, NarrowBand)>) -> Option<(f64, Vec<f64>)> {
        let duration_s = self.samples.duration_s();
        let cell_hz = 1.0 / duration_s;
        let spectra = Spectra::new(&self.samples);
        for frequency_hz in self.candidates(&spectra) {
            if self.refused_hz.iter().any(|refused| (refused - frequency_hz).abs() < cell_hz) {
                continue;
            }
            let half_cells = self.half_cells(frequency_hz);
            if half_cells < HALF_CELLS_MIN {
                continue;
            }
            if band.as_ref().is_none_or(|(known, _)| *known != half_cells) {
                *band = Some((half_cells, NarrowBand::new(half_cells)));
            }
            let (_, band) = band.as_ref()?;
            let in_band = |f: &&f64| (*f - frequency_hz).abs() < half_cells as f64 * cell_hz;
            let modes = modes_hz.iter().filter(in_band).count();
            // A line may be in any cell; the weights make the most of what is in this one, so that
            // the same holds of the test against a mode that they leave.
            let chance = LINE_ON_MODE_CHANCE / (0.5 * self.samples.rows() as f64);
            let beside = beside_modes::weights(&spectra, frequency_hz * duration_s, half_cells, modes, chance)
                .and_then(|w| band.lines(&self.samples.envelope(&w, frequency_hz, half_cells, Present::All), chance));
            let lines = beside.or_else(|| {
                let weights = self.samples.weights(frequency_hz);
                band.lines(&self.samples.envelope(&weights, frequency_hz, half_cells, Present::Any), LINE_CHANCE)
            });
            match lines {
                Some(lines) => {
                    return Some((frequency_hz, lines.iter().map(|l| frequency_hz + l.cells * cell_hz).collect()));
                }
                None => self.refused_hz.push(frequency_hz),
            }
        }
        None
    }

    /// Half a band that stays clear of zero and of the Nyquist frequency.
    fn half_cells(&self, frequency_hz: f64) -> usize {
        let duration_s = self.samples.duration_s();
        let to_nyquist = (0.5 * self.samples.rate_hz - frequency_hz) * duration_s;
        let room = (0.5 * frequency_hz * duration_s).min(0.5 * to_nyquist).min(self.samples.rows() as f64 / 16.0);
        HALF_CELLS.min(room.max(0.0) as usize)
    }

    /// Peaks of the periodogram by their height above the neighbourhood.
    fn candidates(&self, spectra: &Spectra) -> Vec<f64> {
        if self.samples.rows() < 64 {
            return Vec::new();
        }
        let (power, per_cell) = (spectra.power(&self.samples.variances()), spectra.per_cell());
        let reach = |cells: usize| (cells as f64 * per_cell) as usize;
        let far = reach(*NEIGHBOURS.end());
        let mut found: Vec<(f64, f64)> = Vec::new();
        for k in far..power.len().saturating_sub(far) {
            if power[k] < power[k - 1] || power[k] < power[k + 1] || power[k] == 0.0 {
                continue;
            }
            // The median of cells: a mode beside the line fills some of them.
            let mut around: Vec<f64> =
                NEIGHBOURS.flat_map(|cells| [power[k - reach(cells)], power[k + reach(cells)]]).collect();
            around.sort_by(f64::total_cmp);
            let level = around[around.len() / 2];
            if power[k] > CANDIDATE_RATIO * level {
                found.push((power[k] / level, k as f64 / per_cell / self.samples.duration_s()));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(CANDIDATES_MAX);
        found.into_iter().map(|(_, frequency_hz)| frequency_hz).collect()
    }

    /// Takes lines out together, as sinusoids of the samples that exist.
    fn take_out(&mut self, centre_hz: f64, lines_hz: &[f64]) {
        let phases: Vec<Vec<f64>> = lines_hz
            .iter()
            .map(|f| (0..self.samples.rows()).map(|t| TAU * f * t as f64 / self.samples.rate_hz).collect())
            .collect();
        let amplitudes = self.subtract(&phases);
        let cell_hz = 1.0 / self.samples.duration_s();
        for ((frequency_hz, amplitude), phase) in lines_hz.iter().zip(amplitudes).zip(phases) {
            // What an error of its frequency left of a line before is no other line.
            let known = |tone: &&Tone| (tone.frequency_hz - frequency_hz).abs() < REMAINDER_CELLS * cell_hz;
            let of_known = self.tones.iter().find(known).map(|tone| tone.frequency_hz);
            let tone_hz = of_known.unwrap_or(*frequency_hz);
            self.removed.push(Removed { tone_hz, phase, amplitude: amplitude.clone() });
            if of_known.is_some() {
                continue;
            }
            let sigma_frequency_hz = self.line_deviation(*frequency_hz, &amplitude);
            self.tones.push(Tone {
                frequency_hz: *frequency_hz,
                sigma_frequency_hz,
                wander_hz: 0.0,
                amplitude,
                hides_hz: 2.0 * cell_hz,
            });
        }
        self.refused_hz.retain(|refused| (refused - centre_hz).abs() > HALF_CELLS as f64 * cell_hz);
    }

    /// Cramér–Rao bound of the frequency of a line in the noise that is left about it:
    /// `σ_f² = 6 S / (π² Σ|a|² T³)`, S the density two to ten cells away. Rife & Boorstyn 1974.
    fn line_deviation(&self, frequency_hz: f64, amplitude: &[c64]) -> f64 {
        let duration_s = self.samples.duration_s();
        let mut density = vec![0.0; amplitude.len()];
        let offsets = [-9.0, -7.0, -5.0, -3.0, 3.0, 5.0, 7.0, 9.0];
        let window = 0.375 * (self.samples.rows() as f64);
        for offset in offsets {
            let at = self.samples.at(frequency_hz + offset / duration_s);
            density.iter_mut().zip(&at).for_each(|(sum, y)| *sum += y.norm_sqr() / window / self.samples.rate_hz);
        }
        let information: f64 = amplitude
            .iter()
            .zip(&density)
            .filter(|(_, density)| **density > 0.0)
            .map(|(a, density)| a.norm_sqr() / (density / offsets.len() as f64))
            .sum();
        if information > 0.0 {
            (6.0 / (core::f64::consts::PI * core::f64::consts::PI * information * duration_s.powi(3))).sqrt()
        } else {
            0.0
        }
    }

    /// Least squares of cosine and sine along every phase, jointly; per phase and channel the
    /// complex amplitude.
    fn subtract(&mut self, phases: &[Vec<f64>]) -> Vec<Vec<c64>> {
        let (l, rows, columns) = (self.samples.channels, self.samples.rows(), 2 * phases.len());
        let mut amplitudes = vec![vec![c64::new(0.0, 0.0); l]; phases.len()];
        let mut basis = Vec::with_capacity(rows * columns);
        for t in 0..rows {
            for phase in phases {
                let e = turn(phase[t]);
                basis.extend([e.re, -e.im]);
            }
        }
        for c in 0..l {
            let mut normal = vec![0.0; columns * columns];
            let mut right = vec![0.0; columns];
            for (t, row) in basis.chunks_exact(columns).enumerate() {
                let y = self.samples.values[t * l + c];
                if y.is_finite() {
                    for a in 0..columns {
                        right[a] += row[a] * y;
                        (0..columns).for_each(|b| normal[a * columns + b] += row[a] * row[b]);
                    }
                }
            }
            let solution = solve(normal, right);
            for (t, row) in basis.chunks_exact(columns).enumerate() {
                let part: f64 = row.iter().zip(&solution).map(|(x, a)| x * a).sum();
                self.samples.values[t * l + c] -= part;
            }
            for (k, amplitude) in amplitudes.iter_mut().enumerate() {
                amplitude[c] = c64::new(solution[2 * k], solution[2 * k + 1]);
            }
        }
        amplitudes
    }

    /// Whether what was taken for this mode is a tone that wanders; then it is taken out.
    pub fn wandering(&mut self, mode: &Mode) -> bool {
        let cells = mode.damping_ratio * mode.frequency_hz * self.samples.duration_s();
        let sigma = mode.sigma_damping / mode.damping_ratio * cells;
        let Some(half_cells) = self.wide_band(mode.frequency_hz, ENVELOPE_WIDTHS * cells) else { return false };
        let variances = self.samples.variances();
        let of = |(psi, variance): (&c64, &f64)| if *variance > 0.0 { psi.conj() / *variance } else { *psi * 0.0 };
        let weights: Vec<c64> = mode.mode_shape.iter().zip(&variances).map(of).collect();
        let envelope = self.samples.envelope(&weights, mode.frequency_hz, half_cells, Present::Any);
        // Two modes taken for a wide one change less often than that.
        let counted = constant_envelope::half_width(&envelope);
        let (cells, sigma) = if counted < cells { (counted, COUNTED_SHARE * counted) } else { (cells, sigma) };
        let found = constant_envelope::is_constant(&envelope, cells, sigma);
        if found {
            self.take_out_along(mode.frequency_hz, &envelope);
        }
        found
    }

    /// Tones that wander and were taken for two modes, where they turn: neighbours of one shape
    /// whose band together has a constant envelope. How many were taken out.
    pub fn wandering_pairs(&mut self, modes: &[Mode]) -> usize {
        let one_shape = |pair: &&[Mode]| {
            pair[1].frequency_hz - pair[0].frequency_hz < HORNS * pair[0].frequency_hz
                && modal_assurance_criterion(&pair[0].mode_shape, &pair[1].mode_shape) > SIDE_BAND_MAC
        };
        let between: Vec<f64> = modes
            .windows(2)
            .filter(one_shape)
            .map(|pair| 0.5 * (pair[0].frequency_hz + pair[1].frequency_hz))
            .collect();
        between.into_iter().filter(|f| self.wandering_peak(*f)).count()
    }

    /// Tones that wander and were taken for no mode: peaks of the smoothed spectrum away from
    /// `modes_hz` with an envelope more constant than that of a mode as wide. How many were taken
    /// out.
    pub fn wandering_peaks(&mut self, modes_hz: &[f64]) -> usize {
        let spectra = Spectra::new(&self.samples);
        let power = spectra.power(&self.samples.variances());
        let per_hz = spectra.per_cell() * self.samples.duration_s();
        let mut sums = vec![0.0];
        power.iter().for_each(|p| sums.push(sums[sums.len() - 1] + p));
        let mean = |from: f64, to: f64| {
            let (a, b) = ((from * per_hz) as usize, ((to * per_hz) as usize).min(power.len()));
            if b > a { (sums[b] - sums[a]) / (b - a) as f64 } else { 0.0 }
        };
        let near = |f: f64| mean(f * (1.0 - WANDER_SHARE), f * (1.0 + WANDER_SHARE));
        let grid = |lowest: f64, highest: f64| {
            let steps = (libm::log(highest / lowest) / (0.5 * WANDER_SHARE)) as usize;
            (0..=steps).map(move |k| lowest * libm::exp(0.5 * WANDER_SHARE * k as f64)).collect::<Vec<f64>>()
        };
        let all = grid(2.0 * HALF_CELLS as f64 / self.samples.duration_s(), 0.45 * self.samples.rate_hz);
        let levels: Vec<f64> = all.iter().map(|f| near(*f)).collect();
        let mut taken = 0;
        for k in 8..all.len().saturating_sub(8) {
            let (f, level) = (all[k], levels[k]);
            let mut around: Vec<f64> = [&levels[k - 8..k - 3], &levels[k + 4..k + 9]].concat();
            around.sort_by(f64::total_cmp);
            let stands_out = level > WANDER_RATIO * around[around.len() / 2];
            let is_peak = level >= levels[k - 1] && level >= levels[k + 1];
            let of_a_mode = modes_hz.iter().any(|mode| (f / mode - 1.0).abs() < 2.0 * WANDER_SHARE);
            if stands_out && is_peak && !of_a_mode && self.wandering_peak(f) {
                taken += 1;
            }
        }
        taken
    }

    fn wandering_peak(&mut self, frequency_hz: f64) -> bool {
        let duration_s = self.samples.duration_s();
        let Some(half_cells) = self.wide_band(frequency_hz, 2.0 * WANDER_SHARE * frequency_hz * duration_s) else {
            return false;
        };
        let weights = self.samples.weights(frequency_hz);
        let envelope = self.samples.envelope(&weights, frequency_hz, half_cells, Present::Any);
        let cells = constant_envelope::half_width(&envelope);
        let found = constant_envelope::is_constant(&envelope, cells, COUNTED_SHARE * cells);
        if found {
            self.take_out_along(frequency_hz, &envelope);
        }
        found
    }

    /// Half a band of so many cells, if it stays clear of zero and the Nyquist frequency.
    fn wide_band(&self, frequency_hz: f64, cells: f64) -> Option<usize> {
        let room = (0.5 * frequency_hz).min(0.25 * (0.5 * self.samples.rate_hz - frequency_hz));
        let half_cells = cells.min(room * self.samples.duration_s()) as usize;
        (HALF_CELLS_MIN..=ENVELOPE_CELLS_MAX).contains(&half_cells).then_some(half_cells)
    }

    /// Takes out a line whose phase is that of the envelope.
    fn take_out_along(&mut self, centre_hz: f64, envelope: &[c64]) {
        let (rows, rate_hz, duration_s) = (self.samples.rows(), self.samples.rate_hz, self.samples.duration_s());
        let mut turns: Vec<f64> = Vec::with_capacity(envelope.len());
        for a in envelope {
            let phase = libm::atan2(a.im, a.re);
            let last = turns.last().copied().unwrap_or(phase);
            turns.push(phase + TAU * libm::round((last - phase) / TAU));
        }
        let per_row = envelope.len() as f64 / rows as f64;
        let phase = |t: usize| {
            let at = ((t as f64 + 0.5) * per_row - 0.5).clamp(0.0, (turns.len() - 1) as f64);
            let k = (at as usize).min(turns.len() - 2);
            let part = at - k as f64;
            TAU * centre_hz * t as f64 / rate_hz + turns[k] * (1.0 - part) + turns[k + 1] * part
        };
        let phases: Vec<f64> = (0..rows).map(phase).collect();
        let amplitude = self.subtract(std::slice::from_ref(&phases)).swap_remove(0);
        let step_s = duration_s / envelope.len() as f64;
        let mean_hz = (turns[turns.len() - 1] - turns[0]) / TAU / (duration_s - step_s);
        // Wander: over twenty values, so that noise in the band is not taken for it.
        let span = (turns.len() / 20).max(4).min(turns.len() - 1);
        let rates = turns.windows(span + 1).map(|w| (w[span] - w[0]) / TAU / (span as f64 * step_s) - mean_hz);
        let wander_hz = rates.fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let tone_hz = centre_hz + mean_hz;
        self.removed.push(Removed { tone_hz, phase: phases, amplitude: amplitude.clone() });
        self.tones.push(Tone {
            frequency_hz: tone_hz,
            sigma_frequency_hz: wander_hz / (envelope.len() as f64).sqrt(),
            wander_hz,
            amplitude,
            hides_hz: wander_hz + 2.0 / duration_s,
        });
    }
}

/// Mean square over all channels of the motion in the bands about some frequencies with dampings.
pub(crate) fn powers(values: &[f64], channels: usize, rate_hz: f64, of: &[(f64, f64)]) -> Vec<f64> {
    let samples = Samples::new(values, channels, rate_hz);
    let in_band = |(frequency_hz, damping_ratio): &(f64, f64)| {
        let half_cells = ((2.0 * damping_ratio * frequency_hz * samples.duration_s()) as usize).max(1);
        let of_channel = |c: usize| {
            let alone: Vec<c64> = (0..channels).map(|k| c64::new(f64::from(u8::from(k == c)), 0.0)).collect();
            let envelope = samples.envelope(&alone, *frequency_hz, half_cells, Present::Any);
            envelope.iter().map(c64::norm_sqr).sum::<f64>() / envelope.len() as f64
        };
        (0..channels).map(of_channel).sum()
    };
    of.iter().map(in_band).collect()
}

/// Symmetric positive equations by Gaussian elimination; a dependent column gets zero.
fn solve(mut a: Vec<f64>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    let largest = (0..n).map(|k| a[k * n + k]).fold(0.0, f64::max);
    for k in 0..n {
        if a[k * n + k] <= 1e-9 * largest {
            (a[k * n + k], b[k]) = (f64::INFINITY, 0.0);
            continue;
        }
        for row in k + 1..n {
            let factor = a[row * n + k] / a[k * n + k];
            (k..n).for_each(|column| a[row * n + column] -= factor * a[k * n + column]);
            b[row] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|column| a[k * n + column] * b[column]).sum();
        b[k] = if a[k * n + k].is_finite() { (b[k] - known) / a[k * n + k] } else { 0.0 };
    }
    b
}
