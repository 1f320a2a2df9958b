//! A mode that a change of temperature kicks.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Prior, Scan, Spread};
use dynamics::real::Real;

/// Thermal snap of a mode: modal force `F (1 − e^(−(t−t0)/T))` from `t0` on.
pub static EFFECT: Effect = Effect {
    kind: "mode_thermal_snap",
    title: "Thermal snap of an appendage's mode",
    sites: &[SiteKind::Mode],
    parameters: &[
        EffectParameter::new("force", "sqrt(kg) m/s^2", [-100.0, 100.0], 0.05, "modal force F of the new shape")
            .amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time of the change").onset(),
        EffectParameter::new("time_constant", "s", [1e-3, 1e4], 5.0, "time over which the new shape is taken")
            .width(Scan::DurationOver(5.0))
            .with_prior(Prior::Free(Spread::Relative(1.0))),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Disturbance,
    what: "Modal force = F (1 - e^(-(t-t0)/T)) from t0 on: the appendage bends to a new shape (Boley 1956; Thornton and Kim 1993).",
    signature: "A burst at the modal frequency that begins at one instant, and an offset that stays.",
    confounders: "thermal_snap of the body, thruster_leak, sensor_step; all are located in time only.",
    experiment: "The next eclipse: it repeats there.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, begin, time) = (p[0], p[1], p[2]);
    let since = local.t_s - begin;
    if since > 0.0 {
        action.force += T::constant(-force * libm::expm1(-since / time));
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_begins_at_its_time_and_settles_exponentially() {
        let force = |t_s| Trial { t_s, ..Trial::default() }.force(&EFFECT, &[0.5, 10.0, 2.0]);
        assert_eq!(force(10.0), 0.0);
        assert!((force(12.0) - 0.5 * (1.0 - libm::exp(-1.0))).abs() < 1e-16); // rounding
        assert_eq!(force(1e3), 0.5);
    }
}
