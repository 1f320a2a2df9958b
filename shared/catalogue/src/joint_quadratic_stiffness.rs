//! A spring that is stiffer one way than the other.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Scan};
use dynamics::real::Real;

/// Quadratic stiffness: `F = −k2 (q − q0)²`.
pub static EFFECT: Effect = Effect {
    kind: "joint_quadratic_stiffness",
    title: "Quadratic stiffness across a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^3", [-1e9, 1e9], 0.05, "coefficient k2").amplitude(),
        EffectParameter::new("rest", "*", [-3.2, 3.2], 0.0, "coordinate q0 about which it is even")
            .scanned(Scan::Inside),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Stiffness,
    what: "F = -k2 (q - q0)^2; pre-load, a bent beam, a spring used off its middle (Nayfeh and Mook 1979).",
    signature: "Even harmonics and a shift of the mean with amplitude; force over angle is a parabola.",
    confounders: "joint_torque_bias (its mean), joint_cubic_stiffness with a shifted rest.",
    experiment: "Sinusoidal motion of two amplitudes: the second harmonic grows with the square.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let stretch = local.coordinate - T::constant(p[1]);
    action.force -= (stretch * stretch).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_force_is_an_even_parabola_about_its_rest_and_conserves_over_a_cycle() {
        let force = |coordinate| Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[3.0, 0.5]);
        assert_eq!(force(0.5), 0.0);
        assert_eq!(force(2.5), -12.0);
        assert_eq!(force(2.5), force(-1.5));
        assert!(work_of_a_cycle(&EFFECT, &[3.0, 0.5], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
