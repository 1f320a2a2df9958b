//! Equally spaced samples of channels, for methods that need them.
//!
//! [`Channel::uniform`] takes the longest stretch without a gap: as recorded where the stamps are
//! even to 0.1 % of a step, else interpolated by the cubic through four neighbours. Where the
//! stamps are irregular throughout, an interval somewhat longer than others is no gap.

use crate::channel::{Channel, GAP_MEDIANS, IRREGULAR_GAP_MEDIANS};

/// Stamps even to this share of a step are taken as equally spaced.
const EVEN_SHARE: f64 = 1e-3;

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
    /// Time of sample `i` \[s\].
    #[must_use]
    pub fn time_s(&self, i: usize) -> f64 {
        self.start_s + i as f64 * self.dt_s
    }

    /// Time of the last sample \[s\].
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.time_s(self.value.len().saturating_sub(1))
    }
}

impl Channel {
    /// The longest stretch without gap or backward stamp, equally spaced; `None` below eight
    /// samples.
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
/// No more steps than the finer channel has samples: what is common lies within its span. `None`
/// when fewer than `samples_min` steps are common.
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
