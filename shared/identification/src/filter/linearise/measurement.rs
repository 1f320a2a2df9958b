//! Rows of measurement at one event: of readings by state, noise inputs and clone.

use crate::filter::dense::add_product;
use crate::filter::jacobian::{Along, carry_row, put};
use crate::filter::linear::STEP;
use crate::filter::propagator::{Mean, Propagator};
use crate::filter::wide::wide;

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
    /// States at both ends of means; means by them and by the noise (channels × n, n and m).
    ends: [Vec<f64>; 2],
    by_ends: [Vec<f64>; 2],
    by_noise: Vec<f64>,
    still: Vec<f64>,
    /// Of a row what it says of rates held, and room for its powers.
    held: Vec<f64>,
    powers: [Vec<f64>; 2],
}

impl Scratch {
    pub fn new(propagator: &Propagator<'_>) -> Self {
        let (n, t) = (propagator.x0.len(), propagator.layout.tangent);
        let (p, m) = (propagator.layout.lag_of.len(), propagator.layout.noise_inputs.len());
        let zeros = |n: usize| vec![0.0; n];
        Self {
            delta: zeros(t),
            moved: zeros(n),
            w: zeros(m),
            y: zeros(p),
            y0: zeros(p),
            ends: [zeros(n), zeros(n)],
            by_ends: [zeros(p * n), zeros(p * n)],
            by_noise: zeros(p * m),
            still: zeros(p),
            held: zeros(n),
            powers: [zeros(n), zeros(n)],
        }
    }

    /// Rows by the slopes of `along`. Readings of an instant τ behind their stamp are carried there
    /// by the same slopes, `e^{−A τ}` and `−∫ e^{−A s} B ds`; means are differences at the states
    /// of their own ends, carried likewise.
    pub fn measurement_along(
        &mut self,
        propagator: &mut Propagator<'_>,
        (k, along): (usize, &Along),
        mean: &Mean,
        out: &mut [f64],
    ) {
        let (n, m, c) = (propagator.layout.tangent, propagator.layout.noise_inputs.len(), propagator.layout.clone);
        let (timeline, here) = (propagator.timeline, &along.here);
        let event = timeline.events[k];
        let mut taken = None;
        for (row, sample) in out.chunks_exact_mut(n + m + c).zip(event.first..event.first + event.count) {
            let channel = timeline.channel[sample];
            if propagator.is_uninformative(k, channel) {
                continue;
            }
            let behind = if propagator.is_shifted(channel) { propagator.behind(sample, channel) } else { 0.0 };
            let (by_x, rest) = row.split_at_mut(n);
            let (by_w, clone) = rest.split_at_mut(m);
            if !propagator.is_mean(channel) {
                by_x.copy_from_slice(&here.c[channel * n..(channel + 1) * n]);
                by_w.copy_from_slice(&here.d[channel * m..(channel + 1) * m]);
                self.carry(-behind, (&here.a, &here.b), (by_x, by_w));
                continue;
            }
            let interval = (behind, timeline.interval_s[sample]);
            if taken != Some(interval) {
                self.take_means(propagator, (k, interval), mean);
                taken = Some(interval);
            }
            by_x.copy_from_slice(&self.by_ends[1][channel * n..(channel + 1) * n]);
            by_w.copy_from_slice(&self.by_noise[channel * m..(channel + 1) * m]);
            clone.copy_from_slice(&self.by_ends[0][channel * n..(channel + 1) * n]);
            self.carry(-behind, (&here.a, &here.b), (by_x, by_w));
            self.carry(-behind, (&along.begun[0], &along.begun[1]), (clone, by_w));
        }
    }

    /// A row by the state of an instant, as one by the state and the noise `h` \[s\] earlier.
    fn carry(&mut self, h: f64, (a, b): (&[f64], &[f64]), (row, by_w): (&mut [f64], &mut [f64])) {
        if h == 0.0 {
            return;
        }
        let (n, m) = (row.len(), by_w.len());
        let Self { held, powers, .. } = self;
        wide(
            #[inline(always)]
            || {
                carry_row(a, h, row, held, powers);
                if m > 0 {
                    add_product(held, n, (b, m), (by_w, m));
                }
            },
        );
    }

    /// Means of one interval by their ends, at which nothing is integrated any more.
    fn take_means(&mut self, propagator: &mut Propagator<'_>, (k, interval): (usize, (f64, f64)), mean: &Mean) {
        let (n, m, from) = (self.held.len(), self.w.len(), mean.clone_event);
        let Self { ends, by_ends, by_noise, w, y, y0, still, .. } = self;
        let read = |propagator: &mut Propagator<'_>, ends: &[Vec<f64>; 2], w: &[f64], out: &mut [f64]| {
            propagator.means_between((k, from), interval, ends, w);
            let means = out.iter_mut().enumerate().filter(|(channel, _)| propagator.is_mean(*channel));
            means.for_each(|(channel, out)| *out = propagator.taken(channel));
        };
        w.copy_from_slice(&mean.w);
        propagator.ends_behind((k, interval.0), (&mean.x, w), (&mean.clone, from), ends);
        read(propagator, ends, w, still);
        for side in 0..2 {
            for column in 0..n {
                let at = ends[side][column];
                ends[side][column] = at + CENTRAL_STEP;
                read(propagator, ends, w, y);
                ends[side][column] = at - CENTRAL_STEP;
                // most of the state no mean feels at all
                if y == still {
                    y0.copy_from_slice(still)
                } else {
                    read(propagator, ends, w, y0)
                }
                ends[side][column] = at;
                put(&mut by_ends[side], (column, n), (y, y0), 2.0 * CENTRAL_STEP);
            }
        }
        let felt = if propagator.system.means_are_kinematic() { 0 } else { m };
        for column in 0..felt {
            w[column] = mean.w[column] + CENTRAL_STEP;
            read(propagator, ends, w, y);
            w[column] = mean.w[column] - CENTRAL_STEP;
            read(propagator, ends, w, y0);
            w[column] = mean.w[column];
            put(by_noise, (column, m), (y, y0), 2.0 * CENTRAL_STEP);
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
