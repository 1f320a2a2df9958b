//! A signal stated by rows: held from row to row, or joined by natural cubic splines.

use super::{EDGE_S, SignalValue};

/// Rows of a table; before the first and after the last row their values hold.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    time_s: Vec<f64>,
    value: Vec<f64>,
    /// Second derivatives at the rows; empty: held.
    curvature: Vec<f64>,
}

impl Table {
    /// Table of `value` at `time_s`, smooth or held.
    pub(crate) fn new(time_s: &[f64], value: &[f64], smooth: bool) -> Result<Self, &'static str> {
        if time_s.is_empty() || time_s.len() != value.len() {
            return Err("a table needs as many values as times, at least one");
        }
        if time_s.windows(2).any(|pair| pair[1].partial_cmp(&pair[0]) != Some(core::cmp::Ordering::Greater)) {
            return Err("the times of a table must increase");
        }
        let curvature = if smooth { natural_spline(time_s, value) } else { Vec::new() };
        Ok(Self { time_s: time_s.to_vec(), value: value.to_vec(), curvature })
    }

    /// Cost: a binary search.
    pub(crate) fn at(&self, t_s: f64) -> SignalValue {
        let held = |row: usize| SignalValue { value: self.value[row], rate: 0.0, acceleration: 0.0 };
        let last = self.time_s.len() - 1;
        if self.curvature.is_empty() {
            let after = self.time_s.partition_point(|time| *time <= t_s + EDGE_S);
            return held(after.saturating_sub(1));
        }
        if t_s <= self.time_s[0] || t_s >= self.time_s[last] {
            return held(if t_s <= self.time_s[0] { 0 } else { last });
        }
        let right = self.time_s.partition_point(|time| *time <= t_s);
        self.cubic(right - 1, t_s)
    }

    fn cubic(&self, left: usize, t_s: f64) -> SignalValue {
        let h = self.time_s[left + 1] - self.time_s[left];
        let (b, a) = ((t_s - self.time_s[left]) / h, (self.time_s[left + 1] - t_s) / h);
        let (y_0, y_1) = (self.value[left], self.value[left + 1]);
        let (m_0, m_1) = (self.curvature[left], self.curvature[left + 1]);
        SignalValue {
            value: a * y_0 + b * y_1 + h * h / 6.0 * ((a * a - 1.0) * a * m_0 + (b * b - 1.0) * b * m_1),
            rate: (y_1 - y_0) / h + h / 6.0 * ((3.0 * b * b - 1.0) * m_1 - (3.0 * a * a - 1.0) * m_0),
            acceleration: a * m_0 + b * m_1,
        }
    }
}

/// Second derivatives of the cubic spline through the rows, zero at both ends:
/// `h_i m_{i−1} + 2 (h_i + h_{i+1}) m_i + h_{i+1} m_{i+1} = 6 (slope_{i+1} − slope_i)`, by
/// elimination without pivots (diagonally dominant).
fn natural_spline(time_s: &[f64], value: &[f64]) -> Vec<f64> {
    let n = time_s.len();
    let mut curvature = vec![0.0; n];
    let mut upper = vec![0.0; n];
    for i in 1..n.saturating_sub(1) {
        let (h_0, h_1) = (time_s[i] - time_s[i - 1], time_s[i + 1] - time_s[i]);
        let bend = 6.0 * ((value[i + 1] - value[i]) / h_1 - (value[i] - value[i - 1]) / h_0);
        let pivot = 2.0 * (h_0 + h_1) - h_0 * upper[i - 1];
        upper[i] = h_1 / pivot;
        curvature[i] = (bend - h_0 * curvature[i - 1]) / pivot;
    }
    for i in (1..n.saturating_sub(1)).rev() {
        curvature[i] -= upper[i] * curvature[i + 1];
    }
    curvature
}
