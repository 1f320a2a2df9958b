//! Looseness: a spring with a dead band about a fixed centre.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Scan};
use dynamics::real::Real;

/// Spring with a dead band about a fixed centre: `F = −k (x − b sgn x) − c q'` where `|x| > b`.
pub static EFFECT: Effect = Effect {
    kind: "joint_looseness",
    title: "Looseness of a joint about a fixed centre",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^2", [0.0, 1e8], 10.0, "spring constant k outside the gap").amplitude(),
        EffectParameter::new("half_gap", "*", [0.0, 1.0], 0.01, "half b of the play")
            .width(Scan::OfRange(&[0.03, 0.15])),
        EffectParameter::new("centre", "*", [-3.2, 3.2], 0.0, "coordinate q0 in the middle of the play")
            .scanned(Scan::Inside),
        EffectParameter::new("contact_time", "s", [0.0, 1.0], 0.0, "damper c = k T while in contact"),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Clearance,
    limits: &[Limit { kind: "joint_stiffness", at: &[("half_gap", 0.0), ("contact_time", 0.0)] }],
    what: "With x = q - q0: F = 0 while |x| <= b, else -k (x - b sgn x) - c q', held so that contact only pushes; c = k T; a loose grapple, a \
           pin in its hole. Play between motor and link: joint_backlash.",
    signature: "Bursts at high frequency that cluster at reversals; free motion in the gap, a line that rises with amplitude.",
    confounders: "joint_backlash; joint_stiffness and joint_cubic_stiffness (cosine 0.96 to 0.99 on small motion); sensor_quantisation.",
    experiment: "Bias the joint to one side with a constant torque: play disappears, a spring stays.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (k, half_gap, centre, c) = (p[0], p[1], p[2], p[0] * p[3]);
    let x = local.coordinate - T::constant(centre);
    let depth = x.abs() - T::constant(half_gap);
    if depth.value() <= 0.0 || k == 0.0 {
        return;
    }
    let outward = if x.value() < 0.0 { -local.rate } else { local.rate };
    let push = (depth.scale(k) + outward.scale(c)).max(T::zero());
    action.force -= if x.value() < 0.0 { -push } else { push };
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn nothing_acts_in_the_gap_and_a_spring_beyond_it() {
        let force =
            |coordinate| Trial { coordinate, rate: 0.3, ..Trial::default() }.force(&EFFECT, &[100.0, 0.1, 0.5, 0.0]);
        for inside in [0.41, 0.5, 0.59] {
            assert_eq!(force(inside), 0.0);
        }
        assert!((force(0.8) + 100.0 * 0.2).abs() < 1e-12); // rounding
        assert!((force(0.2) - 100.0 * 0.2).abs() < 1e-12);
    }

    #[test]
    fn contact_pushes_only_and_takes_energy_only_through_its_damper() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[10.0, 0.1, 0.0, 5.0]) * state.coordinate <= 0.0);
        }
        assert!(work_of_a_cycle(&EFFECT, &[100.0, 0.1, 0.0, 0.0], 0.3, 2.0).abs() < 1e-8); // midpoint rule over a kink
        assert!(work_of_a_cycle(&EFFECT, &[100.0, 0.1, 0.0, 0.01], 0.3, 2.0) < -0.1);
    }
}
