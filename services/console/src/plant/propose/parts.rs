//! Actuators and sensors of a proposed plant file.

use super::mechanism::{Axis, Mechanism, axis_of};
use super::names::plain;
use super::roles::{Guess, Role, noise_sigma, resolution};
use super::samples::{longest, median_step, rates};
use crate::plant::words::digits;
use channels::{Channel, Recording};
use std::fmt::Write;

/// What drives: one actuator for a channel that is set.
pub fn actuator(channel: &Channel, guess: &Guess, mechanism: &Mechanism, text: &mut String) {
    let kind = match guess.role {
        Role::Imposed => imposed(channel, mechanism),
        Role::Command => commanded(channel, mechanism),
        _ => return,
    };
    let unit = channel.unit.as_str();
    let Some(kind) = kind else {
        let _ = write!(text, "\n# '{}' [{unit}] has no joint that it could act in\n", channel.name);
        return;
    };
    let peak = channel.value.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let amplitude = digits(if peak > 0.0 { peak } else { 1.0 }, 3);
    let (form, hertz) = if guess.role == Role::Imposed { ("sine", "0.5 Hz") } else { ("square", "0.1 Hz") };
    let _ = write!(
        text,
        "\n[[actuator]] # {}\nname = \"{}\"\n{kind}\
         # the command is the channel of that name; for simulation, as large as recorded:\n\
         command = {{ kind = \"{form}\", amplitude = \"{amplitude} {unit}\", frequency = \"{hertz}\" }}\n",
        guess.why,
        plain(&channel.name)
    );
}

fn imposed(channel: &Channel, mechanism: &Mechanism) -> Option<String> {
    let joint = mechanism.joint(channel, channel.unit.starts_with('m'))?;
    let what = match channel.unit.as_str() {
        "rad/s" | "m/s" => "rate",
        "m/s^2" => "acceleration",
        _ => "position",
    };
    Some(format!("kind = \"prescribed_joint\"\njoint = \"{}\"\nwhat = \"{what}\"\n", joint.name))
}

fn commanded(channel: &Channel, mechanism: &Mechanism) -> Option<String> {
    let unit = channel.unit.as_str();
    let on = |joint: &Axis, kind: &str| format!("kind = \"{kind}\"\njoint = \"{}\"\n", joint.name);
    if matches!(unit, "A" | "V") {
        let joint = mechanism.joint(channel, false).or(mechanism.axes.last())?;
        let drive = if unit == "A" { "drive = \"current\"\n" } else { VOLTAGE };
        return Some(format!("{}{CONSTANT}{drive}", on(joint, "motor")));
    }
    if mechanism.free || (unit == "N" && mechanism.joint(channel, true).is_none()) {
        return Some(on_body(channel, mechanism));
    }
    mechanism.joint(channel, unit == "N").map(|joint| on(joint, "joint_torque"))
}

const CONSTANT: &str = "constant = { value = \"? N*m/A\", sigma = \"? N*m/A\" } # FILL IN: torque per ampere, data sheet\n\
     gear = 1 # CHECK: turns of the motor for one of the joint\n";
const VOLTAGE: &str = "drive = \"voltage\"\n\
     resistance = { value = \"? ohm\", sigma = \"? ohm\" } # FILL IN: data sheet\n\
     back_emf = { value = \"? V*s/rad\", sigma = \"? V*s/rad\" } # FILL IN: in SI the torque constant\n";

/// A force or torque on a body: thrusters, wheels.
fn on_body(channel: &Channel, mechanism: &Mechanism) -> String {
    let axis = axis_of(&channel.name).filter(|axis| mechanism.spatial || *axis != "z");
    let axis = axis.or(mechanism.bearing.filter(|_| channel.unit == "N*m"));
    let body = mechanism.body();
    let direction = match axis {
        Some(axis) => format!("direction = \"{axis}\" # CHECK: in the body's axes\n"),
        None => "direction = \"?\" # FILL IN: in the body's axes, as in \"x\", \"-z\" or [0.6, 0.8, 0]\n".to_owned(),
    };
    if channel.unit == "N*m" {
        let direction = if mechanism.spatial { direction } else { String::new() };
        return format!("kind = \"body_torque\"\nbody = \"{body}\"\n{direction}");
    }
    let place = if mechanism.spatial { "[\"? m\", \"? m\", \"? m\"]" } else { "[\"? m\", \"? m\"]" };
    format!(
        "kind = \"body_force\"\nbody = \"{body}\"\n{direction}\
         position = {place} # FILL IN: where it acts, from the body's origin\n"
    )
}

/// What reads: one sensor for a channel that was measured, a remark for one that is not used.
pub fn sensor(channel: &Channel, guess: &Guess, mechanism: &Mechanism, parts: &[Recording], text: &mut String) {
    let Some(kind) = kind(channel, guess, mechanism) else {
        if guess.role != Role::Command {
            let name = channel.name.replace('\n', " ");
            let _ = write!(text, "\n# '{name}' [{}] is not used: {}\n", channel.unit, guess.why);
        }
        return;
    };
    // two channels cannot have one name: what is imposed is also read
    let imposed = guess.role == Role::Imposed;
    let name = plain(&channel.name) + if imposed { "_reading" } else { "" };
    let why = if imposed { "the imposed motion as it was read" } else { guess.why.as_str() };
    let values = longest(channel, parts);
    let unit = channel.unit.as_str();
    let Reading { sigma, step, bias } = Reading::of(values, unit);
    let noise = match step {
        Some(step) if sigma <= step / 12.0_f64.sqrt() => {
            format!("noise = \"{} {unit}\" # not above the resolution\n", digits(step / 12.0_f64.sqrt(), 2))
        }
        _ => {
            format!("noise = \"{} {unit}\" # of one sample, from the recording's third differences\n", digits(sigma, 2))
        }
    };
    let step = step.map_or(String::new(), |step| {
        format!("resolution = \"{} {unit}\" # smallest step in the recording\n", digits(step, 3))
    });
    let bias = digits(bias, 2);
    let _ = write!(
        text,
        "\n[[sensor]] # {why}\nname = \"{name}\"\n{kind}{noise}{step}\
         bias = {{ value = 0, sigma = \"{bias} {unit}\", scope = \"per recording\" }} # CHECK: data sheet\n{}",
        own_period(channel, parts)
    );
}

/// How well a sensor reads, from its samples.
pub struct Reading {
    /// White noise of one sample.
    pub sigma: f64,
    /// Smallest step.
    pub step: Option<f64>,
    /// Standard deviation of the offset.
    pub bias: f64,
}

/// Offset of a sensor whose data sheet nobody has, as a share of the range it read: the accuracy
/// class of common industrial sensors (IEC 60051: 0.5 to 1.5 %).
const ACCURACY_CLASS: f64 = 0.01;
/// Noise where a channel has none: that of the last digit of a single-precision logger, as a share
/// of the largest value (2⁻²⁴).
const LAST_DIGIT: f64 = 6e-8;

impl Reading {
    /// Of the samples of a channel; an angle is read within a turn, however many turns there are.
    pub fn of(values: &[f64], unit: &str) -> Self {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (span, size) = if values.is_empty() { (0.0, 0.0) } else { (most - least, most.abs().max(least.abs())) };
        let span = if unit == "rad" { span.min(core::f64::consts::TAU) } else { span };
        let step = resolution(values);
        let sigma = noise_sigma(values).max(LAST_DIGIT * size).max(f64::MIN_POSITIVE.sqrt());
        let bias = (ACCURACY_CLASS * span).max(3.0 * sigma).max(step.unwrap_or(0.0));
        Reading { sigma, step, bias }
    }
}

/// Kind and place of a sensor.
fn kind(channel: &Channel, guess: &Guess, mechanism: &Mechanism) -> Option<String> {
    let body = mechanism.body();
    let spatial_axis = axis_of(&channel.name).filter(|axis| mechanism.spatial || *axis != "z");
    let along = spatial_axis.or(mechanism.axes.last().map(|axis| axis.along)).unwrap_or("x");
    let on_joint = |kind: &str, linear: bool| {
        mechanism.joint(channel, linear).map(|joint| format!("kind = \"{kind}\"\njoint = \"{}\"\n", joint.name))
    };
    match guess.role {
        Role::Angle => on_joint("encoder", false),
        Role::Displacement => on_joint("encoder", true),
        Role::Imposed => {
            let reads = if matches!(channel.unit.as_str(), "rad" | "m") { "encoder" } else { "joint_rate" };
            on_joint(reads, channel.unit.starts_with('m')).filter(|_| channel.unit != "m/s^2")
        }
        Role::AngleRate => on_joint("joint_rate", false).or_else(|| {
            let axis = format!("axis = \"{}\"\n", spatial_axis.unwrap_or("z"));
            let axis = if mechanism.spatial { axis } else { String::new() };
            Some(format!("kind = \"gyro\"\nbody = \"{body}\"\n{axis}"))
        }),
        Role::Velocity => on_joint("joint_rate", true).or_else(|| {
            Some(format!("kind = \"velocity\"\nbody = \"{body}\"\naxis = \"{along}\" # of inertial space\n"))
        }),
        Role::Acceleration => {
            let place = if mechanism.spatial { "[\"? m\", \"? m\", \"? m\"]" } else { "[\"? m\", \"? m\"]" };
            Some(format!(
                "kind = \"accelerometer\"\nbody = \"{body}\"\naxis = \"{along}\" # CHECK\n\
                 position = {{ value = {place}, sigma = \"? m\" }} # FILL IN: where it sits, from the body's origin; the axes of one unit alike\n"
            ))
        }
        Role::Force => on_joint("joint_torque", true),
        Role::Torque => on_joint("joint_torque", false),
        Role::Command | Role::Unused | Role::Unknown => None,
    }
}

fn own_period(channel: &Channel, parts: &[Recording]) -> String {
    let (period_s, _) = rates(parts);
    let own_s = median_step(&channel.time_s);
    if (own_s / period_s - 1.0).abs() < 0.01 { String::new() } else { format!("period = \"{} s\"\n", digits(own_s, 6)) }
}
