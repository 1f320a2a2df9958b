//! Derivatives of rates and readings at one point, by residuals that share one factorisation.
//!
//! ```text
//! M = ∂r/∂a,   ∂a/∂(x, w) = −M⁻¹ ∂r/∂(x, w),   ∂y/∂(x, w) = ∂y/∂(x, w)|ₐ + ∂y/∂a ∂a/∂(x, w)
//! ```

use super::dense::{add_product, cholesky, solve};
use super::linear::STEP;
use super::propagator::{Point, Propagator};
use nalgebra::DMatrix;

/// Derivatives of the residual r (v) and of the readings y at a fixed acceleration, by rows.
#[derive(Clone, Debug)]
pub(super) struct Jacobian {
    /// Numbers of the state, of the noise inputs, of the accelerations, and of the readings.
    pub n: usize,
    pub m: usize,
    pub v: usize,
    pub channels: usize,
    /// Rows of x' above the accelerations, by x.
    rates: Vec<f64>,
    mass: Vec<f64>,
    r_x: Vec<f64>,
    r_w: Vec<f64>,
    y_a: Vec<f64>,
    y_x: Vec<f64>,
    y_w: Vec<f64>,
    /// Scratch: r, y, x, x' and a; a mass matrix.
    moved: [Vec<f64>; 5],
    there: DMatrix<f64>,
}

/// `x' = A x + B w`, `y = C x + D w` about a point, and what a force there makes.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    /// n × n and n × m.
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    /// channels × n and channels × m.
    pub c: Vec<f64>,
    pub d: Vec<f64>,
    /// Lower factor of M, and ∂y/∂a (channels × v).
    pub factor: Vec<f64>,
    pub y_a: Vec<f64>,
    there: DMatrix<f64>,
}

impl Jacobian {
    pub fn new(propagator: &Propagator<'_>, point: &Point) -> Self {
        let (n, m) = (point.x.len(), propagator.layout.noise_inputs.len());
        let (v, channels) = (point.at.len(), point.y.len());
        let zeros = |count: usize| vec![0.0; count];
        Self {
            n,
            m,
            v,
            channels,
            rates: zeros(point.at.start * n),
            mass: zeros(v * v),
            r_x: zeros(v * n),
            r_w: zeros(v * m),
            y_a: zeros(channels * v),
            y_x: zeros(channels * n),
            y_w: zeros(channels * m),
            moved: [zeros(v), zeros(channels), zeros(n), zeros(n), zeros(v)],
            there: DMatrix::zeros(v, v),
        }
    }

    /// At `point`, where `propagator` was placed; it is placed elsewhere behind it.
    ///
    /// Cost: a residual for each number of the state, the noise inputs and the accelerations.
    pub fn take(&mut self, propagator: &mut Propagator<'_>, point: &Point) {
        // what acts is linear in its command, unless a law feels it
        let command = if propagator.system.has_laws() { STEP } else { 1.0 };
        let [r, y, x, x_dot, a] = &mut self.moved;
        for column in 0..self.v {
            a.copy_from_slice(&point.x_dot[point.at.clone()]);
            a[column] += 1.0;
            propagator.at_acceleration(point, a, (r, y));
            put(&mut self.mass, (column, self.v), (r, &point.r), 1.0);
            put(&mut self.y_a, (column, self.v), (y, &point.y), 1.0);
        }
        for column in 0..self.m {
            propagator.at_input(point, (column, command), (r, y));
            put(&mut self.r_w, (column, self.m), (r, &point.r), command);
            put(&mut self.y_w, (column, self.m), (y, &point.y), command);
        }
        for column in 0..self.n {
            x.copy_from_slice(&point.x);
            x[column] += STEP;
            propagator.at_state(point, x, (r, y), x_dot);
            put(&mut self.rates, (column, self.n), (x_dot, &point.x_dot), STEP);
            put(&mut self.r_x, (column, self.n), (r, &point.r), STEP);
            put(&mut self.y_x, (column, self.n), (y, &point.y), STEP);
        }
    }
}

/// Change of the mass matrix, relative to the roots of its diagonal, from which derivatives are
/// taken anew behind an update: as much of a slope.
const MASS_CHANGE: f64 = 1e-4;

impl Jacobian {
    /// The mass matrix in state `x` is about that of here; `propagator` is placed nowhere behind
    /// it.
    pub fn serves(&mut self, propagator: &mut Propagator<'_>, x: &[f64]) -> bool {
        propagator.mass(x, &mut self.there);
        let v = self.v;
        let scale = |i: usize, j: usize| libm::sqrt(self.mass[i * v + i] * self.mass[j * v + j]);
        let near = |i: usize, j: usize| (self.there[(i, j)] - self.mass[i * v + j]).abs() <= MASS_CHANGE * scale(i, j);
        (0..v).all(|i| (0..=i).all(|j| near(i, j)))
    }
}

/// A difference as a column of a matrix of `width`, as many rows as it has.
pub(super) fn put(matrix: &mut [f64], (column, width): (usize, usize), (moved, still): (&[f64], &[f64]), step: f64) {
    for (row, (moved, still)) in matrix.chunks_exact_mut(width).zip(moved.iter().zip(still)) {
        row[column] = (moved - still) / step;
    }
}

impl Slopes {
    /// Room for those of `jacobian`.
    pub fn new(jacobian: &Jacobian) -> Self {
        let Jacobian { n, m, v, channels, .. } = *jacobian;
        let zeros = |count: usize| vec![0.0; count];
        Self {
            a: zeros(n * n),
            b: zeros(n * m),
            c: zeros(channels * n),
            d: zeros(channels * m),
            factor: zeros(v * v),
            y_a: zeros(channels * v),
            there: DMatrix::zeros(v, v),
        }
    }

    /// Of the mass matrix in state `x` itself, and the readings' share between two points; false
    /// where the mass is not positive. `propagator` is placed nowhere behind it.
    pub fn take_mass_at(
        &mut self,
        propagator: &mut Propagator<'_>,
        x: &[f64],
        ([begin, end], share): ([&Jacobian; 2], f64),
    ) -> bool {
        propagator.mass(x, &mut self.there);
        // symmetric: by columns as by rows
        self.factor.copy_from_slice(self.there.as_slice());
        between(&mut self.y_a, (&begin.y_a, &end.y_a), share);
        cholesky(&mut self.factor, begin.v)
    }

    /// Mass and readings' share alone, between two points; false where the mass is not positive.
    pub fn take_mass(&mut self, [begin, end]: [&Jacobian; 2], share: f64) -> bool {
        between(&mut self.factor, (&begin.mass, &end.mass), share);
        between(&mut self.y_a, (&begin.y_a, &end.y_a), share);
        cholesky(&mut self.factor, begin.v)
    }

    /// At a share of the way between two points; false where the mass is not positive.
    pub fn take(&mut self, points: [&Jacobian; 2], share: f64) -> bool {
        let [begin, end] = points;
        let Jacobian { n, m, v, .. } = *begin;
        if !self.take_mass(points, share) {
            return false;
        }
        let above = begin.rates.len();
        between(&mut self.a[..above], (&begin.rates, &end.rates), share);
        let acceleration = &mut self.a[above..];
        between(acceleration, (&begin.r_x, &end.r_x), share);
        solve(&self.factor, v, acceleration, n);
        acceleration.iter_mut().for_each(|a| *a = -*a);
        between(&mut self.c, (&begin.y_x, &end.y_x), share);
        add_product(&self.y_a, v, (acceleration, n), (&mut self.c, n));
        let acceleration = &mut self.b[(n - v) * m..];
        between(acceleration, (&begin.r_w, &end.r_w), share);
        solve(&self.factor, v, acceleration, m);
        acceleration.iter_mut().for_each(|b| *b = -*b);
        between(&mut self.d, (&begin.y_w, &end.y_w), share);
        add_product(&self.y_a, v, (acceleration, m), (&mut self.d, m));
        true
    }
}

/// Terms of an exponential over a part of an interval: ωh = 1 leaves 1/9! = 3e-6.
const TERMS: usize = 8;

/// What a row c by a state says of the state `h` \[s\] before under the rates `a` (n × n):
/// `c e^{A h}` in its place, and `c ∫₀ʰ e^{A s} ds` of rates held between.
#[inline(always)]
pub(super) fn carry_row(a: &[f64], h: f64, row: &mut [f64], held: &mut [f64], scratch: &mut [Vec<f64>; 2]) {
    let n = row.len();
    let [power, next] = scratch;
    power.copy_from_slice(row);
    held.fill(0.0);
    for term in 1..=TERMS {
        let share = h / term as f64;
        power.iter_mut().for_each(|power| *power *= share);
        held.iter_mut().zip(&*power).for_each(|(sum, power)| *sum += power);
        next.fill(0.0);
        add_product(power, n, (a, n), (next, n));
        core::mem::swap(power, next);
        row.iter_mut().zip(&*power).for_each(|(sum, power)| *sum += power);
    }
}

fn between(out: &mut [f64], (begin, end): (&[f64], &[f64]), share: f64) {
    out.iter_mut().zip(begin.iter().zip(end)).for_each(|(out, (a, b))| *out = a + share * (b - a));
}

/// Jacobians along a run: at an event and at the one before it.
pub(super) struct Along {
    point: Point,
    jacobians: [Jacobian; 2],
    /// At the event, and in the middle between both.
    pub here: Slopes,
    pub between: Slopes,
    /// Of `x' = A x + B w` at the beginning of means.
    pub begun: [Vec<f64>; 2],
}

impl Along {
    /// `None` where the plant has no residual, or more than held commands drives it.
    pub fn of(propagator: &Propagator<'_>) -> Option<Self> {
        let point = Point::of(propagator).filter(|_| propagator.is_driven_plainly())?;
        let jacobian = Jacobian::new(propagator, &point);
        let slopes = Slopes::new(&jacobian);
        let begun = [slopes.a.clone(), slopes.b.clone()];
        Some(Self { point, jacobians: [jacobian.clone(), jacobian], here: slopes.clone(), between: slopes, begun })
    }

    /// Means begin where it was taken last.
    pub fn begin_mean(&mut self) {
        self.begun[0].copy_from_slice(&self.here.a);
        self.begun[1].copy_from_slice(&self.here.b);
    }

    /// At the beginning of the interval behind event `k`: in state `x` under the noise `w`, where
    /// that is another plant than before the update.
    pub fn begin(&mut self, propagator: &mut Propagator<'_>, k: usize, x: &[f64], w: &[f64]) {
        if self.jacobians[1].serves(propagator, x) {
            return;
        }
        let event = propagator.timeline.events[k];
        self.point.x.copy_from_slice(x);
        propagator.place((event.t_s, event.row, w), &mut self.point);
        self.jacobians[1].take(propagator, &self.point);
    }

    /// Goes on to event `k` in state `x` under the noise `w`.
    ///
    /// # Errors
    /// The mass matrix is not positive.
    pub fn take(&mut self, propagator: &mut Propagator<'_>, k: usize, x: &[f64], w: &[f64]) -> Result<(), String> {
        let event = propagator.timeline.events[k];
        self.point.x.copy_from_slice(x);
        propagator.place((event.t_s, event.row, w), &mut self.point);
        self.jacobians.swap(0, 1);
        self.jacobians[1].take(propagator, &self.point);
        let [before, here] = &self.jacobians;
        let positive = self.here.take([here, here], 0.0) && (k == 0 || self.between.take([before, here], 0.5));
        positive.then_some(()).ok_or_else(|| format!("the mass matrix is not positive at {} s", event.t_s))
    }
}
