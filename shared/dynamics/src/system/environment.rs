//! Gravity, the constant disturbance, the gravity gradient, and a base that is shaken.

use super::System;
use super::actuation::Acts;
use super::geometry::{add, along, cross, subtract, times, turn, turn_back};
use super::workspace::{BaseMotion, Workspace};
use crate::effect::{Pick, Surroundings};
use crate::multibody::momentum_after_kinematics;

/// Circular orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orbit {
    pub rate_rad_s: f64,
    pub phase_rad: f64,
}

/// Environment of the plant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surrounding {
    /// Arguments common to all laws.
    pub constants: Surroundings,
    /// Inertial axes; force at the centre of mass of `disturbed`.
    pub force_n: [f64; 3],
    pub torque_n_m: [f64; 3],
    /// The first free body, or the first.
    pub disturbed: usize,
    /// `None`: no gravity gradient.
    pub orbit: Option<Orbit>,
    pub shaken: bool,
}

impl Surrounding {
    /// Something outside acts on bodies, gravity apart.
    pub fn pushes(&self) -> bool {
        self.force_n != [0.0; 3] || self.torque_n_m != [0.0; 3] || self.orbit.is_some()
    }
}

impl System {
    /// Motion of the accelerated frame: gravity is less by its acceleration.
    pub(super) fn move_base<T: Pick>(&self, ws: &mut Workspace<T>, u: &[T]) {
        if !self.environment.shaken {
            return;
        }
        let mut base = BaseMotion::default();
        for actuator in &self.actuators {
            let Acts::Base { direction } = &actuator.acts else { continue };
            let part = |k: usize| direction.map(|d| u[actuator.input + k].scale(d));
            base.position = add(base.position, part(0));
            base.velocity = add(base.velocity, part(1));
            base.acceleration = add(base.acceleration, part(2));
        }
        let gravity = subtract(self.environment.constants.gravity_m_s2.map(T::constant), base.acceleration);
        ws.base = base;
        ws.data.gravity = gravity.into();
        ws.data.frames[0].acceleration = gravity.map(|g| -g).into();
    }

    /// Adds wrenches; after kinematics.
    #[inline]
    pub(super) fn apply_environment<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64) {
        let outside = &self.environment;
        if outside.force_n != [0.0; 3] || outside.torque_n_m != [0.0; 3] {
            let rotation = ws.data.link_pose(outside.disturbed).1;
            let force = turn_back(&rotation, outside.force_n.map(T::constant));
            let torque = turn_back(&rotation, outside.torque_n_m.map(T::constant));
            let arm = self.model.links[outside.disturbed].com.array().map(T::constant);
            add_wrench(&mut ws.wrench[outside.disturbed], add(torque, cross(arm, force)), force);
        }
        if let Some(orbit) = outside.orbit {
            self.apply_gravity_gradient(ws, t_s, orbit);
        }
    }

    /// First-order tide about the system's centre of mass: on every link the torque `3 n² r × I r`
    /// and the force `m n² (3 r (r·ρ) − ρ)`, `r` the unit vector to the planet, `ρ` the link's
    /// place relative to that centre.
    ///
    /// Forces add up to zero, torques about the centre of mass to `3 n² r × I r` of the whole
    /// (Hughes, Spacecraft Attitude Dynamics, ch. 8). Modal displacements are neglected. Masses
    /// must be given as of a circular orbit, states relative to the freely falling centre.
    fn apply_gravity_gradient<T: Pick>(&self, ws: &mut Workspace<T>, t_s: f64, orbit: Orbit) {
        let (sin, cos) = libm::sincos(orbit.phase_rad + orbit.rate_rad_s * t_s);
        let to_planet = [cos, sin, 0.0];
        let square = orbit.rate_rad_s * orbit.rate_rad_s;
        let com = momentum_after_kinematics(&self.model, &ws.data, &ws.velocity).com;
        for (i, link) in self.model.links.iter().enumerate().filter(|(_, link)| link.mass > 0.0) {
            let (origin, rotation) = ws.data.link_pose(i);
            let arm = link.com.array().map(T::constant);
            let offset = subtract(add(origin, turn(&rotation, arm)), com);
            let reach = along(offset, &to_planet).scale(3.0);
            let tide = subtract(to_planet.map(|r| reach.scale(r)), offset);
            let force = turn_back(&rotation, times(tide, T::constant(link.mass * square)));
            let r = turn_back(&rotation, to_planet.map(T::constant));
            let torque = times(cross(r, self.inertia_about_com(i, r)), T::constant(3.0 * square));
            add_wrench(&mut ws.wrench[i], add(torque, cross(arm, force)), force);
        }
    }

    /// `I r` with the link's inertia about its centre of mass.
    fn inertia_about_com<T: Pick>(&self, link: usize, r: [T; 3]) -> [T; 3] {
        let rows = self.inertia_com[link];
        [along(r, &rows[0]), along(r, &rows[1]), along(r, &rows[2])]
    }
}

fn add_wrench<T: Pick>(sum: &mut [T; 6], torque: [T; 3], force: [T; 3]) {
    for k in 0..3 {
        sum[k] += torque[k];
        sum[3 + k] += force[k];
    }
}
