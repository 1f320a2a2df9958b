//! An encoder whose disc is off centre.

use super::applies::encoder;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Prior, Spread};
use dynamics::real::Real;

/// Periodic error of an encoder: `y = q + A sin(N q + φ)`.
pub static EFFECT: Effect = Effect {
    kind: "encoder_ripple",
    title: "Periodic error of an encoder",
    sites: &[SiteKind::Sensor],
    applies: encoder,
    parameters: &[
        EffectParameter::new("amplitude", "*", [0.0, 0.05], 1e-3, "amplitude A").amplitude(),
        EffectParameter::new("order", "rad/*", [0.5, 1e6], 1.0, "periods per turn, or radians per metre")
            .order()
            .with_prior(Prior::FreeUnlessWhole(Spread::Relative(0.1))),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "phase at zero reading").direction(1.0),
    ],
    law: Law::Sensor(both!(law)),
    family: Family::Ripple,
    what: "y = q + A sin(N q + phase); eccentric disc (order 1), interpolation error (order of its lines), resolver (order 2).",
    signature: "A line over position in the encoder alone; the joint's torque does not need it.",
    confounders: "joint_gear_ripple, which rate and torque see too.",
    experiment: "Constant slow speed with a gyro on the link as witness.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (amplitude, order, phase) = (p[0], p[1], p[2]);
    action.value += (action.value.scale(order) + T::constant(phase)).sin().scale(amplitude);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_error_repeats_order_times_a_turn() {
        let error = |reading| Trial { reading, ..Trial::default() }.value(&EFFECT, &[0.01, 3.0, 0.5]) - reading;
        assert!((error(0.0) - 0.01 * libm::sin(0.5)).abs() < 1e-17);
        assert!((error(0.4) - error(0.4 + core::f64::consts::TAU / 3.0)).abs() < 1e-15); // rounding of a reading of 2.5
        assert!((error(0.4) + error(0.4 + core::f64::consts::PI / 3.0)).abs() < 1e-15);
    }
}
