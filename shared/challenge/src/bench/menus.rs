//! Effects that can be hidden at each bench, with the first amplitude of the search.

use super::Entry;
use crate::hidden::Seat::{self, Coordinate, Input, Sensor, Structure};

const DRY: &[&str] =
    &["joint_stribeck", "joint_lugre", "joint_bouc_wen", "joint_load_friction", "joint_asymmetric_friction"];

const fn entry(
    kind: &'static str,
    site: &'static str,
    seat: Seat,
    amplitude: (&'static str, f64, f64),
    signed: bool,
) -> Entry {
    Entry { kind, site, seat, amplitude, signed, shape: &[], kin: &[] }
}

const fn shaped(entry: Entry, shape: &'static [(&'static str, f64, f64)]) -> Entry {
    Entry { shape, ..entry }
}

const fn kin(entry: Entry, kin: &'static [&'static str]) -> Entry {
    Entry { kin, ..entry }
}

const fn coulomb(site: &'static str, coordinate: usize, start: f64) -> Entry {
    kin(entry("joint_coulomb", site, Coordinate(coordinate), ("force", start, 1e3 * start), false), DRY)
}

const fn quadratic(site: &'static str, coordinate: usize, start: f64) -> Entry {
    let base = entry("joint_quadratic_damping", site, Coordinate(coordinate), ("damping", start, 1e3 * start), false);
    kin(base, &["joint_cubic_damping", "aerodynamic_spin_damping", "spin_damping", "drag", "quadratic_drag"])
}

const fn cubic_damping(site: &'static str, coordinate: usize, start: f64) -> Entry {
    let base = entry("joint_cubic_damping", site, Coordinate(coordinate), ("damping", start, 1e3 * start), false);
    kin(base, &["joint_quadratic_damping", "aerodynamic_spin_damping", "spin_damping", "drag", "quadratic_drag"])
}

const fn cubic(site: &'static str, coordinate: usize, start: f64) -> Entry {
    entry("joint_cubic_stiffness", site, Coordinate(coordinate), ("stiffness", start, 1e3 * start), true)
}

const fn scale(site: &'static str, sensor: usize) -> Entry {
    kin(entry("sensor_scale", site, Sensor(sensor), ("error", 3e-3, 0.25), true), &["sensor_misalignment"])
}

const fn stiffness(site: &'static str, coordinate: usize, start: f64, most: f64) -> Entry {
    kin(entry("joint_stiffness", site, Coordinate(coordinate), ("stiffness", start, most), false), &["joint_looseness"])
}

const fn tone(site: &'static str, seat: Seat, start: f64, most: f64) -> Entry {
    entry("sensor_tone", site, seat, ("amplitude", start, most), false)
}

const fn drift(site: &'static str, sensor: usize, start: f64, most: f64) -> Entry {
    kin(entry("sensor_drift", site, Sensor(sensor), ("rate", start, most), true), &["sensor_warm_up"])
}

/// Rivals that are never hidden: the scale of a sensor, the bias and the gain of an actuator.
const fn rival_scale(site: &'static str, sensor: usize) -> Entry {
    entry("sensor_scale", site, Sensor(sensor), ("error", 3e-3, 0.25), false)
}

const fn rival_bias(site: &'static str, input: usize, start: f64) -> Entry {
    entry("actuator_bias", site, Input(input), ("bias", start, 1e3 * start), false)
}

const fn rival_gain(site: &'static str, input: usize) -> Entry {
    entry("motor_constant_error", site, Input(input), ("error", 0.03, 0.5), false)
}

/// Rivals of the effects hidden at the motor drive.
pub static DRIVE_RIVALS: &[Entry] =
    &[rival_scale("sensor:angle", 0), rival_bias("actuator:motor", 0, 5e-2), rival_gain("actuator:motor", 0)];
/// Rivals of the effects hidden at the oscillator.
pub static OSCILLATOR_RIVALS: &[Entry] =
    &[rival_scale("sensor:displacement", 0), rival_bias("actuator:shaker", 0, 1e-2), rival_gain("actuator:shaker", 0)];
/// Rivals of the effects hidden at the planar tank.
pub static TANK_RIVALS: &[Entry] = &[
    rival_scale("sensor:acceleration_y", 1),
    rival_bias("actuator:force_x", 0, 1e-3),
    rival_gain("actuator:force_x", 0),
    rival_gain("actuator:force_y", 1),
    rival_gain("actuator:torque", 2),
];
/// Rivals of the effects hidden at the hub with a flexible panel.
pub static PANEL_RIVALS: &[Entry] = &[
    rival_scale("sensor:acceleration_3", 0),
    rival_scale("sensor:acceleration_10", 2),
    rival_bias("actuator:torque", 0, 1e-2),
    rival_gain("actuator:torque", 0),
];

const fn step(site: &'static str, sensor: usize, start: f64) -> Entry {
    entry("sensor_step", site, Sensor(sensor), ("step", start, 1e3 * start), true)
}

/// Effects that a case can hide at the pendulum.
pub static PENDULUM: &[Entry] = &[
    coulomb("joint:pivot", 0, 2e-3),
    quadratic("joint:pivot", 0, 1e-3),
    cubic_damping("joint:pivot", 0, 1e-3),
    cubic("joint:pivot", 0, 0.02),
    shaped(
        entry("joint_gear_ripple", "joint:pivot", Coordinate(0), ("sine", 1e-2, 10.0), true),
        &[("cosine", 0.0, 0.0), ("order", 6.0, 20.0)],
    ),
    shaped(
        entry("encoder_ripple", "sensor:angle", Sensor(0), ("amplitude", 1e-4, 0.05), false),
        &[("order", 3.0, 20.0), ("phase", 0.1, 3.0)],
    ),
    drift("sensor:angle", 0, 1e-5, 1.0),
    shaped(step("sensor:angle", 0, 2e-4), &[("begin", 4.0, 8.0), ("duration", 1.0, 4.0)]),
    shaped(tone("sensor:angle", Sensor(0), 1e-4, 1.0), &[("frequency", 2.0, 15.0), ("phase", 0.1, 3.0)]),
];

/// Effects that a case can hide at the motor drive.
pub static DRIVE: &[Entry] = &[
    coulomb("joint:drive", 0, 5e-3),
    shaped(
        kin(
            entry("joint_stribeck", "joint:drive", Coordinate(0), ("force", 1e-2, 10.0), false),
            &["joint_coulomb", "joint_lugre", "joint_bouc_wen"],
        ),
        &[("stribeck_rate", 0.1, 0.4)],
    ),
    quadratic("joint:drive", 0, 1e-2),
    cubic_damping("joint:drive", 0, 5e-3),
    stiffness("joint:drive", 0, 2e-2, 1e3),
    cubic("joint:drive", 0, 2e-2),
    shaped(
        entry("joint_gear_ripple", "joint:drive", Coordinate(0), ("sine", 5e-3, 10.0), true),
        &[("cosine", 0.0, 0.0), ("order", 6.0, 24.0)],
    ),
    kin(
        entry("joint_torque_bias", "joint:drive", Coordinate(0), ("force", 5e-3, 10.0), true),
        &["actuator_bias", "joint_stiffness", "constant_torque", "joint_asymmetric_friction", "thermal_snap"],
    ),
    shaped(
        kin(
            entry("joint_bouc_wen", "joint:drive", Coordinate(0), ("force", 1e-2, 10.0), false),
            &["joint_lugre", "joint_coulomb"],
        ),
        &[("yield", 0.02, 0.1), ("exponent", 1.5, 1.5), ("share", 0.5, 0.5)],
    ),
    shaped(
        kin(
            entry("joint_flexibility", "joint:drive", Structure, ("compliance", 3e-5, 5e-3), false),
            &["joint_backlash", "joint_looseness", "appendage_left_out", "appendage_rotation_left_out"],
        ),
        &[("damping_ratio", 0.02, 0.1)],
    ),
    kin(
        entry("actuator_delay", "actuator:motor", Input(0), ("delay", 2e-4, 0.05), false),
        &["actuator_lag", "actuator_second_order"],
    ),
    kin(
        entry("actuator_lag", "actuator:motor", Input(0), ("time_constant", 2e-4, 0.1), false),
        &["actuator_delay", "actuator_second_order"],
    ),
    entry("actuator_dead_zone", "actuator:motor", Input(0), ("half_width", 5e-3, 1.0), false),
    scale("sensor:rate", 1),
    kin(
        entry("sensor_lag", "sensor:rate", Sensor(1), ("time_constant", 2e-4, 0.1), false),
        &["sensor_delay", "clock_offset"],
    ),
    kin(entry("sensor_delay", "sensor:rate", Sensor(1), ("delay", 2e-4, 9e-3), false), &["sensor_lag", "clock_offset"]),
    shaped(
        entry("encoder_ripple", "sensor:angle", Sensor(0), ("amplitude", 2e-5, 0.05), false),
        &[("order", 4.0, 30.0), ("phase", 0.1, 3.0)],
    ),
    drift("sensor:rate", 1, 3e-4, 1.0),
    shaped(step("sensor:rate", 1, 1e-3), &[("begin", 2.0, 4.0), ("duration", 0.5, 2.0)]),
    shaped(tone("sensor:rate", Sensor(1), 5e-4, 1.0), &[("frequency", 5.0, 40.0), ("phase", 0.1, 3.0)]),
];

/// Effects that a case can hide at the double pendulum.
pub static DOUBLE_PENDULUM: &[Entry] = &[
    coulomb("joint:pivot_1", 0, 5e-4),
    coulomb("joint:pivot_2", 1, 2e-4),
    quadratic("joint:pivot_1", 0, 2e-4),
    quadratic("joint:pivot_2", 1, 1e-4),
    cubic("joint:pivot_1", 0, 1e-2),
    cubic("joint:pivot_2", 1, 5e-3),
    stiffness("joint:pivot_2", 1, 3e-3, 10.0),
    scale("sensor:angle_1", 0),
    scale("sensor:angle_2", 1),
    shaped(
        entry("encoder_ripple", "sensor:angle_2", Sensor(1), ("amplitude", 2e-4, 0.05), false),
        &[("order", 3.0, 20.0), ("phase", 0.1, 3.0)],
    ),
    drift("sensor:angle_1", 0, 1e-4, 1.0),
    shaped(step("sensor:angle_2", 1, 3e-4), &[("begin", 1.5, 3.0), ("duration", 0.5, 1.5)]),
    shaped(tone("sensor:angle_1", Sensor(0), 2e-4, 1.0), &[("frequency", 6.0, 40.0), ("phase", 0.1, 3.0)]),
];

/// Effects that a case can hide at the oscillator.
pub static OSCILLATOR: &[Entry] = &[
    coulomb("joint:rail", 0, 1e-2),
    quadratic("joint:rail", 0, 0.3),
    cubic_damping("joint:rail", 0, 2.0),
    cubic("joint:rail", 0, 1e5),
    shaped(
        kin(
            entry("joint_bouc_wen", "joint:rail", Coordinate(0), ("force", 3e-2, 10.0), false),
            &["joint_lugre", "joint_coulomb"],
        ),
        &[("yield", 5e-4, 2e-3), ("exponent", 1.5, 1.5), ("share", 0.5, 0.5)],
    ),
    kin(
        entry("actuator_delay", "actuator:shaker", Input(0), ("delay", 3e-5, 0.02), false),
        &["actuator_lag", "actuator_second_order"],
    ),
    kin(
        entry("actuator_lag", "actuator:shaker", Input(0), ("time_constant", 3e-5, 0.05), false),
        &["actuator_delay", "actuator_second_order"],
    ),
    entry("actuator_dead_zone", "actuator:shaker", Input(0), ("half_width", 1e-2, 2.0), false),
    scale("sensor:acceleration", 1),
    entry("sensor_quadratic", "sensor:acceleration", Sensor(1), ("coefficient", 1e-3, 0.1), true),
    kin(
        entry("sensor_lag", "sensor:acceleration", Sensor(1), ("time_constant", 3e-5, 0.05), false),
        &["sensor_delay", "clock_offset"],
    ),
    kin(
        entry("sensor_delay", "sensor:acceleration", Sensor(1), ("delay", 3e-5, 5e-3), false),
        &["sensor_lag", "clock_offset"],
    ),
    drift("sensor:displacement", 0, 1e-6, 1e-2),
    shaped(step("sensor:displacement", 0, 1e-6), &[("begin", 1.0, 2.0), ("duration", 0.3, 1.0)]),
    shaped(tone("sensor:acceleration", Sensor(1), 5e-3, 5.0), &[("frequency", 10.0, 70.0), ("phase", 0.1, 3.0)]),
];

/// Effects that a case can hide at the planar tank.
pub static TANK: &[Entry] = &[
    shaped(
        kin(
            entry("slosh_second_mode", "tank:fuel", Structure, ("mass_ratio", 0.1, 0.9), false),
            &["slosh_pendulum", "appendage_left_out", "appendage_rotation_left_out", "mode_left_out"],
        ),
        &[("frequency", 0.03, 0.1), ("damping_ratio", 0.005, 0.03)],
    ),
    entry("slosh_cubic", "tank:fuel", Coordinate(3), ("stiffness", 5e-2, 1e6), true),
    entry("slosh_quadratic_damping", "tank:fuel", Coordinate(3), ("damping", 1.0, 1e5), false),
    scale("sensor:rate", 2),
    scale("sensor:acceleration_x", 0),
    drift("sensor:rate", 2, 1e-9, 1e-3),
    shaped(step("sensor:acceleration_y", 1, 5e-5), &[("begin", 300.0, 600.0), ("duration", 100.0, 300.0)]),
    entry("actuator_bias", "actuator:torque", Input(2), ("bias", 1e-4, 1.0), true),
    entry("actuator_bias", "actuator:force_y", Input(1), ("bias", 1e-3, 10.0), true),
    kin(
        entry("actuator_lag", "actuator:torque", Input(2), ("time_constant", 0.1, 20.0), false),
        &["actuator_delay", "actuator_second_order"],
    ),
    shaped(tone("sensor:acceleration_x", Sensor(0), 5e-5, 1.0), &[("frequency", 0.03, 0.2), ("phase", 0.1, 3.0)]),
];

// No joint_viscous at the bearing: no sensor measures its rate, and an unknown initial rate is
// worth as much as the friction.
/// Effects that a case can hide at the hub with a flexible panel.
pub static PANEL: &[Entry] = &[
    shaped(
        kin(
            entry("mode_left_out", "mode:bending_2", Structure, ("mass_ratio", 0.05, 0.9), false),
            &["bending_mode_left_out", "appendage_left_out", "appendage_rotation_left_out"],
        ),
        &[("frequency", 9.0, 25.0), ("damping_ratio", 0.003, 0.02)],
    ),
    entry("mode_duffing", "mode:bending_1", Coordinate(1), ("stiffness", 100.0, 1e7), true),
    entry("mode_quadratic_damping", "mode:bending_1", Coordinate(1), ("damping", 0.1, 1e3), false),
    coulomb("joint:bearing", 0, 1e-2),
    kin(
        entry("actuator_delay", "actuator:torque", Input(0), ("delay", 2e-4, 0.05), false),
        &["actuator_lag", "actuator_second_order"],
    ),
    kin(
        entry("actuator_lag", "actuator:torque", Input(0), ("time_constant", 2e-4, 0.1), false),
        &["actuator_delay", "actuator_second_order"],
    ),
    scale("sensor:acceleration_6", 1),
    kin(
        entry("sensor_lag", "sensor:acceleration_10", Sensor(2), ("time_constant", 2e-4, 0.05), false),
        &["sensor_delay", "clock_offset"],
    ),
    shaped(step("sensor:acceleration_3", 0, 1e-4), &[("begin", 2.0, 3.5), ("duration", 0.5, 1.5)]),
    shaped(tone("sensor:acceleration_10", Sensor(2), 1e-4, 1.0), &[("frequency", 12.0, 40.0), ("phase", 0.1, 3.0)]),
];
