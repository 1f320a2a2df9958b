//! Planar hub with slosh masses that slide along body y from one place.
//!
//! Coordinates x, y (inertial), θ, s [, s2]. With R the hub's turn, J a quarter turn, e body y,
//! `d = p + s e`, mass μ each: `T = ½ M |ṙ|² + ½ I θ'² + Σ ½ μ |ṙ + θ' R J d + s' R e|²`. The
//! second mass is taken out of the hub where it rests: the hub keeps `M − μ2`, first moment
//! `−μ2 p`, and about its origin `I − μ2 |p|²`.

use crate::equations::{Equations, Extra, Matrix, Numbers, Vector};

/// Planar hub with one or two slosh masses of the plant `tank_planar`.
pub struct Tank {
    hub_kg: f64,
    /// First moment and inertia about the hub's origin.
    moment_kg_m: [f64; 2],
    inertia_kg_m2: f64,
    place_m: [f64; 2],
    /// Mass, stiffness, damping.
    slosh: Vec<[f64; 3]>,
    accelerometer_m: [f64; 2],
}

impl Tank {
    /// Reads the parameters of the plant file by name; `extra.second` adds a slosh mass.
    ///
    /// # Panics
    /// A parameter is not in `numbers`.
    pub fn new(numbers: &Numbers, extra: Extra) -> Self {
        let place_m = ["x", "y"].map(|axis| numbers.get(&format!("fuel.position.{axis}")));
        let first = ["mass", "stiffness.y", "damping.y"].map(|what| numbers.get(&format!("fuel.{what}")));
        let (mut slosh, mut lost) = (vec![first], 0.0);
        if let Some([ratio, frequency_hz, zeta]) = extra.second {
            let (mass, omega) = (ratio * first[0], core::f64::consts::TAU * frequency_hz);
            slosh.push([mass, mass * omega * omega, 2.0 * zeta * omega * mass]);
            lost = mass;
        }
        let [x, y] = place_m;
        Self {
            hub_kg: numbers.get("hub.mass") - lost,
            moment_kg_m: [-lost * x, -lost * y],
            inertia_kg_m2: numbers.get("hub.inertia.zz") - lost * (x * x + y * y),
            place_m,
            slosh,
            accelerometer_m: [0.5, -0.3],
        }
    }

    /// Velocity of the accelerometer, inertial axes.
    fn velocity(&self, q: &Vector, v: &Vector) -> [f64; 2] {
        let [x, y] = self.accelerometer_m;
        let [jx, jy] = turn(q[2], [-y, x]);
        [v[0] + v[2] * jx, v[1] + v[2] * jy]
    }
}

fn turn(angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    [cos * x - sin * y, sin * x + cos * y]
}

impl Equations for Tank {
    fn dof(&self) -> usize {
        3 + self.slosh.len()
    }

    fn mass(&self, q: &Vector) -> Matrix {
        let mut mass = Matrix::identity();
        let [px, py] = self.place_m;
        let total = self.hub_kg + self.slosh.iter().map(|part| part[0]).sum::<f64>();
        let [mut hx, mut hy] = self.moment_kg_m;
        let mut inertia = self.inertia_kg_m2;
        for (k, part) in self.slosh.iter().enumerate() {
            let (m, dy) = (part[0], py + q[3 + k]);
            (hx, hy) = (hx + m * px, hy + m * dy);
            inertia += m * (px * px + dy * dy);
            let [ex, ey] = turn(q[2], [0.0, m]);
            // (J d) · e = d_x
            for (row, value) in [ex, ey, m * px].into_iter().enumerate() {
                (mass[(row, 3 + k)], mass[(3 + k, row)]) = (value, value);
            }
            mass[(3 + k, 3 + k)] = m;
        }
        let [jx, jy] = turn(q[2], [-hy, hx]);
        (mass[(0, 0)], mass[(1, 1)], mass[(2, 2)]) = (total, total, inertia);
        (mass[(0, 2)], mass[(2, 0)], mass[(1, 2)], mass[(2, 1)]) = (jx, jx, jy, jy);
        mass
    }

    fn force(&self, q: &Vector, v: &Vector, u: &[f64]) -> Vector {
        let mut force = Vector::zeros();
        let (omega, py) = (v[2], self.place_m[1]);
        let [fx, fy] = turn(q[2], [u[0], u[1]]);
        // centrifugal pull on the hub's own first moment
        let [hx, hy] = turn(q[2], self.moment_kg_m);
        (force[0], force[1], force[2]) = (fx + omega * omega * hx, fy + omega * omega * hy, u[2]);
        for (k, [m, stiffness, damping]) in self.slosh.iter().enumerate() {
            let (s, rate, dy) = (q[3 + k], v[3 + k], py + q[3 + k]);
            // acceleration of the mass at rest in the coordinates: −ω² d + 2 ω s' J e, body axes
            let bias = [-omega * omega * self.place_m[0] - 2.0 * omega * rate, -omega * omega * dy];
            let [bx, by] = turn(q[2], bias);
            force[0] -= m * bx;
            force[1] -= m * by;
            force[2] -= 2.0 * m * omega * rate * dy;
            force[3 + k] = m * omega * omega * dy - stiffness * s - damping * rate;
        }
        force
    }

    fn read(&self, _: &Vector, _: &Vector, _: &Vector, y: &mut [f64]) {
        y.fill(0.0);
    }

    fn read_mean(&self, begin: (&Vector, &Vector), end: (&Vector, &Vector), dt_s: f64) -> Option<Vec<f64>> {
        let (a, b) = (self.velocity(begin.0, begin.1), self.velocity(end.0, end.1));
        let middle = 0.5 * (begin.0[2] + end.0[2]);
        let [x, y] = turn(-middle, [(b[0] - a[0]) / dt_s, (b[1] - a[1]) / dt_s]);
        Some(vec![x, y, (end.0[2] - begin.0[2]) / dt_s])
    }
}
