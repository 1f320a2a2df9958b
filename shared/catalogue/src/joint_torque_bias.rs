//! A constant force or torque in a joint.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Constant generalised force in a joint.
pub static EFFECT: Effect = Effect {
    kind: "joint_torque_bias",
    title: "Constant force or torque in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[EffectParameter::new("force", "J/*", [-1e5, 1e5], 0.02, "force or torque F").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Actuation,
    what: "F = constant; offset of the current sensor, a pre-loaded harness, an unbalanced link on a tilted base.",
    signature: "Mean of the joint torque residual; an integrating controller carries it, a proportional one stands off.",
    confounders: "actuator_bias of the joint's motor (identical), joint_coulomb where motion has one direction, joint_stiffness with a far \
                  rest, gravity_error.",
    experiment: "Motion both ways through several angles; hold with the drive off.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force += T::constant(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_force_is_the_same_everywhere_and_does_no_work_over_a_cycle() {
        for k in 0..50 {
            assert_eq!(Trial::random(k).force(&EFFECT, &[-0.3]), -0.3);
        }
        assert!(work_of_a_cycle(&EFFECT, &[0.3], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
