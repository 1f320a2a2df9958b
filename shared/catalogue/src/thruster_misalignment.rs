//! Thrust that points aside.

use super::applies::thruster;
use super::geometry::{across, push, tilt_factors};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Misalignment of a thruster: `F d → F (cos e d + sin e (e1 t1 + e2 t2) / e)` at the same point.
pub static EFFECT: Effect = Effect {
    kind: "thruster_misalignment",
    title: "Misalignment of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("tilt_1", "rad", [-0.2, 0.2], 0.01, "tilt of the true thrust towards t1 = z x thrust")
            .amplitude(),
        EffectParameter::new("tilt_2", "rad", [-0.2, 0.2], 0.0, "tilt towards t2 = thrust x t1")
            .amplitude()
            .out_of_plane(),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "F d -> F (cos e d + sin e (e1 t1 + e2 t2) / e), e the length of the tilt (e1, e2), at the same point; Wertz 1978.",
    signature: "Hub torque and side force in step with this thruster's command.",
    confounders: "com_shift (the same torque from one thruster; another thruster parts them); thruster_displacement and thruster_plume (its moment, exactly).",
    experiment: "Fire another thruster of different direction: a shift of the centre of mass acts on both, a misalignment does not.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let axis = local.surroundings.site_axis;
    let [first, second] = across(axis);
    let (cos, along) = tilt_factors([p[0], p[1]]);
    let thrust = action.value;
    let change =
        core::array::from_fn(|i| thrust.scale((cos - 1.0) * axis[i] + along * (p[0] * first[i] + p[1] * second[i])));
    push(&mut action.wrench, local.surroundings.site_position_m, change, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::geometry::dot;
    use crate::trial::Trial;

    #[test]
    fn the_thrust_is_turned_not_lengthened_and_keeps_its_point() {
        for k in 0..100 {
            let state = Trial::random(k);
            let (f, d, r) = (state.command, state.surroundings.site_axis, state.surroundings.site_position_m);
            let w = state.wrench(&EFFECT, &[0.05, 0.12]);
            let total: [f64; 3] = core::array::from_fn(|i| f * d[i] + w[i + 3]);
            assert!((dot(total, total) - f * f).abs() <= 1e-14 * f * f); // rounding
            assert!((dot(total, d) - f * libm::cos(0.13)).abs() <= 1e-14 * f.abs());
            let torque = [w[0], w[1], w[2]];
            let size = (dot(r, r) * f * f).sqrt();
            assert!(dot(torque, [w[3], w[4], w[5]]).abs() <= 1e-14 * size * f.abs()); // a force at a point has no moment along itself
            assert!(dot(torque, r).abs() <= 1e-14 * size * dot(r, r).sqrt());
        }
    }

    #[test]
    fn in_the_plane_a_tilt_is_positive_about_z() {
        let mut state = Trial { command: 10.0, ..Trial::default() };
        state.surroundings.site_position_m = [-0.5, 0.0, 0.0];
        let w = state.wrench(&EFFECT, &[0.01, 0.0]);
        assert!((w[4] - 10.0 * libm::sin(0.01)).abs() < 1e-15); // rounding
        assert!((w[2] + 0.5 * 10.0 * libm::sin(0.01)).abs() < 1e-15);
    }
}
