//! The pass with frozen gains.

use super::Propagator;
use crate::filter::Frozen;
use dynamics::lags::LagState;

/// What the pass carries from event to event.
#[derive(Clone, Debug)]
pub struct Mean {
    pub x: Vec<f64>,
    pub w: Vec<f64>,
    /// Noise inputs that acted until the event.
    pub w_until: Vec<f64>,
    /// State at the beginning of means, and its event.
    pub clone: Vec<f64>,
    pub clone_event: usize,
    pub lag: Vec<LagState>,
    /// Last reading before the lag, and whether there was one.
    pub lag_input: Vec<f64>,
    pub lag_started: Vec<bool>,
    pub lag_time_s: Vec<f64>,
}

impl Propagator<'_> {
    /// The mean before the first event: initial state, noise inputs and lags at zero.
    pub fn start(&self) -> Mean {
        let channels = self.sensors.len();
        Mean {
            x: self.x0.clone(),
            w: vec![0.0; self.layout.noise_inputs.len()],
            w_until: vec![0.0; self.layout.noise_inputs.len()],
            clone: self.x0.clone(),
            clone_event: 0,
            lag: vec![LagState::default(); channels],
            lag_input: vec![0.0; channels],
            lag_started: vec![false; channels],
            lag_time_s: vec![0.0; channels],
        }
    }

    /// `z ← z ⊕ change` for the parts that the pass carries.
    pub fn correct(&mut self, mean: &mut Mean, change: &[f64]) {
        let n = self.layout.tangent;
        self.stage.copy_from_slice(&mean.x);
        self.system.retract(&self.stage, &change[..n], &mut mean.x);
        for (w, change) in mean.w.iter_mut().zip(&change[n..]) {
            *w += change;
        }
        for (channel, lag) in self.layout.lag_of.iter().enumerate() {
            if let Some(lag) = lag {
                mean.lag[channel].output += change[self.layout.lags_at() + lag];
            }
        }
        if self.layout.clone > 0 {
            let at = self.layout.clone_at();
            self.stage.copy_from_slice(&mean.clone);
            self.system.retract(&self.stage, &change[at..at + n], &mut mean.clone);
        }
    }

    /// Draws noise anew where the event says so, before its readings.
    pub fn renew(&self, k: usize, mean: &mut Mean) {
        mean.w_until.copy_from_slice(&mean.w);
        self.renew_noise(k, &mut mean.w);
    }

    /// Of [`Propagator::renew`], noise inputs alone.
    pub fn renew_noise(&self, k: usize, w: &mut [f64]) {
        let reset = self.timeline.events[k].reset;
        for (w, input) in w.iter_mut().zip(&self.layout.noise_inputs) {
            if reset >> input.min(&63) & 1 == 1 {
                *w = 0.0;
            }
        }
    }

    /// Keeps the state at the beginning of a mean, after the update of its event.
    pub fn begin_mean(&self, k: usize, mean: &mut Mean) {
        if self.any_mean && self.timeline.events[k].begins_mean {
            mean.clone.copy_from_slice(&mean.x);
            mean.clone_event = k;
        }
    }

    /// Innovations `y − ŷ` of the whole run with frozen gains. `map[i]` is the place in this
    /// propagator's z of entry i of the gains' z. Returns false where the state ran away.
    pub fn pass(&mut self, frozen: &Frozen, map: &[usize], nu: &mut [f64]) -> bool {
        let mut mean = self.start();
        let mut change = vec![0.0; self.layout.len()];
        let mut predicted = vec![0.0; self.sensors.len()];
        let events = self.timeline.events.len();
        for k in 0..events {
            let event = self.timeline.events[k];
            self.renew(k, &mut mean);
            if event.count > 0 {
                self.predict(k, &mut mean, &mut predicted);
                let gain = &frozen.gain[frozen.first[k]..];
                change.fill(0.0);
                for slot in 0..event.count {
                    let innovation = self.timeline.value[event.first + slot] - predicted[slot];
                    nu[event.first + slot] = innovation;
                    for (row, at) in map.iter().enumerate() {
                        change[*at] += gain[row * event.count + slot] * innovation;
                    }
                }
                if !change.iter().all(|c| c.abs() < 1e12) {
                    return false;
                }
                self.correct(&mut mean, &change);
            }
            self.begin_mean(k, &mut mean);
            if k + 1 < events {
                let mut x = core::mem::take(&mut mean.x);
                self.flow(k, &mut x, &mean.w);
                mean.x = x;
            }
        }
        mean.x.iter().all(|x| x.is_finite())
    }
}
