//! A gear that winds up between motor and link.

use super::applies::anywhere;
use super::{Effect, EffectParameter, Law, parts};
use crate::description::{Body, Joint, JointKind, Orientation, Plant, Quantity, Site, SiteKind};

pub static EFFECT: Effect = Effect {
    kind: "joint_flexibility",
    title: "Flexibility between motor and link",
    sites: &[SiteKind::Joint],
    applies: anywhere,
    parameters: &[
        EffectParameter::new("compliance", "*^2/J", [0.0, 1.0], 1e-4, "one over the spring constant of the gear"),
        EffectParameter::new("damping_ratio", "1", [0.0, 1.0], 0.02, "damping ratio of motor against link"),
        EffectParameter::new(
            "inertia_share",
            "1",
            [1e-3, 10.0],
            0.1,
            "motor inertia over the link's about the axis, where the joint states no rotor inertia",
        ),
    ],
    hidden_states: 0,
    law: Law::Structure(build),
    what: "The joint is split: actuators, sensors and friction stay on the motor, whose inertia is the joint's rotor inertia; the link follows \
           through a spring and a damper. Spong 1987. Compliance is the amplitude: zero is a stiff gear.",
    signature: "A resonance, and an anti-resonance seen by the motor's encoder; the link lags behind the motor in proportion to torque.",
    confounders: "actuator_second_order and appendage_left_out; joint_backlash on small motion; actuator_delay well below the resonance.",
    experiment: "Chirp through the resonance; load the link with the motor locked. A gyro on the link.",
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (compliance, zeta, share) = (p[0], p[1], p[2]);
    if compliance == 0.0 {
        return Ok(());
    }
    let motor_name = parts::free_name(plant, &format!("{}_motor", site.name));
    let gear_name = parts::free_name(plant, &format!("{}_gear", site.name));
    let place = plant.bodies.iter().position(|body| body.joint.name == site.name);
    let place = place.ok_or_else(|| format!("no joint '{}'", site.name))?;
    let link = &mut plant.bodies[place];
    let link_inertia =
        inertia_about_joint(link).ok_or_else(|| format!("{site} has more than one degree of freedom"))?;
    let zero = Quantity::known(0.0);
    if link.joint.rotor_inertia.value == 0.0 {
        link.joint.rotor_inertia = Quantity::known(share * link_inertia);
    }
    let motor_inertia = link.joint.rotor_inertia.value;
    let reduced = motor_inertia * link_inertia / (motor_inertia + link_inertia);
    let stiffness = 1.0 / compliance;
    let gear = Joint {
        name: gear_name,
        kind: link.joint.kind,
        position_m: [zero; 3],
        orientation: Orientation::default(),
        viscous_friction: Quantity::known(2.0 * zeta * libm::sqrt(stiffness * reduced)),
        rotor_inertia: zero,
        stiffness: Quantity::known(stiffness),
        rest: zero,
    };
    let motor = Body {
        name: motor_name.clone(),
        parent: link.parent.replace(motor_name),
        joint: core::mem::replace(&mut link.joint, gear),
        mass_kg: zero,
        com_m: [zero; 3],
        inertia_com_kg_m2: [zero; 6],
    };
    plant.bodies.insert(place, motor);
    Ok(())
}

/// What the joint's rotation or translation moves of its own body: `a·I a + m |a × c|²`, or the mass.
fn inertia_about_joint(body: &Body) -> Option<f64> {
    let (m, c) = (body.mass_kg.value, body.com_m.map(|x| x.value));
    let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|i| i.value);
    match body.joint.kind {
        JointKind::Prismatic { .. } => Some(m),
        JointKind::Revolute { axis: a } => {
            let about_com = a[0] * a[0] * xx + a[1] * a[1] * yy + a[2] * a[2] * zz;
            let products = 2.0 * (a[0] * a[1] * xy + a[0] * a[2] * xz + a[1] * a[2] * yz);
            let arm = super::geometry::cross_f64(a, c);
            Some(about_com + products + m * (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]))
        }
        JointKind::Free | JointKind::Fixed => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::trial::plant;

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
        assert!((motor.joint.rotor_inertia.value - 0.1 * link).abs() < 1e-15);
        assert_eq!(arm.joint.stiffness.value, 1000.0);
        // free-free resonance of motor against link has the stated damping ratio
        let reduced = 0.1 * link * link / (1.1 * link);
        let omega = libm::sqrt(1000.0 / reduced);
        assert!((arm.joint.viscous_friction.value / (2.0 * reduced * omega) - 0.02).abs() < 1e-16);
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
}
