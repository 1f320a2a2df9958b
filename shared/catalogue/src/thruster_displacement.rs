//! A thruster whose line of thrust is displaced.

use super::applies::thruster;
use super::geometry::{across, cross_f64, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Thrust along a parallel line: `T = F o × d`, o the displacement across the thrust.
pub static EFFECT: Effect = Effect {
    kind: "thruster_displacement",
    title: "Displaced line of thrust",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("offset_1", "m", [-0.5, 0.5], 0.005, "displacement along t1 = z x thrust").amplitude(),
        EffectParameter::new("offset_2", "m", [-0.5, 0.5], 0.0, "displacement along t2 = thrust x t1")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "The thrust F d acts at r + o1 t1 + o2 t2: the torque F o x d besides. A nozzle mounted beside its place, or a jet that leaves it \
           unevenly; a displacement along the thrust has no effect.",
    signature: "A torque in step with this thruster's command; force and direction are as commanded.",
    confounders: "com_shift (the same from one thruster; another thruster parts them), thruster_misalignment (a side force besides), \
                  thruster_plume (less force besides).",
    experiment: "Fire another thruster of different direction: a shift of the centre of mass acts on both, a displacement does not.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let axis = local.surroundings.site_axis;
    let [first, second] = across(axis);
    let moment = cross_f64(core::array::from_fn(|i| p[0] * first[i] + p[1] * second[i]), axis);
    let thrust = action.value;
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], moment.map(|m| thrust.scale(m)));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_thrust_acts_along_a_parallel_line() {
        let mut state = Trial { command: 10.0, ..Trial::default() };
        state.surroundings.site_axis = [1.0, 0.0, 0.0];
        // t1 = z x thrust = y: 10 N along x at y = 0.2 m
        assert_eq!(state.wrench(&EFFECT, &[0.2, 0.0]), [0.0, 0.0, -2.0, 0.0, 0.0, 0.0]);
        assert_eq!(state.value(&EFFECT, &[0.2, 0.0]), 10.0);
        // t2 = x x y = z: at z = 0.2 m
        assert_eq!(state.wrench(&EFFECT, &[0.0, 0.2]), [0.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
