//! Aerodynamic drag at a centre of pressure.

use super::geometry::{norm, push, velocity_through_medium};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Needs};
use dynamics::real::Real;

/// Aerodynamic drag at a centre of pressure: `F = −½ ρ c_d A |v| v`, v relative to the medium.
pub static EFFECT: Effect = Effect {
    kind: "drag",
    title: "Aerodynamic drag at a centre of pressure",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("area", "m^2", [0.0, 1e3], 1.0, "drag coefficient x area").amplitude(),
        EffectParameter::new("arm_x", "m", [-10.0, 10.0], 0.0, "centre of pressure from the centre of mass, body x"),
        EffectParameter::new("arm_y", "m", [-10.0, 10.0], 0.0, "centre of pressure from the centre of mass, body y"),
        EffectParameter::new("arm_z", "m", [-10.0, 10.0], 0.0, "centre of pressure from the centre of mass, body z")
            .out_of_plane(),
        EffectParameter::new("density", "kg/m^3", [0.0, 1.5], 1e-11, "density, where the environment states none"),
    ],
    law: Law::Body(both!(law)),
    needs: Needs::Atmosphere,
    family: Family::Aerodynamics,
    what: "F = -1/2 rho c_d A |v| v at the centre of pressure, v of the centre of mass through the medium; density and wind of the \
           environment; Newton 1687, Montenbruck and Gill 2000. 1e-11 kg/m^3 is some 350 km above the Earth.",
    signature: "Deceleration with the square of speed; a torque that turns with attitude, where the centre of pressure is aside.",
    confounders: "quadratic_drag (the same without an arm); linear_drag at one speed; constant_force, constant_torque and solar_pressure in \
                  orbit at one attitude.",
    experiment: "Coast at two attitudes, at two speeds.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let surroundings = local.surroundings;
    let density = if surroundings.density_kg_m3 > 0.0 { surroundings.density_kg_m3 } else { p[4] };
    let velocity = velocity_through_medium(local);
    let size = norm(velocity).scale(-0.5 * density * p[0]);
    let at = core::array::from_fn(|i| surroundings.body_com_m[i] + p[1 + i]);
    push(&mut action.wrench, at, velocity.map(|v| v * size), [T::zero(); 3]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn drag_takes_the_density_of_the_environment_and_turns_a_body_about_its_centre_of_mass() {
        let mut state = Trial::default();
        state.body.velocity_m_s = [4.0, 0.0, 0.0];
        state.surroundings.body_com_m = [0.0, 1.0, 0.0];
        let p = [0.5, 0.0, 0.25, 0.0, 2.0];
        assert_eq!(state.wrench(&EFFECT, &p), [0.0, 0.0, 10.0, -8.0, 0.0, 0.0]); // 1/2 2 0.5 16 N at y = 1.25 m
        state.surroundings.density_kg_m3 = 1.0;
        assert_eq!(state.wrench(&EFFECT, &p)[3], -4.0);
    }

    #[test]
    fn without_an_arm_drag_never_drives_in_still_air() {
        for k in 0..100 {
            let mut state = Trial::random(k);
            state.surroundings.wind_m_s = [0.0; 3];
            assert!(state.body_power(&EFFECT, &[0.5, 0.0, 0.0, 0.0, 1.0]) <= 1e-9);
        }
    }
}
