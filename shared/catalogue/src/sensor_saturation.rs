//! A reading that is cut.

use super::parts;
use dynamics::description::{Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Saturation of a sensor: `y` is clipped to ±1/`inverse_limit`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_saturation",
    title: "Saturation of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("inverse_limit", "1/*", [0.0, 1e5], 1.0, "one over the largest magnitude read")
        .amplitude()],
    law: Law::Structure(build),
    family: Family::SensorError,
    what: "y is clipped to 1/inverse_limit behind lag, delay and noise, as the range of the sensor is. The inverse is the amplitude: zero is no limit.",
    signature: "Plateaus of one height in one channel while others move on.",
    confounders: "actuator_saturation, joint_end_stop (both seen by other channels).",
    experiment: "Histogram of the readings; the same motion at half size.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] != 0.0 {
        let sensor = parts::sensor_mut(plant, site)?;
        let stated = sensor.range.map_or(f64::INFINITY, |range| range.value);
        sensor.range = Some(Quantity::known(stated.min(1.0 / p[0])));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn the_narrower_of_the_stated_range_and_the_limit_counts() {
        let site = "sensor:enc".parse().unwrap();
        let mut built = plant();
        for (inverse, range) in [(0.5, 2.0), (0.25, 2.0), (4.0, 0.25)] {
            build(&mut built, &site, &[inverse]).unwrap();
            assert_eq!(built.sensors[2].range.unwrap().value, range);
        }
    }
}
