//! A body that is heavier than its data sheet says.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Mass other than stated: `m → (1 + e) m`, inertia about the centre of mass unchanged.
pub static EFFECT: Effect = Effect {
    kind: "mass_error",
    title: "Mass other than stated",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new("error", "1", [-0.5, 0.5], 0.02, "relative error of the mass").amplitude()],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "m -> (1 + e) m, inertia about the centre of mass unchanged: a mass that the file holds for known and that is another.",
    signature: "Acceleration per force, and weight, off by one factor.",
    confounders: "motor_constant_error and sensor_scale of accelerometers (exactly, for all bodies together); nothing is left of it where the mass is estimated.",
    experiment: "Weigh it, or a force from outside.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] != 0.0 {
        parts::body_mut(plant, &site.name)?.mass_kg.value *= 1.0 + p[0];
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn only_the_mass_of_one_body_changes() {
        let mut built = plant();
        build(&mut built, &"body:arm".parse().unwrap(), &[0.25]).unwrap();
        assert_eq!(built.bodies[1].mass_kg.value, 12.5);
        built.bodies[1].mass_kg.value = 10.0;
        assert_eq!(built, plant());
    }
}
