//! Large commands that are cut.

use super::applies::effort;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Saturation of an actuator: `u_acting` is `u`, clipped to ±1/`inverse_limit`.
pub static EFFECT: Effect = Effect {
    kind: "actuator_saturation",
    title: "Saturation of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new(
        "inverse_limit",
        "1/*",
        [0.0, 1e5],
        1.0,
        "one over the largest magnitude that acts",
    )
    .amplitude()],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "u_acting = u clipped to 1/inverse_limit; current limit, supply voltage, blow-down. The inverse is the amplitude: zero is no limit.",
    signature: "Response flattens above one command level; odd harmonics at large amplitude only; integrators of the loop wind up.",
    confounders: "The actuator's own range (identical, but that a recording shows what the range has cut); motor_constant_error at one level, actuator_lag in steps.",
    experiment: "Command ladder up to the rated value: below the limit nothing is missing.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let inverse = p[0];
    if (action.value.value() * inverse).abs() > 1.0 {
        action.value = T::constant(libm::copysign(1.0 / inverse, action.value.value()));
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn commands_pass_up_to_the_limit_and_no_further() {
        let value = |command| Trial { command, ..Trial::default() }.value(&EFFECT, &[0.5]);
        assert_eq!(value(1.9), 1.9);
        assert_eq!(value(2.0), 2.0);
        assert_eq!(value(7.0), 2.0);
        assert_eq!(value(-7.0), -2.0);
    }
}
