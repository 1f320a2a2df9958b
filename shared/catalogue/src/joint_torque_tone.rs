//! A force or torque in a joint that oscillates.

use super::geometry::tone;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Generalised force in a joint at one frequency, from an onset on, for a time.
pub static EFFECT: Effect = Effect {
    kind: "joint_torque_tone",
    title: "Oscillating force or torque in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 1e5], 0.02, "amplitude F").amplitude(),
        EffectParameter::new("frequency", "Hz", [0.001, 1e4], 1.0, "frequency f").frequency(),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "phase p at the onset").direction(1.0),
        EffectParameter::new("begin", "s", [0.0, 1e6], 0.0, "time t0 at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Disturbance,
    what: "F sin(2 pi f (t - t0) + p) from t0 on, for a time; a loop of the motor's electronics that \
           oscillates, a pump or a fan on the link.",
    signature: "A narrow line in the joint's motion that follows time, not angle, and may begin and end.",
    confounders: "joint_gear_ripple (follows the angle), mode_left_out (decays), sensor_tone where one sensor alone shows it.",
    experiment: "Hold the joint still, and move it at two rates: a ripple's frequency follows the rate, a tone's does not.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force += T::constant(p[0] * tone(local.t_s, [p[1], p[2], p[3], p[4]]));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_begins_with_its_phase_and_ends() {
        let quarter = core::f64::consts::FRAC_PI_2;
        let at = |t_s: f64| Trial { t_s, ..Trial::default() }.force(&EFFECT, &[2.0, 0.25, quarter, 10.0, 4.5]);
        assert_eq!([at(9.9), at(14.5)], [0.0; 2]);
        for (t_s, force) in [(10.0, 2.0), (11.0, 0.0), (12.0, -2.0), (14.0, 2.0)] {
            assert!((at(t_s) - force).abs() < 1e-14); // rounding of a phase of 2 pi
        }
    }
}
