//! Dynamics of a tree of rigid bodies with internal coordinates, in three dimensions; planar
//! systems are the special case.
//!
//! A [`Model`] holds constants, a [`Data`] is its workspace; the algorithms are functions of
//! (model, data, q, v, …), generic in the scalar so that the same lines run on plain and on dual
//! numbers. None of them allocates.
//!
//! Conventions. Position `q`: free joint `[x, y, z, qw, qx, qy, qz]` (body → world), planar free
//! joint `[x, y, θ]`, one number per revolute or prismatic joint, none per fixed joint. Velocity
//! `v`: free joint `[ω, v]` of the link's origin in body axes, angular first; planar
//! `[ω_z, v_x, v_y]`; links in order, then the internal coordinates, whose positions the caller
//! keeps. Accelerations are the rates of change of `v`. Wrenches are `[torque; force]` about the
//! link's origin in link axes.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008). Every algorithm works in *world
//! axes at each link's origin* with classical accelerations: a link is rotated once, articulated
//! inertias are only translated.

mod apart;
mod base_parameters;
mod carried;
mod data;
mod derivatives;
mod derivatives_workspace;
mod floating;
mod forward_dynamics;
mod inertia;
mod integration;
mod internal_coordinates;
mod inverse_dynamics;
mod kinematics;
mod link_state;
mod mass_matrix;
mod model;
mod momentum;
mod momentum_span;
mod planar;
mod regressor;
mod vector;

pub use base_parameters::{
    BaseParameter, BaseParameters, RegressorRows, base_parameters, stacked_regressor, standard_parameter_names,
};
pub use data::Data;
pub use derivatives::inverse_dynamics_derivatives;
pub use floating::float_at_momentum;
pub use forward_dynamics::{
    forward_dynamics, forward_dynamics_after_kinematics, forward_dynamics_prescribed,
    forward_dynamics_prescribed_after_kinematics,
};
pub use integration::{integrate_position, position_rate, position_rate_after_kinematics};
pub use inverse_dynamics::{inverse_dynamics, inverse_dynamics_after_kinematics};
pub use kinematics::kinematics;
pub use mass_matrix::mass_matrix;
pub use model::{InternalCoordinate, JointKind, Link, Model, ModelError};
pub use momentum::{Momentum, kinetic_energy, momentum, momentum_after_kinematics, potential_energy};
pub use momentum_span::{
    Dependence, MONOMIALS_MAX, MomentumBasis, MomentumSpan, MomentumSpanError, ParameterFamily, PlanarFunctions,
    momentum_span, planar_tree_functions,
};
pub use regressor::{PARAMETER_NAMES, PARAMETERS_PER_LINK, inverse_dynamics_regressor, momentum_regressor};

#[cfg(test)]
mod tests;
