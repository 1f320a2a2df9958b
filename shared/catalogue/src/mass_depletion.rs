//! Propellant that leaves the body.

use super::applies::body_with_thruster;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Mass depletion by firing: `m(t) = m0 − k ∫ |F| dt`.
pub static EFFECT: Effect = Effect {
    kind: "mass_depletion",
    title: "Mass depletion by firing",
    sites: &[SiteKind::Body],
    applies: body_with_thruster,
    parameters: &[EffectParameter::new("consumption", "s/m", [0.0, 3e-3], 4.5e-4, "mass per impulse k = 1 / (g0 Isp)")
        .amplitude()],
    hidden_states: 1,
    law: Law::Body(both!(law)),
    family: Family::Consumption,
    what: "m(t) = m0 - k integral of |F|, noise apart, at least one percent of m0; taken at the centre of mass; 4.5e-4 s/m is a specific impulse of 227 s.",
    signature: "Acceleration per thrust grows with integrated firing.",
    confounders: "thruster_blow_down (the other way), payload_drift, drag; motor_constant_error in a short record.",
    experiment: "Coast: nothing changes. The same pulse before and after a long burn.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.added_mass_kg -= local.hidden[0].scale(p[0]);
    action.hidden_rate[0] = local.command;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_mass_lost_is_the_consumption_times_the_impulse() {
        let state = Trial { command: 20.0, hidden: [1000.0, 0.0, 0.0, 0.0], ..Trial::default() };
        let action = state.act(&EFFECT, &[4.5e-4]);
        assert_eq!(action.added_mass_kg, -0.45);
        assert_eq!(action.hidden_rate[0], 20.0);
    }
}
