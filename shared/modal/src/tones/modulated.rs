//! Lines of one shape: several tones, or the side bands of one whose frequency wanders?
//!
//! A tone of the power P in Gaussian noise has an envelope of `E|a|⁴ = 2 (E|a|²)² − P²`, however
//! its phase turns: its side bands stand so to each other that its size is constant. Lines of
//! powers `P_j` that are independent beat, `E|a|⁴ = 2 (E|a|²)² − Σ P_j²`. So
//! `Q = (2 (E|a|²)² − E|a|⁴)^½` of the band that holds the lines is `Σ P_j`, or more where not all
//! side bands were found, for one tone, and `(Σ P_j²)^½` for several: errors of both alike, the
//! nearer one is the likelier. The noise, modes among it, has no part in Q.
//!
//! One tone is put back and taken out along the phase of its envelope, whose advance over the
//! record is its mean frequency. What an error of that phase leaves are lines of its shape beside
//! it: they are part of it, and so are three lines or more, a horn of a tone that wanders far.
//!
//! Fails on machines that share a shape and run in step.

use super::baseband::{Present, gain};
use super::fourier::turn;
use super::{Removed, SIDE_BAND_MAC, Tone, ToneSearch, WANDER_SHARE};
use crate::mac::modal_assurance_criterion;
use faer::c64;

/// Lines of one shape this near to each other, relative to their frequency, may be side bands of
/// one tone whose frequency wanders: slower than in ten of its periods.
const SIDE_BANDS: f64 = 0.1;
/// Half the band that is examined, in units of the distance of its farthest line from its centre:
/// side bands fall off fast beyond those that stand out as lines, and within it the gain is 0.85.
const BAND_REACH: f64 = 2.0;
/// As many lines of one shape are one tone: machines share a shape by chance, and one of ten twice.
const SIDE_BANDS_MIN: usize = 3;

impl ToneSearch {
    /// Side bands of one tone become that tone.
    pub fn join_side_bands(&mut self) {
        self.tones.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let mut groups: Vec<Vec<Tone>> = Vec::new();
        for tone in self.tones.drain(..) {
            let belongs = |other: &Tone| {
                tone.frequency_hz - other.frequency_hz < SIDE_BANDS * tone.frequency_hz
                    && modal_assurance_criterion(&tone.amplitude, &other.amplitude) > SIDE_BAND_MAC
            };
            match groups.iter_mut().find(|group| group.iter().any(belongs)) {
                Some(group) => group.push(tone),
                None => groups.push(vec![tone]),
            }
        }
        for group in groups {
            if group.len() == 1 || !self.join(&group) {
                self.tones.extend(group);
            }
        }
        self.tones.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    }

    /// Whether the lines of a group are one tone; then it takes their place.
    fn join(&mut self, group: &[Tone]) -> bool {
        let total: f64 = group.iter().map(power).sum();
        let centre_hz = group.iter().map(|tone| power(tone) * tone.frequency_hz).sum::<f64>() / total;
        let reach = |tone: &Tone| (tone.frequency_hz - centre_hz).abs() + tone.wander_hz;
        let reach_hz = group.iter().map(reach).fold(0.0, f64::max);
        let strongest = group.iter().max_by(|a, b| power(a).total_cmp(&power(b))).expect("a group has members");
        if strongest.wander_hz > 0.0 {
            self.replace(group, strongest.clone());
            return true;
        }
        let is_one = group.len() >= SIDE_BANDS_MIN;
        let mut band_hz = BAND_REACH * reach_hz;
        while !self.is_taken_out_along(group, centre_hz, band_hz, reach_hz) {
            band_hz *= 2.0;
            if !is_one {
                return false;
            }
            if band_hz > 2.0 * WANDER_SHARE * centre_hz {
                self.replace(group, joined(group, strongest, (centre_hz, reach_hz)));
                break;
            }
        }
        true
    }

    /// A tone in the place of the lines of a group, which stay taken out.
    fn replace(&mut self, group: &[Tone], tone: Tone) {
        let of_group = |removed: &&mut Removed| is_member(group, removed.tone_hz);
        self.removed.iter_mut().filter(of_group).for_each(|removed| removed.tone_hz = tone.frequency_hz);
        self.tones.push(tone);
    }

    /// Whether the band `centre_hz` ± `band_hz` holds the lines of a group as one tone; then it is
    /// taken out along its phase.
    fn is_taken_out_along(&mut self, group: &[Tone], centre_hz: f64, band_hz: f64, reach_hz: f64) -> bool {
        let duration_s = self.samples.duration_s();
        let cells = (band_hz * duration_s).max(super::HALF_CELLS_MIN as f64);
        let Some(half_cells) = self.wide_band(centre_hz, cells) else { return false };
        if reach_hz * duration_s > half_cells as f64 {
            return false;
        }
        let strongest = group.iter().max_by(|a, b| power(a).total_cmp(&power(b))).expect("a group has members");
        let variances = self.samples.variances();
        let of = |(a, variance): (&c64, &f64)| if *variance > 0.0 { a.conj() / *variance } else { *a * 0.0 };
        let weights: Vec<c64> = strongest.amplitude.iter().zip(&variances).map(of).collect();
        let mut restored = self.samples.clone();
        for removed in self.removed.iter().filter(|removed| is_member(group, removed.tone_hz)) {
            for (row, phase) in restored.values.chunks_exact_mut(restored.channels).zip(&removed.phase) {
                let e = turn(*phase);
                row.iter_mut().zip(&removed.amplitude).for_each(|(y, a)| *y += (*a * e).re);
            }
        }
        let envelope = restored.envelope(&weights, centre_hz, half_cells, Present::Any);
        // A line `Re(a e^{iφ})` has half its amplitude in its envelope.
        let in_envelope = |tone: &Tone| {
            let offset = (tone.frequency_hz - centre_hz) * duration_s;
            let sum = tone.amplitude.iter().zip(&weights).fold(c64::new(0.0, 0.0), |sum, (a, w)| sum + *a * *w);
            0.25 * sum.norm_sqr() * gain(offset, half_cells) * gain(offset, half_cells)
        };
        let powers: Vec<f64> = group.iter().map(in_envelope).collect();
        if !is_one_tone(&envelope, &powers) {
            return false;
        }
        self.samples = restored;
        self.removed.retain(|removed| !is_member(group, removed.tone_hz));
        self.take_out_along(centre_hz, &envelope);
        if let Some(tone) = self.tones.last_mut() {
            tone.hides_hz = tone.hides_hz.max(reach_hz + 2.0 / duration_s);
        }
        true
    }
}

/// One tone of several side bands: mean frequency and wander by their power.
fn joined(group: &[Tone], strongest: &Tone, (mean_hz, reach_hz): (f64, f64)) -> Tone {
    let total: f64 = group.iter().map(power).sum();
    let spread = |tone: &Tone| power(tone) * (tone.frequency_hz - mean_hz) * (tone.frequency_hz - mean_hz);
    let wander_hz = (2.0 * group.iter().map(spread).sum::<f64>() / total).sqrt();
    let scale = (total / power(strongest)).sqrt();
    Tone {
        frequency_hz: mean_hz,
        sigma_frequency_hz: wander_hz / (group.len() as f64).sqrt(),
        wander_hz,
        amplitude: strongest.amplitude.iter().map(|a| *a * scale).collect(),
        hides_hz: reach_hz + strongest.hides_hz,
    }
}

/// Whether a frequency is that of a tone of the group, to the bit.
fn is_member(group: &[Tone], tone_hz: f64) -> bool {
    group.iter().any(|tone| tone.frequency_hz.to_bits() == tone_hz.to_bits())
}

fn power(tone: &Tone) -> f64 {
    tone.amplitude.iter().map(c64::norm_sqr).sum()
}

/// Whether `Q` of an envelope is nearer to that of one tone than to that of lines of these powers.
fn is_one_tone(envelope: &[c64], powers: &[f64]) -> bool {
    let (mut second, mut fourth) = (0.0, 0.0);
    for power in envelope.iter().map(c64::norm_sqr) {
        second += power / envelope.len() as f64;
        fourth += power * power / envelope.len() as f64;
    }
    let q = (2.0 * second * second - fourth).max(0.0).sqrt();
    let (one, several) = (powers.iter().sum::<f64>(), powers.iter().map(|p| p * p).sum::<f64>().sqrt());
    q > 0.5 * (one + several)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeded::Seeded;
    use core::f64::consts::TAU;

    const COUNT: i32 = 200;

    fn in_noise(random: &mut Seeded, a: impl Fn(f64) -> c64) -> Vec<c64> {
        (0..COUNT).map(|j| a(f64::from(j) / f64::from(COUNT)) + random.complex_normal() * 0.2).collect()
    }

    #[test]
    fn two_machines_beat_and_side_bands_of_one_do_not() {
        let mut random = Seeded::new(31);
        for ratio in [1.0, 0.6, 0.4] {
            let two = in_noise(&mut random, |x| turn(TAU * 3.3 * x) + turn(-TAU * 5.1 * x) * ratio);
            assert!(!is_one_tone(&two, &[1.0, ratio * ratio]), "{ratio}");
        }
        // Squares of the two largest Bessel functions of the swing.
        for (swing, lines) in [(0.6, [0.832, 0.082]), (1.5, [0.311, 0.262]), (6.0, [0.131, 0.128])] {
            let one = in_noise(&mut random, |x| turn(swing * libm::sin(TAU * 4.0 * x)));
            assert!(is_one_tone(&one, &lines), "{swing}");
        }
    }
}
