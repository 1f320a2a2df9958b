//! Rows of measurement at one event: of readings by state, noise inputs and clone.

use crate::filter::jacobian::Slopes;
use crate::filter::linear::STEP;
use crate::filter::propagator::{Mean, Propagator};

/// Step of central differences of means, which are kinematics over an interval h: curvature leaves
/// 2e-9 of a slope, rounding 1e-12/h. Both ends of a mean feel what nothing measures, a velocity
/// against inertial space, and must cancel.
const CENTRAL_STEP: f64 = 1e-4;

pub(super) struct Scratch {
    delta: Vec<f64>,
    moved: Vec<f64>,
    w: Vec<f64>,
    y: Vec<f64>,
    y0: Vec<f64>,
}

impl Scratch {
    pub fn new(propagator: &Propagator<'_>) -> Self {
        let (n, t) = (propagator.x0.len(), propagator.layout.tangent);
        let p = propagator.layout.lag_of.len();
        let zeros = |n: usize| vec![0.0; n];
        Self { delta: zeros(t), moved: zeros(n), w: Vec::new(), y: zeros(p), y0: zeros(p) }
    }

    /// Rows by the slopes `here`; of means and of instants off their stamps by differences.
    pub fn measurement_along(
        &mut self,
        propagator: &mut Propagator<'_>,
        (k, here): (usize, &Slopes),
        mean: &Mean,
        out: &mut [f64],
    ) {
        let (n, m, c) = (propagator.layout.tangent, propagator.layout.noise_inputs.len(), propagator.layout.clone);
        let event = propagator.timeline.events[k];
        let channels = &propagator.timeline.channel[event.first..event.first + event.count];
        for (channel, row) in channels.iter().zip(out.chunks_exact_mut(n + m + c)) {
            if propagator.is_instant(*channel) && !propagator.is_uninformative(k, *channel) {
                row[..n].copy_from_slice(&here.c[channel * n..(channel + 1) * n]);
                row[n..n + m].copy_from_slice(&here.d[channel * m..(channel + 1) * m]);
            }
        }
        let is_apart: Vec<bool> = channels.iter().map(|channel| !propagator.is_instant(*channel)).collect();
        if !is_apart.contains(&true) {
            return;
        }
        let shifted = channels.iter().any(|channel| propagator.is_shifted(*channel));
        let by_noise = shifted || !propagator.system.means_are_kinematic();
        self.w.clone_from(&mean.w);
        for column in (0..n + m + c).filter(|column| by_noise || !(n..n + m).contains(column)) {
            for (by, out) in [(CENTRAL_STEP, &mut self.y), (-CENTRAL_STEP, &mut self.y0)] {
                let (mut x, mut clone) = (&mean.x, &mean.clone);
                if column < n {
                    self.moved.copy_from_slice(x);
                    self.moved[column] += by;
                    x = &self.moved;
                } else if column < n + m {
                    self.w[column - n] = mean.w[column - n] + by;
                } else {
                    self.moved.copy_from_slice(clone);
                    self.moved[column - n - m] += by;
                    clone = &self.moved;
                }
                propagator.read_apart(k, x, &self.w, (clone, mean.clone_event), out);
            }
            if (n..n + m).contains(&column) {
                self.w[column - n] = mean.w[column - n];
            }
            for slot in (0..event.count).filter(|slot| is_apart[*slot]) {
                out[slot * (n + m + c) + column] = (self.y[slot] - self.y0[slot]) / (2.0 * CENTRAL_STEP);
            }
        }
    }

    /// Rows by differences of the readings.
    pub fn measurement(&mut self, propagator: &mut Propagator<'_>, k: usize, mean: &Mean, out: &mut [f64]) {
        let (n, m, c) = (propagator.layout.tangent, propagator.layout.noise_inputs.len(), propagator.layout.clone);
        let count = propagator.timeline.events[k].count;
        self.w.clone_from(&mean.w);
        propagator.read(k, &mean.x, &mean.w, (&mean.clone, mean.clone_event), &mut self.y0);
        for column in 0..n + m + c {
            if column < n {
                self.delta.fill(0.0);
                self.delta[column] = STEP;
                propagator.system.retract(&mean.x, &self.delta, &mut self.moved);
                propagator.read(k, &self.moved, &self.w, (&mean.clone, mean.clone_event), &mut self.y);
            } else if column < n + m {
                self.w[column - n] += STEP;
                propagator.read(k, &mean.x, &self.w, (&mean.clone, mean.clone_event), &mut self.y);
                self.w[column - n] = mean.w[column - n];
            } else {
                self.delta.fill(0.0);
                self.delta[column - n - m] = STEP;
                propagator.system.retract(&mean.clone, &self.delta, &mut self.moved);
                propagator.read(k, &mean.x, &self.w, (&self.moved, mean.clone_event), &mut self.y);
            }
            for slot in 0..count {
                out[slot * (n + m + c) + column] = (self.y[slot] - self.y0[slot]) / STEP;
            }
        }
    }
}
