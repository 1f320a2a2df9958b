//! Readings of a run as its sensors take them, before their lags: at instants off their stamps, and
//! means.

use super::Propagator;

impl Propagator<'_> {
    /// Readings of the samples of event `k` before lags, into `out` (one per sample). `clone` is
    /// the state at the beginning of means.
    pub fn read(&mut self, k: usize, x: &[f64], w: &[f64], clone: (&[f64], usize), out: &mut [f64]) {
        let event = self.timeline.events[k];
        if event.count == 0 {
            return;
        }
        let samples = event.first..event.first + event.count;
        let channels = &self.timeline.channel[samples.clone()];
        if channels.iter().any(|c| !self.sensors[*c].mean) {
            self.load(event.row, w);
            let Self { system, ws, u, y, .. } = self;
            system.read(ws, event.t_s, x, u, y);
            for (out, channel) in out.iter_mut().zip(&self.timeline.channel[samples.clone()]) {
                *out = self.y[*channel];
            }
        }
        for (slot, sample) in samples.enumerate() {
            let channel = self.timeline.channel[sample];
            let behind = if self.any_shifted { self.behind(sample, channel) } else { 0.0 };
            if self.is_uninformative(k, channel) {
                out[slot] = self.timeline.value[sample];
            } else if self.sensors[channel].mean {
                out[slot] = self.read_mean(k, sample, behind, x, w, clone);
            } else if behind != 0.0 {
                out[slot] = self.read_at(k, channel, behind, behind > 0.0, x, w);
            }
        }
        for attitude in &self.attitudes {
            attitude.turn(self.timeline, &event, out);
        }
    }

    /// The sample is about an instant before the recording, where the inputs are unknown: the
    /// first of a channel whose delay is unknown, whatever that is, or known to reach there.
    fn is_uninformative(&self, k: usize, channel: usize) -> bool {
        let sensor = &self.sensors[channel];
        let reaches = sensor.delay_s > self.timeline.shift_s[channel] + 1e-6 * self.timeline.period_s;
        k == 0 && (sensor.delay_is_unknown || reaches)
    }

    /// By how much the instant that the sample is about lies before its event \[s\].
    pub(super) fn behind(&self, sample: usize, channel: usize) -> f64 {
        let sensor = &self.sensors[channel];
        let stamp = self.timeline.stamp_s[sample];
        let truth = (stamp - sensor.offset_s) / (1.0 + sensor.skew);
        stamp - truth + sensor.delay_s - self.timeline.shift_s[channel]
    }

    /// Reading of an instant that lies `behind` event `k`; `before`: under what acted until the
    /// event, else under what acts from it on.
    pub(super) fn read_at(&mut self, k: usize, channel: usize, behind: f64, before: bool, x: &[f64], w: &[f64]) -> f64 {
        let event = self.timeline.events[k];
        let at = if before && k > 0 { k - 1 } else { k };
        let row = if self.timeline.moving { event.row } else { self.timeline.events[at].row };
        self.load(row, w);
        let mut moved = core::mem::take(&mut self.x_at);
        moved.copy_from_slice(x);
        if behind != 0.0 {
            // as finely as the flow
            let step_s = self.timeline.events[at].step_s / self.finer as f64;
            let steps = if step_s > 0.0 { libm::ceil(behind.abs() / step_s).max(1.0) } else { 1.0 };
            for step in 0..steps as usize {
                self.integrate(event.t_s - behind * step as f64 / steps, -behind / steps, &mut moved, None);
            }
        }
        let Self { system, ws, u, y, .. } = self;
        system.read(ws, event.t_s - behind, &moved, u, y);
        self.x_at = moved;
        self.y[channel]
    }

    fn read_mean(&mut self, k: usize, sample: usize, behind: f64, x: &[f64], w: &[f64], clone: (&[f64], usize)) -> f64 {
        let event = self.timeline.events[k];
        let (channel, dt) = (self.timeline.channel[sample], self.timeline.interval_s[sample]);
        let (mut end, mut begin) = (core::mem::take(&mut self.x_at), core::mem::take(&mut self.x_begin));
        end.copy_from_slice(x);
        begin.copy_from_slice(clone.0);
        self.load(event.row, w);
        self.u_end.copy_from_slice(&self.u);
        self.load(clone.1, w);
        if behind != 0.0 {
            self.integrate(event.t_s, -behind, &mut end, None);
            self.integrate(event.t_s - dt, -behind, &mut begin, None);
        }
        let Self { system, ws, u, u_end, y, .. } = self;
        system.read_mean(ws, event.t_s - dt - behind, dt, &begin, u, &end, u_end, y);
        (self.x_at, self.x_begin) = (end, begin);
        self.y[channel]
    }
}
