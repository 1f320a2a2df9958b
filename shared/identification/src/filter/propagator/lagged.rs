//! Readings past the lags of their sensors.
//!
//! A lag is continuous where its input jumps: what feeds through from a command to a reading goes
//! into the lag as it was until the event (`to`), and starts the next interval as it is from then
//! on (`from`). Between two readings the input is the parabola through them and the instant midway:
//! with a time constant far below the interval the lag shows the slope at its end, not the mean
//! slope.

use super::{Mean, Propagator};
use dynamics::lags::LagState;

impl Propagator<'_> {
    /// Readings as the sensors tell them. Call once per event, before the update.
    pub fn predict(&mut self, k: usize, mean: &mut Mean, out: &mut [f64]) {
        self.read(k, &mean.x, &mean.w, (&mean.clone, mean.clone_row), out);
        if self.layout.lags == 0 {
            return;
        }
        let event = self.timeline.events[k];
        for (slot, out) in out.iter_mut().enumerate().take(event.count) {
            let channel = self.timeline.channel[event.first + slot];
            if self.layout.lag_of[channel].is_some() {
                *out = self.lagged(k, event.first + slot, *out, mean);
            }
        }
    }

    fn lagged(&mut self, k: usize, sample: usize, input: f64, mean: &mut Mean) -> f64 {
        let channel = self.timeline.channel[sample];
        let t_s = self.timeline.events[k].t_s;
        let h_s = t_s - mean.lag_time_s[channel];
        if !mean.lag_started[channel] {
            mean.lag[channel] = LagState::settled(input);
        } else if h_s > 0.0 {
            let line = (0.5 * (mean.lag_input[channel] + input), input);
            let (middle, to) = self.until(k, sample, h_s, mean).unwrap_or(line);
            if let Some(lag) = &self.sensors[channel].lag {
                lag.arc(&mut mean.lag[channel], [mean.lag_input[channel], middle, to], h_s);
            }
        }
        mean.lag_started[channel] = true;
        mean.lag_time_s[channel] = t_s;
        mean.lag_input[channel] = input;
        mean.lag[channel].output
    }

    /// Readings half an interval before event `k` and right before it; `None` where readings are
    /// means, where the commands move, or where more than one held command acted since the last
    /// sample: there the line serves.
    fn until(&mut self, k: usize, sample: usize, h_s: f64, mean: &Mean) -> Option<(f64, f64)> {
        let channel = self.timeline.channel[sample];
        let since_last = k > 0 && self.timeline.events[k - 1].t_s <= mean.lag_time_s[channel];
        if self.sensors[channel].mean || self.timeline.moving || !since_last {
            return None;
        }
        let behind = self.behind(sample, channel);
        let halfway = behind + 0.5 * h_s;
        let middle = self.read_at(k, channel, halfway, halfway > 0.0, &mean.x, &mean.w);
        let to = self.read_at(k, channel, behind, behind >= 0.0, &mean.x, &mean.w);
        Some((middle, to))
    }

    /// Share of a lag's old output that is left after `h_s`.
    pub fn lag_decay(&self, channel: usize, h_s: f64) -> f64 {
        let Some(lag) = &self.sensors[channel].lag else { return 0.0 };
        let mut state = LagState::settled(1.0);
        if h_s > 0.0 { lag.ramp(&mut state, 0.0, 0.0, h_s) } else { 1.0 }
    }
}
