//! A flexible appendage that only turns the body it sits on.

use super::applies::turning_body;
use super::parts;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Amplitude, Effect, EffectParameter, Family, Law, Spread};

/// Hub-locked mode of a body taken for rigid: participation of rotation `√(share I)` about each
/// axis.
pub static EFFECT: Effect = Effect {
    kind: "appendage_rotation_left_out",
    title: "Flexible appendage that answers rotation, on a body taken for rigid",
    sites: &[SiteKind::Body],
    applies: turning_body,
    parameters: &[
        EffectParameter::new(
            "share_z",
            "1",
            [0.0, 0.9],
            0.01,
            "effective inertia about body z over the body's inertia",
        )
        .amplitude(),
        EffectParameter::new("share_x", "1", [-0.9, 0.9], 0.0, "about body x; negative: in antiphase to z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("share_y", "1", [-0.9, 0.9], 0.0, "about body y; negative: in antiphase to z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("frequency", "Hz", [0.01, 200.0], 0.5, "frequency, hub locked").frequency(),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.2], 0.005, "damping ratio")
            .damping_ratio(0.03, Spread::Absolute(0.05)),
    ],
    amplitude: Amplitude::ShareOfBody,
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "One hub-locked mode without translation, as two equal panels that bend against each other have it: participation of rotation sqrt(share I) about \
           each axis, I the body's inertia about its own frame, with the sign of the share. The body's inertia includes it undeformed. \
           Likins 1970.",
    signature: "A narrow line at one frequency in the body's rate, excited by torques and not by forces through its centre of mass.",
    confounders: "appendage_left_out where forces turn the body, slosh_second_mode, joint_flexibility, actuator_second_order of the torque.",
    experiment: "A force through the centre of mass beside a torque; another acceleration level.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let share = [p[1], p[2], p[0]];
    if share == [0.0; 3] {
        return Ok(());
    }
    let inertia = parts::inertia_about_frame(parts::body_mut(plant, &site.name)?);
    let participation = |axis: usize| libm::copysign(libm::sqrt(share[axis].abs() * inertia[axis]), share[axis]);
    parts::add_mode(plant, site, [p[3], p[4]], [0.0; 3], core::array::from_fn(participation))
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;
    use dynamics::system::{System, Workspace};

    #[test]
    fn the_mode_turns_its_share_of_the_inertia_about_its_axes_and_the_rest_stays() {
        let mut built = plant();
        let hub = plant().bodies[0].clone();
        let [about_x, _, about_z] = crate::parts::inertia_about_frame(&hub);
        build(&mut built, &"body:hub".parse().unwrap(), &[0.04, -0.09, 0.0, 0.7, 0.01]).unwrap();
        let mode = built.appendages.pop().unwrap().modes.remove(0);
        assert_eq!(mode.translation_sqrt_kg.map(|x| x.value), [0.0; 3]);
        let squares = mode.rotation_sqrt_kg_m.map(|x| x.value.abs() * x.value);
        for (square, expected) in squares.into_iter().zip([-0.09 * about_x, 0.0, 0.04 * about_z]) {
            assert!((square - expected).abs() < 1e-12 * about_z, "{square} {expected}");
        }
        assert_eq!(built, plant());
    }

    #[test]
    fn a_free_hub_with_a_share_of_its_inertia_in_the_mode_rings_faster_by_one_over_the_root_of_the_rest() {
        let description = "format = 1\nname = \"hub\"\nspace = \"planar\"\n[[body]]\nname = \"hub\"\nmass = \"40 kg\"\n\
                           inertia = \"12 kg*m^2\"\njoint = { kind = \"free\" }\n[simulation]\nduration = \"1 s\"\nperiod = \"0.1 s\"\n";
        let mut hub = plant_file::parse("hub.toml", description).unwrap().plant;
        let (share, hz) = (0.36, 0.5);
        build(&mut hub, &"body:hub".parse().unwrap(), &[share, 0.0, 0.0, hz, 0.0]).unwrap();
        let system = System::new(&hub).unwrap();
        let at = |name: &str| system.states().iter().position(|state| state.name.ends_with(name)).unwrap();
        let (eta, rate) = (at("hub_mode"), at("hub_mode.rate"));
        let mut x = vec![0.0; system.states().len()];
        x[eta] = 1e-3;
        let mut x_dot = x.clone();
        system.derivative(&mut Workspace::new(&system), 0.0, &x, &vec![0.0; system.inputs().len()], &mut x_dot);
        let omega = core::f64::consts::TAU * hz;
        // closed form of a hub and a mode: eta'' (1 - share) = - omega^2 eta
        let expected = -omega * omega / (1.0 - share) * 1e-3;
        assert!((x_dot[rate] / expected - 1.0).abs() < 1e-9, "{} {expected}", x_dot[rate]);
    }

    #[test]
    fn more_inertia_than_the_body_has_is_refused() {
        let mut built = plant();
        let twice = [0.6, 0.0, 0.0, 0.7, 0.01];
        build(&mut built, &"body:hub".parse().unwrap(), &twice).unwrap();
        assert!(build(&mut built, &"body:hub".parse().unwrap(), &twice).is_err());
    }
}
