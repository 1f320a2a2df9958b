//! A reading that lies in the past.

use super::filters;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Delay of a sensor: `y(t) = h(t − d)`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_delay",
    title: "Delay of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("delay", "s", [0.0, 1.0], 0.01, "dead time d").amplitude()],
    law: Law::SensorFilter(filters::delay),
    family: Family::Timing,
    what: "y(t) = h(t - d); transport, processing of an image or star tracker.",
    signature: "This channel's phase falls linearly with frequency; its residual is d times its rate.",
    confounders: "clock_offset (the same in the record, not in the loop), sensor_lag, actuator_delay if this sensor is the only one.",
    experiment: "Sharp reversals or a chirp, against a sensor on another clock.",
    ..Effect::PLAIN
};
