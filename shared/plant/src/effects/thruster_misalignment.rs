//! Thrust that points aside.

use super::applies::thruster;
use super::geometry::{perpendicular, push};
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "thruster_misalignment",
    title: "Misalignment of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("angle", "rad", [-0.2, 0.2], 0.01, "angle e between true and stated thrust"),
        EffectParameter::new("clock", "rad", [-3.2, 3.2], 0.0, "direction of the tilt about the thrust; 0: z x thrust"),
    ],
    amplitudes: 1,
    hidden_states: 0,
    law: Law::Actuator(both!(law)),
    what: "F d -> F (cos e d + sin e t), t perpendicular to d, at the same point: torque r x F (cos e - 1, sin e); Wertz 1978.",
    signature: "Hub torque and side force in step with this thruster's command.",
    confounders: "com_shift (the same torque from one thruster; another thruster parts them); thruster_plume.",
    experiment: "Fire another thruster of different direction: a shift of the centre of mass acts on both, a misalignment does not.",
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (sin, cos) = libm::sincos(p[0]);
    let axis = local.surroundings.site_axis;
    let aside = perpendicular(axis, p[1]);
    let thrust = action.value;
    let change = core::array::from_fn(|i| thrust.scale((cos - 1.0) * axis[i] + sin * aside[i]));
    push(&mut action.wrench, local.surroundings.site_position_m, change, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::geometry::dot;
    use crate::effects::trial::Trial;

    #[test]
    fn the_thrust_is_turned_not_lengthened_and_keeps_its_point() {
        for k in 0..100 {
            let state = Trial::random(k);
            let (f, d, r) = (state.command, state.surroundings.site_axis, state.surroundings.site_position_m);
            let w = state.wrench(&EFFECT, &[0.13, 0.6]);
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
