//! Where a difference sits: time windows, frequency bands, coherence with other channels.
//!
//! The yardstick is the white noise under the difference itself ([`white_floor`]); where its
//! spectrum does not end flat, the level at the top of the band serves, which is an upper bound of
//! the noise there and makes the tests on lower bands cautious.

use serde::Serialize;

use super::{FALSE_ALARM, Pair};
use crate::spectrum::{Averaging, cross_spectrum, density};
use channels::{Channel, Recording, Role, common_grid};
use identification::statistics::{differences, fisher_tail, holm, rms, white_floor};

/// Longest list printed.
const LIST_MAX: usize = 5;

/// A time window in which the difference exceeds the noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Window {
    pub start_s: f64,
    pub end_s: f64,
    pub rms: f64,
    /// Share of the squared difference of the whole record.
    pub share: f64,
    /// After correction for all windows tried.
    pub p: f64,
    /// True when it fills less than half of the record.
    pub confined: bool,
}

/// A frequency band in which the difference exceeds the noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    pub low_hz: f64,
    pub high_hz: f64,
    pub rms: f64,
    /// Above the noise floor \[dB\].
    pub above_db: f64,
    pub p: f64,
    /// True when it spans less than half of the bands, counted in octaves.
    pub confined: bool,
}

/// A channel that the difference follows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coherence {
    pub channel: String,
    pub role: Role,
    pub low_hz: f64,
    pub high_hz: f64,
    /// Largest squared coherence.
    pub coherence: f64,
    /// What unrelated channels exceed at the false-alarm level, all lines and channels counted.
    pub level: f64,
    /// Share of the squared difference that follows the channel.
    pub share: f64,
}

/// Where in time and frequency a difference exceeds the noise, and which channels it follows.
pub struct Places {
    pub noise_sigma: Option<f64>,
    pub windows: Vec<Window>,
    pub bands: Vec<Band>,
    pub coherence: Vec<Coherence>,
}

impl Places {
    /// Whether the difference exceeds the noise nowhere and follows no channel.
    pub fn silent(&self) -> bool {
        self.windows.is_empty() && self.bands.is_empty() && self.coherence.is_empty()
    }
}

pub(super) fn locate(error: &[f64], p: &Pair, recording: &Recording, own: &str) -> Places {
    let floor = white_floor(error);
    let sigma = floor.map_or_else(|| rms(error), |f| f.sigma);
    let freedom = floor.map_or(error.len() as f64 / 4.0, |f| f.freedom);
    Places {
        noise_sigma: floor.filter(|f| f.flat).map(|f| f.sigma),
        windows: windows(error, p, sigma, freedom),
        bands: bands(error, p.dt_s, sigma, freedom),
        coherence: coherence(error, p, recording, own),
    }
}

/// Half-overlapping windows of 1/2, 1/4 ... 1/64 of the record; each by an F test of its power
/// against the floor.
fn windows(error: &[f64], p: &Pair, sigma: f64, freedom: f64) -> Vec<Window> {
    let n = error.len();
    let squares: Vec<f64> = core::iter::once(0.0)
        .chain(error.iter().scan(0.0, |s, e| {
            *s += e * e;
            Some(*s)
        }))
        .collect();
    let mut tried: Vec<(usize, usize)> = Vec::new();
    let mut length = n / 2;
    while length >= 16.max(n / 64) {
        tried.extend(
            (0..).map(|k| k * length / 2).take_while(|from| from + length <= n).map(|from| (from, from + length)),
        );
        length /= 2;
    }
    let power = |w: &(usize, usize)| (squares[w.1] - squares[w.0]) / (w.1 - w.0) as f64;
    let raw: Vec<f64> = tried
        .iter()
        .map(|w| fisher_tail(power(w) / (sigma * sigma).max(1e-300), (w.1 - w.0) as f64, freedom))
        .collect();
    let adjusted = holm(&raw);
    let mut order: Vec<usize> = (0..tried.len()).filter(|&i| adjusted[i] < FALSE_ALARM).collect();
    // Most of the excess first: excess power times duration, windows that hold it more tightly
    // before wider ones.
    let weight = |i: usize| (power(&tried[i]) - sigma * sigma) * ((tried[i].1 - tried[i].0) as f64).sqrt();
    order.sort_by(|&i, &j| weight(j).total_cmp(&weight(i)));
    let mut chosen: Vec<usize> = Vec::new();
    for i in order {
        if chosen.len() < LIST_MAX && chosen.iter().all(|&c| tried[i].1 <= tried[c].0 || tried[i].0 >= tried[c].1) {
            chosen.push(i);
        }
    }
    chosen
        .into_iter()
        .map(|i| {
            let (from, to) = tried[i];
            Window {
                start_s: p.time_s[from],
                end_s: p.time_s[to - 1] + p.dt_s,
                rms: power(&tried[i]).sqrt(),
                share: (squares[to] - squares[from]) / squares[n],
                p: adjusted[i],
                confined: 2 * (to - from) < n,
            }
        })
        .collect()
}

/// Third-octave bands against the flat density `2 σ² dt`, neighbours joined.
fn bands(error: &[f64], dt_s: f64, sigma: f64, freedom: f64) -> Vec<Band> {
    let s = density(error, dt_s, Averaging::for_length(error.len()));
    let (line, nyquist) = (s.frequency_hz[1], 0.5 / dt_s);
    let mut edges = vec![0.5 * line];
    while *edges.last().expect("starts with one") < nyquist {
        let last = *edges.last().expect("starts with one");
        edges.push((last * 1.26).max(last + 2.0 * line));
    }
    let flat = 2.0 * sigma * sigma * dt_s;
    let tested: Vec<(f64, f64, f64, f64)> = edges
        .windows(2)
        .filter_map(|w| {
            s.band(w[0], w[1])
                .map(|(level, nu)| (w[0], w[1].min(nyquist), level, fisher_tail(level / flat.max(1e-300), nu, freedom)))
        })
        .collect();
    let adjusted = holm(&tested.iter().map(|t| t.3).collect::<Vec<_>>());
    let mut out: Vec<(Band, f64, usize)> = Vec::new();
    let mut previous = false;
    for (t, p) in tested.iter().zip(&adjusted) {
        let found = *p < FALSE_ALARM;
        let power = t.2 * (t.1 - t.0);
        if found {
            let band = Band {
                low_hz: t.0,
                high_hz: t.1,
                rms: 0.0,
                above_db: 10.0 * libm::log10(t.2 / flat),
                p: *p,
                confined: true,
            };
            match out.last_mut().filter(|_| previous) {
                Some((joined, sum, count)) => {
                    joined.high_hz = band.high_hz;
                    joined.above_db = joined.above_db.max(band.above_db);
                    joined.p = joined.p.min(band.p);
                    *sum += power;
                    *count += 1;
                }
                None => out.push((band, power, 1)),
            }
        }
        previous = found;
    }
    let mut bands: Vec<Band> = out
        .into_iter()
        .map(|(band, power, count)| Band { rms: power.sqrt(), confined: 2 * count < tested.len(), ..band })
        .collect();
    bands.sort_by(|a, b| b.rms.total_cmp(&a.rms));
    bands.truncate(LIST_MAX);
    bands
}

/// Squared coherence of the difference with every other recorded channel and with the simulation of
/// its own.
///
/// Both are differenced first: the coherence does not change, the leakage of slow signals does. The
/// recorded channel itself is left out: its noise is in the difference.
fn coherence(error: &[f64], p: &Pair, recording: &Recording, own: &str) -> Vec<Coherence> {
    let as_channel = |name: &str, role: Role, value: &[f64]| Channel {
        name: name.into(),
        unit: String::new(),
        time_s: p.time_s[..value.len()].to_vec(),
        value: value.to_vec(),
        role,
    };
    let difference = as_channel("difference", Role::Unknown, error);
    let mut others: Vec<Channel> = recording.channels.iter().filter(|c| c.name != own).cloned().collect();
    others.push(as_channel(&format!("{own} (simulated)"), Role::Unknown, &p.simulated));
    let count = others.len() as f64;
    let mut out: Vec<Coherence> = others.iter().filter_map(|c| with_channel(&difference, c, count)).collect();
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out.truncate(LIST_MAX);
    out
}

fn with_channel(difference: &Channel, other: &Channel, channels: f64) -> Option<Coherence> {
    let (e, x) = common_grid(difference, other, 128)?;
    let (de, dx) = (differences(&e.value, 1), differences(&x.value, 1));
    if rms(&dx) == 0.0 {
        return None;
    }
    let s = cross_spectrum(&dx, &de, e.dt_s, Averaging::for_length(de.len()));
    let lines = s.frequency_hz.len();
    let level = s.coherence_level(FALSE_ALARM / (lines as f64 * channels));
    let above: Vec<usize> = (1..lines).filter(|&k| s.coherence(k) > level).collect();
    let best = *above.iter().max_by(|i, j| s.coherence(**i).total_cmp(&s.coherence(**j)))?;
    let reach = |mut k: usize, by: isize| {
        while above.contains(&k.saturating_add_signed(by)) {
            k = k.saturating_add_signed(by);
        }
        k
    };
    // Back from differences: divide the density by |1 - exp(-i w dt)|².
    let power = |k: usize| {
        s.density_y[k] / (2.0 - 2.0 * libm::cos(2.0 * core::f64::consts::PI * s.frequency_hz[k] * e.dt_s)).max(1e-12)
    };
    let total: f64 = (1..lines).map(power).sum();
    Some(Coherence {
        channel: other.name.clone(),
        role: other.role,
        low_hz: s.frequency_hz[reach(best, -1)],
        high_hz: s.frequency_hz[reach(best, 1)],
        coherence: s.coherence(best),
        level,
        share: above.iter().map(|&k| s.coherence(k) * power(k)).sum::<f64>() / total,
    })
}
