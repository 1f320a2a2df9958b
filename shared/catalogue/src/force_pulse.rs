//! A force that begins, and may end.

use super::geometry::{constant, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local};
use dynamics::real::Real;

/// Force on a body from an onset on, for a time.
pub static EFFECT: Effect = Effect {
    kind: "force_pulse",
    title: "Force on a body that begins or ends",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("force_x", "N", [-1e3, 1e3], 0.05, "force F, inertial x").amplitude(),
        EffectParameter::new("force_y", "N", [-1e3, 1e3], 0.0, "force F, inertial y").amplitude(),
        EffectParameter::new("force_z", "N", [-1e3, 1e3], 0.0, "force F, inertial z").amplitude().out_of_plane(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    limits: &[Limit { kind: "constant_force", at: &[("begin", 0.0), ("duration", 1e9)] }],
    what: "F fixed in inertial space at the centre of mass from a time on, for a time: a tow, a gust, a contact, a venting tank.",
    signature: "Velocity begins to grow at an instant, or ends to, without torque.",
    confounders: "constant_force where it begins with the record; thruster_leak (fixed to the body), sensor_step of an accelerometer.",
    experiment: "The same manoeuvre again, without what may have touched the body.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (begin, duration) = (p[3], p[4]);
    if local.t_s >= begin && local.t_s - begin < duration {
        let force = to_body(local, constant([p[0], p[1], p[2]]));
        push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_acts_at_the_centre_of_mass_in_its_time() {
        let mut state = Trial { t_s: 10.0, ..Trial::default() };
        state.surroundings.body_com_m = [0.0, 0.5, 0.0];
        let p = [2.0, 0.0, 0.0, 10.0, 3.0];
        assert_eq!(state.wrench(&EFFECT, &p), [0.0, 0.0, -1.0, 2.0, 0.0, 0.0]);
        for t_s in [9.999, 13.0] {
            assert_eq!(Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &p), [0.0; 6]);
        }
    }
}
