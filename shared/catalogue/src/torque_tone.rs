//! A torque of one frequency on a body.

use super::geometry::{constant, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Tone of a body: `T = a sin 2π f t + b cos 2π f t`, a and b fixed to the body.
pub static EFFECT: Effect = Effect {
    kind: "torque_tone",
    title: "Torque of one frequency on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("sine_x", "N m", [-1e3, 1e3], 0.0, "coefficient a of sin 2 pi f t, body x")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("cosine_x", "N m", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body x")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("sine_y", "N m", [-1e3, 1e3], 0.0, "coefficient a of sin 2 pi f t, body y")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("cosine_y", "N m", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body y")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("sine_z", "N m", [-1e3, 1e3], 0.01, "coefficient a of sin 2 pi f t, body z").amplitude(),
        EffectParameter::new("cosine_z", "N m", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body z").amplitude(),
        EffectParameter::new("frequency", "Hz", [1e-4, 1e4], 0.3, "frequency f").frequency(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "T = a sin 2 pi f t + b cos 2 pi f t, fixed to the body: a rotor out of balance that turns at one rate, a cooler, a shaker.",
    signature: "A line at one frequency in the body's rates that does not depend on how the body moves.",
    confounders: "wheel_imbalance_dynamic where the wheel has one speed, sensor_tone of a gyro, appendage_rotation_left_out near its resonance.",
    experiment: "Switch off what runs on the body; a change of its rate moves the line.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (sin, cos) = libm::sincos(core::f64::consts::TAU * p[6] * local.t_s);
    let torque = constant(core::array::from_fn(|axis| p[2 * axis] * sin + p[2 * axis + 1] * cos));
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_turns_with_the_body() {
        let mut state = Trial { t_s: 1.0, ..Trial::default() };
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        state.surroundings.body_com_m = [0.0, 0.5, 0.0];
        // a quarter of a period
        let wrench = state.wrench(&EFFECT, &[2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.25]);
        let expected = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!(wrench.iter().zip(expected).all(|(own, other)| (own - other).abs() < 1e-15)); // rounding
    }
}
