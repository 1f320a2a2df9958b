//! A reading in steps.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Quantisation of a sensor: `y = D round(y / D)`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_quantisation",
    title: "Quantisation of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("step", "*", [0.0, 1.0], 1e-3, "step D").amplitude()],
    law: Law::Structure(build),
    staircase: true,
    family: Family::SensorError,
    what: "y = D round(y / D), halves away from zero, behind lag, delay, noise and range: the resolution of the sensor.",
    signature: "Readings are multiples of one number; residual of up to half a step that sweeps like a saw where the motion is slow.",
    confounders: "joint_backlash, sensor noise of D / sqrt(12).",
    experiment: "Histogram of the readings; a slow ramp.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] != 0.0 {
        let sensor = parts::sensor_mut(plant, site)?;
        sensor.resolution.value = sensor.resolution.value.max(p[0]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn the_coarser_of_the_stated_step_and_this_one_counts() {
        let site = "sensor:enc".parse().unwrap();
        let mut built = plant();
        for (step, resolution) in [(0.5, 0.5), (0.25, 0.5), (4.0, 4.0)] {
            build(&mut built, &site, &[step]).unwrap();
            assert_eq!(built.sensors[2].resolution.value, resolution);
        }
    }
}
