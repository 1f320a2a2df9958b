//! Pulses too short to be fired.

use super::applies::thruster;
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "thruster_minimum_impulse_bit",
    title: "Minimum impulse bit of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("impulse", "N s", [0.0, 10.0], 0.02, "smallest impulse I of one pulse"),
        EffectParameter::new("period", "s", [1e-3, 10.0], 0.1, "pulse period P over which the command is a mean"),
    ],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::Actuator(both!(law)),
    what: "A command of mean force u is fired as one pulse of u P each period; |u| P < I is not fired. Wertz 1978; the mean over a period \
           acts, not the pulse.",
    signature: "No response to small commands, all of large ones (a dead zone falls short of those as well); limit cycle in fine pointing.",
    confounders: "actuator_dead_zone, joint_coulomb of a bench; thruster_rise_tail_off on short pulses.",
    experiment: "Pulse-width ladder from below the shortest pulse.",
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (impulse, period) = (p[0], p[1]);
    if action.value.value().abs() * period < impulse {
        action.value = T::zero();
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn a_pulse_is_fired_whole_or_not_at_all() {
        let value = |command| Trial { command, ..Trial::default() }.value(&EFFECT, &[0.05, 0.1]);
        assert_eq!(value(0.4999), 0.0);
        assert_eq!(value(-0.4999), 0.0);
        assert_eq!(value(0.5001), 0.5001);
        assert_eq!(value(-3.0), -3.0);
    }
}
