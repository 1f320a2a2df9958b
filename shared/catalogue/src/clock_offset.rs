//! A clock that is ahead.

use super::{applies, parts};
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Clock offset of a source: stamped time `(1 + skew) t + offset`.
pub static EFFECT: Effect = Effect {
    kind: "clock_offset",
    title: "Clock offset of a source",
    sites: &[SiteKind::Sensor],
    applies: applies::first_of_its_clock,
    parameters: &[EffectParameter::new("offset", "s", [-1.0, 1.0], 0.01, "stamp minus true time").amplitude()],
    law: Law::Structure(build),
    family: Family::Timing,
    what: "Stamped time = (1 + skew) t + offset, for every sensor of the clock; a sensor without a source gets a clock of its own.",
    signature: "All channels of one source lag or lead the others by one time; residuals proportional to rates.",
    confounders: "sensor_delay of those sensors (identical but in the loop), actuator_delay if all sensors share the clock.",
    experiment: "Sharp reversals seen by two sources.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    parts::clock_mut(plant, site)?.clock_offset_s.value += p[0];
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn a_sensor_without_a_source_gets_a_clock_of_its_own_and_keeps_it() {
        let mut built = plant();
        let site = "sensor:gyro_z".parse().unwrap();
        build(&mut built, &site, &[0.25]).unwrap();
        build(&mut built, &site, &[0.25]).unwrap();
        assert_eq!(built.sources.len(), 1);
        assert_eq!(built.sources[0].clock_offset_s.value, 0.5);
        assert_eq!(built.sensors[0].source, Some(built.sources[0].name.clone()));
        assert_eq!(built.sensors[1], plant().sensors[1]);
    }
}
