//! Sloshing propellant in the plane: a free hub, slosh masses on springs, on a rail, or as
//! pendulums, off its centre.
//!
//! Body axes, origin at the centre of mass of the hub alone; `q_i` place of slosh mass i,
//! `w_i = ẑ × q_i`, `P_i` what of its acceleration the hub prescribes (zero for a mass free in the
//! plane, `1 − u u'` for one that moves along `u`):
//!
//! ```text
//! A_i = P_i (a + ω̇ w_i + 2ω ẑ×q̇_i − ω² q_i + J̇_i ṡ_i) + u_i F_i/m_i          acceleration of the mass
//! m0 a + Σ m_i A_i = f,      I0 ω̇ + Σ m_i w_i·A_i = τ                          the force acts at q_i, not at the tank
//! acceleration at s: a + ω̇ ẑ×s − ω² s,      rate: ω
//! ```
//!
//! Position and attitude leave no trace, so the state is `[ω, s, ṡ]` alone. Runge–Kutta of fourth
//! order over each sample: its error (ω dt)⁵/120 per step is hidden by any noise. Units: SI.

use libm::{cos, sin};
use nalgebra::{Vector2, Vector3};

/// What is known of the craft without its propellant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarHub {
    pub mass_kg: f64,
    pub inertia_com_kg_m2: f64,
    /// From the centre of mass to the accelerometer.
    pub sensor_m: Vector2<f64>,
}

/// How a slosh mass hangs on the hub.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspension {
    /// Free in the plane about `position_m`; stiffness and damping along x and y.
    Springs { position_m: Vector2<f64>, stiffness_n_m: Vector2<f64>, damping_n_s_m: Vector2<f64> },
    /// Along one unit vector.
    Rail { position_m: Vector2<f64>, direction: Vector2<f64>, stiffness_n_m: f64, damping_n_s_m: f64 },
    /// On a rod, at rest along −x of the pivot (thrust along +x); damping as a force on the mass
    /// per speed of the mass.
    Pendulum { pivot_m: Vector2<f64>, length_m: f64, damping_n_s_m: f64 },
}

/// A slosh mass and what holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarSlosh {
    pub mass_kg: f64,
    pub suspension: Suspension,
}

/// Force and torque on the hub at its centre of mass, held over a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    pub force_n: Vector2<f64>,
    pub torque_n_m: f64,
}

impl Wrench {
    /// This and `share` of another.
    #[must_use]
    pub fn plus(&self, other: &Self, share: f64) -> Self {
        Self { force_n: self.force_n + other.force_n * share, torque_n_m: self.torque_n_m + other.torque_n_m * share }
    }
}

/// Of hub and M slosh masses: rate, coordinates (the second of a mass on one axis is not used) and
/// their rates. Of a pendulum the coordinate is its angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarState<const M: usize> {
    pub rate_rad_s: f64,
    pub place: [Vector2<f64>; M],
    pub speed: [Vector2<f64>; M],
}

impl<const M: usize> Default for PlanarState<M> {
    fn default() -> Self {
        Self { rate_rad_s: 0.0, place: [Vector2::zeros(); M], speed: [Vector2::zeros(); M] }
    }
}

/// Derivative of the state and the acceleration of the sensor, body axes.
struct Slope<const M: usize> {
    state: PlanarState<M>,
    sensor_m_s2: Vector2<f64>,
}

fn turned(v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v[1], v[0])
}

/// Place, own force and direction of one mass.
#[derive(Clone, Copy)]
struct Hanging {
    place_m: Vector2<f64>,
    /// What the hub's turning adds to `a + ω̇ w`.
    carried_m_s2: Vector2<f64>,
    force_n: Vector2<f64>,
    /// Zero for a mass free in the plane.
    direction: Vector2<f64>,
    /// Metres per unit of the coordinate.
    reach_m: f64,
    is_free: bool,
}

impl Hanging {
    const NOTHING: Self = Self {
        place_m: Vector2::new(0.0, 0.0),
        carried_m_s2: Vector2::new(0.0, 0.0),
        force_n: Vector2::new(0.0, 0.0),
        direction: Vector2::new(0.0, 0.0),
        reach_m: 1.0,
        is_free: true,
    };

    #[inline]
    fn new(suspension: &Suspension, omega: f64, at: &Vector2<f64>, speed: &Vector2<f64>) -> Self {
        let carried = |q: &Vector2<f64>, q_dot: &Vector2<f64>| turned(q_dot) * (2.0 * omega) - q * (omega * omega);
        match *suspension {
            Suspension::Springs { position_m, stiffness_n_m, damping_n_s_m } => {
                let place_m = position_m + at;
                let force_n = -stiffness_n_m.component_mul(at) - damping_n_s_m.component_mul(speed);
                let carried_m_s2 = carried(&place_m, speed);
                Self { place_m, carried_m_s2, force_n, direction: Vector2::zeros(), reach_m: 1.0, is_free: true }
            }
            Suspension::Rail { position_m, direction, stiffness_n_m, damping_n_s_m } => {
                let place_m = position_m + direction * at[0];
                let force_n = direction * (-stiffness_n_m * at[0] - damping_n_s_m * speed[0]);
                let carried_m_s2 = carried(&place_m, &(direction * speed[0]));
                Self { place_m, carried_m_s2, force_n, direction, reach_m: 1.0, is_free: false }
            }
            Suspension::Pendulum { pivot_m, length_m, damping_n_s_m } => {
                let (sine, cosine) = sine_cosine(at[0]);
                let (radial, direction) = (Vector2::new(-cosine, sine), Vector2::new(sine, cosine));
                let (place_m, speed_m_s) = (pivot_m + radial * length_m, length_m * speed[0]);
                let centripetal = radial * (-length_m * speed[0] * speed[0]);
                Self {
                    place_m,
                    carried_m_s2: carried(&place_m, &(direction * speed_m_s)) + centripetal,
                    force_n: direction * (-damping_n_s_m * speed_m_s),
                    direction,
                    reach_m: length_m,
                    is_free: false,
                }
            }
        }
    }
}

/// Hub and what the suspensions carry along: `(diag(m0, m0, I0) + Σ m g g') [a, ω̇] = right`.
struct Equations {
    /// Lower triangle, by rows.
    matrix: [f64; 6],
    right: Vector3<f64>,
}

impl Equations {
    fn new(hub: &PlanarHub, wrench: &Wrench) -> Self {
        let (m0, force_n) = (hub.mass_kg, wrench.force_n);
        Self {
            matrix: [m0, 0.0, m0, 0.0, 0.0, hub.inertia_com_kg_m2],
            right: Vector3::new(force_n[0], force_n[1], wrench.torque_n_m),
        }
    }

    /// `P = n n'`, n across the direction: `g = [n, n·w]`.
    #[inline]
    fn add(&mut self, mass_kg: f64, hung: &Hanging) {
        let (w, force_n) = (turned(&hung.place_m), hung.force_n);
        self.right -= Vector3::new(force_n[0], force_n[1], w.dot(&force_n));
        if hung.is_free {
            return;
        }
        let n = turned(&hung.direction);
        let g = Vector3::new(n[0], n[1], n.dot(&w));
        let mg = g * mass_kg;
        self.right -= mg * n.dot(&hung.carried_m_s2);
        let own = [mg[0] * g[0], mg[1] * g[0], mg[1] * g[1], mg[2] * g[0], mg[2] * g[1], mg[2] * g[2]];
        for (entry, own) in self.matrix.iter_mut().zip(own) {
            *entry += own;
        }
    }

    /// By `L D L'`; `None` where a pivot is not positive.
    #[inline]
    fn solve(&self) -> Option<Vector3<f64>> {
        let [a, b, c, d, e, f] = self.matrix;
        let r = self.right;
        let (l1, l2) = (b / a, d / a);
        let pivot = c - l1 * b;
        let below = e - l2 * b;
        let l3 = below / pivot;
        let last = f - l2 * d - l3 * below;
        if !(a > 0.0 && pivot > 0.0 && last > 0.0) {
            return None;
        }
        let (y1, y0) = (r[1] - l1 * r[0], r[0]);
        let x2 = (r[2] - l2 * y0 - l3 * y1) / last;
        let x1 = y1 / pivot - l3 * x2;
        Some(Vector3::new(y0 / a - l1 * x1 - l2 * x2, x1, x2))
    }
}

/// Of the small angles of one step without a library's detour: the series to x⁷ is exact to 2e-18.
fn sine_cosine(angle: f64) -> (f64, f64) {
    if angle.abs() > 0.02 {
        return (sin(angle), cos(angle));
    }
    let square = angle * angle;
    let sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
    (sine, 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0)))
}

impl<const M: usize> PlanarState<M> {
    fn slope(&self, hub: &PlanarHub, masses: &[PlanarSlosh; M], wrench: &Wrench) -> Option<Slope<M>> {
        let omega = self.rate_rad_s;
        let mut equations = Equations::new(hub, wrench);
        let mut hanging = [Hanging::NOTHING; M];
        for (i, hung) in hanging.iter_mut().enumerate() {
            *hung = Hanging::new(&masses[i].suspension, omega, &self.place[i], &self.speed[i]);
            equations.add(masses[i].mass_kg, hung);
        }
        let solved = equations.solve()?;
        let (a, alpha) = (Vector2::new(solved[0], solved[1]), solved[2]);
        let mut state = Self { rate_rad_s: alpha, place: self.speed, speed: [Vector2::zeros(); M] };
        for ((rate, mass), hung) in state.speed.iter_mut().zip(masses).zip(&hanging) {
            let own = hung.force_n / mass.mass_kg - a - turned(&hung.place_m) * alpha - hung.carried_m_s2;
            *rate = if hung.is_free { own } else { Vector2::new(hung.direction.dot(&own) / hung.reach_m, 0.0) };
        }
        let s = hub.sensor_m;
        Some(Slope { state, sensor_m_s2: a + turned(&s) * alpha - s * (omega * omega) })
    }

    fn moved(&self, slope: &Self, dt: f64) -> Self {
        let mut moved = *self;
        moved.rate_rad_s += slope.rate_rad_s * dt;
        for i in 0..M {
            moved.place[i] += slope.place[i] * dt;
            moved.speed[i] += slope.speed[i] * dt;
        }
        moved
    }

    /// One sample: `[mean acceleration of the sensor (mid-interval body axes), mean rate]`; the
    /// state moves on. `None` when masses that do not exist (negative) leave the equations without
    /// a solution.
    pub fn step(
        &mut self,
        hub: &PlanarHub,
        masses: &[PlanarSlosh; M],
        wrench: &Wrench,
        dt: f64,
    ) -> Option<Vector3<f64>> {
        self.step_along(hub, masses, &[*wrench; 3], dt)
    }

    /// As [`Self::step`] under what acts at the beginning, in the middle and at the end: a straight
    /// line.
    pub fn step_along(
        &mut self,
        hub: &PlanarHub,
        masses: &[PlanarSlosh; M],
        [begin, middle, end]: &[Wrench; 3],
        dt: f64,
    ) -> Option<Vector3<f64>> {
        let start = *self;
        let k1 = start.slope(hub, masses, begin)?;
        let at2 = start.moved(&k1.state, dt / 2.0);
        let k2 = at2.slope(hub, masses, middle)?;
        let at3 = start.moved(&k2.state, dt / 2.0);
        let k3 = at3.slope(hub, masses, middle)?;
        let at4 = start.moved(&k3.state, dt);
        let k4 = at4.slope(hub, masses, end)?;
        let rates = [start.rate_rad_s, at2.rate_rad_s, at3.rate_rad_s, at4.rate_rad_s];
        let angle = dt / 6.0 * (rates[0] + 2.0 * rates[1] + 2.0 * rates[2] + rates[3]);
        // Attitude of each stage, from mid-interval: velocity is integrated in one frame.
        let attitudes = [0.0, rates[0] * dt / 2.0, rates[1] * dt / 2.0, rates[2] * dt].map(|a| a - angle / 2.0);
        let turn = |v: &Vector2<f64>, angle: f64| {
            let (sine, cosine) = sine_cosine(angle);
            Vector2::new(cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1])
        };
        let mean = turn(&k1.sensor_m_s2, attitudes[0])
            + turn(&k2.sensor_m_s2, attitudes[1]) * 2.0
            + turn(&k3.sensor_m_s2, attitudes[2]) * 2.0
            + turn(&k4.sensor_m_s2, attitudes[3]);
        for (slope, weight) in [(&k1, 1.0), (&k2, 2.0), (&k3, 2.0), (&k4, 1.0)] {
            *self = self.moved(&slope.state, dt * weight / 6.0);
        }
        Some(Vector3::new(mean[0] / 6.0, mean[1] / 6.0, angle / dt))
    }
}

/// Stiffnesses along x and y for which hub and slosh mass swing at two circular frequencies, in
/// both orders; `None` where no positive pair does.
///
/// `ρ̈ = −B K ρ`, `B = 1/μ + w w'/I0`: trace `B11 kx + B22 ky = λ1 + λ2`, determinant
/// `|B| kx ky = λ1 λ2`.
pub fn stiffness_from_modes(
    hub: &PlanarHub,
    mass_kg: f64,
    position_m: &Vector2<f64>,
    lambda: [f64; 2],
) -> [Option<Vector2<f64>>; 2] {
    let (per_mu, w) = (1.0 / hub.mass_kg + 1.0 / mass_kg, turned(position_m));
    let b = |i: usize| per_mu + w[i] * w[i] / hub.inertia_com_kg_m2;
    let cross = w[0] * w[1] / hub.inertia_com_kg_m2;
    let (sum, product) = (lambda[0] + lambda[1], lambda[0] * lambda[1] / (b(0) * b(1) - cross * cross));
    // t = B11 kx: t² − sum t + B11 B22 kx ky = 0. Coupled modes repel: where these lie too close
    // there is no pair.
    let quarter = sum * sum / 4.0 - b(0) * b(1) * product;
    let root = libm::sqrt(quarter.max(0.0));
    [root, -root].map(|root| {
        let t = sum / 2.0 + root;
        let k = Vector2::new(t / b(0), (sum - t) / b(1));
        // A quarter of a line apart is as good as together.
        (k.min() > 0.0 && quarter > -0.01 * sum * sum).then_some(k)
    })
}

#[cfg(test)]
mod tests;
