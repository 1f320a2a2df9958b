//! The point of the grid: axis, frequency and damping ratio of a second slosh mass, which with
//! eight numbers make ten.

use libm::sqrt;
use nalgebra::{SMatrix, SVector, Vector2};

use crate::slosh_planar::{PlanarHub, PlanarSlosh, Suspension};
use crate::slosh_planar_fit::PlanarCraft;
use crate::slosh_planar_id::{ONE_AXIS, lateral_spring};

/// Numbers of two slosh masses: `[ms, k, c, bx, by]` of each.
pub const TWO_MASSES: usize = 2 * ONE_AXIS;
/// Those of the first, mass and place of the second.
pub(super) const AT_A_POINT: usize = ONE_AXIS + 3;

/// Axis along which the second of two slosh masses moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondAxis {
    X,
    Y,
}

impl SecondAxis {
    pub(super) fn direction(self) -> Vector2<f64> {
        if self == Self::X { Vector2::x() } else { Vector2::y() }
    }

    /// Acceleration of the second mass against the hub per force between them.
    pub(super) fn per_force(self, hub: &PlanarHub, mass_kg: f64, position_m: &Vector2<f64>) -> f64 {
        let lever = self.direction().perp(position_m);
        1.0 / hub.mass_kg + 1.0 / mass_kg + lever * lever / hub.inertia_com_kg_m2
    }

    /// Of the second mass on its spring against the bare hub.
    pub(super) fn frequency_hz(self, hub: &PlanarHub, ten: &SVector<f64, TWO_MASSES>) -> f64 {
        let per_force = self.per_force(hub, ten[5], &Vector2::new(ten[8], ten[9]));
        sqrt(ten[6] * per_force) / (2.0 * core::f64::consts::PI)
    }
}
/// A mass on a spring along y and one along `axis`.
pub fn two_masses(hub: PlanarHub, axis: SecondAxis, theta: &SVector<f64, TWO_MASSES>) -> Option<PlanarCraft<2>> {
    let first = lateral_spring(hub, &theta.fixed_rows::<ONE_AXIS>(0).into_owned())?.masses[0];
    let suspension = Suspension::Rail {
        position_m: Vector2::new(theta[8], theta[9]),
        direction: axis.direction(),
        stiffness_n_m: theta[6],
        damping_n_s_m: theta[7],
    };
    let masses = [first, PlanarSlosh { mass_kg: theta[5], suspension }];
    (theta[5] > 0.0 && theta[6] > 0.0).then(|| PlanarCraft::at_rest(hub, masses))
}

/// A place on the grid.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub axis: SecondAxis,
    pub hertz: f64,
    pub ratio: f64,
}

impl Point {
    /// All ten numbers of the eight.
    pub fn ten(&self, hub: &PlanarHub, eight: &SVector<f64, AT_A_POINT>) -> SVector<f64, TWO_MASSES> {
        let (mass_kg, place_m) = (eight[5], Vector2::new(eight[6], eight[7]));
        let omega = 2.0 * core::f64::consts::PI * self.hertz;
        let per_force = self.axis.per_force(hub, mass_kg, &place_m);
        let mut ten = SVector::<f64, TWO_MASSES>::zeros();
        ten.fixed_rows_mut::<ONE_AXIS>(0).copy_from(&eight.fixed_rows::<ONE_AXIS>(0));
        let second = [mass_kg, omega * omega / per_force, 2.0 * self.ratio * omega / per_force, place_m[0], place_m[1]];
        ten.fixed_rows_mut::<ONE_AXIS>(ONE_AXIS).copy_from_slice(&second);
        ten
    }

    /// Derivative of the ten by the eight.
    pub fn jacobian(
        &self,
        hub: &PlanarHub,
        eight: &SVector<f64, AT_A_POINT>,
        scale: &SVector<f64, AT_A_POINT>,
    ) -> SMatrix<f64, TWO_MASSES, AT_A_POINT> {
        derivative(|eight| self.ten(hub, eight), eight, scale)
    }

    /// What the ten move by per hertz, the eight held.
    pub fn slope_per_hz(&self, hub: &PlanarHub, eight: &SVector<f64, AT_A_POINT>) -> SVector<f64, TWO_MASSES> {
        let hertz = SVector::<f64, 1>::new(self.hertz);
        derivative(|hertz| Self { hertz: hertz[0], ..*self }.ten(hub, eight), &hertz, &hertz)
    }
}

/// Central differences, a hundred thousandth of `scale` to either side.
pub(super) fn derivative<const N: usize, const OUT: usize>(
    of: impl Fn(&SVector<f64, N>) -> SVector<f64, OUT>,
    at: &SVector<f64, N>,
    scale: &SVector<f64, N>,
) -> SMatrix<f64, OUT, N> {
    const CENTRAL_STEP_SHARE: f64 = 1e-5;
    let mut derivative = SMatrix::<f64, OUT, N>::zeros();
    for (i, scale) in scale.iter().enumerate() {
        let (mut above, mut below) = (*at, *at);
        above[i] += CENTRAL_STEP_SHARE * scale;
        below[i] -= CENTRAL_STEP_SHARE * scale;
        derivative.set_column(i, &((of(&above) - of(&below)) / (2.0 * CENTRAL_STEP_SHARE * scale)));
    }
    derivative
}
