//! A gear that winds up between motor and link.

use super::parts;
use dynamics::description::{Plant, Quantity, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Prior, Scan, Spread};

/// Flexibility between motor and link: a spring and a damper behind the gear.
pub static EFFECT: Effect = Effect {
    kind: "joint_flexibility",
    title: "Flexibility between motor and link",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("compliance", "*^2/J", [0.0, 1.0], 1e-4, "one over the spring constant of the gear")
            .amplitude()
            .multimodal()
            .scanned(Scan::TimesDefault(&[0.25, 1.0, 4.0, 16.0, 64.0])),
        EffectParameter::new("damping_ratio", "1", [0.0, 1.0], 0.02, "damping ratio of motor against link")
            .damping_ratio(0.1, Spread::Relative(1.0)),
        EffectParameter::new(
            "inertia_share",
            "1",
            [1e-3, 0.9],
            0.1,
            "share of the link that moves with the motor, where the joint states no rotor inertia",
        )
        .with_prior(Prior::Free(Spread::Relative(1.0))),
    ],
    law: Law::Structure(build),
    family: Family::Flexibility,
    what: "The joint is split: actuators, sensors and friction stay on the motor, whose inertia is the joint's rotor inertia or a share of the link; the link follows \
           through a spring and a damper. Spong 1987. Compliance is the amplitude: zero is a stiff gear.",
    signature: "A resonance, and an anti-resonance seen by the motor's encoder; the link lags behind the motor in proportion to torque.",
    confounders: "actuator_second_order and appendage_left_out; joint_backlash on small motion; actuator_delay well below the resonance.",
    experiment: "Chirp through the resonance; load the link with the motor locked. A gyro on the link.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (compliance, zeta, share) = (p[0], p[1], p[2]);
    if compliance == 0.0 {
        return Ok(());
    }
    let split = parts::split_joint(plant, site, share)?;
    let reduced = split.motor_inertia * split.link_inertia / (split.motor_inertia + split.link_inertia);
    let stiffness = 1.0 / compliance;
    let gear = &mut plant.bodies[split.link].joint;
    gear.stiffness = Quantity::known(stiffness);
    gear.viscous_friction = Quantity::known(2.0 * zeta * libm::sqrt(stiffness * reduced));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;
    use dynamics::system::{System, Workspace};

    #[test]
    fn the_joint_is_split_in_motor_and_gear_and_keeps_its_name_on_the_motor() {
        let mut built = plant();
        build(&mut built, &"joint:elbow".parse().unwrap(), &[1e-3, 0.02, 0.1]).unwrap();
        let [hub, motor, arm] = built.bodies.as_slice() else { panic!("three bodies") };
        assert_eq!(hub, &plant().bodies[0]);
        assert_eq!((motor.joint.name.as_str(), motor.parent.as_deref()), ("elbow", Some("hub")));
        assert_eq!((arm.joint.name.as_str(), arm.parent.as_deref()), ("elbow_gear", Some("elbow_motor")));
        assert_eq!(motor.joint.position_m, plant().bodies[1].joint.position_m);
        let link = 1.2 + 10.0 * 0.36; // about the joint
        // the rotor turns about the joint, motor and rest of the link together are the link
        assert_eq!((motor.mass_kg.value, arm.mass_kg.value), (0.0, 10.0));
        let about_z = |body: &dynamics::description::Body| body.inertia_com_kg_m2[2].value;
        assert!((about_z(motor) - 0.1 * link).abs() < 1e-15 && (about_z(motor) + about_z(arm) - 1.2).abs() < 1e-15);
        assert_eq!(arm.joint.stiffness.value, 1000.0);
        // free-free resonance of motor against link has the stated damping ratio
        let reduced = 0.1 * 0.9 * link;
        let omega = libm::sqrt(1000.0 / reduced);
        assert!((arm.joint.viscous_friction.value / (2.0 * reduced * omega) - 0.02).abs() < 1e-15);
        assert_eq!((built.actuators, built.sensors), (plant().actuators, plant().sensors));
    }

    #[test]
    fn a_stated_rotor_inertia_is_the_motor_s() {
        let mut built = plant();
        built.bodies[1].joint.rotor_inertia = Quantity::known(0.7);
        build(&mut built, &"joint:elbow".parse().unwrap(), &[1e-3, 0.02, 0.1]).unwrap();
        assert_eq!(built.bodies[1].joint.rotor_inertia.value, 0.7);
        assert_eq!(built.bodies[2].joint.rotor_inertia.value, 0.0);
    }

    #[test]
    fn a_stiff_gear_is_the_joint_that_was() {
        // acceleration under a torque with the gear wound up so that motor and link move as one
        let acceleration = |plant: &Plant, wind_up: f64| {
            let system = System::new(plant).unwrap();
            let at = |name: &str| system.states().iter().position(|state| state.name == name);
            let mut x = vec![0.0; system.states().len()];
            if let Some(gear) = at("joint:elbow_gear") {
                x[gear] = wind_up;
            }
            let mut u = vec![0.0; system.inputs().len()];
            u[system.inputs().iter().position(|input| input.name == "drive").unwrap()] = 3.0;
            let mut rates = x.clone();
            system.derivative(&mut Workspace::new(&system), 0.0, &x, &u, &mut rates);
            [rates[at("joint:elbow.rate").unwrap()], at("joint:elbow_gear.rate").map_or(0.0, |gear| rates[gear])]
        };
        for rotor in [0.0, 0.7] {
            let mut nominal = plant();
            nominal.bodies[1].joint.rotor_inertia = Quantity::known(rotor);
            let mut built = nominal.clone();
            build(&mut built, &"joint:elbow".parse().unwrap(), &[1e-9, 0.02, 0.1]).unwrap();
            // relative acceleration is affine in the wind-up but for the angle itself, of the order
            // of a nanoradian
            let (none, some) = (acceleration(&built, 0.0), acceleration(&built, 1e-9));
            let together = 1e-9 * none[1] / (none[1] - some[1]);
            let [found, relative] = acceleration(&built, together);
            let expected = acceleration(&nominal, 0.0)[0];
            assert!(relative.abs() < 1e-5 * expected.abs(), "{relative}");
            assert!((found - expected).abs() < 1e-5 * expected.abs(), "{rotor}: {found} {expected}");
        }
    }
}
