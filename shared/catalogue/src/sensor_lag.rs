//! A reading that follows slowly.

use super::filters;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// First-order lag of a sensor: `y / h = 1 / (T s + 1)`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_lag",
    title: "First-order lag of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("time_constant", "s", [0.0, 2.0], 0.01, "time constant T")
        .amplitude()
        .multimodal()],
    law: Law::SensorFilter(filters::first_order),
    family: Family::Timing,
    what: "y / h = 1 / (T s + 1); anti-alias filter, thermal or demodulator lag.",
    signature: "This channel alone falls behind and shrinks with frequency.",
    confounders: "sensor_delay of the same time (differs at the order (w T)^2); actuator_lag if this sensor is the only one.",
    experiment: "Multisine up to w T about 1, with a second sensor of the same motion.",
    ..Effect::PLAIN
};
