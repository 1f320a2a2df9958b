//! The body is a magnet.

use super::geometry::{constant, cross, push, to_body};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Needs};
use dynamics::real::Real;

/// Residual magnetic dipole: `T = m × B`, m in body axes.
pub static EFFECT: Effect = Effect {
    kind: "residual_dipole",
    title: "Residual magnetic dipole",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("dipole_x", "A m^2", [-100.0, 100.0], 0.5, "dipole m of the body, body x").amplitude(),
        EffectParameter::new("dipole_y", "A m^2", [-100.0, 100.0], 0.0, "dipole m of the body, body y").amplitude(),
        EffectParameter::new("dipole_z", "A m^2", [-100.0, 100.0], 0.0, "dipole m of the body, body z")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new(
            "field_x",
            "T",
            [-1e-2, 1e-2],
            0.0,
            "field at t = 0, inertial x, where the environment states none",
        ),
        EffectParameter::new(
            "field_y",
            "T",
            [-1e-2, 1e-2],
            3e-5,
            "field at t = 0, inertial y, where the environment states none",
        ),
        EffectParameter::new(
            "field_z",
            "T",
            [-1e-2, 1e-2],
            0.0,
            "field at t = 0, inertial z, where the environment states none",
        )
        .out_of_plane(),
    ],
    law: Law::Body(both!(law)),
    needs: Needs::MagneticField,
    family: Family::Disturbance,
    what: "T = m x B, B of the environment in inertial axes, turning about z at twice the orbit's rate where there is an orbit; Wertz 1978.",
    signature: "Body torque that follows the direction of the field: once per turn of attitude, twice per orbit.",
    confounders: "constant_torque over a short arc, gravity_gradient (twice per turn).",
    experiment: "Turn the body about the field and across it.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let s = local.surroundings;
    let stated = s.field_t.iter().any(|b| *b != 0.0);
    let start = if stated { s.field_t } else { [p[3], p[4], p[5]] };
    let (sin, cos) = libm::sincos(2.0 * s.orbit_rate_rad_s * local.t_s);
    let field = [cos * start[0] - sin * start[1], sin * start[0] + cos * start[1], start[2]];
    let dipole = [p[0], p[1], p[2]];
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], cross(constant(dipole), to_body(local, constant(field))));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_turns_the_dipole_towards_the_field() {
        let p = [2.0, 0.0, 0.0, 0.0, 3e-5, 0.0];
        let mut state = Trial::default();
        assert!((state.wrench(&EFFECT, &p)[2] - 6e-5).abs() < 1e-19); // rounding
        state.surroundings.field_t = [0.0, 1e-4, 0.0];
        assert_eq!(state.wrench(&EFFECT, &p)[2], 2e-4);
        state.body.rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]; // dipole along the field
        assert_eq!(state.wrench(&EFFECT, &p)[2], 0.0);
    }

    #[test]
    fn over_half_an_orbit_the_field_turns_once() {
        let mut state = Trial { t_s: core::f64::consts::PI / 1e-3, ..Trial::default() };
        state.surroundings.orbit_rate_rad_s = 1e-3;
        state.surroundings.field_t = [0.0, 1e-4, 0.0];
        assert!((state.wrench(&EFFECT, &[2.0, 0.0, 0.0, 0.0, 3e-5, 0.0])[2] - 2e-4).abs() < 1e-18); // rounding of 2π
    }
}
