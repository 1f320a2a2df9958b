//! Drag in proportion to speed.

use super::geometry::{push, velocity_through_medium};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Needs};
use dynamics::real::Real;

/// Linear drag at the centre of mass: `F = −c v`, v relative to the medium.
pub static EFFECT: Effect = Effect {
    kind: "linear_drag",
    title: "Linear drag",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new(
        "coefficient",
        "N s/m",
        [0.0, 100.0],
        0.01,
        "coefficient c; 6 pi mu r of a sphere",
    )
    .amplitude()],
    law: Law::Body(both!(law)),
    needs: Needs::Atmosphere,
    family: Family::Aerodynamics,
    what: "F = -c v at the centre of mass, v through the medium; Stokes 1851, eddy currents, an air bearing's film.",
    signature: "Speed decays exponentially with time and linearly with distance.",
    confounders: "drag at one speed, joint_viscous of the joint that carries the body.",
    experiment: "Two speeds.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let force = velocity_through_medium(local).map(|v| v.scale(-p[0]));
    push(&mut action.wrench, local.surroundings.body_com_m, force, [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn drag_is_the_coefficient_times_the_velocity_of_the_centre_of_mass() {
        let mut state = Trial::default();
        state.body.velocity_m_s = [2.0, 0.0, 0.0];
        state.body.omega_rad_s = [0.0, 0.0, 3.0];
        state.surroundings.body_com_m = [1.0, 0.0, 0.0];
        assert_eq!(state.wrench(&EFFECT, &[0.5]), [0.0, 0.0, -1.5, -1.0, -1.5, 0.0]);
    }

    #[test]
    fn in_still_air_drag_never_drives() {
        for k in 0..300 {
            let mut state = Trial::random(k);
            state.surroundings.wind_m_s = [0.0; 3];
            assert!(state.body_power(&EFFECT, &[0.7]) <= 0.0);
        }
    }
}
