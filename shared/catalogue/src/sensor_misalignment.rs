//! A sensitive axis that points aside.

use super::geometry::{across, tilted};
use super::parts;
use dynamics::description::{Plant, Sensor, SensorKind, Site, SiteKind, Space};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Misalignment of a sensor: `a → cos e a + sin e (e1 t1 + e2 t2) / e`, a its sensitive axis.
pub static EFFECT: Effect = Effect {
    kind: "sensor_misalignment",
    title: "Misalignment of a sensor (cross-axis sensitivity)",
    sites: &[SiteKind::Sensor],
    applies: has_axis,
    parameters: &[
        EffectParameter::new("tilt_1", "rad", [-0.2, 0.2], 0.01, "tilt of the true axis towards t1 = z x axis")
            .amplitude(),
        EffectParameter::new("tilt_2", "rad", [-0.2, 0.2], 0.0, "tilt towards t2 = axis x t1")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Structure(build),
    family: Family::SensorError,
    what: "Sensitive axis a -> cos e a + sin e (e1 t1 + e2 t2) / e, e the length of the tilt (e1, e2): the reading takes sin e of the \
           cross-axis motion. For an axis along z, t1 is x.",
    signature: "One channel carries a small copy of what another axis does.",
    confounders: "com_shift and thruster_misalignment where one actuator makes all motion; gyro_g_sensitivity; the sensor's own \
                  misalignment where the file states one with a prior (identical).",
    experiment: "Motion along each axis in turn.",
    ..Effect::PLAIN
};

fn has_axis(plant: &Plant, site: &Site) -> bool {
    let here = plant.sensors.iter().find(|sensor| sensor.name == site.name);
    here.is_some_and(|sensor| sensor.kind.has_direction(plant.space == Space::Planar))
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
    let tilt = if plant.space == Space::Planar { [p[0], 0.0] } else { [p[0], p[1]] };
    if tilt == [0.0; 2] {
        return Ok(());
    }
    let sensor = parts::sensor_mut(plant, site)?;
    let axis = axis(sensor).ok_or_else(|| format!("{site} has no sensitive axis"))?;
    *axis = tilted(*axis, across(*axis), tilt);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{axis, build};
    use crate::geometry::dot;
    use crate::trial::plant;
    use dynamics::description::Space;

    #[test]
    fn the_axis_is_turned_by_the_tilt_and_stays_a_unit_vector() {
        let mut built = plant();
        build(&mut built, &"sensor:acc_x".parse().unwrap(), &[0.1, 0.7]).unwrap(); // the plane does not feel the second
        let turned = *axis(&mut built.sensors[1]).unwrap();
        assert!((turned[1] - libm::sin(0.1)).abs() < 1e-16 && turned[2] == 0.0);
        assert!((dot(turned, turned) - 1.0).abs() < 1e-15); // rounding
        *axis(&mut built.sensors[1]).unwrap() = [1.0, 0.0, 0.0];
        assert_eq!(built, plant()); // nothing else moved
        assert!(build(&mut built, &"sensor:enc".parse().unwrap(), &[0.1, 0.0]).is_err());
    }

    #[test]
    fn in_space_both_components_tilt_and_their_length_is_the_angle() {
        let mut built = plant();
        built.space = Space::Spatial;
        build(&mut built, &"sensor:acc_x".parse().unwrap(), &[0.03, -0.04]).unwrap();
        let turned = *axis(&mut built.sensors[1]).unwrap();
        assert!((turned[0] - libm::cos(0.05)).abs() < 1e-15); // rounding
        assert!((turned[1] - 0.6 * libm::sin(0.05)).abs() < 1e-16 && (turned[2] + 0.8 * libm::sin(0.05)).abs() < 1e-16);
    }
}
