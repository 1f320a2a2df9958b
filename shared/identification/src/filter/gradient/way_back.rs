//! The way back over a run: r, N and g, and the slopes that each sample and each fresh noise adds.

use super::{Gradient, Slope};
use crate::filter::noise_model::WHITE_SHARE;
use crate::filter::recursion::Tape;
use crate::filter::rows::{QUAD, Row, add, combine, product};
use crate::filter::{Layout, Linear, NoiseModel};
use crate::problem::{Event, Timeline};

/// Rows of a sum that are taken at a time.
const SHARES: usize = 32;

/// What goes back: r and, for every channel without a colour, g; and N.
pub(super) struct Back<R> {
    layout: Layout,
    size: usize,
    /// r, then g of every channel.
    vectors: Vec<R>,
    n: Vec<R>,
    /// `F` by rows of the state, `N F` of those rows, scratch.
    f: Vec<R>,
    moved: Vec<R>,
    spare: R,
    q: R,
    /// u and D of the sample of every channel behind.
    behind: Vec<Option<(f64, f64)>>,
    pub(super) found: Gradient,
}

impl<R: Row> Back<R> {
    pub(super) fn new(layout: Layout, noise: &NoiseModel) -> Self {
        let size = layout.len();
        let zeros = |count: usize| (0..count).map(|_| R::zeros(size.next_multiple_of(QUAD))).collect::<Vec<R>>();
        let channels = noise.sensor_sigma.len();
        let [vectors, n, f, moved] = [1 + channels, size, layout.tangent, layout.tangent].map(zeros);
        let [q, spare] = [(); 2].map(|()| R::zeros(size.next_multiple_of(QUAD)));
        let found = Gradient::zeros(noise.input_sigma.len(), channels);
        Self { layout, size, vectors, n, f, moved, spare, q, behind: vec![None; channels], found }
    }

    #[inline(always)]
    pub(super) fn go(
        &mut self,
        (linear, timeline, noise): (&Linear, &Timeline, &NoiseModel),
        (tape, white): (&Tape, &[f64]),
        means: &[f64],
    ) {
        let (n, stride, row_len) = (self.layout.tangent, self.size.next_multiple_of(QUAD), linear.row_len());
        let len = n + self.layout.noise_inputs.len();
        let mut colour = means.len();
        for (k, event) in timeline.events.iter().enumerate().rev() {
            if k + 1 < timeline.events.len() {
                self.propagate(&linear.transition[k * n * len..(k + 1) * n * len]);
            }
            if event.begins_mean {
                self.begin_mean();
            }
            let samples = event.first..event.first + event.count;
            for sample in samples.clone().rev() {
                let own = sample * stride..(sample + 1) * stride;
                let (h, v) = (&tape.h[own.clone()], &tape.v[own]);
                let channel = timeline.channel[sample];
                self.absorb(noise, (channel, linear.slope[sample]), (h, v, tape.root[sample]), white[sample]);
            }
            for sample in samples.rev() {
                let channel = timeline.channel[sample];
                let row = &linear.measurement[sample * row_len..(sample + 1) * row_len];
                self.lag(channel, row, linear.decay[sample]);
                if self.layout.colour_of[channel].is_some() {
                    colour -= 1;
                    let column = &tape.colour[colour * stride..(colour + 1) * stride];
                    self.colour(noise, channel, (means[colour], column));
                }
            }
            self.renew(event, noise);
        }
    }

    /// One sample: slopes of its size, jitter and pole, then r, g and N before it.
    #[inline(always)]
    fn absorb(
        &mut self,
        noise: &NoiseModel,
        (channel, slope): (usize, f64),
        (h, v, root): (&[f64], &[f64], f64),
        e: f64,
    ) {
        let share = 1.0 / root;
        let u = (e - product(v, self.vectors[0].numbers())) * share;
        self.q.numbers_mut().fill(0.0);
        combine(self.q.numbers_mut(), &v[..self.size], &self.n);
        for q in self.q.numbers_mut() {
            *q *= share;
        }
        let d = share * share + share * product(v, self.q.numbers());
        let has_colour = self.layout.colour_of[channel].is_some();
        let sigma = noise.sensor_sigma[channel];
        let white = if has_colour { WHITE_SHARE * sigma } else { sigma };
        let early = noise.jitter_s[channel] * slope;
        self.found.sensor[channel] += Slope::of_variance(white * white, d, u);
        self.found.jitter[channel] += Slope::of_variance(early * early, d, u);
        let (r, g) = self.vectors.split_at_mut(1);
        if !has_colour && let Some((u_behind, d_behind)) = self.behind[channel].replace((u, d)) {
            let both = -share * product(v, g[channel].numbers());
            let variance = sigma * sigma;
            self.found.pole[channel] += Slope {
                first: -2.0 * variance * (u * u_behind - both),
                second: 2.0 * variance * variance * (d * d_behind + both * both),
            };
        }
        for (g, _) in g.iter_mut().zip(&self.behind).filter(|(_, behind)| behind.is_some()) {
            let weight = -share * product(v, g.numbers());
            add(g.numbers_mut(), weight, h);
        }
        if !has_colour {
            for ((g, h), q) in g[channel].numbers_mut().iter_mut().zip(h).zip(self.q.numbers()) {
                *g = d * h - q;
            }
        }
        add(r[0].numbers_mut(), u, h);
        for (i, row) in self.n.iter_mut().enumerate() {
            let (h_i, q_i) = (h[i], self.q.numbers()[i]);
            let along_h = d * h_i - q_i;
            for ((n, h), q) in row.numbers_mut().iter_mut().zip(h).zip(self.q.numbers()) {
                *n += along_h * h - h_i * q;
            }
        }
    }

    /// `Fᵀ r`, `Fᵀ N F`, F the identity but for the rows of the state.
    #[inline(always)]
    fn propagate(&mut self, transition: &[f64]) {
        let n = self.layout.tangent;
        let len = n + self.layout.noise_inputs.len();
        for (f, row) in self.f.iter_mut().zip(transition.chunks_exact(len.max(1))) {
            f.numbers_mut()[..len].copy_from_slice(row);
        }
        let (f, moved) = (&self.f, &mut self.moved);
        let through = |row: &[f64], sum: &mut [f64]| {
            sum[..n].fill(0.0);
            sum[n..].copy_from_slice(&row[n..]);
            combine(sum, &row[..n], f);
        };
        // r, and every g that has begun
        let begun = core::iter::once(true).chain(self.behind.iter().map(Option::is_some));
        for (vector, _) in self.vectors.iter_mut().zip(begun).filter(|(_, begun)| *begun) {
            through(vector.numbers(), self.spare.numbers_mut());
            core::mem::swap(vector, &mut self.spare);
        }
        for (moved, row) in moved.iter_mut().zip(&self.n) {
            through(row.numbers(), moved.numbers_mut());
        }
        let mut shares = [0.0; SHARES];
        for b in 0..len {
            let sum = self.spare.numbers_mut();
            if b < n {
                sum.fill(0.0);
            } else {
                through(self.n[b].numbers(), sum);
            }
            for (first, moved) in moved.chunks(SHARES).enumerate() {
                let rows = transition[first * SHARES * len..].chunks_exact(len);
                shares.iter_mut().zip(rows).for_each(|(share, row)| *share = row[b]);
                combine(sum, &shares[..moved.len()], moved);
            }
            core::mem::swap(&mut self.n[b], &mut self.spare);
        }
        self.mirror(len);
    }

    /// Every row gets its first numbers, at most `len`, from the rows before it. Samples take
    /// nothing off what rounding leaves between the two: it would grow as the plant does without a
    /// filter.
    #[inline(always)]
    fn mirror(&mut self, len: usize) {
        for at in 1..self.size {
            let (before, own) = self.n.split_at_mut(at);
            for (own, row) in own[0].numbers_mut().iter_mut().zip(before.iter().take(len)) {
                *own = row.numbers()[at];
            }
        }
    }

    /// What the clone meant the state means.
    #[inline(always)]
    fn begin_mean(&mut self) {
        let (count, at) = (self.layout.clone, self.layout.clone_at());
        for i in 0..count {
            self.fold(at + i, i, 1.0);
            self.scale(at + i, 0.0);
        }
    }

    /// What the lag took in meant as much of the state.
    #[inline(always)]
    fn lag(&mut self, channel: usize, row: &[f64], decay: f64) {
        let Some(place) = self.layout.lag_of[channel] else { return };
        let at = self.layout.lags_at() + place;
        let (before, clone_at) = (self.layout.lags_at(), self.layout.clone_at());
        for (i, h) in row.iter().enumerate() {
            let i = if i < before { i } else { clone_at + i - before };
            self.fold(at, i, (1.0 - decay) * h);
        }
        self.scale(at, decay);
    }

    #[inline(always)]
    fn colour(&mut self, noise: &NoiseModel, channel: usize, (mean, column): (f64, &[f64])) {
        let Some(place) = self.layout.colour_of[channel] else { return };
        let (at, a) = (self.layout.colours_at() + place, noise.pole[channel]);
        let variance = noise.sensor_sigma[channel].powi(2);
        let (r, n) = (self.vectors[0].numbers()[at], self.n[at].numbers()[at]);
        if column[at] == 0.0 {
            self.found.sensor[channel] += Slope::of_variance(variance, n, r);
            self.scale(at, 0.0);
            return;
        }
        self.found.sensor[channel] += Slope::of_variance((1.0 - a * a) * variance, n, r);
        let moved = |j: usize| if j == at { a * column[j] } else { column[j] };
        let (own, all) = (self.n[at].numbers(), self.vectors[0].numbers());
        let both: f64 = (0..self.size).map(|j| (r * all[j] - own[j]) * moved(j)).sum();
        let along = -2.0 * (r * mean + both) - 2.0 * a * variance * (n - r * r);
        // of a colour that is seen by itself, its size held
        self.found.pole[channel] += Slope { first: (1.0 - a * a) * along, second: 2.0 * (1.0 + a * a) };
        self.scale(at, a);
    }

    /// Fresh noise of the actuators.
    #[inline(always)]
    fn renew(&mut self, event: &Event, noise: &NoiseModel) {
        for k in 0..self.layout.noise_inputs.len() {
            let input = self.layout.noise_inputs[k].min(63);
            if event.reset >> input & 1 == 1 {
                let at = self.layout.noise_at() + k;
                let (r, n) = (self.vectors[0].numbers()[at], self.n[at].numbers()[at]);
                if event.quiet >> input & 1 == 0 {
                    self.found.input[k] += Slope::of_variance(noise.input_sigma[k].powi(2), n, r);
                }
                self.scale(at, 0.0);
            }
        }
    }

    /// The number at `to` meant `share` of the one at `from`, too.
    #[inline(always)]
    fn fold(&mut self, from: usize, to: usize, share: f64) {
        if share == 0.0 {
            return;
        }
        for vector in &mut self.vectors {
            vector.numbers_mut()[to] += share * vector.numbers()[from];
        }
        let row = self.n[from].taken();
        add(self.n[to].numbers_mut(), share, row.numbers());
        self.n[from] = row;
        for row in &mut self.n {
            row.numbers_mut()[to] += share * row.numbers()[from];
        }
    }

    /// The number at `at` meant `share` of what it means behind.
    #[inline(always)]
    fn scale(&mut self, at: usize, share: f64) {
        for vector in &mut self.vectors {
            vector.numbers_mut()[at] *= share;
        }
        for n in self.n[at].numbers_mut() {
            *n *= share;
        }
        for row in &mut self.n {
            row.numbers_mut()[at] *= share;
        }
    }
}
