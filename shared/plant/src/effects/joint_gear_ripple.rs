//! Torque that repeats with the joint's angle.

use super::applies::anywhere;
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "joint_gear_ripple",
    title: "Gear ripple, cogging, eccentricity",
    sites: &[SiteKind::Joint],
    applies: anywhere,
    parameters: &[
        EffectParameter::new("force", "J/*", [-100.0, 100.0], 0.02, "amplitude A"),
        EffectParameter::new("order", "rad/*", [0.5, 1000.0], 12.0, "periods per turn, or radians per metre"),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "phase at zero angle"),
    ],
    hidden_states: 0,
    law: Law::Coordinate(both!(law)),
    what: "F = A sin(N q + phase) = a sin Nq + b cos Nq; teeth, cogging magnets, wave generator of a harmonic drive (order 2 of the motor), \
           eccentricity (order 1).",
    signature: "A line in the spectrum over *position*; in time its frequency N q' / 2 pi moves with speed.",
    confounders: "mode_left_out or slosh_second_mode where the joint has one speed; encoder_ripple (no torque, only reading).",
    experiment: "Two constant speeds: a structural line stays, this one moves with the speed.",
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (amplitude, order, phase) = (p[0], p[1], p[2]);
    action.force += (local.coordinate.scale(order) + T::constant(phase)).sin().scale(amplitude);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::{Trial, work_of_a_cycle};
    use core::f64::consts::TAU;

    #[test]
    fn over_one_turn_the_ripple_is_one_line_at_its_order_with_its_phase() {
        let (n, order, phase) = (256, 7.0, 0.4);
        for line in 0..20 {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for k in 0..n {
                let coordinate = TAU * f64::from(k) / f64::from(n);
                let force = Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[0.3, order, phase]);
                let (s, c) = libm::sincos(f64::from(line) * coordinate);
                sine += 2.0 * force * s / f64::from(n);
                cosine += 2.0 * force * c / f64::from(n);
            }
            let here = f64::from(line) == order;
            let expected = if here { [0.3 * libm::cos(phase), 0.3 * libm::sin(phase)] } else { [0.0, 0.0] };
            assert!((sine - expected[0]).abs() < 1e-13, "{line}"); // rounding of 256 terms
            assert!((cosine - expected[1]).abs() < 1e-13, "{line}");
        }
    }

    #[test]
    fn the_ripple_conserves_over_a_cycle() {
        assert!(work_of_a_cycle(&EFFECT, &[0.3, 12.0, 0.4], 0.7, 2.0).abs() < 1e-12); // rounding of 20 000 terms
    }
}
