//! `[[source]]` and `[[sensor]]`: one entry is one channel, or one per axis of `axis = "xyz"`.

use super::numbers;
use super::section::Section;
use super::{bodies, units};
use dynamics::description::{Noise, Plant, Quantity, Reading, Sensor, SensorKind, Source};

/// Reads one `[[source]]`.
pub(super) fn source(section: &mut Section<'_, '_>) -> Source {
    let source = Source {
        name: section.name("source"),
        clock_offset_s: section.quantity_or("clock_offset", "s", 0.0),
        clock_skew: section.quantity_or("clock_skew", "1", 0.0),
    };
    section.finish();
    source
}

/// Reads one `[[sensor]]`, a channel for each axis; `plant` has its bodies, appendages and
/// actuators.
pub(super) fn sensors(section: &mut Section<'_, '_>, plant: &Plant) -> Vec<Sensor> {
    let name = section.name("sensor");
    let kinds = sensor_kinds(section, plant, &name);
    let mut channels = Vec::with_capacity(kinds.len());
    let one = Sensor {
        name: name.clone(),
        kind: kinds[0].1.clone(),
        noise: Noise::default(),
        bias: Quantity::known(0.0),
        scale: section.quantity_or("scale", "1", 0.0),
        misalignment: bodies::orientation(section, "misalignment"),
        range: None,
        resolution: Quantity::known(0.0),
        low_pass_hz: section.quantity("low_pass", "Hz"),
        delay_s: section.quantity_or("delay", "s", 0.0),
        period_s: section.quantity("period", "s"),
        reading: section
            .word("reading", &[("instant", Reading::Instant), ("mean", Reading::Mean)], Some(Reading::Instant))
            .unwrap_or_default(),
        source: section.text("source"),
    };
    let unit = plant.sensor_unit(&one);
    if let SensorKind::Encoder { joint } | SensorKind::JointRate { joint } | SensorKind::JointTorque { joint } =
        &one.kind
        && section.is_unsure_of_joint(plant, joint)
    {
        section.take_any_unit();
    }
    let range = section.quantity("range", unit);
    let (bias, resolution) = (section.quantity_or("bias", unit, 0.0), resolution(section, &one.kind, unit));
    let one = Sensor { noise: noise(section, unit), bias, range, resolution, ..one };
    for (suffix, kind) in kinds {
        channels.push(Sensor { name: format!("{name}{suffix}"), kind, ..one.clone() });
    }
    section.finish();
    channels
}

/// A density where the unit is one (unit·√s), else a standard deviation of one sample.
fn noise(section: &Section<'_, '_>, unit: &str) -> Noise {
    let Some(node) = section.get("noise") else { return Noise::default() };
    let density = format!("{unit}*sqrt(s)");
    let dimension = units::parse(&density).map(|unit| unit.dimension).ok();
    if numbers::unit_of(node).is_some_and(|given| Some(given.dimension) == dimension) {
        return Noise::Density(section.read("noise", node, &density));
    }
    // the density of an angle where that of a rate is wanted
    let integrated = units::parse(&format!("{density}*s")).map(|unit| unit.dimension).ok();
    if numbers::unit_of(node).is_some_and(|given| Some(given.dimension) == integrated) {
        let message = format!("noise of {} is the density of what {unit} integrates to", section.what);
        let cure = format!(
            "a density is in ({unit})/sqrt(Hz) or, the same, {density}: of a gyro deg/s/sqrt(Hz) or deg/sqrt(h)"
        );
        section.error("noise", message, cure);
        return Noise::default();
    }
    Noise::PerSample(section.read("noise", node, unit))
}

/// A step, or for an angle `"19 bit"`: one turn divided by 2¹⁹.
fn resolution(section: &Section<'_, '_>, kind: &SensorKind, unit: &str) -> Quantity {
    let bits = section
        .get("resolution")
        .and_then(|node| node.get_ref().as_str())
        .and_then(|text| text.trim().strip_suffix("bit"));
    let (Some(bits), true) =
        (bits, unit == "rad" && matches!(kind, SensorKind::Encoder { .. } | SensorKind::Attitude { .. }))
    else {
        return section.quantity_or("resolution", unit, 0.0);
    };
    let Some(bits) = bits.trim().parse::<u32>().ok().filter(|bits| (1..=32).contains(bits)) else {
        let message = format!("resolution of {} is not 1 to 32 bit: '{}'", section.what, bits.trim());
        section.error("resolution", message, "");
        return Quantity::known(0.0);
    };
    Quantity::known(core::f64::consts::TAU / (1_u64 << bits) as f64)
}

const KINDS: [(&str, u8); 11] = [
    ("gyro", 0),
    ("accelerometer", 1),
    ("encoder", 2),
    ("joint_rate", 3),
    ("joint_torque", 4),
    ("force", 5),
    ("torque", 6),
    ("position", 7),
    ("velocity", 8),
    ("attitude", 9),
    ("wheel_speed", 10),
];

type Channels = Vec<(String, SensorKind)>;

/// What is measured, with the suffix of each channel's name; never empty.
fn sensor_kinds(section: &Section<'_, '_>, plant: &Plant, name: &str) -> Channels {
    let body = || section.required_text("body", "the body it sits on");
    let joint = || section.required_text("joint", "the joint it reads");
    let single = |kind| vec![(String::new(), kind)];
    match section.word("kind", &KINDS, None) {
        Some(0) => turning(section, body(), |body, axis| SensorKind::Gyro { body, axis }),
        Some(1) => accelerometer(section, plant),
        Some(2) => single(SensorKind::Encoder { joint: joint() }),
        Some(3) => single(SensorKind::JointRate { joint: joint() }),
        Some(4) => single(SensorKind::JointTorque { joint: joint() }),
        Some(5) => along(section, joint(), |joint, axis| SensorKind::Force { joint, axis }),
        Some(6) => turning(section, joint(), |joint, axis| SensorKind::Torque { joint, axis }),
        Some(7) => {
            let position_m = section.vector_or_zero("position", "m");
            along(section, body(), |body, axis| SensorKind::Position { body, position_m, axis })
        }
        Some(8) => {
            let position_m = section.vector_or_zero("position", "m");
            along(section, body(), |body, axis| SensorKind::Velocity { body, position_m, axis })
        }
        Some(9) => turning(section, body(), |body, axis| SensorKind::Attitude { body, axis }),
        Some(_) => single(SensorKind::WheelSpeed { actuator: section.required_text("actuator", "the wheel") }),
        None => unknown(section, name),
    }
}

/// A stand-in that gives no further report.
fn unknown(section: &Section<'_, '_>, name: &str) -> Channels {
    section.be_lenient();
    section.be_unsure(name);
    for key in ["body", "axis", "noise", "bias", "range", "resolution"] {
        section.get(key);
        section.poison(key);
    }
    vec![(String::new(), SensorKind::Gyro { body: String::new(), axis: [0.0, 0.0, 1.0] })]
}

fn accelerometer(section: &Section<'_, '_>, plant: &Plant) -> Channels {
    let point = section.text("point");
    let Some(point) = point else {
        let body = section.required_text("body", "the body it sits on; or point = \"APPENDAGE:POINT\"");
        let position_m = section.vector_or_zero("position", "m");
        return along(section, body, |body, axis| SensorKind::Accelerometer { body, position_m, axis, point: None });
    };
    let Some((appendage, point)) = point.split_once(':') else {
        section.error(
            "point",
            format!("point of {} is '{point}', not APPENDAGE:POINT", section.what),
            "as in \"panel:tip\"",
        );
        section.poison("body");
        let none = Default::default();
        return along(section, String::new(), |body, axis| SensorKind::Accelerometer {
            body,
            position_m: none,
            axis,
            point: None,
        });
    };
    let found = plant.appendages.iter().find(|candidate| candidate.name == appendage);
    let body = section.text("body").or_else(|| found.map(|found| found.body.clone())).unwrap_or_else(|| {
        // the unknown appendage is reported by itself
        section.poison("body");
        String::new()
    });
    let undeformed =
        found.and_then(|found| found.points.iter().find(|(name, _)| name == point)).map(|(_, position)| *position);
    let position_m = undeformed.unwrap_or_default();
    let point = Some((appendage.to_owned(), point.to_owned()));
    along(section, body, |body, axis| SensorKind::Accelerometer { body, position_m, axis, point: point.clone() })
}

/// Channels that feel along an axis: it must be stated.
fn along(section: &Section<'_, '_>, of: String, kind: impl Fn(String, [f64; 3]) -> SensorKind) -> Channels {
    if let Some(axes) = several(section) {
        return axes.into_iter().map(|(suffix, axis)| (suffix, kind(of.clone(), axis))).collect();
    }
    vec![(String::new(), kind(of, section.required_axis("axis")))]
}

/// Channels that feel about an axis: in a plane it is z.
fn turning(section: &Section<'_, '_>, of: String, kind: impl Fn(String, [f64; 3]) -> SensorKind) -> Channels {
    if section.planar() && !section.has("axis") {
        section.get("axis");
        return vec![(String::new(), kind(of, [0.0, 0.0, 1.0]))];
    }
    along(section, of, kind)
}

/// `axis = "xyz"`: a channel for each letter, named after it.
fn several(section: &Section<'_, '_>) -> Option<Vec<(String, [f64; 3])>> {
    let letters = section.get("axis")?.get_ref().as_str()?;
    let distinct = letters.len() > 1 && letters.bytes().enumerate().all(|(i, b)| !letters.as_bytes()[..i].contains(&b));
    if !distinct || !letters.bytes().all(|letter| b"xyz".contains(&letter)) {
        return None;
    }
    let unit = |letter: char| core::array::from_fn(|i| f64::from(u8::from("xyz".as_bytes()[i] as char == letter)));
    Some(letters.chars().map(|letter| (format!("_{letter}"), unit(letter))).collect())
}
