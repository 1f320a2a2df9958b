//! A spring across a joint: cable bundles, membranes, magnets.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Scan};
use dynamics::real::Real;

/// Stiffness across a joint: `F = −k (q − q0)`.
pub static EFFECT: Effect = Effect {
    kind: "joint_stiffness",
    title: "Stiffness across a joint (cable harness)",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^2", [0.0, 1e7], 0.05, "spring constant k").amplitude(),
        EffectParameter::new("rest", "*", [-3.2, 3.2], 0.0, "coordinate q0 at which it is slack").scanned(Scan::Inside),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Stiffness,
    what: "F = -k (q - q0); a harness across a joint bends like a spring.",
    signature: "Joint torque residual in phase with the joint angle, also when it holds still; a line at a low frequency in free motion.",
    confounders: "The joint's own spring where it has a prior (identical); joint_end_stop and joint_backlash (contact at the ends only), joint_cubic_stiffness; gravity on a bench near hanging.",
    experiment: "Hold at several angles, or sweep |q| well below and above a possible stop.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (k, rest) = (p[0], T::constant(p[1]));
    action.force -= (local.coordinate - rest).scale(k);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_spring_is_straight_about_its_rest_and_conserves_over_a_cycle() {
        let force = |coordinate| Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[3.0, 0.5]);
        assert_eq!(force(0.5), 0.0);
        assert_eq!(force(1.5), -3.0);
        assert_eq!(force(-0.5), 3.0);
        assert!(work_of_a_cycle(&EFFECT, &[3.0, 0.5], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
