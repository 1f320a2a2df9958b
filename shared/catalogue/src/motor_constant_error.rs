//! An actuator that gives more or less than is commanded.

use super::applies::effort;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Gain of an actuator other than stated: `u_acting = (1 + e) u`.
pub static EFFECT: Effect = Effect {
    kind: "motor_constant_error",
    title: "Actuator gain (motor constant, thrust level) other than stated",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[
        EffectParameter::new("error", "1", [-1.0, 0.5], 0.03, "relative error e of the gain; -1: dead").amplitude()
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "u_acting = (1 + e) u; a voltage motor's back-emf constant is off by the same factor; motor constant off its data sheet, warm magnets, thrust off its acceptance test.",
    signature: "Every response to this actuator is scaled by one factor, at all frequencies; no response of its own.",
    confounders: "mass and inertia of all it moves, exactly, where it is the only actuator; sensor_scale of every sensor at once; \
                  joint_load_friction where the joint never brakes.",
    experiment: "Excite the same motion with a second actuator, or add a known mass.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let gain = 1.0 + p[0];
    // (1 + e) K (V - (1 + e) B w) = K (V' - B w)
    let induced = local.rate.scale(local.surroundings.back_emf_v_s_rad * (gain * gain - 1.0));
    action.value = action.value.scale(gain) - induced;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn a_voltage_motor_has_torque_and_back_emf_of_one_constant() {
        let (k, b, e, v, w) = (2.0, 0.3, 0.25, 5.0, 3.0);
        let mut state = Trial { command: v, rate: w, ..Trial::default() };
        state.surroundings.back_emf_v_s_rad = b;
        let torque = k * (state.value(&EFFECT, &[e]) - b * w);
        assert!((torque - k * (1.0 + e) * (v - b * (1.0 + e) * w)).abs() < 1e-14); // rounding
    }

    #[test]
    fn what_acts_is_the_command_times_one_gain() {
        assert_eq!(Trial { command: -4.0, ..Trial::default() }.value(&EFFECT, &[0.25]), -5.0);
        assert_eq!(Trial { command: 4.0, ..Trial::default() }.value(&EFFECT, &[-0.5]), 2.0);
    }
}
