//! What every number does at one point, at a fixed state: to the rates and to the readings.

use super::{FOUR, Moved};
use crate::filter::dense::{add_product, solve};
use crate::filter::jacobian::Slopes;
use crate::filter::propagator::{Point, Propagator};
use crate::filter::wide::wide;

pub(super) struct Local {
    pub point: Point,
    /// Of every column its plant; the first `moving` of them move.
    pub order: Vec<usize>,
    moving: usize,
    /// Numbers in a row of columns, of all and of what moves.
    pub width: usize,
    pub narrow: usize,
    /// b where it was taken last (accelerations × narrow).
    pub b: Vec<f64>,
    r: Vec<f64>,
    y: Vec<f64>,
}

impl Local {
    pub fn new(moved: &[Moved<'_>], point: Point) -> Self {
        let moving = moved.iter().filter(|one| one.moves()).count();
        let (width, narrow) = (moved.len().max(1).next_multiple_of(FOUR), moving.max(1).next_multiple_of(FOUR));
        let mut order: Vec<usize> = (0..moved.len()).collect();
        order.sort_by_key(|i| !moved[*i].moves());
        let (r, y) = (vec![0.0; point.at.len()], vec![0.0; point.y.len()]);
        Self { b: vec![0.0; r.len() * narrow], point, order, moving, width, narrow, r, y }
    }

    /// Places the nominal plant.
    pub fn place(&mut self, nominal: &mut Propagator<'_>, at: (f64, usize, &[f64]), x: &[f64]) {
        self.point.x.copy_from_slice(x);
        nominal.place(at, &mut self.point);
    }

    /// `∂r/∂θ` and, where they are wanted, `∂y/∂θ` at the fixed acceleration (channels × width),
    /// where the nominal plant was placed.
    pub fn take(&mut self, nominal: &mut Propagator<'_>, moved: &mut [Moved<'_>], mut d: Option<&mut [f64]>) {
        let columns = if d.is_some() { self.order.len() } else { self.moving };
        // what only reads comes first: the others leave their forces behind
        for (column, i) in self.order[..columns].iter().enumerate().rev() {
            let one = &mut moved[*i];
            let y = d.is_some().then_some(&mut self.y[..]);
            nominal.beside((&mut one.propagator, one.differs), &self.point, (&mut self.r, y));
            let per = 1.0 / one.step;
            let put = |out: &mut [f64], width: usize, (moved, still): (&[f64], &[f64])| {
                for (row, (moved, still)) in out.chunks_exact_mut(width).zip(moved.iter().zip(still)) {
                    row[column] = (moved - still) * per;
                }
            };
            if let Some(d) = &mut d {
                put(d, self.width, (&self.y, &self.point.y));
            }
            if column < self.moving {
                put(&mut self.b, self.narrow, (&self.r, &self.point.r));
            }
        }
    }

    /// b from `∂r/∂θ`, and what it adds to the readings.
    pub fn finish(&mut self, mass: &Slopes, d: Option<&mut [f64]>) {
        let v = self.r.len();
        wide(
            #[inline(always)]
            || {
                solve(&mass.factor, v, &mut self.b, self.narrow);
                self.b.iter_mut().for_each(|b| *b = -*b);
                if let Some(d) = d {
                    add_product(&mass.y_a, v, (&self.b, self.narrow), (d, self.width));
                }
            },
        );
    }
}
