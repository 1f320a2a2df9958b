//! A torque on a body that oscillates.

use super::geometry::{constant, push, tone};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Torque on a body at one frequency, body axes, from an onset on, for a time.
pub static EFFECT: Effect = Effect {
    kind: "torque_tone",
    title: "Oscillating torque on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("torque_x", "N m", [-1e3, 1e3], 0.0, "amplitude T, body x").amplitude().out_of_plane(),
        EffectParameter::new("torque_y", "N m", [-1e3, 1e3], 0.0, "amplitude T, body y").amplitude().out_of_plane(),
        EffectParameter::new("torque_z", "N m", [-1e3, 1e3], 0.01, "amplitude T, body z").amplitude(),
        EffectParameter::new("frequency", "Hz", [0.001, 1e4], 1.0, "frequency f").frequency(),
        EffectParameter::new("phase", "rad", [-6.4, 6.4], 0.0, "phase p at the onset").phase(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 0.0, "time t0 at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "T sin(2 pi f (t - t0) + p) fixed to the body, from t0 on, for a time: a cooler, a pump, an \
           antenna's drive on the body.",
    signature: "A narrow line in the rates that follows no angle and no speed, and may begin and end.",
    confounders: "wheel_imbalance_dynamic (follows the wheel's speed), mode_left_out (decays), sensor_tone where one sensor alone shows it.",
    experiment: "Record with the machine off that may cause it; another speed of the wheels.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let share = tone(local.t_s, [p[3], p[4], p[5], p[6]]);
    let torque = constant([p[0], p[1], p[2]].map(|own| own * share));
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_turns_with_the_body_and_keeps_its_time() {
        let p = [2.0, 0.0, 3.0, 0.25, core::f64::consts::FRAC_PI_2, 10.0, 4.5];
        let mut state = Trial { t_s: 10.0, ..Trial::default() };
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(state.wrench(&EFFECT, &p), [2.0, 0.0, 3.0, 0.0, 0.0, 0.0]);
        for t_s in [9.9, 14.5] {
            assert_eq!(Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &p), [0.0; 6]);
        }
    }
}
