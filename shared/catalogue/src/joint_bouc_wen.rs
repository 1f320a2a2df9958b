//! Smooth hysteresis: dampers, cable bundles, bolted joints.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Prior, Scan, Spread};
use dynamics::real::Real;

/// Bouc–Wen hysteresis: `F = −F z`, `z' = (q' − b |q'| |z|^(n−1) z − (1−b) q' |z|^n) / d`.
pub static EFFECT: Effect = Effect {
    kind: "joint_bouc_wen",
    title: "Bouc-Wen hysteresis in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("force", "J/*", [0.0, 1e5], 0.05, "force F at which the hysteresis saturates").amplitude(),
        EffectParameter::new("yield", "*", [1e-4, 1.0], 0.02, "displacement d over which it does")
            .width(Scan::OfRangeFollowed(&[0.02, 0.15])),
        EffectParameter::new("exponent", "1", [1.0, 5.0], 1.5, "sharpness n of the knee")
            .with_prior(Prior::FreeIfPreferred(Spread::Relative(0.5))),
        EffectParameter::new("share", "1", [0.5, 1.0], 0.5, "share b of unloading curvature; 0.5: straight unloading")
            .with_prior(Prior::FreeIfPreferred(Spread::Absolute(0.2))),
    ],
    hidden_states: 1,
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    limits: &[Limit { kind: "joint_coulomb", at: &[("yield", 1e-4)] }],
    what: "F = -F z, z' = (q' - b |q'| |z|^(n-1) z - (1-b) q' |z|^n) / d; Bouc 1967, Wen 1976, normalised to |z| <= 1 (Ikhouane and \
           Rodellar 2007); 0.5 <= b keeps it passive. d is at least n |q'| h, the way of one step of integration h \
           times the sharpness.",
    signature: "Loops in force over displacement that neither amplitude nor rate closes; stiffness falls and damping rises, then falls, \
                with amplitude; nothing depends on speed.",
    confounders: "joint_coulomb (its limit for small d), joint_lugre, joint_cubic_stiffness (softening) at one amplitude.",
    experiment: "One shape at several speeds and several sizes: the loop keeps its shape with speed, changes it with size.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, d, n, b) = (p[0], p[1], p[2], p[3]);
    let (v, z) = (local.rate, local.hidden[0]);
    // |z|^(n-1) has no derivative at zero for n < 2; there both terms it enters vanish
    let power = if z.value() == 0.0 { T::zero() } else { z.abs().powf(n - 1.0) };
    let loading = (v.abs() * power * z).scale(b);
    let unloading = (v * power * z.abs()).scale(1.0 - b);
    // near saturation z falls at n |v| / d: no faster than one step of integration can follow
    let yielding = T::constant(d).max(v.abs().scale(n * local.surroundings.step_s));
    action.hidden_rate[0] = (v - loading - unloading) / yielding;
    action.force -= z.scale(force);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn hysteresis_saturates_at_its_force_whatever_exponent_and_share() {
        for (n, b) in [(1.0, 0.5), (1.5, 0.7), (3.0, 1.0)] {
            let (mut z, dx) = (0.0, 1e-4);
            for _ in 0..20_000 {
                let state = Trial { rate: 1.0, hidden: [z, 0.0, 0.0, 0.0], ..Trial::default() };
                z += dx * state.act(&EFFECT, &[2.0, 0.05, n, b]).hidden_rate[0];
            }
            let end = Trial { hidden: [z, 0.0, 0.0, 0.0], ..Trial::default() }.force(&EFFECT, &[2.0, 0.05, n, b]);
            assert!((end + 2.0).abs() < 1e-12, "{n} {b} {end}"); // 40 yield displacements: e^-40 = 4e-18
        }
    }

    #[test]
    fn with_exponent_one_loading_is_an_exponential_approach() {
        let (mut z, dx, d) = (0.0, 1e-6, 0.01);
        for _ in 0..10_000 {
            let state = Trial { rate: 1.0, hidden: [z, 0.0, 0.0, 0.0], ..Trial::default() };
            z += dx * state.act(&EFFECT, &[1.0, d, 1.0, 0.5]).hidden_rate[0];
        }
        assert!((z - (1.0 - libm::exp(-1.0))).abs() < 0.5 * dx / d); // Euler's global error, step over length
    }

    #[test]
    fn half_a_share_unloads_straight_and_rate_does_not_matter() {
        let state = Trial { rate: -0.3, hidden: [0.8, 0.0, 0.0, 0.0], ..Trial::default() };
        assert!((state.act(&EFFECT, &[1.0, 0.1, 2.0, 0.5]).hidden_rate[0] + 3.0).abs() < 1e-15); // rounding
        let slow = work_of_a_cycle(&EFFECT, &[1.0, 0.1, 2.0, 0.6], 0.2, 0.1);
        let fast = work_of_a_cycle(&EFFECT, &[1.0, 0.1, 2.0, 0.6], 0.2, 10.0);
        assert!((slow - fast).abs() < 1e-10 * slow.abs()); // the same path in other units of time: rounding of 60 000 steps
        assert!(slow < 0.0);
    }
}
