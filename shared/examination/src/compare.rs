//! Two recordings of what should be the same: how far apart, and by what.
//!
//! For users whose simulation lives elsewhere: no plant is needed. Channels meet by name; the
//! simulated one is read at the recorded stamps, interpolated by a cubic only where the stamps
//! differ, and that is said, as is how many samples were used: the longest stretch that both hold
//! without a gap. Bands count the samples as equally spaced, windows carry the stamps. Each simple
//! explanation (lag, scale, sign, offset) is tried alone, with its sigma and the fit it would give;
//! what is left is located in time windows and frequency bands against the white noise under the
//! residual, and in coherence with every other channel. Each list is corrected for its length
//! (Holm) at [`FALSE_ALARM`] per channel and list.

mod align;
mod conclude;
mod locate;
mod pair;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub use align::Correction;
pub use locate::{Band, Coherence, Window};

use crate::doctor::short;
use channels::{Channel, Recording};
use identification::statistics::{deviation, mean, rms};
use pair::{Pair, pair};

/// Probability that one list (windows, bands, coherence) of one channel names a place when only
/// white noise separates the two.
pub const FALSE_ALARM: f64 = 1e-4;
/// Fewest common samples.
const COMPARED_SAMPLES_MIN: usize = 32;

/// What separates a channel from its simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    Identical,
    OnlyNoise,
    Lag,
    Scale,
    Sign,
    Offset,
    /// Confined to frequency bands.
    Band,
    /// Confined to time windows.
    Window,
    /// Neither confined nor explained by one number.
    Unexplained,
    /// Nothing of the recorded channel follows the simulated one.
    Unrelated,
    /// The recorded channel never changes: fit, lag and scale are undefined.
    Constant,
    /// Recorded and simulated in units of different quantities.
    Units,
    /// One ends before the other begins.
    NoCommonTime,
    TooShort,
}

impl Verdict {
    /// Whether the two channels were held against each other at all.
    #[must_use]
    pub fn compared(self) -> bool {
        !matches!(self, Self::Units | Self::NoCommonTime | Self::TooShort)
    }
}

/// One channel of both recordings. Alternatives are alone, not together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelComparison {
    pub name: String,
    pub unit: String,
    pub samples: usize,
    /// Rms of real minus simulated.
    pub rms: f64,
    /// `100 (1 - |e| / |y - mean y|)`; `None` where the recorded channel is constant.
    pub fit_percent: Option<f64>,
    /// Real comes this much after simulated \[s\].
    pub lag_s: f64,
    pub lag_sigma_s: f64,
    pub lag_fit_percent: Option<f64>,
    /// Real over simulated.
    pub scale: f64,
    pub scale_sigma: f64,
    pub scale_fit_percent: Option<f64>,
    /// -1 where the simulated channel fits better with its sign turned.
    pub sign: f64,
    pub sign_fit_percent: Option<f64>,
    /// Mean of real minus simulated.
    pub offset: f64,
    pub offset_sigma: f64,
    pub offset_fit_percent: Option<f64>,
    /// White noise under the difference, where its spectrum ends flat.
    pub noise_sigma: Option<f64>,
    pub windows: Vec<Window>,
    pub bands: Vec<Band>,
    pub coherence: Vec<Coherence>,
    /// How the stamps were brought together.
    pub resampling: String,
    pub verdict: Verdict,
    pub conclusion: String,
}

/// A channel without partner.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unmatched {
    pub name: String,
    /// `real` or `simulated`: where it stands.
    pub side: String,
    /// Names of the other side, nearest first.
    pub nearest: Vec<String>,
}

/// Result of [`compare`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    pub real: String,
    pub simulated: String,
    pub channels: Vec<ChannelComparison>,
    pub unmatched: Vec<Unmatched>,
}

/// Compares channel by channel. Names match exactly, else without regard to case; nothing is
/// guessed beyond that.
#[must_use]
pub fn compare(real: &Recording, simulated: &Recording) -> Comparison {
    let partner = |name: &str, side: &Recording| {
        side.channels
            .iter()
            .position(|c| c.name == name)
            .or_else(|| side.channels.iter().position(|c| c.name.eq_ignore_ascii_case(name)))
    };
    let mut channels = Vec::new();
    let mut unmatched = Vec::new();
    for channel in &real.channels {
        match partner(&channel.name, simulated) {
            Some(k) => channels.push(compare_channel(channel, &simulated.channels[k], real)),
            None => unmatched.push(lonely(channel, "real", simulated)),
        }
    }
    for channel in simulated.channels.iter().filter(|c| partner(&c.name, real).is_none()) {
        unmatched.push(lonely(channel, "simulated", real));
    }
    Comparison { real: real.name.clone(), simulated: simulated.name.clone(), channels, unmatched }
}

fn lonely(channel: &Channel, side: &str, others: &Recording) -> Unmatched {
    let mut names: Vec<(usize, &str)> =
        others.channels.iter().map(|c| (edits(&channel.name, &c.name), c.name.as_str())).collect();
    names.sort();
    Unmatched {
        name: channel.name.clone(),
        side: side.into(),
        nearest: names.into_iter().take(3).map(|(_, n)| n.to_string()).collect(),
    }
}

/// Levenshtein distance without regard to case.
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.to_lowercase().chars().collect(), b.to_lowercase().chars().collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// `100 (1 - |e| / |y - mean y|)`.
fn fit_percent(error: &[f64], y: &[f64]) -> Option<f64> {
    (!constant(y)).then(|| 100.0 * (1.0 - rms(error) / deviation(y)))
}

/// All values equal; their deviation is rounding.
fn constant(y: &[f64]) -> bool {
    y.windows(2).all(|w| w[0] == w[1])
}

fn compare_channel(real: &Channel, simulated: &Channel, recording: &Recording) -> ChannelComparison {
    let p = match pair(real, simulated) {
        Ok(p) => p,
        Err((verdict, conclusion)) => return ChannelComparison { verdict, conclusion, ..not_compared(real) },
    };
    let error: Vec<f64> = p.real.iter().zip(&p.simulated).map(|(y, s)| y - s).collect();
    if constant(&p.real) && !constant(&p.simulated) {
        return stands_still(real, &p, &error);
    }
    let corrections = align::corrections(&p);
    let mut out = ChannelComparison {
        samples: error.len(),
        rms: rms(&error),
        fit_percent: fit_percent(&error, &p.real),
        lag_s: corrections.lag.value,
        lag_sigma_s: corrections.lag.sigma,
        lag_fit_percent: fit_percent(&corrections.lag.residual, &p.real),
        scale: corrections.scale.value,
        scale_sigma: corrections.scale.sigma,
        scale_fit_percent: fit_percent(&corrections.scale.residual, &p.real),
        sign: corrections.sign.value,
        sign_fit_percent: fit_percent(&corrections.sign.residual, &p.real),
        offset: corrections.offset.value,
        offset_sigma: corrections.offset.sigma,
        offset_fit_percent: fit_percent(&corrections.offset.residual, &p.real),
        resampling: p.resampling.clone(),
        ..not_compared(real)
    };
    if out.rms <= 1e-9 * rms(&p.real) {
        (out.verdict, out.conclusion) = (Verdict::Identical, "identical".into());
        return out;
    }
    let places = locate::locate(&error, &p, recording, &real.name);
    out.noise_sigma = places.noise_sigma;
    (out.windows, out.bands, out.coherence) = (places.windows, places.bands, places.coherence);
    (out.verdict, out.conclusion) = conclude::conclude(&out, &corrections, &p, recording, &error);
    out
}

/// A recorded channel that never changes, against a simulation that does.
fn stands_still(real: &Channel, p: &Pair, error: &[f64]) -> ChannelComparison {
    let unit = &real.unit;
    ChannelComparison {
        samples: error.len(),
        rms: rms(error),
        offset: mean(error),
        resampling: p.resampling.clone(),
        verdict: Verdict::Constant,
        conclusion: format!(
            "never changes: all {} recorded samples are {} {unit}, the simulation moves by {} {unit} rms; fit, lag and scale are undefined. \
             Look whether it was recorded",
            error.len(),
            short(p.real[0]),
            short(deviation(&p.simulated))
        ),
        ..not_compared(real)
    }
}

fn not_compared(real: &Channel) -> ChannelComparison {
    ChannelComparison {
        name: real.name.clone(),
        unit: real.unit.clone(),
        samples: 0,
        rms: 0.0,
        fit_percent: None,
        lag_s: 0.0,
        lag_sigma_s: 0.0,
        lag_fit_percent: None,
        scale: 1.0,
        scale_sigma: 0.0,
        scale_fit_percent: None,
        sign: 1.0,
        sign_fit_percent: None,
        offset: 0.0,
        offset_sigma: 0.0,
        offset_fit_percent: None,
        noise_sigma: None,
        windows: Vec::new(),
        bands: Vec::new(),
        coherence: Vec::new(),
        resampling: String::new(),
        verdict: Verdict::TooShort,
        conclusion: String::new(),
    }
}
