//! Inverse dynamics and momentum as functions linear in the standard inertial parameters.
//!
//! Ten parameters per link, `[m, mcx, mcy, mcz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz]`, the inertia about
//! the link's origin in link axes ([`Model::standard_parameters`]). Rotor inertias and internal
//! coordinates are not among them: their efforts are to be subtracted from the left-hand side. A
//! workspace with [`Data::set_internal_positions`] or [`Data::set_added_mass`] is refused (a
//! panic): their terms are not a product with these parameters. (Khalil & Dombre, Modeling,
//! Identification and Control of Robots, ch. 9.)

use super::data::Data;
use super::inverse_dynamics::accelerations;
use super::kinematics::kinematics;
use super::link_state::LinkState;
use super::mass_matrix::project_on_chain;
use super::model::Model;
use super::vector::V3;
use nalgebra::DMatrix;

/// Parameters per link.
pub const PARAMETERS_PER_LINK: usize = 10;

/// Names of the ten parameters of one link, in the order of the columns.
pub const PARAMETER_NAMES: [&str; PARAMETERS_PER_LINK] =
    ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"];

/// `Y(q, v, v̇)` (v_len × 10·links) with `Y π = τ`; rows of internal coordinates are zero.
///
/// Cost: O(10 · links · depth), no allocation.
pub fn inverse_dynamics_regressor(
    model: &Model,
    data: &mut Data<f64>,
    q: &[f64],
    v: &[f64],
    acceleration: &[f64],
    regressor: &mut DMatrix<f64>,
) {
    assert!(acceleration.len() == model.v_len());
    assert!(regressor.shape() == (model.v_len(), PARAMETERS_PER_LINK * model.links_len()));
    assert!(data.carries_nothing(), "a regressor knows constant inertias only");
    kinematics(model, data, q, v);
    accelerations(model, data, acceleration);
    regressor.fill(0.0);
    for link in 0..model.links_len() {
        let frame = data.link(link);
        for (k, (moment, force)) in force_columns(frame).into_iter().enumerate() {
            let wrench = (frame.rotation.apply(moment), frame.rotation.apply(force));
            let column = PARAMETERS_PER_LINK * link + k;
            project_on_chain(model, data, link, wrench, |row, value| regressor[(row, column)] = value);
        }
    }
}

/// `[angular momentum about the world's origin; linear momentum]` (6 × 10·links) per unit of each
/// parameter, world axes.
///
/// Cost: O(10 · links), no allocation.
pub fn momentum_regressor(model: &Model, data: &mut Data<f64>, q: &[f64], v: &[f64], regressor: &mut DMatrix<f64>) {
    assert!(regressor.shape() == (6, PARAMETERS_PER_LINK * model.links_len()));
    assert!(data.carries_nothing(), "a regressor knows constant inertias only");
    kinematics(model, data, q, v);
    for link in 0..model.links_len() {
        let frame = data.link(link);
        let r = &frame.rotation;
        let (omega, velocity) = (r.apply_transposed(frame.omega), r.apply_transposed(frame.velocity));
        for (k, (angular, linear)) in momentum_columns(omega, velocity).into_iter().enumerate() {
            let linear = r.apply(linear);
            let angular = r.apply(angular) + frame.origin.cross(linear);
            let column = PARAMETERS_PER_LINK * link + k;
            for (row, value) in angular.array().into_iter().chain(linear.array()).enumerate() {
                regressor[(row, column)] = value;
            }
        }
    }
}

/// `I x` per unit of `[Ixx, Ixy, Iyy, Ixz, Iyz, Izz]`.
fn inertia_columns(x: V3<f64>) -> [V3<f64>; 6] {
    [
        V3::new(x.x, 0.0, 0.0),
        V3::new(x.y, x.x, 0.0),
        V3::new(0.0, x.y, 0.0),
        V3::new(x.z, 0.0, x.x),
        V3::new(0.0, x.z, x.y),
        V3::new(0.0, 0.0, x.z),
    ]
}

const UNIT: [V3<f64>; 3] =
    [V3 { x: 1.0, y: 0.0, z: 0.0 }, V3 { x: 0.0, y: 1.0, z: 0.0 }, V3 { x: 0.0, y: 0.0, z: 1.0 }];

/// (moment about the origin, force) of one link per unit of each parameter, link axes.
fn force_columns(frame: &LinkState<f64>) -> [(V3<f64>, V3<f64>); PARAMETERS_PER_LINK] {
    let r = &frame.rotation;
    let (omega, alpha) = (r.apply_transposed(frame.omega), r.apply_transposed(frame.alpha));
    let linear = r.apply_transposed(frame.acceleration);
    let mut columns = [(V3::zero(), V3::zero()); PARAMETERS_PER_LINK];
    columns[0].1 = linear;
    for (column, unit) in columns[1..4].iter_mut().zip(UNIT) {
        *column = (unit.cross(linear), alpha.cross(unit) + omega.cross_twice(unit));
    }
    let turning = inertia_columns(alpha).into_iter().zip(inertia_columns(omega));
    for (column, (of_alpha, of_omega)) in columns[4..].iter_mut().zip(turning) {
        column.0 = of_alpha + omega.cross(of_omega);
    }
    columns
}

/// (angular momentum about the origin, linear momentum) of one link per unit of each parameter,
/// link axes.
fn momentum_columns(omega: V3<f64>, velocity: V3<f64>) -> [(V3<f64>, V3<f64>); PARAMETERS_PER_LINK] {
    let mut columns = [(V3::zero(), V3::zero()); PARAMETERS_PER_LINK];
    columns[0].1 = velocity;
    for (column, unit) in columns[1..4].iter_mut().zip(UNIT) {
        *column = (unit.cross(velocity), omega.cross(unit));
    }
    for (column, turning) in columns[4..].iter_mut().zip(inertia_columns(omega)) {
        column.0 = turning;
    }
    columns
}
