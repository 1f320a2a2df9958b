//! Channels as numbers over time: what `doctor` and `compare` read.
//!
//! A channel carries its own stamps, so that sources with different clocks and rates stay what they are. Methods that
//! need equal steps ask for [`Channel::uniform`]: the longest stretch without a gap, as recorded where the stamps are
//! even to 0.1 % of a step, else interpolated by the cubic through four neighbours. Where the stamps are irregular throughout,
//! an interval somewhat longer than others is no gap.
//!
//! Units: SI throughout; `unit` is the text of the channel's SI unit.

use estimation::quantiles::{median, quantile};
use serde::Serialize;

/// An interval above this many median intervals is a gap: one sample at least is missing.
pub const GAP_MEDIANS: f64 = 1.5;
/// As [`GAP_MEDIANS`], of stamps that are irregular: three samples at least would have had their place.
pub const IRREGULAR_GAP_MEDIANS: f64 = 4.0;
/// 95 % of the intervals within this share of the median, or the stamps are irregular.
pub const IRREGULAR_SHARE: f64 = 0.2;
/// Stamps even to this share of a step are taken as equally spaced.
const EVEN_SHARE: f64 = 1e-3;

/// What a channel is to the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Command, force or imposed motion.
    Input,
    /// Measured answer.
    Output,
    Unknown,
}

/// One quantity over time.
#[derive(Clone, Debug)]
pub struct Channel {
    pub name: String,
    pub unit: String,
    pub time_s: Vec<f64>,
    pub value: Vec<f64>,
    pub role: Role,
}

/// Channels recorded together.
#[derive(Clone, Debug)]
pub struct Recording {
    pub name: String,
    pub channels: Vec<Channel>,
}

/// Equally spaced samples.
#[derive(Clone, Debug)]
pub struct Uniform {
    pub start_s: f64,
    pub dt_s: f64,
    pub value: Vec<f64>,
    /// False when the samples are those of the recording, untouched.
    pub interpolated: bool,
}

impl Uniform {
    /// Time of sample `i` [s].
    #[must_use]
    pub fn time_s(&self, i: usize) -> f64 {
        self.start_s + i as f64 * self.dt_s
    }

    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.time_s(self.value.len().saturating_sub(1))
    }
}

impl Recording {
    /// What was recorded in the first `share` of the time.
    #[must_use]
    pub fn beginning(&self, share: f64) -> Self {
        let stamps = || self.channels.iter().flat_map(|channel| &channel.time_s).copied().filter(|t| t.is_finite());
        let (first, last) = (stamps().fold(f64::INFINITY, f64::min), stamps().fold(f64::NEG_INFINITY, f64::max));
        let end = first + share * (last - first);
        let mut beginning = self.clone();
        for channel in &mut beginning.channels {
            let keep: Vec<bool> = channel.time_s.iter().map(|t| *t <= end).collect();
            let (mut times, mut values) = (keep.iter(), keep.iter());
            channel.time_s.retain(|_| times.next() == Some(&true));
            channel.value.retain(|_| values.next() == Some(&true));
        }
        beginning
    }
}

impl Channel {
    /// Positions of the samples that are finite in time and value.
    #[must_use]
    pub fn finite(&self) -> Vec<usize> {
        let n = self.time_s.len().min(self.value.len());
        (0..n).filter(|&i| self.time_s[i].is_finite() && self.value[i].is_finite()).collect()
    }

    /// Median of the positive intervals [s]; `None` below three samples.
    #[must_use]
    pub fn interval_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        if steps.len() < 2 { None } else { Some(median(&mut steps)) }
    }

    /// Whether the finite samples come at irregular times: see [`IRREGULAR_SHARE`]. Below 16 intervals nothing is said.
    #[must_use]
    pub fn irregular(&self) -> bool {
        let keep = self.finite();
        let steps = keep.windows(2).map(|w| self.time_s[w[1]] - self.time_s[w[0]]).filter(|d| *d > 0.0);
        let mut departures: Vec<f64> =
            self.interval_s().map_or_else(Vec::new, |interval| steps.map(|d| (d / interval - 1.0).abs()).collect());
        departures.len() >= 16 && quantile(&mut departures, 0.95) > IRREGULAR_SHARE
    }

    /// Positions of the longest stretch of finite samples without a backward stamp or an interval above `gap_medians` median intervals.
    #[must_use]
    pub fn longest_stretch(&self, gap_medians: f64) -> Vec<usize> {
        let keep = self.finite();
        let Some(interval) = self.interval_s() else { return Vec::new() };
        let (mut best, mut first) = (0..0, 0);
        for k in 1..=keep.len() {
            let broken = k == keep.len() || {
                let step = self.time_s[keep[k]] - self.time_s[keep[k - 1]];
                step <= 0.0 || step > gap_medians * interval
            };
            if broken {
                if k - first > best.len() {
                    best = first..k;
                }
                first = k;
            }
        }
        keep[best].to_vec()
    }

    /// The longest stretch without gap or backward stamp, equally spaced; `None` below eight samples.
    #[must_use]
    pub fn uniform(&self) -> Option<Uniform> {
        let stretch = self.longest_stretch(if self.irregular() { IRREGULAR_GAP_MEDIANS } else { GAP_MEDIANS });
        if stretch.len() < 8 {
            return None;
        }
        let time: Vec<f64> = stretch.iter().map(|&i| self.time_s[i]).collect();
        let value: Vec<f64> = stretch.iter().map(|&i| self.value[i]).collect();
        Some(equally_spaced(&time, &value))
    }

    /// Whether both channels carry the same stamps.
    #[must_use]
    pub fn same_clock(&self, other: &Channel) -> bool {
        self.time_s.len() == other.time_s.len() && self.time_s.iter().zip(&other.time_s).all(|(a, b)| a == b)
    }
}

/// Whether two unit texts are the same unit, however products and powers are written.
#[must_use]
pub fn same_unit(a: &str, b: &str) -> bool {
    let plain = |unit: &str| -> String {
        unit.chars().filter(|c| !c.is_whitespace() && !"*·()".contains(*c)).collect::<String>().replace("s^2", "s2")
    };
    plain(a) == plain(b)
}

fn equally_spaced(time: &[f64], value: &[f64]) -> Uniform {
    let n = time.len();
    let dt_s = (time[n - 1] - time[0]) / (n - 1) as f64;
    let even = time.iter().enumerate().all(|(i, t)| (t - time[0] - i as f64 * dt_s).abs() <= EVEN_SHARE * dt_s);
    let value = if even {
        value.to_vec()
    } else {
        (0..n).map(|i| interpolate(time, value, time[0] + i as f64 * dt_s)).collect()
    };
    Uniform { start_s: time[0], dt_s, value, interpolated: !even }
}

/// Value at `t` of the cubic through the four nearest samples; linear at the ends, held outside.
///
/// Assumes increasing `time`. Cost: O(log n).
#[must_use]
pub fn interpolate(time: &[f64], value: &[f64], t: f64) -> f64 {
    let n = time.len();
    let right = time.partition_point(|s| *s <= t);
    if right == 0 {
        return value[0];
    }
    if right >= n {
        return value[n - 1];
    }
    if time[right - 1] == t {
        return value[right - 1];
    }
    if right < 2 || right + 1 >= n {
        let u = (t - time[right - 1]) / (time[right] - time[right - 1]);
        return value[right - 1] + u * (value[right] - value[right - 1]);
    }
    let nodes = right - 2..right + 2;
    nodes
        .clone()
        .map(|i| {
            let weight: f64 = nodes.clone().filter(|&j| j != i).map(|j| (t - time[j]) / (time[i] - time[j])).product();
            weight * value[i]
        })
        .sum()
}

/// Both channels on one equally spaced grid over their common time, at the finer of the two steps.
///
/// `None` when fewer than `samples_min` steps are common.
#[must_use]
pub fn common_grid(a: &Channel, b: &Channel, samples_min: usize) -> Option<(Uniform, Uniform)> {
    let (ua, ub) = (a.uniform()?, b.uniform()?);
    if ua.start_s == ub.start_s && ua.dt_s == ub.dt_s && ua.value.len() == ub.value.len() {
        return (ua.value.len() >= samples_min).then_some((ua, ub));
    }
    let (start, end, dt) = (ua.start_s.max(ub.start_s), ua.end_s().min(ub.end_s()), ua.dt_s.min(ub.dt_s));
    let n = libm::floor((end - start) / dt + 1e-9) + 1.0;
    if n.is_nan() || n < samples_min as f64 {
        return None;
    }
    let on_grid = |u: &Uniform| {
        let time: Vec<f64> = (0..u.value.len()).map(|i| u.time_s(i)).collect();
        let value = (0..n as usize).map(|i| interpolate(&time, &u.value, start + i as f64 * dt)).collect();
        Uniform { start_s: start, dt_s: dt, value, interpolated: true }
    };
    Some((on_grid(&ua), on_grid(&ub)))
}
