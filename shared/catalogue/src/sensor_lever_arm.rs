//! A sensor at a position other than stated.

use super::parts;
use dynamics::description::{Plant, Quantity, Sensor, SensorKind, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Position error of a sensor: `r → r + d`, body axes.
pub static EFFECT: Effect = Effect {
    kind: "sensor_lever_arm",
    title: "Position error of a sensor",
    sites: &[SiteKind::Sensor],
    applies: has_position,
    parameters: &[
        EffectParameter::new("offset_x", "m", [-1.0, 1.0], 0.01, "true minus stated position, body x").amplitude(),
        EffectParameter::new("offset_y", "m", [-1.0, 1.0], 0.0, "true minus stated position, body y").amplitude(),
        EffectParameter::new("offset_z", "m", [-1.0, 1.0], 0.0, "true minus stated position, body z")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Structure(build),
    family: Family::SensorError,
    what: "r -> r + d: an accelerometer gains a x d + w x (w x d), a position or velocity the motion of d.",
    signature: "Residual of one accelerometer in step with angular acceleration and squared rate of its body.",
    confounders: "The sensor's own position where it has a prior (identical); com_shift (moves all accelerometers of the body), sensor_misalignment where force and torque come together.",
    experiment: "Turn without pushing, and push without turning.",
    ..Effect::PLAIN
};

fn has_position(plant: &Plant, site: &Site) -> bool {
    plant.sensors.iter().any(|sensor| sensor.name == site.name && position(&mut sensor.clone()).is_some())
}

fn position(sensor: &mut Sensor) -> Option<&mut [Quantity; 3]> {
    use SensorKind::{Accelerometer, Position, Velocity};
    match &mut sensor.kind {
        Accelerometer { position_m, point: None, .. } | Position { position_m, .. } | Velocity { position_m, .. } => {
            Some(position_m)
        }
        _ => None,
    }
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[..3] == [0.0; 3] {
        return Ok(());
    }
    let axes = parts::axes(plant);
    let sensor = parts::sensor_mut(plant, site)?;
    let position = position(sensor).ok_or_else(|| format!("{site} has no position"))?;
    for (coordinate, component) in position.iter_mut().zip(&p[..axes]) {
        coordinate.value += component;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{build, position};
    use crate::trial::plant;

    #[test]
    fn the_sensor_moves_by_the_offset_in_its_direction_and_nothing_else_does() {
        let mut built = plant();
        build(&mut built, &"sensor:acc_x".parse().unwrap(), &[0.25, 0.0, 0.0]).unwrap();
        let moved = position(&mut built.sensors[1]).unwrap();
        assert_eq!(moved.map(|x| x.value), [0.35, 0.2, 0.0]);
        moved[0].value = 0.1;
        assert_eq!(built, plant());
        assert!(build(&mut built, &"sensor:gyro_z".parse().unwrap(), &[0.25, 0.0, 0.0]).is_err());
    }
}
