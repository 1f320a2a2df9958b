//! The side force of a body that spins as it flies.

use super::geometry::{cross, push, velocity_through_medium};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Needs};
use dynamics::real::Real;

/// Magnus lift at the centre of mass: `F = S ω × v`, v relative to the medium.
pub static EFFECT: Effect = Effect {
    kind: "magnus_lift",
    title: "Magnus lift",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new(
        "coefficient",
        "kg",
        [-1.0, 1.0],
        1e-3,
        "coefficient S; pi rho r^3 of a slow sphere",
    )
    .amplitude()],
    law: Law::Body(both!(law)),
    needs: Needs::Atmosphere,
    family: Family::Aerodynamics,
    what: "F = S w x v at the centre of mass, v through the medium; Magnus 1852, Rubinow and Keller 1961.",
    signature: "Trajectory curves across velocity and spin axis.",
    confounders: "A side wind; thruster_misalignment while the body spins.",
    experiment: "Reverse the spin.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let force = cross(local.body.omega_rad_s, velocity_through_medium(local)).map(|f| f.scale(p[0]));
    push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_lift_is_across_spin_and_velocity_and_does_no_work() {
        let mut state = Trial::default();
        state.body.velocity_m_s = [2.0, 0.0, 0.0];
        state.body.omega_rad_s = [0.0, 0.0, 3.0];
        assert_eq!(state.wrench(&EFFECT, &[0.5])[3..], [0.0, 3.0, 0.0]);
        for k in 0..100 {
            let mut state = Trial::random(k);
            state.surroundings.wind_m_s = [0.0; 3];
            let length = |a: [f64; 3]| libm::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
            let omega = length(state.body.omega_rad_s);
            let speed = length(state.body.velocity_m_s) + omega * length(state.surroundings.body_com_m);
            // rounding, relative to spin times the square of the sum of the speeds that cancel
            assert!(state.body_power(&EFFECT, &[0.5]).abs() <= 1e-14 * omega * speed * speed);
        }
    }
}
