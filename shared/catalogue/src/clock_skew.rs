//! A clock that runs fast.

use super::{applies, parts};
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Clock skew of a source: stamped time `(1 + skew) t + offset`.
pub static EFFECT: Effect = Effect {
    kind: "clock_skew",
    title: "Clock skew of a source",
    sites: &[SiteKind::Sensor],
    applies: applies::first_of_its_clock,
    parameters: &[
        EffectParameter::new("skew", "1", [-0.01, 0.01], 1e-4, "relative error of the clock's rate").amplitude()
    ],
    law: Law::Structure(build),
    family: Family::Timing,
    what: "Stamped time = (1 + skew) t + offset, for every sensor of the clock; a sensor without a source gets a clock of its own.",
    signature: "All channels of one source fall behind more and more; residuals proportional to time times rate.",
    confounders: "clock_offset in a short record; a frequency error of every mode that source sees.",
    experiment: "A long record with the same manoeuvre at both ends.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    parts::clock_mut(plant, site)?.clock_skew.value += p[0];
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::CATALOGUE;
    use crate::trial::plant;
    use dynamics::description::Source;
    use dynamics::effect::sites;

    #[test]
    fn sensors_of_one_source_share_its_skew_and_stand_for_it_once() {
        let mut built = plant();
        let zero = dynamics::description::Quantity::known(0.0);
        built.sources.push(Source { name: "imu".to_owned(), clock_offset_s: zero, clock_skew: zero });
        built.sensors[0].source = Some("imu".to_owned());
        built.sensors[1].source = Some("imu".to_owned());
        let found = sites(CATALOGUE.effect("clock_skew").unwrap(), &built);
        assert_eq!(found.iter().map(|site| site.name.as_str()).collect::<Vec<_>>(), ["gyro_z", "enc"]);
        build(&mut built, &found[0], &[1e-3]).unwrap();
        assert_eq!(built.sources.len(), 1);
        assert_eq!(built.sources[0].clock_skew.value, 1e-3);
    }
}
