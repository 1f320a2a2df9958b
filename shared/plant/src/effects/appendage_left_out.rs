//! A flexible appendage on a body that the model takes for rigid.

use super::applies::anywhere;
use super::geometry::{cross_f64, direction, perpendicular};
use super::{Effect, EffectParameter, Law, parts};
use crate::description::{Appendage, Mode, Plant, Quantity, Site, SiteKind};

pub static EFFECT: Effect = Effect {
    kind: "appendage_left_out",
    title: "Flexible appendage on a body taken for rigid",
    sites: &[SiteKind::Body],
    applies: anywhere,
    parameters: &[
        EffectParameter::new("mass_share", "1", [0.0, 0.9], 0.01, "effective mass of the mode over the body's mass"),
        EffectParameter::new("frequency", "Hz", [0.01, 200.0], 0.5, "frequency, hub locked"),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.2], 0.005, "damping ratio"),
        EffectParameter::new("azimuth", "rad", [-3.2, 3.2], 0.0, "direction of its motion, from body x towards y"),
        EffectParameter::new("elevation", "rad", [-1.6, 1.6], 0.0, "direction of its motion, towards body z"),
        EffectParameter::new("lever", "m", [-20.0, 20.0], 0.0, "participation of rotation over that of translation"),
    ],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::Structure(build),
    what: "One hub-locked mode: participation of translation sqrt(mass_share m) along the direction, of rotation `lever` times that about the \
           normal (z for motion in the plane). The body's mass and inertia include it undeformed. Likins 1970.",
    signature: "A narrow line at one frequency in rate and acceleration of the body, excited by every edge of its actuators.",
    confounders: "slosh_second_mode, joint_flexibility, actuator_second_order of the actuator that excites it, body_tether.",
    experiment: "Excite with two different actuators; another acceleration level.",
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    let name = parts::free_name(plant, &format!("{}_appendage", site.name));
    let mode_name = parts::free_name(plant, &format!("{}_mode", site.name));
    let body = parts::body_mut(plant, &site.name)?.clone();
    let along = direction(p[3], p[4]);
    let normal = cross_f64(along, perpendicular(along, 0.0));
    let participation = libm::sqrt(p[0] * body.mass_kg.value);
    let mode = Mode {
        name: mode_name,
        frequency_hz: Quantity::known(p[1]),
        damping_ratio: Quantity::known(p[2]),
        translation_sqrt_kg: along.map(|x| Quantity::known(participation * x)),
        rotation_sqrt_kg_m: normal.map(|x| Quantity::known(participation * p[5] * x)),
        shape_per_sqrt_kg: Vec::new(),
    };
    plant.appendages.push(Appendage { name, body: site.name.clone(), points: Vec::new(), modes: vec![mode] });
    parts::check_participation(plant, &body)
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::effects::trial::plant;

    #[test]
    fn the_mode_moves_its_share_of_the_mass_along_its_direction() {
        let mut built = plant();
        build(&mut built, &"body:hub".parse().unwrap(), &[0.04, 0.7, 0.01, 0.0, 0.0, 0.5]).unwrap();
        let mode = built.appendages.pop().unwrap().modes.remove(0);
        assert_eq!(mode.translation_sqrt_kg.map(|x| x.value), [4.0, 0.0, 0.0]); // √(0.04 · 400 kg)
        assert_eq!(mode.rotation_sqrt_kg_m.map(|x| x.value), [0.0, 0.0, 2.0]);
        assert_eq!(built, plant());
    }

    #[test]
    fn more_inertia_than_the_body_has_is_refused() {
        let mut built = plant();
        assert!(build(&mut built, &"body:hub".parse().unwrap(), &[0.04, 0.7, 0.01, 0.0, 0.0, 5.0]).is_err());
    }
}
