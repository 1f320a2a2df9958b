//! Sunlight that pushes beside the centre of mass.

use super::applies::in_free_fall;
use super::geometry::{constant, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Solar radiation pressure: a force along the light, inertial axes, at a centre of pressure.
pub static EFFECT: Effect = Effect {
    kind: "solar_pressure",
    title: "Solar radiation pressure",
    sites: &[SiteKind::Body],
    applies: in_free_fall,
    parameters: &[
        EffectParameter::new(
            "force_x",
            "N",
            [-0.01, 0.01],
            1e-4,
            "force F = pressure x area x (1 + reflectivity), inertial x",
        )
        .amplitude(),
        EffectParameter::new("force_y", "N", [-0.01, 0.01], 0.0, "force F along the light, inertial y").amplitude(),
        EffectParameter::new("force_z", "N", [-0.01, 0.01], 0.0, "force F along the light, inertial z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("arm_x", "m", [-10.0, 10.0], 0.0, "centre of pressure from the centre of mass, body x"),
        EffectParameter::new("arm_y", "m", [-10.0, 10.0], 0.5, "centre of pressure from the centre of mass, body y"),
        EffectParameter::new("arm_z", "m", [-10.0, 10.0], 0.0, "centre of pressure from the centre of mass, body z")
            .out_of_plane(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "Force F along the light (inertial direction) at the centre of pressure; the cannon-ball model, pressure 4.56e-6 N/m^2 at 1 au \
           (Montenbruck and Gill 2000). No site where the environment states a weight: that is no orbit.",
    signature: "Constant inertial force, torque that turns with attitude.",
    confounders: "constant_force at the centre of mass where the arm is zero (identical); with an arm, constant_torque until the attitude \
                  changes; drag.",
    experiment: "Turn the body about the sun line and across it; eclipse.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let force = to_body(local, constant([p[0], p[1], p[2]]));
    let at = core::array::from_fn(|i| local.surroundings.body_com_m[i] + p[3 + i]);
    push(&mut action.wrench, at, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_force_stays_along_the_light_while_its_torque_turns_with_the_body() {
        let mut state = Trial::default();
        assert_eq!(state.wrench(&EFFECT, &[2.0, 0.0, 0.0, 0.0, 0.5, 0.0]), [0.0, 0.0, -1.0, 2.0, 0.0, 0.0]);
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]; // a quarter turn: the light comes along body -y
        assert_eq!(state.wrench(&EFFECT, &[2.0, 0.0, 0.0, 0.0, 0.5, 0.0]), [0.0, 0.0, 0.0, 0.0, -2.0, 0.0]);
    }
}
