//! An actuator that follows its command slowly.

use super::applies::effort;
use super::filters;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// First-order lag of an actuator: `u_acting / u = 1 / (T s + 1)`.
pub static EFFECT: Effect = Effect {
    kind: "actuator_lag",
    title: "First-order lag of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new("time_constant", "s", [0.0, 2.0], 0.01, "time constant T")
        .amplitude()
        .multimodal()],
    law: Law::ActuatorFilter(filters::first_order),
    family: Family::Timing,
    what: "u_acting / u = 1 / (T s + 1); winding inductance, current loop, valve and chamber filling.",
    signature: "Phase and amplitude fall towards the corner at 1/T; exponential edges.",
    confounders: "actuator_delay of the same time (differs at the order (w T)^2); thruster_rise_tail_off with a ratio of one.",
    experiment: "Multisine up to w T about 1, or steps sampled faster than T.",
    ..Effect::PLAIN
};
