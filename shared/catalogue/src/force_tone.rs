//! A force on a body that oscillates.

use super::geometry::{constant, push, tone};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Force at a body's centre of mass at one frequency, body axes, from an onset on, for a time.
pub static EFFECT: Effect = Effect {
    kind: "force_tone",
    title: "Oscillating force on a body",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("force_x", "N", [-1e3, 1e3], 0.05, "amplitude F, body x").amplitude(),
        EffectParameter::new("force_y", "N", [-1e3, 1e3], 0.0, "amplitude F, body y").amplitude(),
        EffectParameter::new("force_z", "N", [-1e3, 1e3], 0.0, "amplitude F, body z").amplitude().out_of_plane(),
        EffectParameter::new("frequency", "Hz", [0.001, 1e4], 1.0, "frequency f").frequency(),
        EffectParameter::new("phase", "rad", [-6.4, 6.4], 0.0, "phase p at the onset").phase(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 0.0, "time t0 at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "F sin(2 pi f (t - t0) + p) at the centre of mass, fixed to the body, from t0 on, for a time: \
           a shaker, a cooler, a pump.",
    signature: "A narrow line in accelerations that follows no angle and no speed, and may begin and end; no torque.",
    confounders: "wheel_imbalance_static (follows the wheel's speed), mode_left_out (decays), sensor_tone where one sensor alone shows it.",
    experiment: "Record with the machine off that may cause it; another speed of the wheels.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let share = tone(local.t_s, [p[3], p[4], p[5], p[6]]);
    let force = constant([p[0], p[1], p[2]].map(|own| own * share));
    push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_acts_at_the_centre_of_mass_in_its_time() {
        let p = [2.0, 0.0, 0.0, 0.25, core::f64::consts::FRAC_PI_2, 10.0, 4.5];
        let mut state = Trial { t_s: 10.0, ..Trial::default() };
        state.surroundings.body_com_m = [0.0, 0.5, 0.0];
        assert_eq!(state.wrench(&EFFECT, &p), [0.0, 0.0, -1.0, 2.0, 0.0, 0.0]);
        for t_s in [9.9, 14.5] {
            assert_eq!(Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &p), [0.0; 6]);
        }
    }
}
