//! An actuator that gives more or less than it is told.

use super::applies::effort;
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "motor_constant_error",
    title: "Actuator gain (motor constant, thrust level) other than stated",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new("error", "1", [-0.5, 0.5], 0.03, "relative error e of the gain")],
    hidden_states: 0,
    law: Law::Actuator(both!(law)),
    what: "u_acting = (1 + e) u; motor constant off its data sheet, warm magnets, thrust off its acceptance test.",
    signature: "Every response to this actuator is scaled by one factor, at all frequencies; no response of its own.",
    confounders: "mass and inertia of all it moves, exactly, where it is the only actuator; sensor_scale of every sensor at once; \
                  joint_load_friction where the joint never brakes.",
    experiment: "Excite the same motion with a second actuator, or add a known mass.",
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value = action.value.scale(1.0 + p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn what_acts_is_the_command_times_one_gain() {
        assert_eq!(Trial { command: -4.0, ..Trial::default() }.value(&EFFECT, &[0.25]), -5.0);
        assert_eq!(Trial { command: 4.0, ..Trial::default() }.value(&EFFECT, &[-0.5]), 2.0);
    }
}
