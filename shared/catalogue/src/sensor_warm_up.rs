//! A bias that settles after power-on.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Prior, Scan, Spread};
use dynamics::real::Real;

/// Warm-up of a sensor: `y = h + b e^(−t/T)`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_warm_up",
    title: "Warm-up of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[
        EffectParameter::new("bias", "*", [-10.0, 10.0], 1e-3, "bias b at the start, relative to the end").amplitude(),
        EffectParameter::new("time_constant", "s", [0.1, 1e5], 30.0, "time constant T")
            .width(Scan::DurationOver(5.0))
            .with_prior(Prior::Free(Spread::Relative(1.0))),
    ],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    limits: &[Limit { kind: "sensor_bias", at: &[("time_constant", 1e5)] }],
    what: "y = h + b e^(-t/T); self-heating.",
    signature: "One channel settles exponentially from the start of the record, whatever the motion.",
    confounders: "sensor_bias with sensor_drift in a short record; a decaying slosh_contact_line or other free response.",
    experiment: "Repeat the record with the sensor already warm.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += T::constant(p[0] * libm::exp(-local.t_s / p[1]));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_bias_falls_to_a_part_in_e_each_time_constant() {
        let value = |t_s| Trial { t_s, ..Trial::default() }.value(&EFFECT, &[0.5, 30.0]);
        assert_eq!(value(0.0), 0.5);
        assert!((value(90.0) / value(60.0) - libm::exp(-1.0)).abs() < 1e-15); // rounding
    }
}
