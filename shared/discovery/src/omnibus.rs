//! What no law was asked about: tiles of time, octave and channel that are louder than white noise.
//!
//! Whitened innovations of every channel and run go through an orthonormal Haar transform, which leaves white noise white. A tile is a
//! window of `n` coefficients of one octave (or of the samples themselves); with energy `E` its evidence against unit variance is
//!
//! ```text
//! 2 ln p(E) / p(E | 1) = E − n − n ln(E / n),   E > n
//! ```
//!
//! It tells that something is left and where, never what: an unknown law and unknown noise look alike here.

use crate::fit::Engine;

/// Octaves from half the sampling frequency down; what is slower is one more band.
const OCTAVES: usize = 5;
/// Coefficients of a window.
const LENGTHS: [usize; 5] = [1, 4, 16, 64, 256];
/// Samples at the beginning of a run that pay for its initial state.
const BEGINNING: usize = 5;

/// The loudest tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Loudest {
    pub channel: usize,
    pub time_s: [f64; 2],
    pub band_hz: [f64; 2],
    /// Decrease of `−2 ln p` were the tile's variance free.
    pub evidence: f64,
    /// Tiles that were looked at.
    pub tried: usize,
}

impl Loudest {
    /// Chance that the loudest of so many in white noise is as loud.
    #[must_use]
    pub fn p(&self) -> f64 {
        (self.tried as f64 * libm::exp(-0.5 * self.evidence)).min(1.0)
    }

    /// Evidence beyond what the loudest of so many has by chance at `alpha`.
    #[must_use]
    pub fn stands(&self, alpha: f64) -> bool {
        self.p() < alpha
    }
}

/// A band of coefficients, each of which spans `span` samples.
struct Band {
    w: Vec<f64>,
    span: usize,
    /// Shares of the sampling frequency.
    edges: [f64; 2],
}

/// The loudest tile of whitened innovations `r` of all runs; none where every run is too short.
#[must_use]
pub fn loudest(engine: &Engine<'_>, r: &[f64]) -> Option<Loudest> {
    let (mut best, mut tried): (Option<Loudest>, usize) = (None, 0);
    for channel in 0..engine.problem.plant.sensors.len() {
        for (timeline, offset) in engine.timelines.iter().zip(&engine.offsets) {
            let own = (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel);
            let own: Vec<usize> = own.skip(BEGINNING).collect();
            let series: Vec<f64> = own.iter().map(|s| r[offset + s]).collect();
            for band in bands(&series) {
                let (tile, count) = within(&band.w);
                tried += count;
                let Some((evidence, from, n)) = tile else { continue };
                if best.as_ref().is_none_or(|best| evidence > best.evidence) {
                    let stamp_s = |k: usize| timeline.stamp_s[own[k.min(own.len() - 1)]];
                    let time_s = [stamp_s(from * band.span), stamp_s((from + n) * band.span - 1)];
                    let rate_hz = 1.0 / engine.interval_s(channel);
                    let band_hz = band.edges.map(|edge| edge * rate_hz);
                    best = Some(Loudest { channel, time_s, band_hz, evidence, tried: 0 });
                }
            }
        }
    }
    best.map(|best| Loudest { tried, ..best })
}

/// The samples themselves, the octaves of their Haar transform, and what is slower.
fn bands(series: &[f64]) -> Vec<Band> {
    let mut list = vec![Band { w: series.to_vec(), span: 1, edges: [0.0, 0.5] }];
    let mut slow = series.to_vec();
    let mut span = 1;
    for _ in 0..OCTAVES {
        let pairs = slow.chunks_exact(2);
        let fast = pairs.clone().map(|pair| core::f64::consts::FRAC_1_SQRT_2 * (pair[0] - pair[1])).collect();
        slow = pairs.map(|pair| core::f64::consts::FRAC_1_SQRT_2 * (pair[0] + pair[1])).collect();
        list.push(Band { w: fast, span: 2 * span, edges: [0.25, 0.5].map(|edge| edge / span as f64) });
        span *= 2;
    }
    list.push(Band { w: slow, span, edges: [0.0, 0.5 / span as f64] });
    list
}

/// Evidence, first coefficient and length of the loudest window, and how many there were. Windows overlap by half.
fn within(w: &[f64]) -> (Option<(f64, usize, usize)>, usize) {
    let mut sums = Vec::with_capacity(w.len() + 1);
    sums.push(0.0);
    for w in w {
        sums.push(sums[sums.len() - 1] + w * w);
    }
    let (mut best, mut count) = (None::<(f64, usize, usize)>, 0);
    for n in LENGTHS.into_iter().filter(|n| *n <= w.len()) {
        for from in (0..=w.len() - n).step_by((n / 2).max(1)) {
            count += 1;
            let found = evidence(sums[from + n] - sums[from], n as f64);
            if best.is_none_or(|(best, ..)| found > best) {
                best = Some((found, from, n));
            }
        }
    }
    (best, count)
}

fn evidence(energy: f64, n: f64) -> f64 {
    if energy > n { energy - n - n * libm::log(energy / n) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    #[test]
    fn the_transform_keeps_the_energy_and_the_loudest_of_white_noise_stands_as_often_as_it_should() {
        let alpha = 0.05;
        let mut stood = 0;
        for seed in 0..400 {
            let x = Noise::new(seed).series(1024, 1.0);
            let list = bands(&x);
            let energy = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>();
            let parts: f64 = list[1..].iter().map(|band| energy(&band.w)).sum();
            assert!((parts / energy(&x) - 1.0).abs() < 1e-12);
            let tiles = list.iter().map(|band| within(&band.w));
            let (mut most, mut tried) = (0.0f64, 0);
            for (tile, count) in tiles {
                most = most.max(tile.map_or(0.0, |tile| tile.0));
                tried += count;
            }
            let found = Loudest { channel: 0, time_s: [0.0; 2], band_hz: [0.0; 2], evidence: most, tried };
            stood += usize::from(found.stands(alpha));
        }
        // At most as promised (20 of 400, and three standard deviations of that), and not idle: overlapping tiles and the price of a
        // free variance keep it below.
        assert!(stood <= 33, "{stood}");
    }

    #[test]
    fn a_spike_and_a_burst_in_one_octave_are_found_where_they_are() {
        let mut x = Noise::new(3).series(2048, 1.0);
        x[700] += 9.0;
        let (tile, _) = within(&bands(&x)[0].w);
        assert_eq!(tile.map(|tile| (tile.1, tile.2)), Some((700, 1)));
        let mut x = Noise::new(4).series(2048, 1.0);
        // twice the amplitude, alternating in pairs: a quarter of the sampling frequency, in the second octave
        (1024..1280).for_each(|k| x[k] += if k % 4 < 2 { 2.0 } else { -2.0 });
        let list = bands(&x);
        let best = |band: &Band| within(&band.w).0.expect("long enough");
        let loudest = (0..list.len()).max_by(|a, b| best(&list[*a]).0.total_cmp(&best(&list[*b]).0)).expect("bands");
        let (_, from, n) = best(&list[loudest]);
        assert_eq!(loudest, 2);
        assert!(from * 4 >= 960 && (from + n) * 4 <= 1344, "{from} {n}");
    }
}
