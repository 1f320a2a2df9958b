//! Motor torque that varies over a turn of the rotor.

use super::applies::wheel;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Torque ripple of a wheel: `u_acting = u + A sin(N p + φ)`, `p' = W`.
pub static EFFECT: Effect = Effect {
    kind: "wheel_torque_ripple",
    title: "Torque ripple of a wheel",
    sites: &[SiteKind::Actuator],
    applies: wheel,
    parameters: &[
        EffectParameter::new("torque", "N m", [0.0, 0.1], 5e-4, "amplitude A").amplitude(),
        EffectParameter::new("order", "1", [1.0, 200.0], 12.0, "periods N per turn").order(),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "phase at the start").direction(1.0),
    ],
    hidden_states: 1,
    law: Law::Actuator(both!(law)),
    family: Family::Ripple,
    what: "u_acting = u + A sin(N p + phase), p' = W; cogging and commutation.",
    signature: "A line at N times wheel speed in the gyro about the wheel's axis, of constant amplitude in torque.",
    confounders: "wheel_imbalance_static and wheel_imbalance_dynamic (order one, other axes), a structural mode.",
    experiment: "Ramp the wheel: the line follows N times its speed.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (torque, order, phase) = (p[0], p[1], p[2]);
    action.value += (local.hidden[0].scale(order) + T::constant(phase)).sin().scale(torque);
    action.hidden_rate[0] = local.rate;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_ripple_repeats_order_times_a_turn_and_means_nothing() {
        let value =
            |turn: f64| Trial { hidden: [turn, 0.0, 0.0, 0.0], ..Trial::default() }.value(&EFFECT, &[0.01, 6.0, 0.5]);
        let sixth = core::f64::consts::TAU / 6.0;
        assert!((value(0.3) - value(0.3 + sixth)).abs() < 1e-16); // rounding
        let mean: f64 = (0..100).map(|k| value(sixth * f64::from(k) / 100.0)).sum::<f64>() / 100.0;
        assert!(mean.abs() < 1e-16);
        assert!((value(0.0) - 0.01 * libm::sin(0.5)).abs() < 1e-18);
    }
}
