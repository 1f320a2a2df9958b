//! A bias that begins at an instant.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local};
use dynamics::real::Real;

/// Step of a sensor's bias: `y = h + b` for a time from an onset on.
pub static EFFECT: Effect = Effect {
    kind: "sensor_step",
    title: "Step of a sensor's bias",
    sites: &[SiteKind::Sensor],
    parameters: &[
        EffectParameter::new("step", "*", [-10.0, 10.0], 1e-3, "change b of the reading").amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    limits: &[Limit { kind: "sensor_bias", at: &[("begin", 0.0), ("duration", 1e9)] }],
    what: "y = h + b from a time on, for a time; turn-on transients, radiation hits, a connector.",
    signature: "One channel jumps between two samples; no other channel moves.",
    confounders: "thruster_leak and thermal_snap for an accelerometer (identical without a velocity or position on that axis).",
    experiment: "A second sensor on the same axis; repeat the manoeuvre.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (step, begin, duration) = (p[0], p[1], p[2]);
    if local.t_s >= begin && local.t_s - begin < duration {
        action.value += T::constant(step);
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_bias_begins_and_ends_at_its_times() {
        let value = |t_s| Trial { t_s, reading: 1.0, ..Trial::default() }.value(&EFFECT, &[0.5, 10.0, 2.0]);
        assert_eq!([value(9.99), value(10.0), value(11.99), value(12.0)], [1.0, 1.5, 1.5, 1.0]);
    }
}
