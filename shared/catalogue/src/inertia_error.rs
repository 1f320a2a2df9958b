//! A body that is harder to turn than its data sheet says.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Inertia other than stated: `I → (1 + e) I` about the centre of mass, mass unchanged.
pub static EFFECT: Effect = Effect {
    kind: "inertia_error",
    title: "Inertia other than stated",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new("error", "1", [-0.5, 0.5], 0.02, "relative error of the inertia").amplitude()],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "I -> (1 + e) I about the centre of mass, mass unchanged: an inertia that the file holds for known and that is another.",
    signature: "Angular acceleration per torque off by one factor.",
    confounders: "motor_constant_error of a wheel, sensor_scale of a gyro; nothing is left of it where the inertia is estimated.",
    experiment: "Turn with a second actuator; a pendulum test.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] != 0.0 {
        for inertia in &mut parts::body_mut(plant, &site.name)?.inertia_com_kg_m2 {
            inertia.value *= 1.0 + p[0];
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn all_of_the_inertia_of_one_body_changes_by_one_factor() {
        let mut built = plant();
        build(&mut built, &"body:hub".parse().unwrap(), &[0.25]).unwrap();
        let before = plant().bodies[0].inertia_com_kg_m2;
        assert_eq!(built.bodies[0].inertia_com_kg_m2.map(|i| i.value), before.map(|i| 1.25 * i.value));
        built.bodies[0].inertia_com_kg_m2 = before;
        assert_eq!(built, plant());
    }
}
