//! Workspace of the algorithms, and their results in it.

use super::derivatives_workspace::Derivatives;
use super::link_state::LinkState;
use super::model::Model;
use super::vector::{M3, V3};
use crate::real::Real;

/// Contents of `moment` and `force` after the last algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointForce {
    None,
    /// `inertia · acceleration + force`.
    Articulated,
    /// `force` itself.
    Direct,
}

/// Workspace of one model: all memory is allocated here.
///
/// Frame 0 is the world. Valid after the call that filled it: poses and velocities after any of
/// them, accelerations and joint wrenches after forward or inverse dynamics.
#[derive(Clone, Debug)]
pub struct Data<T: Real> {
    pub(crate) frames: Vec<LinkState<T>>,
    pub(crate) gravity: V3<T>,
    pub(crate) joint_force: JointForce,
    /// The planar kernels serve: the model lies in the plane, and so does all that was ever added
    /// to it.
    pub(crate) plane: bool,
    /// Room for [`inverse_dynamics_derivatives`](super::inverse_dynamics_derivatives).
    pub(crate) derivatives: Derivatives,
    /// Room for one number per velocity coordinate.
    pub(crate) efforts: Vec<T>,
}

impl<T: Real> Data<T> {
    /// Workspace for `model`.
    pub fn new(model: &Model) -> Self {
        let mut frames = vec![LinkState { rotation: M3::identity(), ..LinkState::default() }; model.links_len() + 1];
        let gravity = V3::constant(&model.gravity);
        frames[0].acceleration = -gravity;
        Self {
            frames,
            gravity,
            joint_force: JointForce::None,
            plane: model.plane,
            derivatives: Derivatives::new(model),
            efforts: vec![T::zero(); model.v_len()],
        }
    }

    /// State of a link; the world is not a link.
    #[inline]
    pub(crate) fn link(&self, link: usize) -> &LinkState<T> {
        &self.frames[link + 1]
    }

    /// Origin of the link, and link → world by rows.
    pub fn link_pose(&self, link: usize) -> ([T; 3], [[T; 3]; 3]) {
        let frame = self.link(link);
        (frame.origin.array(), frame.rotation.arrays())
    }

    /// Spatial velocity `[ω; v]` of the link's origin, link axes.
    pub fn link_velocity(&self, link: usize) -> [T; 6] {
        let frame = self.link(link);
        six(frame.rotation.apply_transposed(frame.omega), frame.rotation.apply_transposed(frame.velocity))
    }

    /// Spatial acceleration in link axes: the rate of change of
    /// [`link_velocity`](Self::link_velocity), gravity included.
    pub fn link_acceleration(&self, link: usize) -> [T; 6] {
        let frame = self.link(link);
        let linear = frame.acceleration + self.gravity - frame.omega.cross(frame.velocity);
        six(frame.rotation.apply_transposed(frame.alpha), frame.rotation.apply_transposed(linear))
    }

    /// World position of a point of the link (`point_m`: link frame).
    pub fn point_position(&self, link: usize, point_m: [T; 3]) -> [T; 3] {
        let frame = self.link(link);
        (frame.origin + frame.rotation.apply(point_m.into())).array()
    }

    /// Velocity of a point of the link against the world, link axes.
    pub fn point_velocity(&self, link: usize, point_m: [T; 3]) -> [T; 3] {
        let frame = self.link(link);
        let r = frame.rotation.apply(point_m.into());
        frame.rotation.apply_transposed(frame.velocity + frame.omega.cross(r)).array()
    }

    /// Second derivative of the world position of a point of the link, link axes.
    pub fn point_acceleration(&self, link: usize, point_m: [T; 3]) -> [T; 3] {
        self.rotated_acceleration(link, point_m, self.gravity)
    }

    /// Specific force at a point of a link: acceleration − gravity, link axes.
    pub fn specific_force(&self, link: usize, point_m: [T; 3]) -> [T; 3] {
        self.rotated_acceleration(link, point_m, V3::zero())
    }

    fn rotated_acceleration(&self, link: usize, point_m: [T; 3], added: V3<T>) -> [T; 3] {
        let frame = self.link(link);
        let r = frame.rotation.apply(point_m.into());
        let acceleration = frame.acceleration + added + frame.alpha.cross(r) + frame.omega.cross_twice(r);
        frame.rotation.apply_transposed(acceleration).array()
    }

    /// `[torque; force]` that the parent exerts on the link through its joint, about the link's
    /// origin, link axes.
    ///
    /// Meaningful after forward or inverse dynamics; zero before.
    pub fn joint_wrench(&self, link: usize) -> [T; 6] {
        let frame = self.link(link);
        let (moment, force) = match self.joint_force {
            JointForce::None => (V3::zero(), V3::zero()),
            JointForce::Direct => (frame.moment, frame.force),
            JointForce::Articulated => {
                let (moment, force) = frame.inertia.apply(frame.alpha, frame.acceleration);
                (moment + frame.moment, force + frame.force)
            }
        };
        six(frame.rotation.apply_transposed(moment), frame.rotation.apply_transposed(force))
    }
}

#[inline]
pub(crate) fn six<T: Real>(angular: V3<T>, linear: V3<T>) -> [T; 6] {
    [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z]
}
