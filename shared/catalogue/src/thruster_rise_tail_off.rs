//! Thrust that builds up and dies away.

use super::applies::thruster;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};
use dynamics::lags::FilterKind;

/// Thrust rise and tail-off: first order, one time constant while `|thrust|` grows, another while
/// it falls.
pub static EFFECT: Effect = Effect {
    kind: "thruster_rise_tail_off",
    title: "Thrust rise and tail-off",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("rise", "s", [0.0, 1.0], 0.02, "time constant of build-up").amplitude(),
        EffectParameter::new(
            "tail_off_ratio",
            "1",
            [0.1, 10.0],
            2.0,
            "time constant of tail-off over that of build-up",
        ),
    ],
    law: Law::ActuatorFilter(filter),
    family: Family::Timing,
    what: "First order, with one time constant while |thrust| grows and another while it falls; chamber filling and propellant left behind \
           the valve (Sutton and Biblarz 2017).",
    signature: "At pulse edges only; each pulse brings F (tail-off - rise) more impulse than commanded.",
    confounders: "actuator_delay and actuator_lag (equal rise and fall bring no impulse), motor_constant_error at one pulse width.",
    experiment: "Pulse-width ladder: impulse over width is a straight line with an intercept; a lag has none.",
    ..Effect::PLAIN
};

fn filter(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::Asymmetric { rise_s: p[0], fall_s: p[0] * p[1] } }
}

#[cfg(test)]
mod tests {
    use super::filter;
    use dynamics::lags::FilterKind;

    #[test]
    fn the_filter_rises_in_its_time_and_falls_in_the_ratio_s() {
        assert_eq!(filter(&[0.25, 2.0]), FilterKind::Asymmetric { rise_s: 0.25, fall_s: 0.5 });
    }
}
