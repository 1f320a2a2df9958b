//! The torque of a long body in orbit.

use super::applies::in_free_fall;
use super::geometry::{constant, cross, direction, dot, push, to_body};
use dynamics::both;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Prior, Scan};
use dynamics::real::Real;

/// Gravity-gradient torque: `T = −2 A (r·b) (r × b)`, r to the planet, b the body's long axis.
pub static EFFECT: Effect = Effect {
    kind: "gravity_gradient",
    title: "Gravity-gradient torque",
    sites: &[SiteKind::Body],
    applies: left_out,
    parameters: &[
        EffectParameter::new("torque", "N m", [0.0, 10.0], 5e-4, "largest torque A = 3/2 n^2 dI").amplitude(),
        EffectParameter::new("axis_azimuth", "rad", [-3.2, 3.2], 0.0, "axis of least inertia, from body x towards y")
            .direction(2.0),
        EffectParameter::new("axis_elevation", "rad", [-1.6, 1.6], 0.0, "axis of least inertia, towards body z")
            .out_of_plane(),
        EffectParameter::new("orbit_rate", "rad/s", [0.0, 2e-3], 1.1e-3, "n")
            .width(Scan::Default)
            .with_prior(Prior::Kept),
        EffectParameter::new("planet_azimuth", "rad", [-3.2, 3.2], 0.0, "direction to the planet at t = 0"),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    what: "T = 3 n^2 r x I r = -2 A (r.b) (r x b), r to the planet, b the long axis; in the plane -A sin 2(theta - theta_planet). Wertz 1978. \
           Written with the difference of inertia, which planar plants do not state. No site where the \
           environment states the orbit (the torque is there already) or a weight (that is no orbit).",
    signature: "Body torque with sin 2 theta of attitude and twice the orbital rate.",
    confounders: "wheel_viscous in a multisine (cosine 0.93), constant_torque and actuator_bias over a short arc, residual_dipole.",
    experiment: "Turn the body by 45 degrees, or a longer arc of the orbit.",
    ..Effect::PLAIN
};

/// An environment that states the orbit has this torque already.
fn left_out(plant: &Plant, site: &Site) -> bool {
    plant.environment.gravity_gradient.is_none() && in_free_fall(plant, site)
}

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let angle = p[4] + p[3] * local.t_s;
    let planet = to_body(local, constant(direction(angle, 0.0)));
    let long = constant(direction(p[1], p[2]));
    let size = dot(planet, long).scale(-2.0 * p[0]);
    let torque = cross(planet, long).map(|component| component * size);
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::geometry::{cross_f64, direction, to_body};
    use crate::trial::Trial;

    #[test]
    fn in_the_plane_the_torque_is_minus_sine_of_twice_the_angle_to_the_planet() {
        for k in 0..20 {
            let theta = 0.4 * f64::from(k);
            let (sin, cos) = libm::sincos(theta);
            let mut state = Trial { t_s: 100.0, ..Trial::default() };
            state.body.rotation = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
            let w = state.wrench(&EFFECT, &[0.3, 0.2, 0.0, 1e-3, 0.5]);
            let expected = -0.3 * libm::sin(2.0 * (theta + 0.2 - 0.5 - 0.1));
            assert!((w[2] - expected).abs() < 1e-14, "{theta}"); // rounding of angles up to 16 rad
            assert_eq!(w[3..], [0.0; 3]);
        }
    }

    #[test]
    fn the_torque_is_three_n_squared_r_cross_i_r_of_a_body_with_one_long_axis() {
        for k in 0..50 {
            let state = Trial::random(k);
            let (n, lack) = (1e-3, 7.0); // I = i0 1 - lack b bᵀ
            let surroundings = state.surroundings;
            let state = Trial { t_s: 0.0, ..state };
            let b = direction(0.3, 0.7);
            let no_hidden: [f64; 0] = [];
            let local = dynamics::effect::Local {
                displacement: [0.0; 3],
                displacement_rate: [0.0; 3],
                t_s: 0.0,
                coordinate: 0.0,
                rate: 0.0,
                command: 0.0,
                reading: 0.0,
                body: &state.body,
                hidden: &no_hidden,
                surroundings: &surroundings,
            };
            let r = to_body(&local, direction(0.9, 0.0));
            let i_r: [f64; 3] =
                core::array::from_fn(|i| 20.0 * r[i] - lack * b[i] * (0..3).map(|j| b[j] * r[j]).sum::<f64>());
            let expected = cross_f64(r, i_r).map(|x| 3.0 * n * n * x);
            let w = state.wrench(&EFFECT, &[1.5 * n * n * lack, 0.3, 0.7, 0.0, 0.9]);
            for i in 0..3 {
                assert!((w[i] - expected[i]).abs() < 1e-19, "{k}"); // rounding of terms of 6e-5
            }
        }
    }

    #[test]
    fn an_environment_that_states_the_orbit_leaves_it_no_site() {
        use crate::trial::plant;
        use dynamics::description::{GravityGradient, Quantity};
        use dynamics::effect::sites;
        assert!(!sites(&EFFECT, &plant()).is_empty());
        let mut in_orbit = plant();
        in_orbit.environment.gravity_gradient =
            Some(GravityGradient { orbit_rate_rad_s: Quantity::known(1e-3), phase_rad: Quantity::known(0.0) });
        assert!(sites(&EFFECT, &in_orbit).is_empty());
        let mut on_ground = plant();
        on_ground.environment.gravity_m_s2[1] = Quantity::known(-9.81);
        assert!(sites(&EFFECT, &on_ground).is_empty());
    }
}
