//! The catalogue of left-out physics: one effect per file, one list.
//!
//! An effect knows the sites it can sit at, its parameters with unit and plausible range, what it looks like in a recording, what it is
//! confused with and the experiment that separates them. It acts through a law of what is locally known; the same law runs
//! in simulation, in a filter's prediction and, over [`Dual`](dynamics::dual::Dual) numbers, in a Jacobian.
//!
//! Every effect has an *amplitude*, its first parameter or, where it is a vector, its first few ([`Effect::amplitudes`]): where all of
//! it is zero nothing changes, whatever the other parameters say. Hidden states may go on at zero amplitude (a rotor turns), nothing of
//! what acts or is read does.
//!
//! Effects act in the order of the catalogue, whatever their order in a file. Structures: wrong numbers first, then parts, so that a
//! share of a mass is one of the true mass; those that sit at parts which others have made come last. At an actuator: maps of the
//! command, then what adds to it (bias, leak, friction, ripple), then wrenches in proportion to what acts. At a sensor likewise: maps of
//! the truth, then errors of its own. Forces on coordinates and bodies add up.
//!
//! Vectors that are amplitudes are given by components x, y, z; planar plants do not feel those that leave their plane.
//!
//! Why no entry for aliasing: it is no law of an instant. It appears by itself where a sensor without low-pass is read more slowly than
//! the plant moves; what a disturbance from outside the plant aliases to is `sensor_tone`.
//!
//! Not there, and why: misaligned wheel axes (no entry yet); a centre of mass that moves with firing (the mass that leaves is taken at the centre of mass); eclipses (`solar_pressure` is always on).

#![forbid(unsafe_code)]

mod applies;
mod filters;
mod geometry;
mod parts;
#[cfg(test)]
mod trial;

mod actuator_bias;
mod actuator_dead_zone;
mod actuator_delay;
mod actuator_lag;
mod actuator_saturation;
mod actuator_second_order;
mod actuator_stuck;
mod aerodynamic_spin_damping;
mod appendage_left_out;
mod appendage_rotation_left_out;
mod body_tether;
mod clock_offset;
mod clock_skew;
mod com_shift;
mod constant_force;
mod constant_torque;
mod drag;
mod encoder_ripple;
mod gravity_error;
mod gravity_gradient;
mod gyro_g_sensitivity;
mod inertia_error;
mod joint_asymmetric_friction;
mod joint_axis_misalignment;
mod joint_backlash;
mod joint_bouc_wen;
mod joint_coulomb;
mod joint_cubic_damping;
mod joint_cubic_stiffness;
mod joint_end_stop;
mod joint_flexibility;
mod joint_gear_ripple;
mod joint_load_friction;
mod joint_looseness;
mod joint_lugre;
mod joint_quadratic_damping;
mod joint_quadratic_stiffness;
mod joint_stiffness;
mod joint_stribeck;
mod joint_torque_bias;
mod joint_viscous;
mod linear_drag;
mod magnus_lift;
mod mass_depletion;
mod mass_error;
mod mode_centrifugal_stiffening;
mod mode_coulomb;
mod mode_coupling;
mod mode_duffing;
mod mode_left_out;
mod mode_quadratic_damping;
mod mode_thermal_snap;
mod motor_constant_error;
mod payload_drift;
mod principal_axes_misalignment;
mod quadratic_drag;
mod residual_dipole;
mod sensor_bias;
mod sensor_delay;
mod sensor_drift;
mod sensor_lag;
mod sensor_lever_arm;
mod sensor_misalignment;
mod sensor_quadratic;
mod sensor_quantisation;
mod sensor_saturation;
mod sensor_scale;
mod sensor_step;
mod sensor_tone;
mod sensor_warm_up;
mod slosh_contact_line;
mod slosh_cubic;
mod slosh_pendulum;
mod slosh_quadratic_damping;
mod slosh_second_mode;
mod solar_pressure;
mod spin_damping;
mod thermal_snap;
mod thruster_blow_down;
mod thruster_leak;
mod thruster_minimum_impulse_bit;
mod thruster_misalignment;
mod thruster_plume;
mod thruster_rise_tail_off;
mod wheel_coulomb;
mod wheel_imbalance_dynamic;
mod wheel_imbalance_static;
mod wheel_speed_saturation;
mod wheel_torque_ripple;
mod wheel_viscous;

use dynamics::effect::{Catalogue, Effect};

/// Every effect, in the order in which they act.
pub static EFFECTS: &[&Effect] = &[
    &gravity_error::EFFECT,
    &mass_error::EFFECT,
    &inertia_error::EFFECT,
    &principal_axes_misalignment::EFFECT,
    &com_shift::EFFECT,
    &joint_axis_misalignment::EFFECT,
    &joint_coulomb::EFFECT,
    &joint_stribeck::EFFECT,
    &joint_viscous::EFFECT,
    &joint_quadratic_damping::EFFECT,
    &joint_cubic_damping::EFFECT,
    &joint_load_friction::EFFECT,
    &joint_asymmetric_friction::EFFECT,
    &joint_lugre::EFFECT,
    &joint_bouc_wen::EFFECT,
    &joint_stiffness::EFFECT,
    &joint_quadratic_stiffness::EFFECT,
    &joint_cubic_stiffness::EFFECT,
    &joint_backlash::EFFECT,
    &joint_looseness::EFFECT,
    &joint_end_stop::EFFECT,
    &joint_gear_ripple::EFFECT,
    &joint_torque_bias::EFFECT,
    &joint_flexibility::EFFECT,
    &actuator_dead_zone::EFFECT,
    &actuator_saturation::EFFECT,
    &thruster_minimum_impulse_bit::EFFECT,
    &actuator_stuck::EFFECT,
    &wheel_speed_saturation::EFFECT,
    &thruster_blow_down::EFFECT,
    &motor_constant_error::EFFECT,
    &actuator_bias::EFFECT,
    &thruster_leak::EFFECT,
    &wheel_viscous::EFFECT,
    &wheel_coulomb::EFFECT,
    &wheel_torque_ripple::EFFECT,
    &thruster_misalignment::EFFECT,
    &thruster_plume::EFFECT,
    &wheel_imbalance_static::EFFECT,
    &wheel_imbalance_dynamic::EFFECT,
    &actuator_delay::EFFECT,
    &actuator_lag::EFFECT,
    &actuator_second_order::EFFECT,
    &thruster_rise_tail_off::EFFECT,
    &slosh_second_mode::EFFECT,
    &slosh_pendulum::EFFECT,
    &slosh_cubic::EFFECT,
    &slosh_quadratic_damping::EFFECT,
    &slosh_contact_line::EFFECT,
    &mode_left_out::EFFECT,
    &appendage_left_out::EFFECT,
    &appendage_rotation_left_out::EFFECT,
    &mode_coupling::EFFECT,
    &mode_duffing::EFFECT,
    &mode_coulomb::EFFECT,
    &mode_quadratic_damping::EFFECT,
    &mode_centrifugal_stiffening::EFFECT,
    &mode_thermal_snap::EFFECT,
    &gravity_gradient::EFFECT,
    &solar_pressure::EFFECT,
    &drag::EFFECT,
    &quadratic_drag::EFFECT,
    &linear_drag::EFFECT,
    &magnus_lift::EFFECT,
    &spin_damping::EFFECT,
    &aerodynamic_spin_damping::EFFECT,
    &residual_dipole::EFFECT,
    &constant_force::EFFECT,
    &constant_torque::EFFECT,
    &body_tether::EFFECT,
    &thermal_snap::EFFECT,
    &mass_depletion::EFFECT,
    &payload_drift::EFFECT,
    &encoder_ripple::EFFECT,
    &gyro_g_sensitivity::EFFECT,
    &sensor_scale::EFFECT,
    &sensor_quadratic::EFFECT,
    &sensor_bias::EFFECT,
    &sensor_misalignment::EFFECT,
    &sensor_lever_arm::EFFECT,
    &sensor_lag::EFFECT,
    &sensor_delay::EFFECT,
    &clock_offset::EFFECT,
    &clock_skew::EFFECT,
    &sensor_quantisation::EFFECT,
    &sensor_saturation::EFFECT,
    &sensor_step::EFFECT,
    &sensor_drift::EFFECT,
    &sensor_warm_up::EFFECT,
    &sensor_tone::EFFECT,
];

/// [`EFFECTS`], as plants carry it.
pub const CATALOGUE: Catalogue = Catalogue::new(EFFECTS);

#[cfg(test)]
mod tests;
