//! Slosh that sticks to the wall.

use super::geometry::{constant, dot, norm};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Contact-line friction of a slosh mode: `F = −F tanh(|s'|/v0) s'/|s'|`, s along all slosh axes.
pub static EFFECT: Effect = Effect {
    kind: "slosh_contact_line",
    title: "Contact-line friction of a slosh mode",
    sites: &[SiteKind::Tank],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 100.0], 0.01, "force F that the moving contact line resists with")
            .amplitude(),
        EffectParameter::new("smooth_rate", "*/s", [1e-6, 0.1], 1e-3, "rate v0 over which the sign turns").smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    what: "F = -F tanh(|s'|/v0) s'/|s'|, s' the rate along all slosh axes; contact-angle hysteresis (Keulegan 1959; Cocciaro, Faetti and Festa 1993).",
    signature: "Small slosh dies out linearly, in finite time; damping ratio grows as amplitude falls.",
    confounders: "The nominal slosh damper at one amplitude; slosh_quadratic_damping has the opposite trend.",
    experiment: "A free decay to the noise.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, v_0) = (p[0], p[1]);
    let rate = local.displacement_rate;
    let speed = norm(rate);
    let along = dot(constant(local.surroundings.site_axis), rate);
    // tanh(v/v0) / v is 1/v0 at rest
    let per_rate =
        if speed.value() > 1e-6 * v_0 { speed.scale(1.0 / v_0).tanh() / speed } else { T::constant(1.0 / v_0) };
    action.force -= (along * per_rate).scale(force);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn friction_tends_to_the_sign_of_the_rate_and_never_drives() {
        let force = |rate| Trial { rate, ..Trial::default() }.force(&EFFECT, &[0.3, 1e-3]);
        assert_eq!([force(0.5), force(-0.5)], [-0.3, 0.3]);
        assert_eq!(force(1e-3), -0.3 * libm::tanh(1.0));
        for k in 0..200 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0, 0.1]) * state.rate <= 0.0);
        }
    }
}
