//! A mass that changes with time.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Mass that drifts with time: `m(t) = m0 + r t` at the centre of mass.
pub static EFFECT: Effect = Effect {
    kind: "payload_drift",
    title: "Mass that drifts with time",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new("rate", "kg/s", [-0.1, 0.1], 1e-3, "mass gained per time").amplitude()],
    law: Law::Body(both!(law)),
    family: Family::Consumption,
    what: "m(t) = m0 + r t at the centre of mass, at least one percent of m0; refuelling, boil-off, a payload that is filled or emptied.",
    signature: "Acceleration per force changes with time, also while coasting.",
    confounders: "mass_depletion under steady firing, thruster_blow_down, sensor_drift.",
    experiment: "The same excitation at the start and the end, with a long coast between.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.added_mass_kg += T::constant(p[0] * local.t_s);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_mass_gained_is_the_rate_times_the_time() {
        assert_eq!(Trial { t_s: 8.0, ..Trial::default() }.act(&EFFECT, &[-0.25]).added_mass_kg, -2.0);
    }
}
