//! Torque that repeats with the joint's angle.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Gear ripple, cogging, eccentricity: `F = a sin N q + b cos N q`.
pub static EFFECT: Effect = Effect {
    kind: "joint_gear_ripple",
    title: "Gear ripple, cogging, eccentricity",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("sine", "J/*", [-1e5, 1e5], 0.02, "coefficient a of sin N q").amplitude(),
        EffectParameter::new("cosine", "J/*", [-1e5, 1e5], 0.0, "coefficient b of cos N q").amplitude(),
        EffectParameter::new("order", "rad/*", [0.5, 1000.0], 12.0, "periods per turn, or radians per metre").order(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Ripple,
    what: "F = a sin N q + b cos N q; teeth, cogging magnets, wave generator of a harmonic drive (order 2 of the motor), \
           eccentricity (order 1).",
    signature: "A line in the spectrum over *position*; in time its frequency N q' / 2 pi moves with speed.",
    confounders: "mode_left_out or slosh_second_mode where the joint has one speed; encoder_ripple (no torque, only reading).",
    experiment: "Two constant speeds: a structural line stays, this one moves with the speed.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (sin, cos) = local.coordinate.scale(p[2]).sin_cos();
    action.force += sin.scale(p[0]) + cos.scale(p[1]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};
    use core::f64::consts::TAU;

    #[test]
    fn over_one_turn_the_ripple_is_one_line_at_its_order() {
        let (n, order, a, b) = (256, 7.0, 0.27, 0.12);
        for line in 0..20 {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for k in 0..n {
                let coordinate = TAU * f64::from(k) / f64::from(n);
                let force = Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[a, b, order]);
                let (s, c) = libm::sincos(f64::from(line) * coordinate);
                sine += 2.0 * force * s / f64::from(n);
                cosine += 2.0 * force * c / f64::from(n);
            }
            let here = f64::from(line) == order;
            let expected = if here { [a, b] } else { [0.0, 0.0] };
            assert!((sine - expected[0]).abs() < 1e-13, "{line}"); // rounding of 256 terms
            assert!((cosine - expected[1]).abs() < 1e-13, "{line}");
        }
    }

    #[test]
    fn the_ripple_conserves_over_a_cycle() {
        assert!(work_of_a_cycle(&EFFECT, &[0.3, 0.1, 12.0], 0.7, 2.0).abs() < 1e-12); // rounding of 20 000 terms
    }
}
