//! Exhaust that hits the spacecraft.

use super::applies::thruster;
use super::geometry::{across, cross_f64, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Plume impingement on the thruster's own body: a force `−c F d` beside the line of thrust d.
pub static EFFECT: Effect = Effect {
    kind: "thruster_plume",
    title: "Plume impingement on the thruster's own body",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("fraction", "1", [0.0, 0.5], 0.03, "share c of the thrust that comes back").amplitude(),
        EffectParameter::new(
            "moment_1",
            "m",
            [-5.0, 5.0],
            0.015,
            "c times the surface's distance aside, along t1 = z x thrust",
        )
        .amplitude(),
        EffectParameter::new("moment_2", "m", [-5.0, 5.0], 0.0, "c times its distance along t2 = thrust x t1")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "A surface on the thruster's body takes the force -c F d at r + o: the torque -F (c o) x d besides, o aside of the thrust's line; the \
           moment c o is the amplitude, so that its direction needs no angle. The distance along d does not matter. A surface on another \
           body (an arm in some pose) is a constant_force on that body while the thruster fires.",
    signature: "Less force and a torque in step with this thruster's command.",
    confounders: "motor_constant_error (its force, exactly), thruster_displacement, thruster_misalignment and com_shift (its torque).",
    experiment: "Fire with the appendage or arm in two poses; only impingement changes.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let axis = local.surroundings.site_axis;
    let [first, second] = across(axis);
    let moment = cross_f64(core::array::from_fn(|i| p[1] * first[i] + p[2] * second[i]), axis);
    let thrust = action.value;
    let torque = moment.map(|m| thrust.scale(-m));
    push(&mut action.wrench, local.surroundings.site_position_m, axis.map(|d| thrust.scale(-p[0] * d)), torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn a_share_of_the_thrust_comes_back_on_its_arm() {
        let mut state = Trial { command: 10.0, ..Trial::default() };
        state.surroundings.site_axis = [1.0, 0.0, 0.0];
        state.surroundings.site_position_m = [-0.5, 0.2, 0.0];
        let w = state.wrench(&EFFECT, &[0.1, 0.2, 0.0]);
        // -1 N along x at y = 2.2 m: torque +2.2 N m about z
        assert_eq!(w, [0.0, 0.0, 2.2, -1.0, 0.0, 0.0].map(|x: f64| x + 0.0));
    }
}
