//! Time between a command and its effect.

use super::applies::effort;
use super::filters;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Delay of an actuator: `u_acting(t) = u(t − d)`.
pub static EFFECT: Effect = Effect {
    kind: "actuator_delay",
    title: "Delay of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new("delay", "s", [0.0, 1.0], 0.01, "dead time d").amplitude()],
    law: Law::ActuatorFilter(filters::delay),
    family: Family::Timing,
    what: "u_acting(t) = u(t - d), by splitting the held intervals; bus cycles, valve opening.",
    signature: "Phase that falls linearly with frequency, amplitude untouched.",
    confounders: "actuator_lag of the same time (differs at the order (w d)^2), clock_offset and sensor_delay of every sensor at once.",
    experiment: "Multisine up to w d about 1: amplitude tells the two apart.",
    ..Effect::PLAIN
};
