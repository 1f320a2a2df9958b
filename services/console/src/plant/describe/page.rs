//! The page that `obsid plant describe` prints.

use super::Facts;
use super::poles::LoopPole;
use crate::plant::words::{count, digits, direction, joint, noise, quantity, vector, with_unit};
use dynamics::description::{
    Actuator, ActuatorKind, Body, Controller, Drive, Plant, Sensor, SensorKind, SignalKind, Space, TankModel,
};
use std::fmt::Write;

/// The plant on one page of text: bodies, parts, drives, sensors, modes and base parameters.
pub fn text(plant: &Plant, facts: &Facts) -> String {
    let mut text = String::new();
    head(plant, &mut text);
    bodies(plant, facts, &mut text);
    parts(plant, &mut text);
    drives(plant, &mut text);
    sensors(plant, &mut text);
    states(facts, &mut text);
    poles(facts, &mut text);
    base(facts, &mut text);
    effects(plant, facts, &mut text);
    text
}

fn head(plant: &Plant, text: &mut String) {
    let space = if plant.space == Space::Planar { "planar (x-y, about z)" } else { "spatial" };
    let gravity = plant.environment.gravity_m_s2.map(|g| g.value);
    let gravity = if gravity == [0.0; 3] { "none".into() } else { format!("{} m/s^2", vector(&gravity)) };
    let settings = &plant.simulation;
    let _ = writeln!(text, "{}: {}", plant.name, plant.about);
    let _ = writeln!(
        text,
        "{space}; gravity {gravity}; record of {} s, control period {}, step {}",
        digits(settings.duration_s, 6),
        with_unit(settings.period_s, "s"),
        with_unit(settings.step_s, "s")
    );
}

fn bodies(plant: &Plant, facts: &Facts, text: &mut String) {
    let _ = writeln!(
        text,
        "\nbodies{:<24} {:<34} {:>12} {:>22}  inertia about it [kg*m^2]",
        "", "joint", "mass [kg]", "centre of mass [m]"
    );
    for body in plant.bodies.iter().filter(|body| body.parent.is_none()) {
        branch(plant, body, 1, text);
    }
    let total = &facts.inertial;
    let inertia = match (total.inertia_com_kg_m2, plant.space) {
        (None, _) => "-".into(),
        (Some(inertia), Space::Planar) => digits(inertia[2][2], 5),
        (Some(inertia), Space::Spatial) => vector(&[inertia[0][0], inertia[1][1], inertia[2][2]]),
    };
    let _ = writeln!(
        text,
        "  {:<28} {:<34} {:>12} {:>22}  {inertia}",
        "all, with tanks",
        "in the initial posture",
        digits(total.mass_kg, 6),
        vector(&total.com_m[..if plant.space == Space::Planar { 2 } else { 3 }])
    );
}

fn branch(plant: &Plant, body: &Body, depth: usize, text: &mut String) {
    let planar = plant.space == Space::Planar;
    let com = body.com_m.map(|c| c.value);
    let inertia = body.inertia_com_kg_m2.map(|i| i.value);
    let (com, inertia) =
        if planar { (vector(&com[..2]), digits(inertia[2], 5)) } else { (vector(&com), vector(&inertia[..3])) };
    let named = if body.joint.name == body.name {
        joint(&body.joint)
    } else {
        format!("{}: {}", body.joint.name, joint(&body.joint))
    };
    let name = format!("{}{}", "  ".repeat(depth), body.name);
    let _ = writeln!(text, "{name:<30} {named:<34} {:>12} {com:>22}  {inertia}", digits(body.mass_kg.value, 6));
    for child in plant.bodies.iter().filter(|child| child.parent.as_ref() == Some(&body.name)) {
        branch(plant, child, depth + 1, text);
    }
}

fn parts(plant: &Plant, text: &mut String) {
    for tank in &plant.tanks {
        let model = match &tank.model {
            TankModel::Spring { axes, stiffness_n_m, .. } => {
                let axes: Vec<String> = axes.iter().map(|axis| direction(*axis)).collect();
                let alone: Vec<String> = stiffness_n_m
                    .iter()
                    .map(|k| digits((k.value / tank.mass_kg.value).max(0.0).sqrt() / core::f64::consts::TAU, 4))
                    .collect();
                format!("spring along {}, {} Hz with the body held", axes.join(" "), alone.join(" "))
            }
            TankModel::Pendulum { rest, length_m, .. } => {
                format!("pendulum of {} towards {}", with_unit(length_m.value, "m"), direction(*rest))
            }
        };
        let _ = writeln!(text, "tank {} on {}: {}, {model}", tank.name, tank.body, quantity(tank.mass_kg, "kg"));
    }
    for appendage in &plant.appendages {
        let points: Vec<&str> = appendage.points.iter().map(|(name, _)| name.as_str()).collect();
        let _ = writeln!(text, "appendage {} on {}, points {}", appendage.name, appendage.body, points.join(" "));
        for mode in &appendage.modes {
            let _ = writeln!(
                text,
                "  {}: {} with the body held, damping {} %",
                mode.name,
                quantity(mode.frequency_hz, "Hz"),
                digits(100.0 * mode.damping_ratio.value, 4)
            );
        }
    }
}

fn drives(plant: &Plant, text: &mut String) {
    if plant.actuators.is_empty() {
        let _ = writeln!(text, "\nno actuator: a free response");
        return;
    }
    let _ = writeln!(text, "\n{}", count(plant.actuators.len(), "actuator"));
    for actuator in &plant.actuators {
        let unit = plant.actuator_unit(actuator);
        let commands: Vec<&str> = actuator.command.iter().map(|term| signal(&term.kind)).collect();
        let loops = plant.controllers.iter().filter(|controller| controller.actuator == actuator.name);
        let mut sources: Vec<String> = commands.into_iter().map(str::to_owned).collect();
        sources.extend(loops.map(|controller| format!("loop {}", controller.name)));
        let sources = if sources.is_empty() { "nothing commanded".into() } else { sources.join(" + ") };
        let range = actuator.range.map_or(String::new(), |range| format!(", range {}", with_unit(range.value, unit)));
        let unknown = if actuator.noise.value == 0.0 {
            String::new()
        } else {
            format!(", noise {}", with_unit(actuator.noise.value, unit))
        };
        let _ = writeln!(text, "  {:<20} {:<44} [{unit}] {sources}{range}{unknown}", actuator.name, acts(actuator));
    }
    for controller in &plant.controllers {
        let _ = writeln!(text, "  {:<20} {}", controller.name, gains(controller));
    }
}

fn acts(actuator: &Actuator) -> String {
    match &actuator.kind {
        ActuatorKind::JointTorque { joint } => format!("effort in joint {joint}"),
        ActuatorKind::BodyForce { body, direction: along, .. } => {
            format!("force on {body} along {}", direction(*along))
        }
        ActuatorKind::BodyTorque { body, direction: about } => format!("torque on {body} about {}", direction(*about)),
        ActuatorKind::Thruster { body, direction: along, .. } => {
            format!("thruster on {body} along {}", direction(*along))
        }
        ActuatorKind::Wheel { body, axis, .. } => format!("wheel in {body} about {}", direction(*axis)),
        ActuatorKind::Motor { joint, drive, .. } => {
            let drive = if matches!(drive, Drive::Current) { "current" } else { "voltage" };
            format!("motor in joint {joint}, {drive}")
        }
        ActuatorKind::PrescribedJoint { joint, .. } => format!("moves joint {joint} as commanded"),
        ActuatorKind::PrescribedBase { .. } => "moves inertial space as commanded".into(),
    }
}

const fn signal(kind: &SignalKind) -> &'static str {
    match kind {
        SignalKind::Constant { .. } => "constant",
        SignalKind::Sine { .. } => "sine",
        SignalKind::Square { .. } => "square",
        SignalKind::Multisine { .. } => "multisine",
        SignalKind::Chirp { .. } => "chirp",
        SignalKind::Fourier { .. } => "fourier",
        SignalKind::Step { .. } => "step",
        SignalKind::Pulse { .. } => "pulse",
        SignalKind::Staircase { .. } => "staircase",
        SignalKind::Slew { .. } => "slew",
        SignalKind::Table { .. } => "table",
    }
}

fn gains(controller: &Controller) -> String {
    let gains = [("kp", controller.kp), ("ki", controller.ki), ("kd", controller.kd)];
    let mut stated: Vec<String> = gains
        .iter()
        .filter(|(_, gain)| gain.value != 0.0)
        .map(|(name, gain)| format!("{name} {}", digits(gain.value, 5)))
        .collect();
    if controller.feed_forward.value != 0.0 {
        stated.push(format!("feed-forward {} %", digits(100.0 * controller.feed_forward.value, 3)));
    }
    let reference: Vec<&str> = controller.reference.iter().map(|term| signal(&term.kind)).collect();
    let reference = if reference.is_empty() { "hold".into() } else { reference.join(" + ") };
    format!(
        "{} -> {}: {}, reference {reference}",
        controller.position_sensor.as_deref().unwrap_or("-"),
        controller.actuator,
        stated.join(", ")
    )
}

fn sensors(plant: &Plant, text: &mut String) {
    let _ = writeln!(
        text,
        "\n{:<27} {:<34} {:<8} {:<24} {:<14} every",
        count(plant.sensors.len(), "sensor"),
        "of",
        "unit",
        "noise",
        "resolution"
    );
    for sensor in &plant.sensors {
        let unit = plant.sensor_unit(sensor);
        let step = sensor.resolution.value;
        let period_s = sensor.period_s.map_or(plant.simulation.period_s, |period| period.value);
        let _ = writeln!(
            text,
            "  {:<25} {:<34} {unit:<8} {:<24} {:<14} {}",
            sensor.name,
            measures(sensor),
            noise(sensor.noise, unit),
            if step == 0.0 { "-".into() } else { with_unit(step, unit) },
            with_unit(period_s, "s")
        );
    }
}

fn measures(sensor: &Sensor) -> String {
    match &sensor.kind {
        SensorKind::Gyro { body, axis } => format!("rate of {body} about {}", direction(*axis)),
        SensorKind::Accelerometer { body, axis, point: None, .. } => {
            format!("acceleration of {body} along {}", direction(*axis))
        }
        SensorKind::Accelerometer { axis, point: Some((appendage, point)), .. } => {
            format!("acceleration of {appendage}:{point} along {}", direction(*axis))
        }
        SensorKind::Encoder { joint } => format!("joint {joint}"),
        SensorKind::JointRate { joint } => format!("rate of joint {joint}"),
        SensorKind::JointTorque { joint } => format!("effort in joint {joint}"),
        SensorKind::Force { joint, axis } => format!("force through {joint} along {}", direction(*axis)),
        SensorKind::Torque { joint, axis } => format!("torque through {joint} about {}", direction(*axis)),
        SensorKind::Position { body, axis, .. } => format!("position of {body} along {}", direction(*axis)),
        SensorKind::Velocity { body, axis, .. } => format!("velocity of {body} along {}", direction(*axis)),
        SensorKind::Attitude { body, axis } => format!("attitude of {body} about {}", direction(*axis)),
        SensorKind::WheelSpeed { actuator } => format!("speed of {actuator}"),
    }
}

fn states(facts: &Facts, text: &mut String) {
    let names: Vec<String> = facts.states.iter().map(|state| format!("{} [{}]", state.name, state.unit)).collect();
    let _ = writeln!(text, "\n{}: {}", count(names.len(), "state"), names.join(", "));
}

fn poles(facts: &Facts, text: &mut String) {
    let poles = &facts.poles;
    let _ =
        writeln!(text, "\npoles {}, inputs held (loops open, bodies as their joints carry them)", poles.about.text());
    for mode in &poles.open {
        let _ = writeln!(text, "  {}  {}", pole(mode.frequency_hz, mode.damping_ratio), mode.label);
    }
    let _ = writeln!(text, "  {} at zero: rigid-body motion and free integrators", count(poles.zeros, "pole"));
    let Some(closed) = &poles.closed else { return };
    let _ = writeln!(
        text,
        "poles with the loops closed, sampled, without lags and delays; rigid-body ones at zero left out"
    );
    for LoopPole { frequency_hz, damping_ratio } in closed {
        let _ = writeln!(text, "  {}", pole(*frequency_hz, *damping_ratio));
    }
}

fn pole(frequency_hz: f64, damping_ratio: f64) -> String {
    if damping_ratio.abs() > 1.0 - 1e-9 {
        let time_s = 1.0 / (core::f64::consts::TAU * frequency_hz);
        let what = if damping_ratio > 0.0 { "decays" } else { "GROWS" };
        return format!("{what} in {:>10} s {:>16}", digits(time_s, 4), "");
    }
    format!("{:>12} Hz, damping {:>9} %", digits(frequency_hz, 5), digits(100.0 * damping_ratio, 4))
}

fn base(facts: &Facts, text: &mut String) {
    let base = &facts.inertial.base;
    let _ = writeln!(
        text,
        "\n{} of the rigid bodies, if all efforts{} were measured; condition number {}, gap {}",
        count(base.rank(), "base parameter"),
        if facts.inertial.free_base { " and the wrench on the free base" } else { "" },
        digits(base.condition_number, 3),
        if base.gap.is_finite() { format!("{:.0e}", base.gap) } else { "infinite".into() }
    );
    for parameter in &base.base {
        let _ = writeln!(text, "  {}", parameter.text);
    }
    for (names, what) in [(&base.regrouped, "only in these sums"), (&base.unidentifiable, "in no equation")] {
        if !names.is_empty() {
            let _ = writeln!(text, "  {what}: {}", names.join(", "));
        }
    }
    let Some(momentum) = &facts.inertial.momentum else { return };
    let span = &momentum.span;
    let _ = writeln!(
        text,
        "\n{} in the angular momentum of the free-floating arm (zero offsets taken as exact), manifold of {} dimensions{}",
        count(span.span_dimension, "base parameter"),
        span.manifold_dimension,
        if momentum.dependences.is_empty() { String::new() } else { format!(": {}", momentum.dependences.join(", ")) }
    );
    for (i, (function, value)) in span.functions.iter().zip(&span.coefficients).enumerate() {
        let _ = writeln!(text, "  a{:<3} {:>12} kg*m^2  of {function}", i + 1, digits(*value, 6));
    }
}

fn effects(plant: &Plant, facts: &Facts, text: &mut String) {
    let sites: Vec<String> = facts.effects.iter().map(|(site, number)| format!("{site} {number}")).collect();
    let _ = writeln!(
        text,
        "\neffects that can sit on it, by site (`obsid effects --plant FILE` lists them): {}",
        sites.join(", ")
    );
    for effect in &plant.effects {
        let _ = writeln!(text, "  carries {}@{}", effect.kind, effect.site);
    }
}
