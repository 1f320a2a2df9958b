//! Readings of a run as its sensors take them, before their lags: at instants off their stamps, and
//! means.

use super::Propagator;

impl Propagator<'_> {
    /// Readings of the samples of event `k` before lags, into `out` (one per sample). `clone` is
    /// the state at the beginning of means, and its event.
    pub fn read(&mut self, k: usize, x: &[f64], w: &[f64], clone: (&[f64], usize), out: &mut [f64]) {
        let event = self.timeline.events[k];
        if event.count == 0 {
            return;
        }
        let samples = event.first..event.first + event.count;
        let channels = &self.timeline.channel[samples.clone()];
        if channels.iter().any(|channel| !self.sensors[*channel].mean) {
            self.load(event.row, w);
            let Self { system, ws, u, y, .. } = self;
            system.read(ws, event.t_s, x, u, y);
            for (out, channel) in out.iter_mut().zip(&self.timeline.channel[samples]) {
                *out = self.y[*channel];
            }
        }
        self.read_apart(k, x, w, clone, out);
        for attitude in &self.attitudes {
            attitude.turn(self.timeline, &event, out);
        }
    }

    /// Of [`Propagator::read`], the readings that are means or of instants off their stamps.
    pub fn read_apart(&mut self, k: usize, x: &[f64], w: &[f64], clone: (&[f64], usize), out: &mut [f64]) {
        let event = self.timeline.events[k];
        // means of one interval are taken together
        let mut taken: Option<(f64, f64)> = None;
        for (slot, sample) in (event.first..event.first + event.count).enumerate() {
            let channel = self.timeline.channel[sample];
            let behind = if self.any_shifted { self.behind(sample, channel) } else { 0.0 };
            if self.is_uninformative(k, channel) {
                out[slot] = self.timeline.value[sample];
            } else if self.sensors[channel].mean {
                let interval = (behind, self.timeline.interval_s[sample]);
                if taken != Some(interval) {
                    self.take_means(k, interval, x, w, clone);
                    taken = Some(interval);
                }
                out[slot] = self.y[channel];
            } else if behind != 0.0 {
                out[slot] = self.read_at(k, channel, behind, behind > 0.0, x, w);
                taken = None;
            }
        }
    }

    /// The sample is about an instant before the recording, where the inputs are unknown: the
    /// first of a channel whose delay is unknown, whatever that is, or known to reach there.
    pub fn is_uninformative(&self, k: usize, channel: usize) -> bool {
        let sensor = &self.sensors[channel];
        let reaches = sensor.delay_s > self.timeline.shift_s[channel] + 1e-6 * self.timeline.period_s;
        k == 0 && (sensor.delay_is_unknown || reaches)
    }

    /// By how much the instant that the sample is about lies before its event \[s\].
    pub fn behind(&self, sample: usize, channel: usize) -> f64 {
        let sensor = &self.sensors[channel];
        let stamp = self.timeline.stamp_s[sample];
        let truth = (stamp - sensor.offset_s) / (1.0 + sensor.skew);
        stamp - truth + sensor.delay_s - self.timeline.shift_s[channel]
    }

    /// Reading of an instant that lies `behind` event `k`; `before`: under what acted until the
    /// event, else under what acts from it on.
    pub(super) fn read_at(&mut self, k: usize, channel: usize, behind: f64, before: bool, x: &[f64], w: &[f64]) -> f64 {
        let mut moved = core::mem::take(&mut self.x_at);
        moved.copy_from_slice(x);
        self.carry((k, before), behind, &mut moved, w);
        let t_s = self.timeline.events[k].t_s - behind;
        let Self { system, ws, u, y, .. } = self;
        system.read(ws, t_s, &moved, u, y);
        self.x_at = moved;
        self.y[channel]
    }

    /// Moves `x` from event `k` to the instant that lies `behind` it, and loads the inputs there.
    /// Commands act where they did: an instant beyond a switch is reached under both.
    fn carry(&mut self, (k, before): (usize, bool), behind: f64, x: &mut [f64], w: &[f64]) {
        let events = &self.timeline.events;
        let mut at = if before && k > 0 { k - 1 } else { k };
        let (mut t_s, until_s) = (events[k].t_s, events[k].t_s - behind);
        loop {
            let event = self.timeline.events[at];
            // before the first event and behind the last one the same goes on
            let edge_s = match behind > 0.0 {
                true if at > 0 => until_s.max(event.t_s),
                false if behind < 0.0 && at + 1 < self.timeline.events.len() => {
                    until_s.min(self.timeline.events[at + 1].t_s)
                }
                _ => until_s,
            };
            self.load(if self.timeline.moving { self.timeline.events[k].row } else { event.row }, w);
            let length_s = edge_s - t_s;
            if length_s != 0.0 {
                // as finely as the flow
                let step_s = event.step_s / self.finer as f64;
                let steps = if step_s > 0.0 { libm::ceil(length_s.abs() / step_s).max(1.0) } else { 1.0 };
                for step in 0..steps as usize {
                    self.integrate(t_s + length_s * step as f64 / steps, length_s / steps, x, None);
                }
            }
            if edge_s == until_s {
                return;
            }
            t_s = edge_s;
            at = if behind > 0.0 { at - 1 } else { at + 1 };
        }
    }

    /// Means that begin at the event of `clone` and end at event `k`, both as much `behind`, into
    /// the readings.
    fn take_means(&mut self, k: usize, (behind, dt_s): (f64, f64), x: &[f64], w: &[f64], clone: (&[f64], usize)) {
        let mut ends = [core::mem::take(&mut self.x_begin), core::mem::take(&mut self.x_at)];
        self.ends_behind((k, behind), (x, w), clone, &mut ends);
        self.means_between((k, clone.1), (behind, dt_s), &ends, w);
        [self.x_begin, self.x_at] = ends;
    }

    /// States at both ends of such a mean.
    pub fn ends_behind(
        &mut self,
        (k, behind): (usize, f64),
        (x, w): (&[f64], &[f64]),
        clone: (&[f64], usize),
        [begin, end]: &mut [Vec<f64>; 2],
    ) {
        end.copy_from_slice(x);
        begin.copy_from_slice(clone.0);
        if behind != 0.0 {
            self.carry((k, behind > 0.0), behind, end, w);
            self.carry((clone.1, behind > 0.0), behind, begin, w);
        }
    }

    /// Means between two states, which began at event `from` and end at event `k`, into the
    /// readings.
    pub fn means_between(
        &mut self,
        (k, from): (usize, usize),
        (behind, dt_s): (f64, f64),
        [begin, end]: &[Vec<f64>; 2],
        w: &[f64],
    ) {
        let event = self.timeline.events[k];
        self.load(event.row, w);
        self.u_end.copy_from_slice(&self.u);
        self.load(self.timeline.events[from].row, w);
        let Self { system, ws, u, u_end, y, .. } = self;
        system.read_mean(ws, event.t_s - dt_s - behind, dt_s, begin, u, end, u_end, y);
    }

    /// The reading of `channel` that was taken last.
    pub fn taken(&self, channel: usize) -> f64 {
        self.y[channel]
    }

    /// Readings of `channel` are means.
    pub fn is_mean(&self, channel: usize) -> bool {
        self.sensors[channel].mean
    }
}
