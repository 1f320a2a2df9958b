//! Omnibus test of the residuals: energy in time–frequency bins.
//!
//! Whitened innovations of every channel and run go through an orthonormal Haar transform and,
//! whole, a Fourier transform; both leave white noise white. A time–frequency bin is a window of
//! `n` coefficients of one octave (or of the samples themselves), or of the real and imaginary
//! parts of neighbouring lines of the spectrum; with energy `E` its evidence against unit variance
//! is
//!
//! ```text
//! 2 ln p(E) / p(E | 1) = E − n − n ln(E / n),   E > n
//! ```
//!
//! The test shows that residual energy is left and where, never what it is: an unknown law and
//! unknown noise look alike here.

use identification::fit::EstimationSession;
use identification::problem::Timeline;
use realfft::RealFftPlanner;

/// Octaves from half the sampling frequency down; lower frequencies are one more band.
const OCTAVES: usize = 5;
/// Lengths of a window in coefficients.
const WINDOW_LENGTHS: [usize; 5] = [1, 4, 16, 64, 256];
/// Samples at the start of a run that are not tested: they carry the error of its initial state.
const INITIAL_TRANSIENT_SAMPLES: usize = 5;

/// The time–frequency bin of most evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct StrongestBin {
    pub channel: usize,
    pub run: usize,
    /// In the recording's time.
    pub time_s: [f64; 2],
    pub band_hz: [f64; 2],
    /// Decrease of `−2 ln p` if the bin's variance were free.
    pub evidence: f64,
    /// Number of bins tested.
    pub tried: usize,
}

impl StrongestBin {
    /// p value: probability that the largest of so many bins of white noise has as much evidence.
    #[must_use]
    pub fn p(&self) -> f64 {
        (self.tried as f64 * libm::exp(-0.5 * self.evidence)).min(1.0)
    }
}

/// Whitened innovations beyond this are clipped [standard deviations]: 6e-5 of a normal
/// distribution. Chosen, no derivation.
const OUTLIER_SIGMA: f64 = 4.0;
/// Largest share of a channel's samples that outliers may be. Chosen, no derivation: more often
/// they may be a law of every reversal or contact.
const OUTLIER_SHARE_MAX: f64 = 0.01;

/// Isolated innovations of one channel that are too large for a normal distribution.
#[derive(Clone, Debug, PartialEq)]
pub struct Outliers {
    pub channel: usize,
    /// How many lie beyond `OUTLIER_SIGMA` standard deviations, of how many.
    pub count: usize,
    pub samples: usize,
    /// The largest [standard deviations], where and when.
    pub largest: f64,
    pub run: usize,
    pub time_s: f64,
}

impl Outliers {
    /// Too few to be a law of every reversal or contact.
    #[must_use]
    pub fn is_rare(&self) -> bool {
        self.count as f64 <= OUTLIER_SHARE_MAX * self.samples as f64
    }
}

/// Outliers of every channel that has some, the largest first, and the bin of most evidence once
/// they are clipped.
#[must_use]
pub fn without_outliers(session: &EstimationSession<'_>, r: &[f64]) -> (Vec<Outliers>, Option<StrongestBin>) {
    let clipped: Vec<f64> = r.iter().map(|r| r.clamp(-OUTLIER_SIGMA, OUTLIER_SIGMA)).collect();
    let of = |channel: usize| {
        let runs = session.timelines.iter().zip(&session.offsets).enumerate();
        let own = runs.flat_map(|(run, (timeline, offset))| {
            let samples = samples_of(timeline, channel).into_iter();
            samples.map(move |s| (r[offset + s].abs(), run, timeline.stamp_s[s]))
        });
        let own: Vec<(f64, usize, f64)> = own.collect();
        let (largest, run, time_s) = own.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let count = own.iter().filter(|(size, ..)| *size > OUTLIER_SIGMA).count();
        (count > 0).then_some(Outliers { channel, count, samples: own.len(), largest, run, time_s })
    };
    let mut list: Vec<Outliers> = (0..session.problem.plant.sensors.len()).filter_map(of).collect();
    list.sort_by(|a, b| b.largest.total_cmp(&a.largest));
    (list, strongest_bin(session, &clipped))
}

/// A band of coefficients.
struct Band {
    w: Vec<f64>,
    along: Along,
}

#[derive(Clone, Copy)]
enum Along {
    /// Each coefficient spans so many samples; edges in shares of the sampling frequency.
    Time { span: usize, edges: [f64; 2] },
    /// Two coefficients a line from the first on, of the spectrum of so many samples.
    Frequency { samples: usize },
}

impl Along {
    /// Time and band of `n` coefficients from index `from` on.
    fn place(self, from: usize, n: usize, stamp_s: &[f64]) -> ([f64; 2], [f64; 2]) {
        let last = stamp_s.len() - 1;
        let rate_hz = last as f64 / (stamp_s[last] - stamp_s[0]);
        match self {
            Self::Time { span, edges } => {
                ([stamp_s[from * span], stamp_s[(from + n) * span - 1]], edges.map(|edge| edge * rate_hz))
            }
            Self::Frequency { samples } => {
                let edge = |at: usize| (at as f64 / 2.0 + 0.5) * rate_hz / samples as f64;
                ([stamp_s[0], stamp_s[last]], [edge(from), edge(from + n)])
            }
        }
    }
}

/// Whitened innovations of one channel in one run.
struct Series {
    channel: usize,
    run: usize,
    stamp_s: Vec<f64>,
    r: Vec<f64>,
}

/// Samples of a channel in a run without those that carry the error of the initial state.
fn samples_of(timeline: &Timeline, channel: usize) -> Vec<usize> {
    (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).skip(INITIAL_TRANSIENT_SAMPLES).collect()
}

/// The bin of most evidence of whitened innovations `r` of all runs; `None` where every run is too
/// short. Cost: O(n log n) for each channel.
#[must_use]
pub fn strongest_bin(session: &EstimationSession<'_>, r: &[f64]) -> Option<StrongestBin> {
    let mut list = Vec::new();
    for channel in 0..session.problem.plant.sensors.len() {
        for (run, (timeline, offset)) in session.timelines.iter().zip(&session.offsets).enumerate() {
            let own = samples_of(timeline, channel);
            let stamp_s = own.iter().map(|s| timeline.stamp_s[*s]).collect();
            list.push(Series { channel, run, stamp_s, r: own.iter().map(|s| r[offset + s]).collect() });
        }
    }
    among(&list)
}

fn among(list: &[Series]) -> Option<StrongestBin> {
    let (mut best, mut tried): (Option<StrongestBin>, usize) = (None, 0);
    for Series { channel, run, stamp_s, r } in list.iter().filter(|series| series.r.len() > 1) {
        for Band { w, along } in bands(r).into_iter().chain(spectrum(r)) {
            let (bin, count) = within(&w, along);
            tried += count;
            let Some((evidence, from, n)) = bin else { continue };
            if best.as_ref().is_none_or(|best| evidence > best.evidence) {
                let (time_s, band_hz) = along.place(from, n, stamp_s);
                best = Some(StrongestBin { channel: *channel, run: *run, time_s, band_hz, evidence, tried: 0 });
            }
        }
    }
    best.map(|best| StrongestBin { tried, ..best })
}

/// The samples themselves, the octaves of their Haar transform, and the rest below them.
fn bands(series: &[f64]) -> Vec<Band> {
    let time = |w: Vec<f64>, span: usize, edges: [f64; 2]| Band { w, along: Along::Time { span, edges } };
    let mut list = vec![time(series.to_vec(), 1, [0.0, 0.5])];
    let mut slow = series.to_vec();
    let mut span = 1;
    for _ in 0..OCTAVES {
        let pairs = slow.chunks_exact(2);
        let fast = pairs.clone().map(|pair| core::f64::consts::FRAC_1_SQRT_2 * (pair[0] - pair[1])).collect();
        slow = pairs.map(|pair| core::f64::consts::FRAC_1_SQRT_2 * (pair[0] + pair[1])).collect();
        list.push(time(fast, 2 * span, [0.25, 0.5].map(|edge| edge / span as f64)));
        span *= 2;
    }
    list.push(time(slow, span, [0.0, 0.5 / span as f64]));
    list
}

/// Real and imaginary parts of the lines between zero and half the sampling frequency, of unit
/// variance each for white noise of unit variance.
fn spectrum(series: &[f64]) -> Option<Band> {
    let lines = (series.len() - 1) / 2;
    let transform = RealFftPlanner::new().plan_fft_forward(series.len());
    let mut out = transform.make_output_vec();
    transform.process(&mut series.to_vec(), &mut out).ok()?;
    let scale = (2.0 / series.len() as f64).sqrt();
    let w = out[1..=lines].iter().flat_map(|line| [scale * line.re, scale * line.im]).collect();
    (lines > 0).then_some(Band { w, along: Along::Frequency { samples: series.len() } })
}

/// Evidence, first coefficient and length of the window of most evidence, and how many were tested.
/// Windows overlap by half.
fn within(w: &[f64], along: Along) -> (Option<(f64, usize, usize)>, usize) {
    let mut sums = Vec::with_capacity(w.len() + 1);
    sums.push(0.0);
    for w in w {
        sums.push(sums[sums.len() - 1] + w * w);
    }
    let (mut best, mut count) = (None::<(f64, usize, usize)>, 0);
    // a line has two coefficients
    let least = if matches!(along, Along::Frequency { .. }) { 2 } else { 1 };
    for n in WINDOW_LENGTHS.map(|n| n * least).into_iter().filter(|n| *n <= w.len()) {
        for from in (0..=w.len() - n).step_by((n / 2).max(least)) {
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

    fn series(run: usize, interval_s: f64, r: Vec<f64>) -> Series {
        Series { channel: 0, run, stamp_s: (0..r.len()).map(|k| interval_s * k as f64).collect(), r }
    }

    #[test]
    fn the_transform_keeps_the_energy_and_the_strongest_bin_of_white_noise_is_significant_as_often_as_it_should() {
        let mut stood = [0; 2];
        for seed in 0..400 {
            let x = Noise::new(seed).series(1024, 1.0);
            let energy = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>();
            let parts: f64 = bands(&x)[1..].iter().map(|band| energy(&band.w)).sum();
            assert!((parts / energy(&x) - 1.0).abs() < 1e-12);
            let found = among(&[series(0, 0.01, x)]).expect("long enough");
            stood[0] += usize::from(found.p() < 0.05);
            stood[1] += usize::from(found.p() < 1.0);
        }
        // At most as promised (20 of 400, and three standard deviations of that); windows overlap
        // and a free variance has its price, but where every largest of a chance of one may pass,
        // some do.
        assert!(stood[0] <= 33 && stood[1] >= 10, "{stood:?}");
    }

    #[test]
    fn a_tone_that_no_window_of_time_shows_is_found_at_its_line() {
        for turn in [0.43, 2.9] {
            let mut tone = Noise::new(8).series(2000, 1.0);
            // d = 0.4 √1000 = 12.6 over the whole, drowned by noise in any window
            tone.iter_mut().enumerate().for_each(|(k, y)| *y += 0.4 * (turn * k as f64 + 0.2).sin());
            let found = among(&[series(0, 0.01, tone)]).expect("long enough");
            let hz = turn / (0.01 * core::f64::consts::TAU);
            assert!(found.p() < 1e-6 && found.band_hz[0] < hz && hz < found.band_hz[1], "{hz} {found:?}");
            let whole = found.time_s == [0.0, 0.01 * 1999.0];
            assert!(whole && found.band_hz[1] - found.band_hz[0] < 0.11, "{found:?}");
        }
    }

    #[test]
    fn a_spike_and_a_burst_in_one_octave_are_found_in_their_run_at_their_time_and_frequency() {
        let mut spiked = Noise::new(3).series(2048, 1.0);
        spiked[700] += 9.0;
        let list = [series(0, 0.01, Noise::new(5).series(900, 1.0)), series(1, 0.02, spiked)];
        let found = among(&list).expect("long enough");
        assert!(found.p() < 1e-6);
        assert_eq!((found.run, found.time_s, found.band_hz), (1, [14.0, 14.0], [0.0, 25.0]));
        let mut burst = Noise::new(4).series(2048, 1.0);
        // amplitude two, alternating in pairs: a quarter of the sampling frequency, between the
        // first and second octave's middle
        (1024..1280).for_each(|k| burst[k] += if k % 4 < 2 { 2.0 } else { -2.0 });
        let found = among(&[series(0, 0.01, burst)]).expect("long enough");
        assert_eq!(found.band_hz, [12.5, 25.0]);
        assert!(found.time_s[0] >= 9.59 && found.time_s[1] <= 13.45, "{found:?}");
    }
}
