//! What every number does to means, and to readings of instants off their stamps.
//!
//! Of a reading of an instant τ behind its event, with c its row by the state there and b of the
//! interval that it lies in,
//!
//! ```text
//! D = D there − c ∫₀^τ e^{−A s} b ds,   c e^{−A τ} being the row of measurement
//! ```
//!
//! so that nothing is integrated for a number but those of the sensor's clock.

use super::Moved;
use super::interval::Interval;
use super::local::Local;
use crate::filter::Linear;
use crate::filter::dense::add_product;
use crate::filter::jacobian::{Slopes, carry_row};
use crate::filter::propagator::Propagator;
use crate::filter::wide::wide;
use dynamics::system::Differs;

pub(super) struct Apart {
    width: usize,
    narrow: usize,
    /// b at the event, under what acts from it on (accelerations × narrow).
    pub b: Vec<f64>,
    /// State at the beginning of means, and its event; A there, b until it and from it on.
    clone: (Vec<f64>, usize),
    begun: [Vec<f64>; 3],
    /// States at both ends of means.
    ends: [Vec<f64>; 2],
    /// Readings of the nominal plant and of one beside it.
    y: [Vec<f64>; 2],
    /// A row, what it says of rates held, and room for its powers.
    row: Vec<f64>,
    held: Vec<f64>,
    powers: [Vec<f64>; 2],
}

/// What a run has about an event: slopes at it, and the interval before it.
type Along<'a> = (&'a Slopes, &'a Interval);

impl Apart {
    pub fn new(nominal: &Propagator<'_>, local: &Local) -> Self {
        let (n, channels) = (local.point.x.len(), local.point.y.len());
        let zeros = |count: usize| vec![0.0; count];
        Self {
            width: local.width,
            narrow: local.narrow,
            b: local.b.clone(),
            clone: (nominal.x0.clone(), 0),
            begun: [zeros(n * n), local.b.clone(), local.b.clone()],
            ends: [zeros(n), zeros(n)],
            y: [zeros(channels), zeros(channels)],
            row: zeros(n),
            held: zeros(n),
            powers: [zeros(n), zeros(n)],
        }
    }

    /// Whether slopes at event `k` are asked for.
    pub fn needs_rates(nominal: &Propagator<'_>, k: usize) -> bool {
        let event = nominal.timeline.events[k];
        let channels = &nominal.timeline.channel[event.first..event.first + event.count];
        event.begins_mean || channels.iter().any(|channel| !nominal.is_instant(*channel))
    }

    /// Means begin at event `k`, behind its update.
    pub fn begin_mean(&mut self, linear: &Linear, k: usize, (rates, interval): Along<'_>) {
        let n = self.clone.0.len();
        self.clone.0.copy_from_slice(&linear.updated[k * n..(k + 1) * n]);
        self.clone.1 = k;
        self.begun[0].copy_from_slice(&rates.a);
        self.begun[1].copy_from_slice(if k > 0 { interval.b_end() } else { &self.b });
        self.begun[2].copy_from_slice(&self.b);
    }

    /// D of the samples of event `k` that are apart; `d` has that of readings at the event, of
    /// columns in their `order`.
    pub fn read(
        &mut self,
        (nominal, moved): (&mut Propagator<'_>, &mut [Moved<'_>]),
        (linear, k): (&Linear, usize),
        (rates, interval): Along<'_>,
        (d, order): (&mut [f64], &[usize]),
    ) {
        let timeline = nominal.timeline;
        let event = timeline.events[k];
        let is_apart = |nominal: &Propagator<'_>, sample: &usize| {
            let channel = timeline.channel[*sample];
            !nominal.is_instant(channel) && !nominal.is_uninformative(k, channel)
        };
        let samples = || event.first..event.first + event.count;
        if !samples().any(|sample| is_apart(nominal, &sample)) {
            return;
        }
        let v = self.b.len() / self.narrow;
        let (mut taken, mut by_plants) = (None, false);
        for sample in samples() {
            let channel = timeline.channel[sample];
            if !is_apart(nominal, &sample) {
                continue;
            }
            if nominal.is_mean(channel) {
                by_plants |= !nominal.system.means_are_kinematic();
                let of = (nominal.behind(sample, channel), timeline.interval_s[sample]);
                if taken != Some(of) {
                    self.read_means((nominal, moved), (linear, k), of, (d, order));
                    taken = Some(of);
                }
            } else {
                // a force that switches between the instant and its stamp is in the reading at once
                by_plants |= rates.y_a[channel * v..(channel + 1) * v].iter().any(|y| *y != 0.0);
            }
        }
        for sample in samples().filter(|sample| is_apart(nominal, sample)) {
            let channel = timeline.channel[sample];
            let behind = nominal.behind(sample, channel);
            let own = channel * self.width..(channel + 1) * self.width;
            self.carry((linear, sample), (k, behind), (rates, interval), &mut d[own]);
        }
        let passes = |one: &Moved<'_>| by_plants || one.retimed;
        if !moved.iter().any(passes) {
            return;
        }
        let (x, w) = at(linear, k);
        let clone = (&self.clone.0[..], self.clone.1);
        let [still, there] = &mut self.y;
        nominal.read_apart(k, x, w, clone, still);
        for (column, i) in order.iter().enumerate() {
            let one = &mut moved[*i];
            if !passes(one) {
                continue;
            }
            one.propagator.read_apart(k, x, w, clone, there);
            for (slot, sample) in samples().enumerate().filter(|(_, sample)| is_apart(nominal, sample)) {
                d[timeline.channel[sample] * self.width + column] = (there[slot] - still[slot]) / one.step;
            }
        }
    }

    /// D of the means of event `k` over the interval `of`, at fixed states of its ends.
    fn read_means(
        &mut self,
        (nominal, moved): (&mut Propagator<'_>, &mut [Moved<'_>]),
        (linear, k): (&Linear, usize),
        of: (f64, f64),
        (d, order): (&mut [f64], &[usize]),
    ) {
        let timeline = nominal.timeline;
        let event = timeline.events[k];
        let (x, w) = at(linear, k);
        let (from, still) = (self.clone.1, &mut self.y[0]);
        nominal.ends_behind((k, of.0), (x, w), (&self.clone.0, from), &mut self.ends);
        nominal.means_between((k, from), of, &self.ends, w);
        still.iter_mut().enumerate().for_each(|(channel, y)| *y = nominal.taken(channel));
        for (column, i) in order.iter().enumerate() {
            let one = &mut moved[*i];
            let reads = one.differs != Differs::InForces;
            if reads {
                one.propagator.means_between((k, from), of, &self.ends, w);
            }
            for sample in event.first..event.first + event.count {
                let channel = timeline.channel[sample];
                let own = || (nominal.behind(sample, channel), timeline.interval_s[sample]) == of;
                if nominal.is_mean(channel) && own() {
                    let found = if reads { (one.propagator.taken(channel) - still[channel]) / one.step } else { 0.0 };
                    d[channel * self.width + column] = found;
                }
            }
        }
    }

    /// Adds what forces do between the instants of a sample and its event.
    fn carry(
        &mut self,
        (linear, sample): (&Linear, usize),
        (k, behind): (usize, f64),
        (rates, interval): Along<'_>,
        out: &mut [f64],
    ) {
        if behind == 0.0 {
            return;
        }
        let (n, narrow, width) = (self.row.len(), self.narrow, self.width);
        let until = behind > 0.0;
        let b = if until && k > 0 { interval.b_end() } else { &self.b[..] };
        let begun = &self.begun[if until { 1 } else { 2 }];
        let len = linear.row_len();
        let whole = &linear.measurement[sample * len..(sample + 1) * len];
        let clone = &whole[linear.layout.lags_at()..];
        let Self { row, held, powers, .. } = self;
        let parts = [(&whole[..n], &rates.a[..], b), (clone, &self.begun[0][..], &begun[..])];
        for (own, a, b) in parts.into_iter().filter(|(own, ..)| !own.is_empty()) {
            row.copy_from_slice(own);
            wide(
                #[inline(always)]
                || {
                    carry_row(a, behind, row, held, powers);
                    held.iter_mut().for_each(|held| *held = -*held);
                    let forces = &held[n - b.len() / narrow..];
                    add_product(forces, forces.len(), (b, narrow), (out, width));
                },
            );
        }
    }
}

/// State and noise inputs at event `k`, before its update.
fn at(linear: &Linear, k: usize) -> (&[f64], &[f64]) {
    let m = linear.layout.noise_inputs.len();
    let n = linear.state_names.len();
    (&linear.states[k * n..(k + 1) * n], &linear.held[k * m..(k + 1) * m])
}
