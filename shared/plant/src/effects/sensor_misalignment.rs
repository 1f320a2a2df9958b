//! A sensitive axis that points aside.

use super::geometry::perpendicular;
use super::{Effect, EffectParameter, Law, parts};
use crate::description::{Plant, Sensor, SensorKind, Site, SiteKind};

pub static EFFECT: Effect = Effect {
    kind: "sensor_misalignment",
    title: "Misalignment of a sensor (cross-axis sensitivity)",
    sites: &[SiteKind::Sensor],
    applies: has_axis,
    parameters: &[
        EffectParameter::new("angle", "rad", [-0.2, 0.2], 0.01, "angle e between true and stated axis"),
        EffectParameter::new("clock", "rad", [-3.2, 3.2], 0.0, "direction of the tilt about the axis; 0: z x axis"),
    ],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::Structure(build),
    what: "Sensitive axis a -> cos e a + sin e t, t perpendicular to a: the reading takes sin e of the cross-axis motion.",
    signature: "One channel carries a small copy of what another axis does.",
    confounders: "com_shift and thruster_misalignment where one actuator makes all motion; gyro_g_sensitivity.",
    experiment: "Motion along each axis in turn.",
};

fn has_axis(plant: &Plant, site: &Site) -> bool {
    plant.sensors.iter().any(|sensor| sensor.name == site.name && axis(&mut sensor.clone()).is_some())
}

fn axis(sensor: &mut Sensor) -> Option<&mut [f64; 3]> {
    use SensorKind::{Accelerometer, Attitude, Force, Gyro, Position, Torque, Velocity};
    match &mut sensor.kind {
        Gyro { axis, .. } | Accelerometer { axis, .. } | Force { axis, .. } | Torque { axis, .. } => Some(axis),
        Position { axis, .. } | Velocity { axis, .. } | Attitude { axis, .. } => Some(axis),
        SensorKind::Encoder { .. } | SensorKind::JointRate { .. } => None,
        SensorKind::JointTorque { .. } | SensorKind::WheelSpeed { .. } => None,
    }
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    let sensor = parts::sensor_mut(plant, site)?;
    let axis = axis(sensor).ok_or_else(|| format!("{site} has no sensitive axis"))?;
    let (sin, cos) = libm::sincos(p[0]);
    let aside = perpendicular(*axis, p[1]);
    *axis = core::array::from_fn(|i| cos * axis[i] + sin * aside[i]);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{axis, build};
    use crate::effects::geometry::dot;
    use crate::effects::trial::plant;

    #[test]
    fn the_axis_is_turned_by_the_angle_and_stays_a_unit_vector() {
        let mut built = plant();
        build(&mut built, &"sensor:acc_x".parse().unwrap(), &[0.1, 0.0]).unwrap();
        let turned = *axis(&mut built.sensors[1]).unwrap();
        assert!((turned[1] - libm::sin(0.1)).abs() < 1e-16 && turned[2] == 0.0);
        assert!((dot(turned, turned) - 1.0).abs() < 1e-15); // rounding
        *axis(&mut built.sensors[1]).unwrap() = [1.0, 0.0, 0.0];
        assert_eq!(built, plant()); // nothing else moved
        assert!(build(&mut built, &"sensor:enc".parse().unwrap(), &[0.1, 0.0]).is_err());
    }
}
