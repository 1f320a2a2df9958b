//! A free body that hangs on its cables.

use super::applies::free_body;
use super::geometry::{push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Spring between a free body's origin and ground: `F = −k (r − r0)`, inertial axes.
pub static EFFECT: Effect = Effect {
    kind: "body_tether",
    title: "Harness or tether between a free body and ground",
    sites: &[SiteKind::Body],
    applies: free_body,
    parameters: &[
        EffectParameter::new("stiffness", "N/m", [0.0, 1e4], 0.5, "spring constant k").amplitude(),
        EffectParameter::new("rest_x", "m", [-100.0, 100.0], 0.0, "rest position of the body's origin, inertial x"),
        EffectParameter::new("rest_y", "m", [-100.0, 100.0], 0.0, "rest position, inertial y"),
        EffectParameter::new("rest_z", "m", [-100.0, 100.0], 0.0, "rest position, inertial z").out_of_plane(),
    ],
    law: Law::Body(both!(law)),
    family: Family::Stiffness,
    what: "F = -k (r - r0) on the body's origin; power and data cables of an air-bearing vehicle, soft suspension of a ground test.",
    signature: "A rigid-body mode at sqrt(k/m), force in phase with position.",
    confounders: "gravity_error (a slope is a constant force), drag; for a suspension the first flexible mode.",
    experiment: "Hold the body at several positions.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let position = local.body.position_m;
    let pull = core::array::from_fn(|i| (position[i] - T::constant(p[1 + i])).scale(-p[0]));
    push(&mut action.wrench, [0.0; 3], to_body(local, pull), [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_power_is_what_the_spring_loses_of_its_energy() {
        let p = [3.0, 0.4, -0.2, 0.1];
        for k in 0..50 {
            let state = Trial::random(k);
            let c_ib = state.body.rotation;
            let v = state.body.velocity_m_s;
            let velocity: [f64; 3] = core::array::from_fn(|i| (0..3).map(|j| c_ib[i][j] * v[j]).sum());
            let loss: f64 = (0..3).map(|i| -p[0] * (state.body.position_m[i] - p[1 + i]) * velocity[i]).sum();
            let size: f64 = (0..3).map(|i| (p[0] * (state.body.position_m[i] - p[1 + i]) * velocity[i]).abs()).sum();
            assert!((state.body_power(&EFFECT, &p) - loss).abs() <= 1e-13 * size + 1e-15, "{k}"); // rounding
        }
    }
}
