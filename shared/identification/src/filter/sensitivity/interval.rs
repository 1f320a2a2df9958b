//! What every number does over the interval between two events, by the Runge–Kutta method on
//! `g' = A g + b` from zero.

use super::Moved;
use super::local::Local;
use crate::filter::Linear;
use crate::filter::dense::add_product;
use crate::filter::jacobian::{Jacobian, Slopes};
use crate::filter::propagator::Propagator;
use crate::filter::wide::wide;
use crate::problem::Event;

pub(super) struct Interval {
    n: usize,
    pub narrow: usize,
    /// Changes of the state at the end and in the middle (n × narrow).
    pub g: Vec<f64>,
    pub g_middle: Vec<f64>,
    /// D at the end, under what acted until then, and in the middle (channels × width).
    pub d: Vec<f64>,
    pub d_middle: Vec<f64>,
    /// b at the beginning, in the middle and at the end of a step.
    b: [Vec<f64>; 3],
    /// A slope, the state that the next one is taken at, and their sum.
    stages: [Vec<f64>; 3],
    /// States at the beginning and the end of a step and in its middle, and rates there.
    x: [Vec<f64>; 3],
    rates: [Vec<f64>; 3],
}

/// One interval: its event, noise inputs held over it, Jacobians at both ends.
pub(super) struct Stretch<'a> {
    pub event: Event,
    pub w: &'a [f64],
    pub jacobians: [&'a Jacobian; 2],
    length_s: f64,
}

impl<'a> Stretch<'a> {
    /// Behind event `k` of a run.
    pub fn new(nominal: &Propagator<'_>, linear: &'a Linear, k: usize, jacobians: [&'a Jacobian; 2]) -> Self {
        let (event, m) = (nominal.timeline.events[k], linear.layout.noise_inputs.len());
        let w = &linear.held_updated[k * m..(k + 1) * m];
        Self { event, w, jacobians, length_s: event.step_s * event.steps as f64 }
    }
}

impl Interval {
    pub fn new(local: &Local) -> Self {
        let (n, narrow, channels) = (local.point.x.len(), local.narrow, local.point.y.len());
        let zeros = |count: usize| vec![0.0; count];
        let readings = || zeros(channels * local.width);
        Self {
            n,
            narrow,
            g: zeros(n * narrow),
            g_middle: zeros(n * narrow),
            d: readings(),
            d_middle: readings(),
            b: [(); 3].map(|()| local.b.clone()),
            stages: [(); 3].map(|()| zeros(n * narrow)),
            x: [(); 3].map(|()| zeros(n)),
            rates: [(); 3].map(|()| zeros(n)),
        }
    }

    /// b at the end, under what acted until then (accelerations × narrow).
    pub fn b_end(&self) -> &[f64] {
        &self.b[2]
    }

    /// From state `x` over a stretch in `steps`, with its `d` where it `reads`; false where the
    /// mass matrix is not positive.
    pub fn take(
        &mut self,
        (nominal, moved): (&mut Propagator<'_>, &mut [Moved<'_>]),
        (local, slopes, mass): (&mut Local, &Slopes, &mut Slopes),
        (stretch, x, (steps, reads)): (&Stretch<'_>, &[f64], (usize, bool)),
    ) -> bool {
        let (begin_s, h) = (stretch.event.t_s, stretch.length_s / steps as f64);
        let [from, to, middle] = &mut self.x;
        let [b_begin, b_middle, b_end] = &mut self.b;
        let [rates, rates_end, rates_middle] = &mut self.rates;
        let mut at = |nominal: &mut Propagator<'_>,
                      (t_s, x): (f64, &[f64]),
                      [b, x_dot]: [&mut Vec<f64>; 2],
                      mut d: Option<&mut [f64]>| {
            let share = (t_s - begin_s) / stretch.length_s;
            let solved = mass.take_mass_at(nominal, x, (stretch.jacobians, share));
            local.place(nominal, (t_s, stretch.event.row, stretch.w), x);
            local.take(nominal, moved, d.as_deref_mut());
            if solved {
                local.finish(mass, d);
                b.copy_from_slice(&local.b);
                x_dot.copy_from_slice(&local.point.x_dot);
            }
            solved.then_some(())
        };
        let mut go = || -> Option<()> {
            from.copy_from_slice(x);
            self.g.fill(0.0);
            at(nominal, (begin_s, from), [b_end, rates_end], None)?;
            for step in 0..steps {
                let t_s = begin_s + h * step as f64;
                core::mem::swap(b_begin, b_end);
                core::mem::swap(rates, rates_end);
                to.copy_from_slice(from);
                nominal.step(t_s, h, to);
                let read = 2 * (step + 1) == steps || step + 1 == steps;
                let d = (reads && read).then_some(&mut self.d[..]);
                at(nominal, (t_s + h, to), [b_end, rates_end], d)?;
                // Hermite's cubic
                let ends = from.iter().zip(&*to).zip(rates.iter().zip(&*rates_end));
                for (middle, ((from, to), (begin, end))) in middle.iter_mut().zip(ends) {
                    *middle = 0.5 * (from + to) + 0.125 * h * (begin - end);
                }
                at(nominal, (t_s + 0.5 * h, middle), [b_middle, rates_middle], None)?;
                core::mem::swap(from, to);
                let b = [&b_begin[..], &b_middle[..], &b_end[..]];
                let (g, stages, width) = (&mut self.g[..], &mut self.stages, self.narrow);
                wide(
                    #[inline(always)]
                    || advance((&slopes.a, self.n), h, b, (g, width), stages),
                );
                if 2 * (step + 1) == steps {
                    self.g_middle.copy_from_slice(&self.g);
                    self.d_middle.copy_from_slice(&self.d);
                }
            }
            Some(())
        };
        go().is_some()
    }
}

/// One step of length `h`: `g' = A g + b`, b at its beginning, in its middle and at its end, in the
/// last rows.
#[inline(always)]
fn advance(
    (a, n): (&[f64], usize),
    h: f64,
    [begin, middle, end]: [&[f64]; 3],
    (g, width): (&mut [f64], usize),
    [k, at, sum]: &mut [Vec<f64>; 3],
) {
    let above = g.len() - begin.len();
    sum.fill(0.0);
    at.copy_from_slice(g);
    for (b, weight, next) in [(begin, 1.0, 0.5), (middle, 2.0, 0.5), (middle, 2.0, 1.0), (end, 1.0, 0.0)] {
        k[..above].fill(0.0);
        k[above..].copy_from_slice(b);
        add_product(a, n, (at, width), (k, width));
        for ((sum, k), (at, g)) in sum.iter_mut().zip(&*k).zip(at.iter_mut().zip(&*g)) {
            *sum += weight * k;
            *at = g + next * h * k;
        }
    }
    g.iter_mut().zip(&*sum).for_each(|(g, sum)| *g += h / 6.0 * sum);
}
