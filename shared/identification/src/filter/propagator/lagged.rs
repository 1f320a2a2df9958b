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
        self.read(k, &mean.x, &mean.w, (&mean.clone, mean.clone_event), out);
        if self.layout.lags == 0 {
            return;
        }
        let event = self.timeline.events[k];
        let mut taken = None;
        for (slot, out) in out.iter_mut().enumerate().take(event.count) {
            let channel = self.timeline.channel[event.first + slot];
            if self.layout.lag_of[channel].is_some() {
                *out = self.lagged((k, event.first + slot), *out, mean, &mut taken);
            }
        }
    }

    fn lagged(
        &mut self,
        (k, sample): (usize, usize),
        input: f64,
        mean: &mut Mean,
        taken: &mut Option<[f64; 2]>,
    ) -> f64 {
        let channel = self.timeline.channel[sample];
        let t_s = self.timeline.events[k].t_s;
        let h_s = t_s - mean.lag_time_s[channel];
        if !mean.lag_started[channel] {
            mean.lag[channel] = LagState::settled(input);
        } else if h_s > 0.0 {
            let line = (0.5 * (mean.lag_input[channel] + input), input);
            let (middle, to) = self.until((k, sample), h_s, mean, taken).unwrap_or(line);
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
    /// sample: there the line serves. `taken`: of which instants all readings are at hand.
    fn until(
        &mut self,
        (k, sample): (usize, usize),
        h_s: f64,
        mean: &Mean,
        taken: &mut Option<[f64; 2]>,
    ) -> Option<(f64, f64)> {
        let channel = self.timeline.channel[sample];
        if !self.lag_is_bent(k, channel, mean.lag_time_s[channel]) {
            return None;
        }
        let behind = self.behind(sample, channel);
        let halfway = behind + 0.5 * h_s;
        if *taken != Some([behind, halfway]) {
            self.read_at(k, channel, halfway, halfway > 0.0, &mean.x, &mean.w_until);
            self.y_middle.copy_from_slice(&self.y);
            self.read_at(k, channel, behind, behind >= 0.0, &mean.x, &mean.w_until);
            self.y_to.copy_from_slice(&self.y);
            *taken = Some([behind, halfway]);
        }
        Some((self.y_middle[channel], self.y_to[channel]))
    }

    /// Between the reading of `channel` at `last_s` and event `k` its lag takes in a parabola: one
    /// command was held.
    pub fn lag_is_bent(&self, k: usize, channel: usize, last_s: f64) -> bool {
        let since = self.timeline.events[..k].iter().rev();
        let mut within = since.take_while(|event| event.t_s > last_s);
        let held = k > 0 && !last_s.is_nan() && within.all(|event| event.reset == 0);
        !self.sensors[channel].mean && !self.timeline.moving && held
    }

    /// Share of a lag's old output that is left after `h_s`.
    pub fn lag_decay(&self, channel: usize, h_s: f64) -> f64 {
        let Some(lag) = &self.sensors[channel].lag else { return 0.0 };
        let mut state = LagState::settled(1.0);
        if h_s > 0.0 { lag.ramp(&mut state, 0.0, 0.0, h_s) } else { 1.0 }
    }
}
