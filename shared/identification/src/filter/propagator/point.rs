//! The equations at one point of a run, of this plant and of plants beside it: residuals at the
//! acceleration that was found.

use super::Propagator;
use core::ops::Range;
use dynamics::system::Differs;
use nalgebra::DMatrix;

/// A point of a trajectory: rates x' of its state, readings y before lags, and what rounding leaves
/// of the residual r at its acceleration.
#[derive(Clone, Debug)]
pub struct Point {
    pub t_s: f64,
    pub x: Vec<f64>,
    pub x_dot: Vec<f64>,
    pub r: Vec<f64>,
    pub y: Vec<f64>,
    /// Accelerations in x'.
    pub at: Range<usize>,
}

impl Point {
    /// Room for the points of `propagator`; `None` where its plant has no residual
    /// ([`dynamics::system::System::accelerations`]).
    pub fn of(propagator: &Propagator<'_>) -> Option<Self> {
        let at = propagator.system.accelerations()?;
        let (states, sensors) = (propagator.x0.len(), propagator.sensors.len());
        let zeros = |count: usize| vec![0.0; count];
        Some(Self { t_s: 0.0, x: zeros(states), x_dot: zeros(states), r: zeros(at.len()), y: zeros(sensors), at })
    }

    fn acceleration(&self) -> &[f64] {
        &self.x_dot[self.at.clone()]
    }
}

impl Propagator<'_> {
    /// Places this plant in state `point.x` at `t_s` under the inputs of `row` and the noise `w`.
    pub fn place(&mut self, (t_s, row, w): (f64, usize, &[f64]), point: &mut Point) {
        self.load(row, w);
        self.evaluations += 2;
        point.t_s = t_s;
        let Self { system, ws, u, .. } = self;
        system.derivative(ws, t_s, &point.x, u, &mut point.x_dot);
        let Point { x, x_dot, r, y, at, .. } = point;
        system.residual(ws, t_s, (x, u, &x_dot[at.clone()]), r);
        system.readings_in_place(ws, t_s, x, y);
    }

    /// Mass matrix in state `x`; this plant is placed nowhere behind it.
    pub fn mass(&mut self, x: &[f64], mass: &mut DMatrix<f64>) {
        self.evaluations += 1;
        let Self { system, ws, u, .. } = self;
        system.mass(ws, x, u, mass);
    }

    /// The same under the inputs as event `k` begins its stretch.
    pub fn mass_at(&mut self, k: usize, x: &[f64], mass: &mut DMatrix<f64>) {
        self.load(self.timeline.events[k].row, &[]);
        self.mass(x, mass);
    }

    /// A step of integration of length `h` under the inputs of where this plant was last placed.
    pub fn step(&mut self, t_s: f64, h: f64, x: &mut [f64]) {
        self.integrate(t_s, h, x, None);
    }

    /// Residual, where this plant was last placed, of a plant beside it that differs so, at the
    /// same state and acceleration; and its readings, where they are wanted.
    pub fn beside(
        &mut self,
        (other, differs): (&mut Propagator<'_>, Differs),
        point: &Point,
        (r, y): (&mut [f64], Option<&mut [f64]>),
    ) {
        let (t_s, arguments) = (point.t_s, (&point.x[..], &self.u[..], point.acceleration()));
        let Propagator { system, ws: own, .. } = other;
        let ws = if differs == Differs::InPoses { own } else { &mut self.ws };
        match differs {
            Differs::InReadings => r.copy_from_slice(&point.r),
            Differs::InForces => system.residual_in_place(ws, t_s, arguments, r),
            Differs::InPoses => system.residual(ws, t_s, arguments, r),
        }
        if let Some(y) = y {
            system.readings_in_place(ws, t_s, &point.x, y);
        }
        self.evaluations += usize::from(differs != Differs::InReadings);
    }

    /// Residual and readings at another acceleration `a`, where this plant was last placed.
    pub fn at_acceleration(&mut self, point: &Point, a: &[f64], (r, y): (&mut [f64], &mut [f64])) {
        self.evaluations += 1;
        let Self { system, ws, u, .. } = self;
        system.residual_in_place(ws, point.t_s, (&point.x, u, a), r);
        system.readings_in_place(ws, point.t_s, &point.x, y);
    }

    /// The same at the acceleration of `point` with one noise input changed.
    pub fn at_input(&mut self, point: &Point, (input, change): (usize, f64), (r, y): (&mut [f64], &mut [f64])) {
        self.evaluations += 1;
        let before = self.u[self.layout.noise_inputs[input]];
        self.u[self.layout.noise_inputs[input]] += change;
        let Self { system, ws, u, .. } = self;
        system.residual_in_place(ws, point.t_s, (&point.x, u, point.acceleration()), r);
        system.readings_in_place(ws, point.t_s, &point.x, y);
        self.u[self.layout.noise_inputs[input]] = before;
    }

    /// The same in another state `x`, which this plant is placed in; the rates of its positions
    /// join `x_dot`.
    pub fn at_state(&mut self, point: &Point, x: &[f64], (r, y): (&mut [f64], &mut [f64]), x_dot: &mut [f64]) {
        self.evaluations += 1;
        let Self { system, ws, u, .. } = self;
        system.residual(ws, point.t_s, (x, u, point.acceleration()), r);
        system.readings_in_place(ws, point.t_s, x, y);
        system.rates_in_place(ws, x_dot);
    }

    /// The noise inputs and the timeline's rows are all that drives, on no motion; only then
    /// points say all.
    pub fn is_driven_plainly(&self) -> bool {
        !self.timeline.moving && self.rows.is_empty() && self.tilts.is_empty()
    }

    /// Readings of `channel` are no means, and of the instants of their stamps.
    pub fn is_instant(&self, channel: usize) -> bool {
        !self.sensors[channel].mean && !self.is_shifted(channel)
    }

    /// Readings of `channel` are of instants off their stamps.
    pub fn is_shifted(&self, channel: usize) -> bool {
        self.sensors[channel].shifted(self.timeline.shift_s[channel])
    }

    /// Every channel is stamped and delayed as in `other`.
    pub fn is_timed_as(&self, other: &Propagator<'_>) -> bool {
        let same = |(a, b): (&super::Channel, &super::Channel)| {
            (a.offset_s, a.skew, a.delay_s) == (b.offset_s, b.skew, b.delay_s)
        };
        self.sensors.iter().zip(&other.sensors).all(same)
    }

    /// Parts of the output of a lag after `h_s` that its old output and its input at the beginning,
    /// in the middle and at the end of the interval have.
    pub fn lag_shares(&self, channel: usize, h_s: f64) -> [f64; 4] {
        use dynamics::lags::LagState;
        let Some(lag) = &self.sensors[channel].lag else { return [0.0, 0.0, 0.0, 1.0] };
        let arc = |output: f64, input: [f64; 3]| lag.arc(&mut LagState::settled(output), input, h_s);
        [arc(1.0, [0.0; 3]), arc(0.0, [1.0, 0.0, 0.0]), arc(0.0, [0.0, 1.0, 0.0]), arc(0.0, [0.0, 0.0, 1.0])]
    }
}
