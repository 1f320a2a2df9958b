//! Drag with the square of the speed.

use super::geometry::{norm, push, velocity_through_medium};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic drag at the centre of mass: `F = −c |v| v`, v relative to the medium.
pub static EFFECT: Effect = Effect {
    kind: "quadratic_drag",
    title: "Quadratic drag of one coefficient",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new(
        "coefficient",
        "kg/m",
        [0.0, 10.0],
        1e-2,
        "half density x drag coefficient x area",
    )
    .amplitude()],
    law: Law::Body(both!(law)),
    family: Family::Aerodynamics,
    what: "F = -c |v| v at the centre of mass, v through the medium (wind of the environment); Newton 1687, Rayleigh 1876. A \
           falling ball, a pendulum's bob, an air-bearing vehicle.",
    signature: "Deceleration with the square of speed, terminal speed sqrt(m g / coefficient).",
    confounders: "drag (the same where density and centre of pressure stay); linear_drag at one speed, joint_quadratic_damping of the joint that carries the body, constant_force in orbit.",
    experiment: "Two speeds; on orbit, coast at two attitudes.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let velocity = velocity_through_medium(local);
    let size = norm(velocity).scale(-p[0]);
    push(&mut action.wrench, local.surroundings.body_com_m, velocity.map(|v| v * size), [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn at_terminal_speed_drag_carries_the_weight() {
        let (m, g, coefficient) = (2.0, 9.81, 0.05f64);
        let mut state = Trial::default();
        state.body.velocity_m_s = [0.0, -(m * g / coefficient).sqrt(), 0.0];
        let w = state.wrench(&EFFECT, &[coefficient]);
        assert!((w[4] - m * g).abs() < 1e-13); // rounding
    }

    #[test]
    fn in_still_air_drag_never_drives() {
        for k in 0..300 {
            let mut state = Trial::random(k);
            state.surroundings.wind_m_s = [0.0; 3];
            assert!(state.body_power(&EFFECT, &[0.7]) <= 0.0);
        }
    }

    #[test]
    fn a_body_that_drifts_with_the_wind_feels_none() {
        let mut state = Trial::default();
        state.surroundings.wind_m_s = [3.0, -1.0, 0.0];
        state.body.velocity_m_s = [3.0, -1.0, 0.0];
        assert_eq!(state.wrench(&EFFECT, &[0.7]), [0.0; 6]);
    }
}
