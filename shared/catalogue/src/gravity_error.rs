//! A base that is not level.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Gravity other than stated, for the whole plant: `g → g + dg`.
pub static EFFECT: Effect = Effect {
    kind: "gravity_error",
    title: "Gravity other than stated (tilted base, sloping table)",
    sites: &[SiteKind::Body],
    applies: first_body,
    parameters: &[
        EffectParameter::new("acceleration_x", "m/s^2", [-2.0, 2.0], 0.01, "true minus stated gravity, inertial x")
            .amplitude(),
        EffectParameter::new("acceleration_y", "m/s^2", [-2.0, 2.0], 0.0, "true minus stated gravity, inertial y")
            .amplitude(),
        EffectParameter::new("acceleration_z", "m/s^2", [-2.0, 2.0], 0.0, "true minus stated gravity, inertial z")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "g -> g + dg for the whole plant; a tilt e of the base across gravity is dg = g sin e (1 mrad: 9.8 mm/s^2). Sits at the first body.",
    signature: "All bodies fall one way; torques of a bench arm follow cos of its angles with the wrong zero.",
    confounders: "constant_force on a single body, joint_torque_bias of one joint near one angle, sensor_bias of accelerometers.",
    experiment: "Turn the rig about the vertical by half a turn.",
    ..Effect::PLAIN
};

fn first_body(plant: &Plant, site: &Site) -> bool {
    plant.bodies.first().is_some_and(|body| body.name == site.name)
}

fn build(plant: &mut Plant, _: &Site, p: &[f64]) -> Result<(), String> {
    if p[..3] == [0.0; 3] {
        return Ok(());
    }
    let axes = parts::axes(plant);
    for (gravity, component) in plant.environment.gravity_m_s2.iter_mut().zip(&p[..axes]) {
        gravity.value += component;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::CATALOGUE;
    use crate::trial::plant;
    use dynamics::effect::sites;

    #[test]
    fn the_error_adds_to_gravity_and_sits_once_in_a_plant() {
        let mut tilted = plant();
        tilted.environment.gravity_m_s2[1].value = -9.81;
        let found = sites(CATALOGUE.effect("gravity_error").unwrap(), &tilted);
        assert_eq!(found.len(), 1);
        build(&mut tilted, &found[0], &[0.25, 0.0, 0.0]).unwrap();
        assert_eq!(tilted.environment.gravity_m_s2.map(|g| g.value), [0.25, -9.81, 0.0]);
    }
}
