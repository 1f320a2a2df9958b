//! A rotor whose principal axis is tilted.

use super::applies::{actuator, wheel};
use super::geometry::push;
use super::wheel_imbalance_static::rotating;
use dynamics::both;
use dynamics::description::{Plant, Site, SiteKind, Space};
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Dynamic imbalance of a wheel: torque `U W² (cos p e1 + sin p e2)` on the body, `p' = W`.
pub static EFFECT: Effect = Effect {
    kind: "wheel_imbalance_dynamic",
    title: "Dynamic imbalance of a wheel",
    sites: &[SiteKind::Actuator],
    applies: spatial_wheel,
    parameters: &[
        EffectParameter::new("imbalance", "kg m^2", [0.0, 0.01], 1e-6, "product of inertia U of the rotor").amplitude(),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "rotor angle at the start").direction(1.0),
    ],
    hidden_states: 1,
    law: Law::Actuator(both!(law)),
    family: Family::Ripple,
    what: "Torque U W^2 (cos p e1 + sin p e2) on the body, p' = W, perpendicular to the axis (Masterson, Miller and Grogan 2002); planar \
           plants do not feel it.",
    signature: "A line at wheel speed in the gyros across the wheel's axis, growing with the square of speed.",
    confounders: "wheel_imbalance_static of a wheel away from the centre of mass; a structural mode; sensor_tone.",
    experiment: "Ramp the wheel; compare accelerometers, which a pure torque hardly moves.",
    ..Effect::PLAIN
};

fn spatial_wheel(plant: &Plant, site: &Site) -> bool {
    plant.space == Space::Spatial && actuator(plant, site).is_some() && wheel(plant, site)
}

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let torque = rotating(local, p[1]).map(|component| component.scale(p[0]));
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
    action.hidden_rate[0] = local.rate;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::geometry::dot;
    use crate::trial::Trial;

    #[test]
    fn the_torque_grows_with_speed_squared_across_the_axis_and_comes_without_force() {
        for k in 0..100 {
            let state = Trial::random(k);
            let w = state.wrench(&EFFECT, &[1e-3, 0.2]);
            let torque = [w[0], w[1], w[2]];
            let expected = 1e-3 * state.rate * state.rate;
            assert!((dot(torque, torque).sqrt() - expected).abs() < 1e-13 * expected); // rounding
            assert!(dot(torque, state.surroundings.site_axis).abs() < 1e-13 * expected);
            assert_eq!(w[3..], [0.0; 3]);
        }
    }
}
