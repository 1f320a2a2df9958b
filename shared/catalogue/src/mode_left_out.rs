//! A mode that the model of an appendage lacks.

use super::parts;
use dynamics::description::{Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Spread};

/// Further hub-locked mode of an appendage: participations and shapes of the site's mode times
/// `√mass_ratio`.
pub static EFFECT: Effect = Effect {
    kind: "mode_left_out",
    title: "Another mode of an appendage",
    sites: &[SiteKind::Mode],
    parameters: &[
        EffectParameter::new("mass_ratio", "1", [0.0, 1.0], 0.1, "its effective mass over that of the mode beside it")
            .amplitude(),
        EffectParameter::new("frequency", "Hz", [0.01, 200.0], 1.0, "its frequency, hub locked").frequency(),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.2], 0.005, "its damping ratio")
            .damping_ratio(0.03, Spread::Absolute(0.05)),
    ],
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "A further hub-locked mode with the direction and shape of the one at the site, participations and shapes times sqrt(mass_ratio): effective \
           masses are squares of participations, so the response to first order is linear in the ratio.",
    signature: "A narrow line at one frequency, in the hub and at the appendage.",
    confounders: "slosh_second_mode, joint_gear_ripple and wheel imbalance at one speed, sensor_tone, gyro scale.",
    experiment: "Chirp through it; another thrust level (slosh moves), another speed (ripple moves).",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    if p[0] == 0.0 {
        return Ok(());
    }
    let name = parts::free_name(plant, &format!("{}_left_out", site.name));
    let (appendage, place) = parts::mode_mut(plant, site)?;
    let mut mode = appendage.modes[place].clone();
    mode.name = name;
    mode.frequency_hz = Quantity::known(p[1]);
    mode.damping_ratio = Quantity::known(p[2]);
    let root = libm::sqrt(p[0]);
    let participations = mode.translation_sqrt_kg.iter_mut().chain(&mut mode.rotation_sqrt_kg_m);
    for number in participations.chain(mode.shape_per_sqrt_kg.iter_mut().flatten()) {
        *number = Quantity::known(number.value * root);
    }
    parts::add_mode_beside(plant, site, mode)
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn the_new_mode_has_its_share_of_effective_mass_and_the_old_ones_stay() {
        let mut built = plant();
        build(&mut built, &"mode:bending".parse().unwrap(), &[0.25, 1.1, 0.01]).unwrap();
        let mode = built.appendages[0].modes.pop().unwrap();
        assert_eq!((mode.name.as_str(), mode.frequency_hz.value), ("bending_left_out", 1.1));
        assert_eq!(mode.translation_sqrt_kg[1].value, 1.25);
        assert_eq!(mode.rotation_sqrt_kg_m[2].value, 2.0);
        // the tip answers the hub with its share as well
        assert_eq!(
            mode.shape_per_sqrt_kg[0][1].value,
            0.5 * plant().appendages[0].modes[0].shape_per_sqrt_kg[0][1].value
        );
        assert_eq!(built, plant());
    }

    #[test]
    fn more_effective_mass_than_the_body_has_is_refused() {
        let mut built = plant();
        built.bodies[0].mass_kg.value = 8.0; // 2.5² + 1.2² = 7.69 kg are in the modes
        let reason = build(&mut built, &"mode:bending".parse().unwrap(), &[0.25, 1.1, 0.01]).unwrap_err();
        assert!(reason.contains("of the 8 kg of hub"), "{reason}");
    }
}
