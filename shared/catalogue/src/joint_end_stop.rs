//! The end of a joint's travel.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Scan};
use dynamics::real::Real;

/// End stops: `F = −k x^1.5 (1 + a x')` at a penetration x, never pulling.
pub static EFFECT: Effect = Effect {
    kind: "joint_end_stop",
    title: "End stops of a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^2.5", [0.0, 1e8], 1e3, "contact coefficient k of |depth|^1.5")
            .amplitude(),
        EffectParameter::new("lower", "*", [-10.0, 10.0], -1.0, "coordinate of the lower stop")
            .scanned(Scan::FromLow(&[0.1, -1.0])),
        EffectParameter::new("upper", "*", [-10.0, 10.0], 1.0, "coordinate of the upper stop")
            .scanned(Scan::FromHigh(&[-0.1])),
        EffectParameter::new("dissipation", "s/*", [0.0, 10.0], 0.2, "coefficient a: restitution about 1 - 2/3 a v"),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Clearance,
    what: "Beyond a stop by x: F = -k x^1.5 (1 + a x'), never pulling; Hunt and Crossley 1975 (Hertzian contact whose loss grows with the \
           speed of impact).",
    signature: "Short torque pulses, high-frequency ringing, only where the joint is near its limits; velocity reversed at contact.",
    confounders: "joint_cubic_stiffness and joint_stiffness where the stop is grazed; joint_backlash.",
    experiment: "Approach each stop slowly, then faster, and sweep clear of both: contact has a threshold in q.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (k, lower, upper, a) = (p[0], p[1], p[2], p[3]);
    let (q, v) = (local.coordinate, local.rate);
    if q.value() > upper {
        action.force -= contact(q - T::constant(upper), v, k, a);
    }
    if q.value() < lower {
        action.force += contact(T::constant(lower) - q, -v, k, a);
    }
}

/// Force of a contact of some depth.
fn contact<T: Real>(depth: T, depth_rate: T, k: f64, a: f64) -> T {
    let loss = (depth_rate.scale(a) + T::one()).max(T::zero());
    (depth * depth.sqrt() * loss).scale(k)
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    const P: [f64; 4] = [1000.0, -0.5, 0.7, 0.2];

    #[test]
    fn between_the_stops_the_joint_is_free_and_beyond_them_pushed_back() {
        let force = |coordinate, rate| Trial { coordinate, rate, ..Trial::default() }.force(&EFFECT, &P);
        assert_eq!(force(0.7, 5.0), 0.0);
        assert_eq!(force(-0.5, -5.0), 0.0);
        assert!((force(0.74, 0.0) + 8.0).abs() < 1e-12); // 1000 · 0.04^1.5, rounding of 0.74 - 0.7
        assert!((force(-0.54, 0.0) - 8.0).abs() < 1e-12);
        assert_eq!(force(0.8, -20.0), 0.0); // leaves faster than the material follows: it never pulls
    }

    #[test]
    fn impact_loses_energy_by_its_dissipation_alone() {
        let elastic = work_of_a_cycle(&EFFECT, &[1000.0, -0.5, 0.7, 0.0], 0.9, 1.0);
        let lossy = work_of_a_cycle(&EFFECT, &P, 0.9, 1.0);
        assert!(elastic.abs() < 1e-6); // midpoint rule over depth^1.5
        assert!(lossy < -1.0);
    }
}
