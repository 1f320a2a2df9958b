//! Angles that were recorded modulo a turn, or counted from another turn than the plant's.
//!
//! An encoder of the plant counts over all turns. A recording that jumps by nearly a turn between
//! samples was wrapped: it is unwrapped. A turn more or less is the same place: the recording is
//! moved by whole turns towards where the plant begins. A zero that is off by less is the bias of
//! the sensor, which must then have a prior.

use core::f64::consts::{PI, TAU};
use dynamics::description::{Initial, Plant, Sensor, SensorKind, Space};

/// A step above this part of a turn between two samples is a wrap.
const WRAP_SHARE: f64 = 0.9;

/// Makes `value` continuous and near the plant's beginning; what was done or is missing, in words.
pub(super) fn turned(plant: &Plant, sensor: &Sensor, initial: &Initial, value: &mut [f64]) -> Option<String> {
    let joint = match &sensor.kind {
        SensorKind::Encoder { joint } if plant.sensor_unit(sensor) == "rad" => Some(joint),
        SensorKind::Attitude { .. } if plant.space == Space::Planar => None,
        _ => return None,
    };
    let wraps = unwrap(value);
    let mut said = (wraps > 0).then(|| format!("'{}' jumps by a turn {wraps} times and was unwrapped", sensor.name));
    let coordinate = format!("joint:{}", joint?);
    let begins = initial.values.iter().find(|v| v.coordinate == coordinate);
    let (Some(begins), Some(first)) = (begins, value.first().copied()) else { return said };
    let expected = begins.position.value + sensor.bias.value;
    // a spring about a rest angle knows one turn from another
    let sprung = plant.joint(joint?).is_some_and(|joint| joint.stiffness.value != 0.0);
    let turns = libm::round((first - expected) / TAU);
    if turns != 0.0 && !sprung {
        value.iter_mut().for_each(|v| *v -= turns * TAU);
        said = Some(format!("'{}' was moved by {} turns to where the plant begins", sensor.name, -turns));
    }
    let off = first - turns * TAU - expected;
    let sigma = libm::hypot(begins.position.sigma.unwrap_or(PI), sensor.bias.sigma.unwrap_or(0.0));
    if off.abs() > 5.0 * sigma {
        said = Some(format!(
            "'{}' begins {off:.3} rad from where the plant does, {:.0} times what its priors allow: is its zero another? Give its bias a prior",
            sensor.name,
            off.abs() / sigma
        ));
    }
    said
}

/// Takes whole turns out of steps that are nearly one; their number.
fn unwrap(value: &mut [f64]) -> usize {
    let (mut offset, mut wraps) = (0.0, 0);
    for i in 1..value.len() {
        let step = value[i] + offset - value[i - 1];
        if step.abs() > WRAP_SHARE * TAU && step.abs() < (2.0 - WRAP_SHARE) * TAU {
            offset -= TAU * step.signum();
            wraps += 1;
        }
        value[i] += offset;
    }
    wraps
}
