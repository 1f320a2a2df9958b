//! What is linear about a pass: transitions and rows of measurement along it.

use super::{Frozen, Layout, NoiseModel};
use crate::problem::Timeline;

/// Transition and measurement of one run about its filtered trajectory.
#[derive(Clone, Debug)]
pub struct Linear {
    pub layout: Layout,
    /// Per event: `tangent × (tangent + noise inputs)`, row-major: to the next event.
    pub transition: Vec<f64>,
    /// Per sample: `tangent + noise inputs + clone` numbers.
    pub measurement: Vec<f64>,
    /// Per sample: rate of change of the predicted reading [SI unit of the channel per s].
    pub slope: Vec<f64>,
    /// Per sample: share of the lag's old output; NaN where the channel does not lag.
    pub decay: Vec<f64>,
    pub initial_sigma: Vec<f64>,
    /// Where the pass starts: change from the mean of the prior; what that mean adds to the
    /// innovations of a pass from there.
    pub start: Vec<f64>,
    pub pull: Vec<f64>,
    /// The gains are those of the prior's width.
    pub is_wide: bool,
    /// Parts that a step of integration was taken in.
    pub finer: usize,
    /// Gains of the pass, and its innovations, those of a start at the prior's mean.
    pub frozen: Frozen,
    /// Lower Cholesky factors of the innovations' covariances under the noise of the pass, samples
    /// × samples of each event; empty where they were not kept.
    pub factor: Vec<f64>,
    pub nu: Vec<f64>,
    /// Filtered state at every event, before its update and after it, and the noise inputs
    /// likewise.
    pub states: Vec<f64>,
    pub updated: Vec<f64>,
    pub held: Vec<f64>,
    pub held_updated: Vec<f64>,
    pub noise: NoiseModel,
    /// Names of the numbers of a small change of state, and of the noise inputs.
    pub names: Vec<String>,
    pub input_names: Vec<String>,
    pub state_names: Vec<String>,
}

impl Linear {
    /// Partial derivatives of one reading: by state, noise inputs and clone.
    pub fn row_len(&self) -> usize {
        self.layout.tangent + self.layout.noise_inputs.len() + self.layout.clone
    }

    /// Largest innovation of the pass, in standard deviations of its sensor.
    pub fn peak(&self, timeline: &Timeline) -> f64 {
        let pass = self.nu.iter().zip(&self.pull).map(|(nu, pull)| (nu - pull).abs());
        pass.zip(&timeline.channel).map(|(nu, c)| nu / self.noise.sensor_sigma[*c]).fold(0.0, f64::max)
    }

    /// Largest change of a state over one interval per unit of noise input `input`.
    pub fn kick(&self, input: usize) -> f64 {
        let (n, m) = (self.layout.tangent, self.layout.noise_inputs.len());
        self.transition.chunks_exact(n + m).map(|row| row[n + input].abs()).fold(0.0, f64::max)
    }

    /// Force at noise input `input` that would make each interval's change of the rate it moves
    /// most.
    pub fn forces(&self, input: usize) -> Vec<f64> {
        let (n, m, x) = (self.layout.tangent, self.layout.noise_inputs.len(), self.state_names.len());
        let intervals = (self.states.len() / x.max(1)).saturating_sub(1);
        let gamma = |k: usize, row: usize| self.transition[k * n * (n + m) + row * (n + m) + n + input];
        let size = |row: &usize| (0..intervals).map(|k| gamma(k, *row).abs()).sum::<f64>();
        let rates = (0..n).filter(|row| self.names[*row].ends_with(".rate"));
        let Some(row) = rates.max_by(|a, b| size(a).total_cmp(&size(b))) else { return Vec::new() };
        let Some(state) = self.state_names.iter().position(|name| *name == self.names[row]) else { return Vec::new() };
        let moved = |k: usize| self.states[(k + 1) * x + state] - self.updated[k * x + state];
        (0..intervals).filter(|k| gamma(*k, row) != 0.0).map(|k| moved(k) / gamma(k, row)).collect()
    }
}

/// Step of the differences: readings and states are of the order of one in SI; curvature below 1e-4
/// of it is not seen.
pub(super) const STEP: f64 = 1e-6;
