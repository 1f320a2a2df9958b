//! Time between a command and its effect.

use super::applies::effort;
use super::{Effect, EffectParameter, Law};
use crate::description::SiteKind;
use crate::filter::FilterKind;

pub static EFFECT: Effect = Effect {
    kind: "actuator_delay",
    title: "Delay of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[EffectParameter::new("delay", "s", [0.0, 1.0], 0.01, "dead time d")],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::ActuatorFilter(filter),
    what: "u_acting(t) = u(t - d), by splitting the held intervals; bus cycles, valve opening.",
    signature: "Phase that falls linearly with frequency, amplitude untouched.",
    confounders: "actuator_lag of the same time (differs at the order (w d)^2), clock_offset and sensor_delay of every sensor at once.",
    experiment: "Multisine up to w d about 1: amplitude tells the two apart.",
};

fn filter(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::Delay { delay_s: p[0] } }
}

#[cfg(test)]
mod tests {
    use super::filter;
    use crate::filter::FilterKind;

    #[test]
    fn the_filter_is_a_delay_of_the_stated_time() {
        assert_eq!(filter(&[0.02]), FilterKind::Delay { delay_s: 0.02 });
    }
}
