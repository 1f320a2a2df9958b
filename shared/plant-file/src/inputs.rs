//! `[[actuator]]` with its command, `[[controller]]`, and the terms of signals.

use super::section::Section;
use dynamics::description::{
    Actuator, ActuatorKind, Base, Controller, Drive, Plant, Prescribed, Quantity, Signal, SignalKind, per_second,
};

const ACTUATORS: [(&str, u8); 8] = [
    ("joint_torque", 0),
    ("body_force", 1),
    ("body_torque", 2),
    ("thruster", 3),
    ("wheel", 4),
    ("motor", 5),
    ("prescribed_joint", 6),
    ("prescribed_base", 7),
];

const DERIVATIVES: [(&str, Prescribed); 3] =
    [("position", Prescribed::Position), ("rate", Prescribed::Rate), ("acceleration", Prescribed::Acceleration)];

/// Reads one `[[actuator]]`; `plant` has its bodies.
pub(super) fn actuator(section: &mut Section<'_, '_>, plant: &Plant) -> Actuator {
    let name = section.name("actuator");
    let kind = actuator_kind(section, &name);
    let none = Quantity::known(0.0);
    let mut actuator = Actuator { name, kind, command: Vec::new(), noise: none, range: None, recorded: true };
    let unit = plant.actuator_unit(&actuator);
    if let ActuatorKind::JointTorque { joint } | ActuatorKind::PrescribedJoint { joint, .. } = &actuator.kind
        && section.is_unsure_of_joint(plant, joint)
    {
        section.take_any_unit();
    }
    actuator.command = signals(section, "command", unit);
    actuator.noise = section.quantity_or("noise", unit, 0.0);
    actuator.range = section.quantity("range", unit);
    actuator.recorded = section.flag("recorded", true);
    section.finish();
    actuator
}

fn actuator_kind(section: &Section<'_, '_>, name: &str) -> ActuatorKind {
    let body = || section.required_text("body", "the body it acts on");
    let joint = || section.required_text("joint", "the joint it drives");
    let about =
        |key| if section.planar() { section.axis(key).unwrap_or([0.0, 0.0, 1.0]) } else { section.required_axis(key) };
    let what = || section.word("what", &DERIVATIVES, None).unwrap_or(Prescribed::Position);
    match section.word("kind", &ACTUATORS, None) {
        Some(0) => ActuatorKind::JointTorque { joint: joint() },
        Some(1) => ActuatorKind::BodyForce {
            body: body(),
            position_m: section.vector_or_zero("position", "m"),
            direction: section.required_axis("direction"),
        },
        Some(2) => ActuatorKind::BodyTorque { body: body(), direction: about("direction") },
        Some(3) => ActuatorKind::Thruster {
            body: body(),
            position_m: section.required_vector("position", "m"),
            direction: section.required_axis("direction"),
        },
        Some(4) => ActuatorKind::Wheel {
            body: body(),
            axis: about("axis"),
            inertia_kg_m2: section.required_quantity("inertia", "kg*m^2"),
            viscous_friction_n_m_s_rad: section.quantity_or("friction", "N*m*s/rad", 0.0),
            initial_speed_rad_s: section.quantity_or("initial_speed", "rad/s", 0.0),
        },
        Some(5) => ActuatorKind::Motor {
            joint: joint(),
            constant_n_m_a: section.required_quantity("constant", "N*m/A"),
            gear: section.quantity_or("gear", "1", 1.0),
            drive: drive(section),
        },
        Some(6) => ActuatorKind::PrescribedJoint { joint: joint(), what: what() },
        Some(_) => ActuatorKind::PrescribedBase {
            base: Base::Translation { direction: section.required_axis("direction") },
            what: what(),
        },
        None => unknown_actuator(section, name),
    }
}

/// A stand-in that gives no further report.
fn unknown_actuator(section: &Section<'_, '_>, name: &str) -> ActuatorKind {
    section.be_lenient();
    section.be_unsure(name);
    for key in ["body", "direction", "command", "noise", "range"] {
        section.poison(key);
    }
    ActuatorKind::BodyTorque { body: String::new(), direction: [0.0, 0.0, 1.0] }
}

fn drive(section: &Section<'_, '_>) -> Drive {
    match section.word("drive", &[("current", false), ("voltage", true)], Some(false)) {
        Some(true) => Drive::Voltage {
            resistance_ohm: section.required_quantity("resistance", "ohm"),
            back_emf_v_s_rad: section.required_quantity("back_emf", "V*s/rad"),
        },
        Some(false) => Drive::Current,
        None => {
            section.be_lenient();
            Drive::Current
        }
    }
}

/// Reads one `[[controller]]`; `plant` has its actuators and sensors.
pub(super) fn controller(section: &mut Section<'_, '_>, plant: &Plant) -> Controller {
    let none = Quantity::known(0.0);
    let mut controller = Controller {
        name: section.name("controller"),
        actuator: section.required_text("actuator", "the actuator it commands"),
        position_sensor: section.text("position_sensor"),
        rate_sensor: section.text("rate_sensor"),
        kp: none,
        ki: none,
        kd: none,
        reference: Vec::new(),
        feed_forward: section.quantity_or("feed_forward", "1", 0.0),
        reference_rate: section.flag("reference_rate", true),
    };
    let (effort, coordinate) = plant.controller_units(&controller);
    let unsure =
        |name: &String| section.is_unsure(name) || (plant.sensor(name).is_none() && plant.actuator(name).is_none());
    let refers_to = [Some(&controller.actuator), controller.position_sensor.as_ref(), controller.rate_sensor.as_ref()];
    if refers_to.into_iter().flatten().any(unsure) {
        section.take_any_unit();
    }
    controller.kp = section.quantity_or("kp", &format!("{effort}/{coordinate}"), 0.0);
    controller.ki = section.quantity_or("ki", &format!("{effort}/{coordinate}/s"), 0.0);
    controller.kd = section.quantity_or("kd", &format!("{effort}*s/{coordinate}"), 0.0);
    controller.reference = signals(section, "reference", coordinate);
    section.finish();
    controller
}

/// Terms of a signal: one table or a list of them.
fn signals(section: &Section<'_, '_>, key: &str, unit: &str) -> Vec<Signal> {
    section.sections(key, key).iter().map(|term| signal(term, unit)).collect()
}

fn signal(section: &Section<'_, '_>, unit: &str) -> Signal {
    let kind = signal_kind(section, unit);
    let signal = Signal { kind, begin_s: section.quantity_or("begin", "s", 0.0), end_s: section.quantity("end", "s") };
    section.finish();
    signal
}

const SIGNALS: [(&str, u8); 11] = [
    ("constant", 0),
    ("sine", 1),
    ("square", 2),
    ("multisine", 3),
    ("chirp", 4),
    ("fourier", 5),
    ("step", 6),
    ("pulse", 7),
    ("staircase", 8),
    ("slew", 9),
    ("table", 10),
];

fn signal_kind(section: &Section<'_, '_>, unit: &str) -> SignalKind {
    let required = |key: &str, unit: &str| section.required_quantity(key, unit);
    match section.word("kind", &SIGNALS, None) {
        Some(0) => SignalKind::Constant { value: required("value", unit) },
        Some(1) => SignalKind::Sine {
            amplitude: required("amplitude", unit),
            frequency_hz: required("frequency", "Hz"),
            phase_rad: section.quantity_or("phase", "rad", 0.0),
        },
        Some(2) => {
            SignalKind::Square { amplitude: required("amplitude", unit), frequency_hz: required("frequency", "Hz") }
        }
        Some(3) => SignalKind::Multisine {
            rms: required("rms", unit),
            period_s: required("period", "s"),
            first: section.count("first"),
            last: section.count("last"),
        },
        Some(4) => SignalKind::Chirp {
            amplitude: required("amplitude", unit),
            begin_hz: required("begin_frequency", "Hz"),
            end_hz: required("end_frequency", "Hz"),
        },
        Some(5) => fourier(section, unit),
        Some(6) => SignalKind::Step { size: required("size", unit) },
        Some(7) => SignalKind::Pulse {
            size: required("size", unit),
            width_s: required("width", "s"),
            period_s: section.quantity("period", "s"),
        },
        Some(8) => SignalKind::Staircase { step: required("step", unit), every_s: required("every", "s") },
        Some(9) => SignalKind::Slew { size: required("size", unit), width_s: required("width", "s") },
        Some(_) => SignalKind::Table {
            time_s: known_list(section, "time", "s"),
            value: known_list(section, "value", unit),
            smooth: section.flag("smooth", false),
        },
        None => {
            section.be_lenient();
            SignalKind::Constant { value: Quantity::known(0.0) }
        }
    }
}

fn fourier(section: &Section<'_, '_>, unit: &str) -> SignalKind {
    let per_second = per_second(unit);
    let coefficients = |key: &str| {
        section.list(key, &per_second).unwrap_or_else(|| {
            section.missing(key, &format!("as in {key} = {{ unit = \"{per_second}\", values = [0.1, 0.2] }}"));
            Vec::new()
        })
    };
    let (sine, cosine) = (coefficients("sine"), coefficients("cosine"));
    SignalKind::Fourier {
        offset: section.quantity_or("offset", unit, 0.0),
        period_s: section.required_quantity("period", "s"),
        sine,
        cosine,
    }
}

fn known_list(section: &Section<'_, '_>, key: &str, unit: &str) -> Vec<f64> {
    let Some(list) = section.list(key, unit) else {
        section.missing(key, &format!("as in {key} = {{ unit = \"{unit}\", values = [0, 1] }}"));
        return Vec::new();
    };
    if list.iter().any(|quantity| quantity.sigma.is_some()) {
        section.error(key, format!("{key} of {} cannot be estimated", section.what), "leave sigma out");
    }
    list.iter().map(|quantity| quantity.value).collect()
}
