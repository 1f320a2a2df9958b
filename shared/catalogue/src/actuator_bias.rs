//! An actuator that acts uncommanded.

use super::applies::effort;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Offset of an actuator: `u_acting = u + b`.
pub static EFFECT: Effect = Effect {
    kind: "actuator_bias",
    title: "Offset of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new("bias", "*", [-10.0, 10.0], 0.01, "offset b of what acts").amplitude()],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "u_acting = u + b; offset of a converter or current sensor.",
    signature: "A constant push along this actuator's axis, from the first sample to the last.",
    confounders: "joint_torque_bias at the same joint and constant_force or constant_torque on the same body (identical); thruster_leak from \
                  the start.",
    experiment: "Power the actuator off; turn the body, so that inertial and body-fixed pushes part.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += T::constant(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_offset_acts_with_and_without_command() {
        assert_eq!(Trial::default().value(&EFFECT, &[0.25]), 0.25);
        assert_eq!(Trial { command: -1.0, ..Trial::default() }.value(&EFFECT, &[0.25]), -0.75);
    }
}
