//! Sloshing propellant in the plane: a free hub, slosh masses on springs, on a rail, or as pendulums, off its centre.
//!
//! Body axes, origin at the centre of mass of the hub alone; `q_i` place of slosh mass i, `w_i = ẑ × q_i`, `P_i` what of its
//! acceleration the hub prescribes (zero for a mass free in the plane, `1 − u u'` for one that moves along `u`):
//!
//! ```text
//! A_i = P_i (a + ω̇ w_i + 2ω ẑ×q̇_i − ω² q_i + J̇_i ṡ_i) + u_i F_i/m_i          acceleration of the mass
//! m0 a + Σ m_i A_i = f,      I0 ω̇ + Σ m_i w_i·A_i = τ                          the force acts at q_i, not at the tank
//! acceleration at s: a + ω̇ ẑ×s − ω² s,      rate: ω
//! ```
//!
//! Position and attitude leave no trace, so the state is `[ω, s, ṡ]` alone. Runge–Kutta of fourth order over each sample:
//! its error (ω dt)⁵/120 per step is hidden by any noise. Units: SI.

use libm::{cos, sin};
use nalgebra::{Matrix3, Vector2, Vector3};

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
    /// On a rod, at rest along −x of the pivot (thrust along +x); damping as a force on the mass per speed of the mass.
    Pendulum { pivot_m: Vector2<f64>, length_m: f64, damping_n_s_m: f64 },
}

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

/// Of hub and M slosh masses: rate, coordinates (the second of a mass on one axis is not used) and their rates. Of a
/// pendulum the coordinate is its angle.
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

/// Place, prescribed part of the acceleration, own force and direction of one mass.
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
                let (sine, cosine) = (sin(at[0]), cos(at[0]));
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

    /// `P v`.
    fn prescribed(&self, v: &Vector2<f64>) -> Vector2<f64> {
        if self.is_free { Vector2::zeros() } else { v - self.direction * self.direction.dot(v) }
    }
}

impl<const M: usize> PlanarState<M> {
    fn slope(&self, hub: &PlanarHub, masses: &[PlanarSlosh; M], wrench: &Wrench) -> Option<Slope<M>> {
        let omega = self.rate_rad_s;
        let hanging: [Hanging; M] =
            core::array::from_fn(|i| Hanging::new(&masses[i].suspension, omega, &self.place[i], &self.speed[i]));
        let mut matrix = Matrix3::from_diagonal(&Vector3::new(hub.mass_kg, hub.mass_kg, hub.inertia_com_kg_m2));
        let mut right = Vector3::new(wrench.force_n[0], wrench.force_n[1], wrench.torque_n_m);
        for (mass, hung) in masses.iter().zip(&hanging) {
            let (m, w) = (mass.mass_kg, turned(&hung.place_m));
            let own = hung.prescribed(&hung.carried_m_s2) * m + hung.force_n;
            right -= Vector3::new(own[0], own[1], w.dot(&own));
            let columns = [Vector2::x(), Vector2::y(), w].map(|v| hung.prescribed(&v) * m);
            for (j, column) in columns.iter().enumerate() {
                matrix[(0, j)] += column[0];
                matrix[(1, j)] += column[1];
                matrix[(2, j)] += w.dot(column);
            }
        }
        let solved = matrix.cholesky()?.solve(&right);
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
        Self {
            rate_rad_s: self.rate_rad_s + slope.rate_rad_s * dt,
            place: core::array::from_fn(|i| self.place[i] + slope.place[i] * dt),
            speed: core::array::from_fn(|i| self.speed[i] + slope.speed[i] * dt),
        }
    }

    /// One sample: `[mean acceleration of the sensor (mid-interval body axes), mean rate]`; the state moves on. `None`
    /// when masses that do not exist (negative) leave the equations without a solution.
    pub fn step(
        &mut self,
        hub: &PlanarHub,
        masses: &[PlanarSlosh; M],
        wrench: &Wrench,
        dt: f64,
    ) -> Option<Vector3<f64>> {
        let start = *self;
        let k1 = start.slope(hub, masses, wrench)?;
        let at2 = start.moved(&k1.state, dt / 2.0);
        let k2 = at2.slope(hub, masses, wrench)?;
        let at3 = start.moved(&k2.state, dt / 2.0);
        let k3 = at3.slope(hub, masses, wrench)?;
        let at4 = start.moved(&k3.state, dt);
        let k4 = at4.slope(hub, masses, wrench)?;
        let rates = [start.rate_rad_s, at2.rate_rad_s, at3.rate_rad_s, at4.rate_rad_s];
        let angle = dt / 6.0 * (rates[0] + 2.0 * rates[1] + 2.0 * rates[2] + rates[3]);
        // Attitude of each stage, from mid-interval: velocity is integrated in one frame.
        let attitudes = [0.0, rates[0] * dt / 2.0, rates[1] * dt / 2.0, rates[2] * dt].map(|a| a - angle / 2.0);
        let turn = |v: &Vector2<f64>, angle: f64| {
            let (sine, cosine) = (sin(angle), cos(angle));
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

/// Stiffnesses along x and y for which hub and slosh mass swing at two circular frequencies, in both orders; `None` where
/// no positive pair does.
///
/// `ρ̈ = −B K ρ`, `B = 1/μ + w w'/I0`: trace `B11 kx + B22 ky = λ1 + λ2`, determinant `|B| kx ky = λ1 λ2`.
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
    // t = B11 kx: t² − sum t + B11 B22 kx ky = 0. Coupled modes repel: where these lie too close there is no pair.
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
