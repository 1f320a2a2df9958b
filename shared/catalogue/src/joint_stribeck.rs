//! The extra friction of a joint that hardly moves.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Scan};
use dynamics::real::Real;

/// Stribeck friction: `F = −dF tanh(q'/v0) exp(−(q'/v_s)²)`, added to the Coulomb level.
pub static EFFECT: Effect = Effect {
    kind: "joint_stribeck",
    title: "Stribeck friction in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 1e5], 0.02, "break-away force above the Coulomb level").amplitude(),
        EffectParameter::new("stribeck_rate", "*/s", [1e-4, 1.0], 0.02, "rate v_s at which it has fallen to 1/e")
            .width(Scan::OfRate(&[0.1, 0.4])),
        EffectParameter::new("smooth_rate", "*/s", [1e-6, 0.1], 1e-3, "rate v0 over which the sign turns").smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    limits: &[Limit { kind: "joint_coulomb", at: &[("stribeck_rate", 1.0)] }],
    what: "F = -dF tanh(q'/v0) exp(-(q'/v_s)^2); Stribeck 1902, in the form of Bo and Pavelescu 1982. Added to joint_coulomb it is the \
           whole Stribeck curve.",
    signature: "Friction that falls with speed, only where |q'| < 3 v_s: stick-slip at a crawl, torque peaks at each reversal.",
    confounders: "joint_coulomb (nested: the two differ only at a crawl); joint_lugre.",
    experiment: "A slow crawl through v_s in both directions, besides slews well above it.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, v_s, v_0) = (p[0], p[1], p[2]);
    let slow = local.rate.scale(1.0 / v_s);
    action.force -= local.rate.scale(1.0 / v_0).tanh() * (-slow * slow).exp().scale(force);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_extra_friction_has_its_level_at_a_crawl_and_a_part_in_e_at_the_stribeck_rate() {
        let force = |rate| Trial { rate, ..Trial::default() }.force(&EFFECT, &[0.5, 0.02, 1e-5]);
        assert!((force(2e-4) + 0.5).abs() < 0.5 * 1.1e-4); // exp(-(2e-4/0.02)²) = 1 - 1.0e-4
        assert!((force(0.02) + 0.5 * libm::exp(-1.0)).abs() < 1e-15); // rounding
        assert!(force(0.06).abs() < 0.5 * 1.3e-4); // exp(-9) = 1.23e-4: gone at three times the rate
        assert_eq!(force(-0.01), -force(0.01));
    }

    #[test]
    fn friction_never_drives() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0, 0.5, 1e-3]) * state.rate <= 0.0);
        }
    }
}
