//! A reading that is cut.

use super::applies::anywhere;
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "sensor_saturation",
    title: "Saturation of a sensor",
    sites: &[SiteKind::Sensor],
    applies: anywhere,
    parameters: &[EffectParameter::new("inverse_limit", "1/*", [0.0, 1e4], 1.0, "one over the largest magnitude read")],
    hidden_states: 0,
    law: Law::Sensor(both!(law)),
    what: "y = h clipped to 1/inverse_limit. The inverse is the amplitude: zero is no limit.",
    signature: "Plateaus of one height in one channel while others move on.",
    confounders: "actuator_saturation, joint_end_stop (both seen by other channels).",
    experiment: "Histogram of the readings; the same motion at half size.",
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let inverse = p[0];
    if (action.value.value() * inverse).abs() > 1.0 {
        action.value = T::constant(libm::copysign(1.0 / inverse, action.value.value()));
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn readings_pass_up_to_the_limit_and_no_further() {
        let value = |reading| Trial { reading, ..Trial::default() }.value(&EFFECT, &[0.5]);
        assert_eq!(value(-1.9), -1.9);
        assert_eq!(value(7.0), 2.0);
        assert_eq!(value(-7.0), -2.0);
    }
}
