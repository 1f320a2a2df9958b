//! S along the run, event by event.

use super::apart::Apart;
use super::interval::Interval;
use super::local::Local;
use super::{Moved, Slopes};
use crate::filter::Linear;
use crate::filter::dense::add_product;
use crate::filter::jacobian::carry_row;
use crate::filter::propagator::Propagator;
use crate::filter::wide::wide;

pub(super) struct Recursion<'l> {
    linear: &'l Linear,
    order: Vec<usize>,
    width: usize,
    /// S (z × width), and its next rows of the state.
    s: Vec<f64>,
    next: Vec<f64>,
    /// D at the event (channels × width), of means over their interval.
    pub d: Vec<f64>,
    /// `∂ŷ` of the samples of the event.
    dy: Vec<f64>,
    /// Per channel, of its reading before the lag: when it was read last, and its sensitivities
    /// then, in the middle of the interval and at its end.
    read_s: Vec<f64>,
    from: Vec<f64>,
    middle: Vec<f64>,
    to: Vec<f64>,
    /// Channels with `middle` and `to`.
    bent: Vec<bool>,
    pub(super) apart: Apart,
    /// A row by x and by w, what it says of rates held, and room for its powers.
    row: Vec<f64>,
    by_w: Vec<f64>,
    held: Vec<f64>,
    powers: [Vec<f64>; 2],
    pub columns: Vec<Vec<f64>>,
}

impl<'l> Recursion<'l> {
    pub fn new(nominal: &Propagator<'_>, linear: &'l Linear, moved: &[Moved<'_>], local: &Local) -> Self {
        let (n, m, channels) = (local.point.x.len(), linear.layout.noise_inputs.len(), local.point.y.len());
        let zeros = |count: usize| vec![0.0; count];
        let readings = || zeros(channels * local.width);
        let mut s = zeros(linear.layout.len() * local.width);
        for (column, i) in local.order.iter().enumerate() {
            let one = &moved[*i];
            for (row, (there, here)) in one.propagator.x0.iter().zip(&nominal.x0).enumerate() {
                s[row * local.width + column] = (there - here) / one.step;
            }
        }
        Self {
            linear,
            order: local.order.clone(),
            width: local.width,
            s,
            next: zeros(n * local.width),
            d: readings(),
            dy: readings(),
            read_s: vec![f64::NAN; channels],
            from: readings(),
            middle: readings(),
            to: readings(),
            bent: vec![false; channels],
            apart: Apart::new(nominal, local),
            row: zeros(n),
            by_w: zeros(m),
            held: zeros(n),
            powers: [zeros(n), zeros(n)],
            columns: vec![zeros(nominal.timeline.value.len()); moved.len()],
        }
    }

    /// Finds the lags of event `k` that take in a parabola; whether there is one.
    pub fn lags_behind(&mut self, nominal: &Propagator<'_>, k: usize) -> bool {
        let event = nominal.timeline.events[k];
        self.bent.fill(false);
        for sample in event.first..event.first + event.count {
            let channel = nominal.timeline.channel[sample];
            let lags = self.linear.layout.lag_of[channel].is_some();
            let last_s = self.read_s[channel];
            let at_once = nominal.timeline.events[k - 1].t_s <= last_s;
            self.bent[channel] = lags && at_once && nominal.lag_is_bent(k, channel, last_s);
        }
        self.bent.iter().any(|bent| *bent)
    }

    /// From event `k − 1` to event `k`.
    pub fn move_on(&mut self, nominal: &Propagator<'_>, k: usize, (interval, slopes): (&Interval, &Slopes)) {
        let half_s = 0.5 * (nominal.timeline.events[k].t_s - nominal.timeline.events[k - 1].t_s);
        wide(
            #[inline(always)]
            || {
                self.read_middle(half_s, (interval, slopes));
                self.propagate(k - 1, interval);
                self.read_end(nominal, k, interval);
            },
        );
    }

    /// `C (e^{A h} S + …) + D` in the middle, h half the interval, by the rows of C.
    #[inline(always)]
    fn read_middle(&mut self, half_s: f64, (interval, slopes): (&Interval, &Slopes)) {
        let (n, m, width) = (self.row.len(), self.by_w.len(), self.width);
        let Self { row, by_w, held, powers, .. } = self;
        for channel in (0..self.bent.len()).filter(|channel| self.bent[*channel]) {
            row.copy_from_slice(&slopes.c[channel * n..(channel + 1) * n]);
            by_w.copy_from_slice(&slopes.d[channel * m..(channel + 1) * m]);
            let out = &mut self.middle[channel * width..(channel + 1) * width];
            out.copy_from_slice(&interval.d_middle[channel * width..(channel + 1) * width]);
            add_product(row, n, (&interval.g_middle, interval.narrow), (out, width));
            carry_row(&slopes.a, half_s, row, held, powers);
            add_product(row, n, (&self.s, width), (out, width));
            if m > 0 {
                add_product(held, n, (&slopes.b, m), (by_w, m));
                add_product(by_w, m, (&self.s[n * width..], width), (out, width));
            }
        }
    }

    #[inline(always)]
    fn propagate(&mut self, k: usize, interval: &Interval) {
        let (n, width) = (self.row.len(), self.width);
        let len = n + self.by_w.len();
        for (next, g) in self.next.chunks_exact_mut(width).zip(interval.g.chunks_exact(interval.narrow)) {
            next[..g.len()].copy_from_slice(g);
            next[g.len()..].fill(0.0);
        }
        let transition = &self.linear.transition[k * n * len..(k + 1) * n * len];
        add_product(transition, len, (&self.s, width), (&mut self.next, width));
        self.s[..n * width].copy_from_slice(&self.next);
    }

    /// Readings at the end of the interval, under what acted until then.
    #[inline(always)]
    fn read_end(&mut self, nominal: &Propagator<'_>, k: usize, interval: &Interval) {
        let (event, width) = (nominal.timeline.events[k], self.width);
        let row_len = self.linear.row_len();
        for sample in event.first..event.first + event.count {
            let channel = nominal.timeline.channel[sample];
            if self.bent[channel] {
                let out = &mut self.to[channel * width..(channel + 1) * width];
                out.copy_from_slice(&interval.d[channel * width..(channel + 1) * width]);
                let row = &self.linear.measurement[sample * row_len..sample * row_len + self.linear.layout.lags_at()];
                add_product(row, row.len(), (&self.s, width), (out, width));
            }
        }
    }

    /// The readings of event `k`, and their update.
    pub fn take_up(
        &mut self,
        (nominal, moved): (&mut Propagator<'_>, &mut [Moved<'_>]),
        k: usize,
        (rates, interval): (&Slopes, &Interval),
    ) {
        let event = nominal.timeline.events[k];
        let (layout, n, width) = (&self.linear.layout, self.row.len(), self.width);
        for (i, input) in layout.noise_inputs.iter().enumerate() {
            if event.reset >> input.min(&63) & 1 == 1 {
                self.s[(n + i) * width..(n + i + 1) * width].fill(0.0);
            }
        }
        if event.count > 0 {
            let (linear, order) = (self.linear, &self.order[..]);
            self.apart.read((nominal, moved), (linear, k), (rates, interval), (&mut self.d, order));
            wide(
                #[inline(always)]
                || self.read(nominal, k),
            );
            for slot in 0..event.count {
                let dy = &self.dy[slot * width..];
                self.order.iter().zip(dy).for_each(|(i, dy)| self.columns[*i][event.first + slot] = *dy);
            }
            let dy = &mut self.dy[..event.count * width];
            dy.iter_mut().for_each(|dy| *dy = -*dy);
            let frozen = &self.linear.frozen;
            let gain = &frozen.gain[frozen.first[k]..][..frozen.rows * event.count];
            let s = &mut self.s;
            wide(
                #[inline(always)]
                || add_product(gain, event.count, (dy, width), (s, width)),
            );
        }
        if event.begins_mean {
            if layout.clone > 0 {
                self.s.copy_within(..n * width, layout.clone_at() * width);
            }
            self.apart.begin_mean(self.linear, k, (rates, interval));
        }
    }

    /// `∂ŷ` of the samples of event `k`; lags move on.
    #[inline(always)]
    fn read(&mut self, nominal: &Propagator<'_>, k: usize) {
        let (event, width, layout) = (nominal.timeline.events[k], self.width, &self.linear.layout);
        let (row_len, before) = (self.linear.row_len(), layout.lags_at());
        for slot in 0..event.count {
            let sample = event.first + slot;
            let channel = nominal.timeline.channel[sample];
            let out = &mut self.dy[slot * width..(slot + 1) * width];
            let own = channel * width..(channel + 1) * width;
            if nominal.is_uninformative(k, channel) {
                out.fill(0.0);
                continue;
            }
            out.copy_from_slice(&self.d[own.clone()]);
            let (row, clone) = self.linear.measurement[sample * row_len..(sample + 1) * row_len].split_at(before);
            add_product(row, before, (&self.s, width), (out, width));
            if !clone.is_empty() {
                add_product(clone, clone.len(), (&self.s[layout.clone_at() * width..], width), (out, width));
            }
            let Some(place) = layout.lag_of[channel] else { continue };
            let h_s = event.t_s - self.read_s[channel];
            let lag = (layout.lags_at() + place) * width;
            let lag = &mut self.s[lag..lag + width];
            if h_s.is_nan() {
                lag.copy_from_slice(out);
            } else if h_s > 0.0 {
                let [kept, from, middle, to] = nominal.lag_shares(channel, h_s);
                let taken = |lag: &mut f64, [begin, mid, end]: [f64; 3]| {
                    *lag = kept * *lag + from * begin + middle * mid + to * end;
                };
                let begin = &self.from[own.clone()];
                if self.bent[channel] {
                    let (between, last) = (&self.middle[own.clone()], &self.to[own.clone()]);
                    for ((lag, begin), (mid, end)) in lag.iter_mut().zip(begin).zip(between.iter().zip(last)) {
                        taken(lag, [*begin, *mid, *end]);
                    }
                } else {
                    for ((lag, begin), end) in lag.iter_mut().zip(begin).zip(&*out) {
                        taken(lag, [*begin, 0.5 * (begin + end), *end]);
                    }
                }
            }
            self.from[own].copy_from_slice(out);
            out.copy_from_slice(lag);
            self.read_s[channel] = event.t_s;
        }
    }
}
