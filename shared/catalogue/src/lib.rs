//! The catalogue of unmodelled physics: laws that a plant may carry beyond its description.
//!
//! What it is: one effect per file and one line in [`EFFECTS`]. An entry states its law, its
//! parameters and its sites, and in words its signature in a recording, its confounders and the
//! experiment that separates it from them.
//!
//! May import: `dynamics` (description, [`Effect`], scalars) and `libm`. It may fly: a law takes no
//! memory.
//!
//! Must never know: files, recordings, likelihoods, the search that tests its entries, other
//! entries of the list.
//!
//! ```
//! use catalogue::CATALOGUE;
//! use dynamics::effect::{Prior, Role, Spread, sites};
//!
//! let stribeck = CATALOGUE.effect("joint_stribeck").expect("an entry");
//! let rate = stribeck.with_role(Role::Width).expect("the Stribeck rate");
//! assert_eq!((stribeck.amplitudes(), rate.name, rate.unit), (1, "stribeck_rate", "*/s"));
//! assert_eq!(rate.prior, Prior::Free(Spread::Relative(0.7))); // a refit estimates it
//! assert_eq!(stribeck.limits[0].kind, "joint_coulomb"); // the simpler law that it contains
//!
//! let joint = "joint = { kind = \"revolute\", name = \"hinge\" }";
//! let link = format!("mass = \"1 kg\"\ninertia = \"1 kg*m^2\"\n{joint}");
//! let head = "format = 1\nname = \"rig\"\nspace = \"planar\"\n[[body]]\nname = \"link\"";
//! let file = format!("{head}\n{link}");
//! let plant = plant_file::parse("rig.toml", &file).expect("a plant").plant;
//! assert_eq!(sites(stribeck, &plant)[0].to_string(), "joint:hinge");
//! ```
//!
//! # One effect, one file, one line
//!
//! `joint_stribeck.rs` holds everything that is known about Stribeck friction: the static `EFFECT`,
//! the function of its law, and tests of its physics. `lib.rs` declares the module and lists
//! `&joint_stribeck::EFFECT`. No other code decides on the name of an effect; a search reads the
//! fields of the entry:
//!
//! | field | question that it answers |
//! |---|---|
//! | [`sites`](Effect::sites), [`applies`](Effect::applies) | where the effect can act |
//! | [`parameters`](Effect::parameters) | name, unit, plausible range, default; role, scan and prior |
//! | [`amplitude`](Effect::amplitude) | which amplitudes are physical |
//! | [`law`](Effect::law) | where in the equations it acts, and how |
//! | [`needs`](Effect::needs) | which part of the environment it requires |
//! | [`family`](Effect::family) | with which laws it is confused most |
//! | [`limits`](Effect::limits) | which simpler laws it contains |
//!
//! [`Effect::PLAIN`] is the default of every field that an entry does not state.
//!
//! # Parameters: role, scan, prior
//!
//! **Role** ([`Role`](dynamics::effect::Role)): the meaning of a parameter to its law. *Amplitudes*
//! come first in the list; several are the components x, y, z of a vector. At zero amplitude the
//! effect changes nothing, whatever its other parameters are. Hidden states may still move at zero
//! amplitude (a rotor turns), but no force, wrench or reading does. The other roles are direction,
//! frequency, damping ratio, order, onset, duration, width, smoothing and shape.
//!
//! **Scan** ([`Scan`](dynamics::effect::Scan)): the values of a parameter at which the law is
//! screened before any refit, derived from the motion of the site: shares of the rms rate, of the
//! range, times of the recording, peaks of a spectrum.
//!
//! **Prior** ([`Prior`](dynamics::effect::Prior)): whether a refit estimates the parameter, and
//! with which standard deviation about the screened value. *Multimodal* parameters start from
//! several values, because their likelihood has maxima a factor apart.
//!
//! The builders of [`EffectParameter`](dynamics::effect::EffectParameter) set all three:
//! `.amplitude()`, `.width(scan)`, `.frequency()`, `.onset()`. A parameter without a builder is a
//! shape that keeps its default.
//!
//! # Families and limits
//!
//! A **family** ([`Family`](dynamics::effect::Family)) groups laws with similar signatures. A
//! **limit** ([`Limit`](dynamics::effect::Limit)) states the parameter values at which an effect
//! approaches a simpler entry: Stribeck friction with a large Stribeck rate is Coulomb friction.
//! Data that do not leave the limit cannot distinguish the two.
//!
//! # Order of action
//!
//! Effects act in the order of [`EFFECTS`], not of a file. Structures: corrections of stated
//! parameters first, then added parts, so that a share of a mass refers to the true mass; effects
//! at sites that other effects create come last. At an actuator: maps of the command, then additive
//! terms (bias, leak, friction, ripple), then wrenches in proportion to the acting force. At a
//! sensor: maps of the true value, then errors of the sensor. Forces on coordinates and bodies add
//! up. Planar plants ignore vector components that leave their plane.
//!
//! # Limits of the catalogue
//!
//! Aliasing is not an entry, because it is not a law of one instant: it follows from a sensor
//! without low-pass whose sampling is slower than the plant. `sensor_tone` covers disturbances from
//! outside the plant. Not modelled: misaligned wheel axes; a centre of mass that moves with firing
//! (the expelled mass leaves at the centre of mass); eclipses (`solar_pressure` acts always).

#![forbid(unsafe_code)]

mod applies;
mod filters;
mod force_pulse;
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
mod bending_mode_left_out;
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
mod thruster_displacement;
mod thruster_leak;
mod thruster_minimum_impulse_bit;
mod thruster_misalignment;
mod thruster_plume;
mod thruster_rise_tail_off;
mod torque_pulse;
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
    &thruster_displacement::EFFECT,
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
    &bending_mode_left_out::EFFECT,
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
    &force_pulse::EFFECT,
    &torque_pulse::EFFECT,
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

/// [`EFFECTS`] as the catalogue that a plant carries.
pub const CATALOGUE: Catalogue = Catalogue::new(EFFECTS);

#[cfg(test)]
mod tests;
