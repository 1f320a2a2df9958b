//! A force or torque of one frequency in a joint.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Tone of a joint: `F = a sin 2π f t + b cos 2π f t`.
pub static EFFECT: Effect = Effect {
    kind: "joint_tone",
    title: "Force or torque of one frequency in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("sine", "J/*", [-1e5, 1e5], 0.02, "coefficient a of sin 2 pi f t").amplitude(),
        EffectParameter::new("cosine", "J/*", [-1e5, 1e5], 0.0, "coefficient b of cos 2 pi f t").amplitude(),
        EffectParameter::new("frequency", "Hz", [1e-4, 1e4], 0.3, "frequency f").frequency(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Disturbance,
    what: "F = a sin 2 pi f t + b cos 2 pi f t: current ripple of a drive, a rotor out of balance that turns at one rate behind the joint.",
    signature: "A line at one frequency in the joint's motion, whatever the joint does.",
    confounders: "joint_gear_ripple where the joint has one speed; sensor_tone (no motion); mode_left_out near its resonance.",
    experiment: "Other speeds of the joint: the line stays. Drive off: a ripple of its current is gone.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (sin, cos) = libm::sincos(core::f64::consts::TAU * p[2] * local.t_s);
    action.force += T::constant(p[0] * sin + p[1] * cos);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_is_one_line_in_time_and_the_same_at_every_position() {
        let force = |t_s, coordinate| Trial { t_s, coordinate, ..Trial::default() }.force(&EFFECT, &[0.3, 0.1, 0.25]);
        assert_eq!(force(0.0, 0.7), 0.1);
        assert!((force(1.0, -2.0) - 0.3).abs() < 1e-15 && (force(2.0, 0.0) + 0.1).abs() < 1e-15); // rounding
        assert_eq!(force(3.3, 0.7), force(3.3, -0.2));
    }
}
