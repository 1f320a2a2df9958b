//! Identities of modes over time: which mode of a later answer is which of an earlier one.
//!
//! Answers over a growing record, or over one experiment after the other, come without names. A
//! mode keeps its number when it lies where it was (frequency within three joint standard
//! deviations, or half its bandwidth) and looks as it looked (modal assurance criterion); pairs
//! that agree best are taken first, so that two close modes do not exchange their numbers. A mode
//! that is not found keeps its number through [`GAP_MAX`] answers. A number once given up is never
//! given again.
//!
//! Fixed memory from the start: [`TRACKS_MAX`] modes.

use crate::mac::modal_assurance_criterion;
use crate::selection::Mode;
use faer::c64;
use serde::{Deserialize, Serialize};

/// Modes that are remembered.
pub const TRACKS_MAX: usize = 16;
/// Answers a mode may miss: at one per second, a minute.
pub const GAP_MAX: u32 = 60;
/// Agreement of shapes that keeps a number. Looser than the criterion of a stable pole: a shape
/// known from a short record scatters.
const MAC_KEEPS: f64 = 0.6;
/// Frequencies this far apart [joint standard deviations] are still one mode.
const FREQUENCY_SIGMA: f64 = 3.0;

/// A mode that was found at least once.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Track {
    identity: u32,
    frequency_hz: f64,
    sigma_frequency_hz: f64,
    damping_ratio: f64,
    /// Real and imaginary parts.
    shape: Vec<f64>,
    missed: u32,
}

/// Gives modes their numbers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ModeTracker {
    tracks: Vec<Track>,
    given: u32,
}

impl ModeTracker {
    /// Takes the memory for modes of `channels` components.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        let mut tracks = Vec::with_capacity(TRACKS_MAX);
        tracks.resize_with(TRACKS_MAX, || Track { shape: Vec::with_capacity(2 * channels), ..Track::default() });
        Self { tracks, given: 0 }
    }

    /// The numbers, from 1, of the modes of an answer, in the order of the answer.
    ///
    /// Cost: modes × [`TRACKS_MAX`] comparisons.
    pub fn identities(&mut self, modes: &[Mode]) -> Vec<u32> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (m, mode) in modes.iter().enumerate() {
            for (t, track) in self.tracks.iter().enumerate().filter(|(_, track)| track.identity > 0) {
                let distance = distance(track, mode);
                if distance <= 1.0 {
                    pairs.push((distance, t, m));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut identities = vec![0; modes.len()];
        let mut seen = [false; TRACKS_MAX];
        for (_, t, m) in pairs {
            if identities[m] == 0 && !seen[t] {
                identities[m] = self.tracks[t].identity;
                seen[t] = true;
                self.tracks[t].see(&modes[m]);
            }
        }
        for (track, _) in self.tracks.iter_mut().zip(seen).filter(|(track, seen)| track.identity > 0 && !seen) {
            track.missed += 1;
            if track.missed > GAP_MAX {
                track.identity = 0;
            }
        }
        for (identity, mode) in identities.iter_mut().zip(modes).filter(|(identity, _)| **identity == 0) {
            *identity = self.begin(mode);
        }
        identities
    }

    /// A number of its own, in the place that is free or was missed longest.
    fn begin(&mut self, mode: &Mode) -> u32 {
        self.given += 1;
        let longest_missed = |track: &&mut Track| (track.identity > 0, u32::MAX - track.missed);
        let track = self.tracks.iter_mut().min_by_key(longest_missed).expect("there are places");
        track.identity = self.given;
        track.see(mode);
        self.given
    }
}

impl Track {
    fn see(&mut self, mode: &Mode) {
        (self.frequency_hz, self.sigma_frequency_hz) = (mode.frequency_hz, mode.sigma_frequency_hz);
        (self.damping_ratio, self.missed) = (mode.damping_ratio, 0);
        self.shape.clear();
        self.shape.extend(mode.mode_shape.iter().flat_map(|psi| [psi.re, psi.im]));
    }
}

/// Above 1 they are not the same mode.
fn distance(track: &Track, mode: &Mode) -> f64 {
    if track.shape.len() != 2 * mode.mode_shape.len() {
        return f64::INFINITY;
    }
    let (a, b) = (track.sigma_frequency_hz, mode.sigma_frequency_hz);
    let joint = FREQUENCY_SIGMA * (a * a + b * b).sqrt();
    let bandwidth = track.damping_ratio.max(mode.damping_ratio) * mode.frequency_hz;
    let apart = (mode.frequency_hz - track.frequency_hz).abs() / joint.max(bandwidth);
    let shape: Vec<c64> = track.shape.chunks_exact(2).map(|psi| c64::new(psi[0], psi[1])).collect();
    let unlike = (1.0 - modal_assurance_criterion(&shape, &mode.mode_shape)) / (1.0 - MAC_KEEPS);
    apart.max(unlike)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(frequency_hz: f64, shape: [f64; 2]) -> Mode {
        Mode {
            frequency_hz,
            damping_ratio: 0.01,
            sigma_frequency_hz: 1e-3 * frequency_hz,
            sigma_damping: 1e-3,
            correlation: 0.0,
            mode_shape: shape.map(|x| c64::new(x, 0.0)).to_vec(),
            shape_deviation: Vec::new(),
            phase_collinearity: 1.0,
            channel_share: vec![1.0; 2],
            dominant_channel: 0,
            orders_found: 10,
            order: 4,
            decimation: 1,
        }
    }

    const A: [f64; 2] = [1.0, 0.5];
    const B: [f64; 2] = [0.5, -1.0];

    #[test]
    fn a_mode_keeps_its_number_while_it_drifts_is_lost_and_comes_again() {
        let mut tracker = ModeTracker::new(2);
        assert_eq!(tracker.identities(&[mode(2.0, A), mode(7.0, B)]), [1, 2]);
        // Ten per cent in all, a tenth of the bandwidth at a time.
        for k in 0..100 {
            assert_eq!(tracker.identities(&[mode(2.0 * (1.0 + 1e-3 * f64::from(k)), A)]), [1]);
            assert_eq!(tracker.identities(&[]).len(), 0);
            if k == 25 {
                assert_eq!(tracker.identities(&[mode(7.0, B)]), [2], "52 answers without it");
            }
        }
        assert_eq!(tracker.identities(&[mode(7.0, B)]), [3], "too long a gap: another number, never the old one");
    }

    #[test]
    fn modes_that_cross_keep_their_numbers_by_their_shapes() {
        let mut tracker = ModeTracker::new(2);
        for k in 0..=40 {
            let apart = 0.01 * (f64::from(k) - 20.0);
            let (a, b) = (mode(5.0 + 0.5 * apart, A), mode(5.0 - 0.5 * apart, B));
            // In order of frequency, as an answer is: b goes below a half way.
            let (modes, expected) = if k < 20 { ([a, b], [1, 2]) } else { ([b, a], [2, 1]) };
            assert_eq!(tracker.identities(&modes), expected, "{k}");
        }
    }

    #[test]
    fn more_modes_than_places_displace_what_was_missed_longest_and_memory_does_not_grow() {
        let mut tracker = ModeTracker::new(2);
        let bytes = |tracker: &ModeTracker| tracker.tracks.iter().map(|t| t.shape.capacity()).sum::<usize>();
        let before = bytes(&tracker);
        assert_eq!(tracker.identities(&[mode(1.0, A)]), [1]);
        for k in 0..TRACKS_MAX as u32 {
            tracker.identities(&[mode(10.0 * 1.3f64.powi(k as i32), A)]);
        }
        assert_eq!(tracker.identities(&[mode(1.0, A)]), [TRACKS_MAX as u32 + 2], "it was missed longest");
        assert_eq!((tracker.tracks.len(), bytes(&tracker)), (TRACKS_MAX, before));
    }
}
