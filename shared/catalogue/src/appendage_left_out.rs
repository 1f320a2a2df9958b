//! A flexible appendage on a body that the model takes for rigid.

use super::parts;
use dynamics::description::{Plant, Site, SiteKind, Space};
use dynamics::effect::{Amplitude, Effect, EffectParameter, Family, Law, Prior, Scan, Spread};

/// What swings sits within some metres of where the body is described.
const LEVER: Spread = Spread::Absolute(1.0);

/// Hub-locked mode of a body taken for rigid: participation of translation `√(share m)` along each
/// axis.
pub static EFFECT: Effect = Effect {
    kind: "appendage_left_out",
    title: "Flexible appendage on a body taken for rigid",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("share_x", "1", [0.0, 0.9], 0.01, "effective mass along body x over the body's mass")
            .amplitude(),
        EffectParameter::new("share_y", "1", [-0.9, 0.9], 0.0, "along body y; negative: in antiphase to x").amplitude(),
        EffectParameter::new("share_z", "1", [-0.9, 0.9], 0.0, "along body z; negative: in antiphase to x")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("frequency", "Hz", [0.01, 200.0], 0.5, "frequency, hub locked").frequency(),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.2], 0.005, "damping ratio")
            .damping_ratio(0.03, Spread::Absolute(0.05)),
        EffectParameter::new(
            "lever_x",
            "m",
            [-20.0, 20.0],
            0.0,
            "participation of rotation about x over that of translation",
        )
        .with_prior(Prior::Free(LEVER))
        .out_of_plane(),
        EffectParameter::new(
            "lever_y",
            "m",
            [-20.0, 20.0],
            0.0,
            "participation of rotation about y over that of translation",
        )
        .with_prior(Prior::Free(LEVER))
        .out_of_plane(),
        EffectParameter::new(
            "lever_z",
            "m",
            [-20.0, 20.0],
            0.0,
            "participation of rotation about z over that of translation",
        )
        .scanned(Scan::Each(&[0.0, -1.0, 1.0]))
        .with_prior(Prior::Free(LEVER)),
    ],
    amplitude: Amplitude::ShareOfBody,
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "One hub-locked mode: participation of translation sqrt(share m) along each axis, with the sign of the share, so that what acts \
           begins in proportion to the amplitude and directions need no angle; of rotation `lever` times the length of that. The body's mass and \
           inertia include it undeformed. Likins 1970.",
    signature: "A narrow line at one frequency in rate and acceleration of the body, excited by every edge of its actuators.",
    confounders: "slosh_second_mode, joint_flexibility, actuator_second_order of the actuator that excites it, body_tether.",
    experiment: "Excite with two different actuators; another acceleration level.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let planar = plant.space == Space::Planar;
    let share = [p[0], p[1], if planar { 0.0 } else { p[2] }];
    if share == [0.0; 3] {
        return Ok(());
    }
    let lever = if planar { [0.0, 0.0, p[7]] } else { [p[5], p[6], p[7]] };
    let mass = parts::body_mut(plant, &site.name)?.mass_kg.value;
    let whole = libm::sqrt(share.iter().map(|share| share.abs()).sum::<f64>() * mass);
    let participation = share.map(|s| libm::copysign(libm::sqrt(s.abs() * mass), s));
    parts::add_mode(plant, site, [p[3], p[4]], participation, lever.map(|lever| whole * lever))
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;

    #[test]
    fn the_mode_moves_its_share_of_the_mass_along_its_direction() {
        let mut built = plant();
        build(&mut built, &"body:hub".parse().unwrap(), &[0.04, 0.0, 0.0, 0.7, 0.01, 0.0, 0.0, 0.5]).unwrap();
        let mode = built.appendages.pop().unwrap().modes.remove(0);
        assert_eq!(mode.translation_sqrt_kg.map(|x| x.value), [4.0, 0.0, 0.0]); // √(0.04 · 400 kg)
        assert_eq!(mode.rotation_sqrt_kg_m.map(|x| x.value), [0.0, 0.0, 2.0]);
        assert_eq!(built, plant());
    }

    #[test]
    fn its_effective_mass_is_the_sum_of_the_shares_and_a_sign_turns_its_direction() {
        let mut built = plant();
        build(&mut built, &"body:hub".parse().unwrap(), &[0.01, -0.04, 0.3, 0.7, 0.01, 0.0, 0.0, 0.1]).unwrap();
        let mode = built.appendages.pop().unwrap().modes.remove(0);
        assert_eq!(mode.translation_sqrt_kg.map(|x| x.value), [2.0, -4.0, 0.0]); // the plane does not feel the third
        assert_eq!(mode.rotation_sqrt_kg_m[2].value, 0.1 * libm::sqrt(0.05 * 400.0));
    }

    #[test]
    fn more_inertia_than_the_body_has_is_refused() {
        let mut built = plant();
        assert!(build(&mut built, &"body:hub".parse().unwrap(), &[0.04, 0.0, 0.0, 0.7, 0.01, 0.0, 0.0, 5.0]).is_err());
    }
}
