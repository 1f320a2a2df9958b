//! A force of one frequency on a body.

use super::geometry::{constant, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Tone of a body: `F = a sin 2π f t + b cos 2π f t`, a and b fixed to the body.
pub static EFFECT: Effect = Effect {
    kind: "force_tone",
    title: "Force of one frequency on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("sine_x", "N", [-1e3, 1e3], 0.05, "coefficient a of sin 2 pi f t, body x").amplitude(),
        EffectParameter::new("cosine_x", "N", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body x").amplitude(),
        EffectParameter::new("sine_y", "N", [-1e3, 1e3], 0.0, "coefficient a of sin 2 pi f t, body y").amplitude(),
        EffectParameter::new("cosine_y", "N", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body y").amplitude(),
        EffectParameter::new("sine_z", "N", [-1e3, 1e3], 0.0, "coefficient a of sin 2 pi f t, body z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("cosine_z", "N", [-1e3, 1e3], 0.0, "coefficient b of cos 2 pi f t, body z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("frequency", "Hz", [1e-4, 1e4], 0.3, "frequency f").frequency(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "F = a sin 2 pi f t + b cos 2 pi f t, fixed to the body, at its centre of mass: a rotor out of balance that turns at one rate, a compressor, a pump.",
    signature: "A line at one frequency in acceleration that does not depend on how the body moves.",
    confounders: "wheel_imbalance_static where the wheel has one speed, sensor_tone of an accelerometer, appendage_left_out near its resonance.",
    experiment: "Switch off what runs on the body; a change of its rate moves the line.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (sin, cos) = libm::sincos(core::f64::consts::TAU * p[6] * local.t_s);
    let force = constant(core::array::from_fn(|axis| p[2 * axis] * sin + p[2 * axis + 1] * cos));
    push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_turns_with_the_body_and_acts_at_its_centre_of_mass() {
        let mut state = Trial { t_s: 1.0, ..Trial::default() };
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        state.surroundings.body_com_m = [0.0, 0.5, 0.0];
        // a quarter of a period
        let wrench = state.wrench(&EFFECT, &[2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.25]);
        let expected = [0.0, 0.0, -1.0, 2.0, 0.0, 0.0];
        assert!(wrench.iter().zip(expected).all(|(own, other)| (own - other).abs() < 1e-15)); // rounding
    }
}
