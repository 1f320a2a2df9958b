//! A reading in steps.

use super::applies::anywhere;
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "sensor_quantisation",
    title: "Quantisation of a sensor",
    sites: &[SiteKind::Sensor],
    applies: anywhere,
    parameters: &[EffectParameter::new("step", "*", [0.0, 1.0], 1e-3, "step D")],
    hidden_states: 0,
    law: Law::Sensor(both!(law)),
    what: "y = D round(h / D), halves away from zero. Over dual numbers the derivative is that of the staircase's chord, one: a filter would \
           otherwise take the sensor for a stuck one.",
    signature: "Readings are multiples of one number; residual of up to half a step that sweeps like a saw where the motion is slow.",
    confounders: "joint_backlash, sensor noise of D / sqrt(12).",
    experiment: "Histogram of the readings; a slow ramp.",
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let step = p[0];
    if step == 0.0 {
        return;
    }
    let reading = action.value.value();
    action.value += T::constant(libm::round(reading / step) * step - reading);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn readings_are_the_nearest_multiples_of_the_step() {
        let value = |reading| Trial { reading, ..Trial::default() }.value(&EFFECT, &[0.25]);
        for (reading, quantised) in [(0.12, 0.0), (0.13, 0.25), (0.125, 0.25), (-0.125, -0.25), (7.6, 7.5)] {
            assert_eq!(value(reading), quantised);
        }
        for k in 0..200 {
            let state = Trial::random(k);
            assert!((state.value(&EFFECT, &[0.01]) - state.reading).abs() <= 0.005 * (1.0 + 1e-9)); // rounding at the half
        }
    }

    #[test]
    fn the_derivative_is_the_slope_of_the_staircase() {
        let (state, direction) = (Trial::random(1), Trial { reading: 1.0, ..Trial::default() });
        let law = state.act_dual(&EFFECT, &[0.25], &direction).value.derivative;
        let chord = state.moved(&direction, 5.0).value(&EFFECT, &[0.25]) - state.value(&EFFECT, &[0.25]);
        assert!((law - chord / 5.0).abs() < 1e-14); // twenty steps; rounding
    }
}
