//! A rotor whose centre of mass is off its axis.

use super::applies::wheel;
use super::geometry::{perpendicular, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Static imbalance of a wheel: force `U W² (cos p e1 + sin p e2)` on the body at the wheel,
/// `p' = W`.
pub static EFFECT: Effect = Effect {
    kind: "wheel_imbalance_static",
    title: "Static imbalance of a wheel",
    sites: &[SiteKind::Actuator],
    applies: wheel,
    parameters: &[
        EffectParameter::new("imbalance", "kg m", [0.0, 0.01], 1e-5, "mass times distance U from the axis").amplitude(),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "rotor angle at the start").direction(1.0),
        EffectParameter::new("position_x", "m", [-10.0, 10.0], 0.0, "where the wheel is on its body, x"),
        EffectParameter::new("position_y", "m", [-10.0, 10.0], 0.0, "where the wheel is on its body, y"),
        EffectParameter::new("position_z", "m", [-10.0, 10.0], 0.0, "where the wheel is on its body, z").out_of_plane(),
    ],
    hidden_states: 1,
    law: Law::Actuator(both!(law)),
    family: Family::Ripple,
    what: "Force U W^2 (cos p e1 + sin p e2) on the body at the wheel's place, p' = W, e1 and e2 perpendicular to the axis (Masterson, Miller and \
           Grogan 2002). The rotor's turn is relative to the body.",
    signature: "A line at wheel speed in every accelerometer, growing with its square, on both axes 90 degrees apart.",
    confounders: "A structural mode at that frequency; what a sensor sampled too slowly makes of it; sensor_tone.",
    experiment: "Ramp the wheel: the line follows its speed, an aliased one runs backwards.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let force = rotating(local, p[1]).map(|component| component.scale(p[0]));
    push(&mut action.wrench, [p[2], p[3], p[4]], force, [T::zero(); 3]);
    action.hidden_rate[0] = local.rate;
}

/// `W² (cos p e1 + sin p e2)`: the unit vector fixed to the rotor, times speed squared.
pub(super) fn rotating<T: Real>(local: &Local<'_, T>, phase_rad: f64) -> [T; 3] {
    let axis = local.surroundings.site_axis;
    let (first, second) = (perpendicular(axis, 0.0), perpendicular(axis, core::f64::consts::FRAC_PI_2));
    let (sin, cos) = (local.hidden[0] + T::constant(phase_rad)).sin_cos();
    let square = local.rate * local.rate;
    core::array::from_fn(|i| (cos.scale(first[i]) + sin.scale(second[i])) * square)
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::geometry::dot;
    use crate::trial::Trial;

    #[test]
    fn the_force_is_centrifugal_perpendicular_to_the_axis_and_turns_with_the_rotor() {
        for k in 0..100 {
            let state = Trial { hidden: [0.7, 0.0, 0.0, 0.0], ..Trial::random(k) };
            let w = state.wrench(&EFFECT, &[1e-3, 0.2, 0.0, 0.0, 0.0]);
            let force = [w[3], w[4], w[5]];
            let expected = 1e-3 * state.rate * state.rate;
            assert!((dot(force, force).sqrt() - expected).abs() < 1e-13 * expected); // rounding
            assert!(dot(force, state.surroundings.site_axis).abs() < 1e-13 * expected);
            assert_eq!(state.act(&EFFECT, &[1e-3, 0.2, 0.0, 0.0, 0.0]).hidden_rate[0], state.rate);
        }
        let mut state = Trial { rate: 10.0, hidden: [core::f64::consts::FRAC_PI_2, 0.0, 0.0, 0.0], ..Trial::default() };
        state.surroundings.site_axis = [0.0, 0.0, 1.0];
        let w = state.wrench(&EFFECT, &[1e-3, 0.0, 0.5, 0.0, 0.0]);
        assert!((w[2] - 0.5 * 0.1).abs() < 1e-16); // on its arm
        assert!((w[4] - 0.1).abs() < 1e-16 && w[3].abs() < 1e-16); // a quarter turn about z takes x to y
    }
}
