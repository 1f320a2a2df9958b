//! A valve that does not close.

use super::applies::thruster;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local};
use dynamics::real::Real;

/// Leak of a thruster: `u_acting = u + F` from an onset on.
pub static EFFECT: Effect = Effect {
    kind: "thruster_leak",
    title: "Leak of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("force", "N", [0.0, 10.0], 0.05, "thrust F of the leak").amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 0.0, "time at which it begins").onset(),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    limits: &[Limit { kind: "actuator_bias", at: &[("begin", 0.0)] }],
    what: "u_acting = u + F from a time on; a valve that sticks or leaks.",
    signature: "A push along this thruster's axis that begins at an instant and stays, fixed to the body.",
    confounders: "actuator_bias (from the start), constant_force, thermal_snap (which decays), sensor_step of an accelerometer on that axis.",
    experiment: "Close the latch valve; turn the body and see whether the push turns with it.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, begin) = (p[0], p[1]);
    if local.t_s >= begin {
        action.value += T::constant(force);
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_leak_begins_at_its_time_and_stays() {
        let value = |t_s| Trial { t_s, command: 2.0, ..Trial::default() }.value(&EFFECT, &[0.25, 10.0]);
        assert_eq!(value(9.999), 2.0);
        assert_eq!(value(10.0), 2.25);
        assert_eq!(value(1e4), 2.25);
    }
}
