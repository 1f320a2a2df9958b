//! Small commands that are lost.

use super::applies::effort;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Dead zone of an actuator: `u_acting = u − b sgn u` where `|u| > b`, else 0.
pub static EFFECT: Effect = Effect {
    kind: "actuator_dead_zone",
    title: "Dead zone of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[
        EffectParameter::new("half_width", "*", [0.0, 10.0], 0.01, "magnitude b of command that is lost").amplitude()
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "u_acting = u - b sgn u where |u| > b, else 0; amplifier threshold, valve overlap (Tao and Kokotovic 1996).",
    signature: "No response to small commands, a constant shortfall on large ones; limit cycles about the target of a closed loop.",
    confounders: "joint_coulomb (the same while the joint moves the way it is pushed), motor_constant_error at one command level.",
    experiment: "Command ladder from below the threshold, braking as well as driving.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let half_width = T::constant(p[0]);
    let lost = action.value.max(-half_width).min(half_width);
    action.value -= lost;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn small_commands_are_lost_and_large_ones_fall_short_by_the_half_width() {
        let value = |command| Trial { command, ..Trial::default() }.value(&EFFECT, &[0.25]);
        assert_eq!(value(0.2), 0.0);
        assert_eq!(value(-0.25), 0.0);
        assert_eq!(value(1.0), 0.75);
        assert_eq!(value(-1.0), -0.75);
    }
}
