//! Friction with memory: bristles that bend before they slide.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Scan};
use dynamics::real::Real;

/// LuGre friction: `F = −F_c (z + T e^−(q'/v_s)² z')`, `z' = (q' − |q'| z / r) / d`.
pub static EFFECT: Effect = Effect {
    kind: "joint_lugre",
    title: "LuGre friction in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 1e5], 0.02, "Coulomb level F_c").amplitude(),
        EffectParameter::new("break_away_ratio", "1", [1.0, 3.0], 1.3, "static over Coulomb friction"),
        EffectParameter::new("stribeck_rate", "*/s", [1e-4, 1.0], 0.02, "rate v_s of the Stribeck curve")
            .width(Scan::OfRate(&[0.1, 0.4])),
        EffectParameter::new("presliding", "*", [1e-6, 0.5], 0.01, "displacement d = F_c / bristle stiffness")
            .width(Scan::OfRangeFollowed(&[0.02, 0.15])),
        EffectParameter::new(
            "bristle_damping",
            "1",
            [0.0, 1.0],
            0.0,
            "bristle damping over the largest that is passive",
        ),
    ],
    hidden_states: 1,
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    limits: &[Limit {
        kind: "joint_coulomb",
        at: &[("break_away_ratio", 1.0), ("presliding", 1e-6), ("bristle_damping", 0.0)],
    }],
    what: "F = -F_c (z + T e^-(q'/v_s)^2 z'), z' = (q' - |q'| z / r) / d, r = 1 + (s - 1) e^-(q'/v_s)^2; Canudas de Wit, Olsson, Astrom \
           and Lischinsky 1995, deflection scaled by d = F_c / sigma_0 so that F_c is an amplitude, bristle damping fading with speed \
           (Olsson 1996), T = 9.3 B d / v_s: passive for B <= 1 (T e^-(q'/v_s)^2 |q'| <= 4 d r). Dahl 1968 with a ratio of one. Bristles \
           bend over no less than the way of one step of integration: d is at least |q'| h.",
    signature: "Spring-like before it slides, Coulomb after, a torque peak at break-away: the residual depends on the last turning point, \
                not on rate alone.",
    confounders: "joint_coulomb with joint_stribeck (its limit for small d); joint_bouc_wen; joint_stiffness while it never slides.",
    experiment: "Reversals of several sizes, some smaller than d: inner loops show memory, Coulomb friction has none.",
    ..Effect::PLAIN
};

/// `4 d r ≥ T fade |v|` holds at every rate up to this `T v_s / d`: `|v| fade` is at most
/// `v_s e^(−1/2) / √2`, and `r ≥ 1`.
const PASSIVE_MAX: f64 = 9.32;

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force_c, ratio, v_s, d) = (p[0], p[1], p[2], p[3]);
    let time = p[4] * PASSIVE_MAX * d / v_s;
    let (v, z) = (local.rate, local.hidden[0]);
    let slow = v.scale(1.0 / v_s);
    let fade = (-slow * slow).exp();
    let r = fade.scale(ratio - 1.0) + T::one();
    // shorter bristles than the way of one step would follow it at more than their own rate, which
    // no explicit step can
    let bent = T::constant(d).max(v.abs().scale(local.surroundings.step_s));
    let z_rate = (v - v.abs() * z / r) / bent;
    action.hidden_rate[0] = z_rate;
    action.force -= (z + (fade * z_rate).scale(time)).scale(force_c);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn at_constant_rate_the_friction_is_the_stribeck_curve() {
        let p = [0.5, 1.4, 0.02, 0.01, 0.01];
        for rate in [-0.3, -0.02, -0.004, 0.001, 0.015, 0.03, 1.0] {
            let stribeck = 1.0 + 0.4 * libm::exp(-rate * rate / 4e-4);
            let hidden = [libm::copysign(stribeck, rate), 0.0, 0.0, 0.0];
            let action = Trial { rate, hidden, ..Trial::default() }.act(&EFFECT, &p);
            assert!(action.hidden_rate[0].abs() < 1e-13); // rounding of v / d
            assert!((action.force + 0.5 * libm::copysign(stribeck, rate)).abs() < 1e-15, "{rate}");
        }
    }

    #[test]
    fn before_sliding_the_friction_is_a_spring() {
        let hidden = [0.01, 0.0, 0.0, 0.0];
        let action = Trial { rate: 1e-9, hidden, ..Trial::default() }.act(&EFFECT, &[0.5, 1.4, 0.02, 0.002, 0.0]);
        assert!((action.hidden_rate[0] - 1e-9 / 0.002).abs() < 1e-2 * 1e-9 / 0.002); // z / r = 1 % of the way to sliding
        assert_eq!(action.force, -0.005);
    }

    #[test]
    fn over_a_cycle_the_friction_only_takes() {
        for amplitude in [0.001, 0.01, 0.1, 1.0] {
            for bristle_damping in [0.0, 1.0] {
                let work = work_of_a_cycle(&EFFECT, &[0.5, 1.4, 0.02, 0.01, bristle_damping], amplitude, 1.0);
                assert!(work < 0.0, "{amplitude} {work}");
            }
        }
        let slides = work_of_a_cycle(&EFFECT, &[0.5, 1.0, 0.02, 1e-3, 0.0], 1.0, 1.0);
        assert!((slides + 4.0 * 0.5).abs() < 4.0 * 0.5 * 3e-3); // dry friction less two presliding distances per reversal
    }

    #[test]
    fn at_every_state_what_is_not_stored_is_lost_over_the_whole_range() {
        for ratio in [1.0, 1.3, 3.0] {
            for v_s in [1e-4, 0.02, 1.0] {
                for d in [1e-6, 1e-5, 0.01, 0.5] {
                    for k in 0..400 {
                        let rate = v_s * 4.0 * (f64::from(k % 20) + 0.5) / 20.0;
                        let z = -3.0 + 6.0 * f64::from(k / 20) / 19.0;
                        let state = Trial { rate, hidden: [z, 0.0, 0.0, 0.0], ..Trial::default() };
                        let action = state.act(&EFFECT, &[1.0, ratio, v_s, d, 1.0]);
                        // power into the joint and into the bristles, of the energy d z^2 / 2
                        let kept = action.force * rate + d * z * action.hidden_rate[0];
                        assert!(kept <= 1e-12 * v_s * (1.0 + z * z), "{ratio} {v_s} {d} {rate} {z}: {kept}");
                    }
                }
            }
        }
    }
}
