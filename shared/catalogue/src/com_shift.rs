//! A centre of mass other than stated.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Shift of a centre of mass: `c → c + d`, body axes; the inertia about the centre of mass stays.
pub static EFFECT: Effect = Effect {
    kind: "com_shift",
    title: "Shift of a centre of mass",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("shift_x", "m", [-1.0, 1.0], 0.01, "true minus stated centre of mass, body x").amplitude(),
        EffectParameter::new("shift_y", "m", [-1.0, 1.0], 0.0, "true minus stated centre of mass, body y").amplitude(),
        EffectParameter::new("shift_z", "m", [-1.0, 1.0], 0.0, "true minus stated centre of mass, body z")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "c -> c + d; the inertia about the centre of mass stays. Propellant that moved, a payload held otherwise than planned.",
    signature: "Torque in step with every force on the body.",
    confounders: "The body's own centre of mass where it has a prior (identical); thruster_misalignment (the same torque from one thruster), sensor_lever_arm, the first moment where it is estimated.",
    experiment: "Fire another thruster; accelerate the body sideways.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[..3] == [0.0; 3] {
        return Ok(());
    }
    let axes = parts::axes(plant);
    let body = parts::body_mut(plant, &site.name)?;
    for (com, component) in body.com_m.iter_mut().zip(&p[..axes]) {
        com.value += component;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn only_the_centre_of_mass_of_one_body_moves() {
        let mut built = plant();
        build(&mut built, &"body:arm".parse().unwrap(), &[0.25, 0.0, 0.0]).unwrap();
        assert_eq!(built.bodies[1].com_m[0].value, 0.85);
        built.bodies[1].com_m = plant().bodies[1].com_m;
        assert_eq!(built, plant());
    }
}
