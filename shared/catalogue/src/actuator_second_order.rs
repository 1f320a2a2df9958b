//! An actuator with a loop of its own that overshoots.

use super::applies::effort;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};
use dynamics::lags::FilterKind;

/// Second-order response of an actuator: `u_acting / u = ω² / (s² + 2 ζ ω s + ω²)`.
pub static EFFECT: Effect = Effect {
    kind: "actuator_second_order",
    title: "Second-order response of an actuator",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[
        EffectParameter::new("natural_period", "s", [0.0, 5.0], 0.05, "undamped natural period; zero: ideal")
            .amplitude(),
        EffectParameter::new("damping_ratio", "1", [0.05, 2.0], 0.7, "damping ratio"),
    ],
    law: Law::ActuatorFilter(filter),
    family: Family::Timing,
    what: "u_acting / u = w^2 / (s^2 + 2 z w s + w^2), w = 2 pi / period; a wheel's or joint's inner loop. The period is the amplitude: \
           zero is ideal.",
    signature: "Phase passes 90 degrees at its natural frequency; overshoot in steps where damping is low.",
    confounders: "actuator_lag and actuator_delay well below the natural frequency; joint_flexibility (which the load also feels).",
    experiment: "Multisine or chirp through the natural frequency.",
    ..Effect::PLAIN
};

fn filter(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 {
        FilterKind::None
    } else {
        FilterKind::SecondOrder { frequency_hz: 1.0 / p[0], damping_ratio: p[1] }
    }
}

#[cfg(test)]
mod tests {
    use super::filter;
    use dynamics::lags::FilterKind;

    #[test]
    fn the_filter_is_a_second_order_one_of_the_stated_period() {
        assert_eq!(filter(&[0.25, 0.7]), FilterKind::SecondOrder { frequency_hz: 4.0, damping_ratio: 0.7 });
    }
}
