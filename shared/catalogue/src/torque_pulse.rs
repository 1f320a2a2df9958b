//! A torque that begins, and may end.

use super::geometry::{constant, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local};
use dynamics::real::Real;

/// Torque on a body from an onset on, for a time.
pub static EFFECT: Effect = Effect {
    kind: "torque_pulse",
    title: "Torque on a body that begins or ends",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("torque_x", "N m", [-1e3, 1e3], 0.0, "torque T, inertial x").amplitude().out_of_plane(),
        EffectParameter::new("torque_y", "N m", [-1e3, 1e3], 0.0, "torque T, inertial y").amplitude().out_of_plane(),
        EffectParameter::new("torque_z", "N m", [-1e3, 1e3], 0.01, "torque T, inertial z").amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time at which it begins").onset(),
        EffectParameter::new("duration", "s", [0.0, 1e9], 1e9, "how long it lasts").duration(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    limits: &[Limit { kind: "constant_torque", at: &[("begin", 0.0), ("duration", 1e9)] }],
    what: "T fixed in inertial space from a time on, for a time: a hose that pulls, a plume of another craft, a contact.",
    signature: "Rate begins to grow at an instant, or ends to.",
    confounders: "constant_torque where it begins with the record; thermal_snap (whose rate returns), thruster_leak (a force besides).",
    experiment: "The same manoeuvre again, without what may have touched the body.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (begin, duration) = (p[3], p[4]);
    if local.t_s >= begin && local.t_s - begin < duration {
        let torque = to_body(local, constant([p[0], p[1], p[2]]));
        push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_keeps_its_inertial_axis_and_its_time() {
        let mut state = Trial { t_s: 10.0, ..Trial::default() };
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let p = [2.0, 0.0, 0.0, 10.0, 3.0];
        assert_eq!(state.wrench(&EFFECT, &p), [0.0, -2.0, 0.0, 0.0, 0.0, 0.0]);
        for t_s in [9.999, 13.0] {
            assert_eq!(Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &p), [0.0; 6]);
        }
    }
}
