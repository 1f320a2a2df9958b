//! A channel: one quantity over the times of its own samples.
//!
//! Units: SI throughout; `unit` is the text of the channel's SI unit.

use estimation::quantiles::{median, quantile};
use serde::Serialize;

/// An interval above this many median intervals is a gap: one sample at least is missing.
pub const GAP_MEDIANS: f64 = 1.5;
/// As [`GAP_MEDIANS`], of stamps that are irregular: three samples at least would have had their
/// place.
pub const IRREGULAR_GAP_MEDIANS: f64 = 4.0;
/// 95 % of the intervals within this share of the median, or the stamps are irregular.
pub const IRREGULAR_SHARE: f64 = 0.2;

/// What a channel is to the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Command, force or imposed motion.
    Input,
    /// Measured answer.
    Output,
    /// Not said by the source.
    Unknown,
}

/// One quantity over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    pub name: String,
    /// Text of the SI unit.
    pub unit: String,
    /// Times of the samples, by the channel's own clock.
    pub time_s: Vec<f64>,
    /// One value per time.
    pub value: Vec<f64>,
    pub role: Role,
}

/// Channels recorded together.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// For messages.
    pub name: String,
    pub channels: Vec<Channel>,
}

impl Recording {
    /// The channel of exactly this name.
    #[must_use]
    pub fn channel_named(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

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
    /// A channel of [`Role::Unknown`].
    #[must_use]
    pub fn new(name: &str, unit: &str, time_s: Vec<f64>, value: Vec<f64>) -> Self {
        Channel { name: name.into(), unit: unit.into(), time_s, value, role: Role::Unknown }
    }

    /// Positions of the samples that are finite in time and value.
    #[must_use]
    pub fn finite(&self) -> Vec<usize> {
        let n = self.time_s.len().min(self.value.len());
        (0..n).filter(|&i| self.time_s[i].is_finite() && self.value[i].is_finite()).collect()
    }

    /// Median of the positive intervals \[s\]; `None` below three samples.
    #[must_use]
    pub fn interval_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        if steps.len() < 2 { None } else { Some(median(&mut steps)) }
    }

    /// Samples a second \[Hz\]: one over the mean of the intervals that are no gap, which stamps in
    /// rounded units leave as it is while the median takes their nearest step; of irregular times
    /// one over the median. `None` below three samples.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let median_s = self.interval_s()?;
        if self.irregular() {
            return Some(1.0 / median_s);
        }
        let steps = self.time_s.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0 && *d <= GAP_MEDIANS * median_s);
        let (sum_s, count) = steps.fold((0.0, 0_u32), |(sum_s, count), step_s| (sum_s + step_s, count + 1));
        Some(f64::from(count) / sum_s)
    }

    /// Whether the finite samples come at irregular times: see [`IRREGULAR_SHARE`]. Below 16
    /// intervals they count as regular.
    #[must_use]
    pub fn irregular(&self) -> bool {
        let keep = self.finite();
        let steps = keep.windows(2).map(|w| self.time_s[w[1]] - self.time_s[w[0]]).filter(|d| *d > 0.0);
        let mut departures: Vec<f64> =
            self.interval_s().map_or_else(Vec::new, |interval| steps.map(|d| (d / interval - 1.0).abs()).collect());
        departures.len() >= 16 && quantile(&mut departures, 0.95) > IRREGULAR_SHARE
    }

    /// Positions of the longest stretch of finite samples without a backward stamp or an interval
    /// above `gap_medians` median intervals.
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
