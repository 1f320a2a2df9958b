//! Damping with the square of the rate: windage, orifices.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic damping: `F = −c |q'| q'`.
pub static EFFECT: Effect = Effect {
    kind: "joint_quadratic_damping",
    title: "Quadratic damping in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[EffectParameter::new("damping", "J s^2/*^3", [0.0, 1e6], 0.05, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "F = -c |q'| q'; turbulent drag of what the joint carries, flow through an orifice (Rayleigh 1877).",
    signature: "Damping in proportion to amplitude: fast free decay at first, hardly any at the end; odd harmonics.",
    confounders: "joint_viscous at one amplitude; joint_cubic_damping; drag of the outboard body, which is the same where that body only \
                  turns about this joint.",
    experiment: "Amplitude ladder or a long free decay from a large amplitude: equivalent damping 8 c a w / 3 pi grows linearly.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force -= (local.rate.abs() * local.rate).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn damping_takes_eight_thirds_c_omega_squared_a_cubed_of_work_a_cycle() {
        let (c, a, omega) = (0.7, 0.3, 2.0);
        let work = work_of_a_cycle(&EFFECT, &[c], a, omega);
        let expected = -8.0 / 3.0 * c * omega * omega * a * a * a;
        assert!((work - expected).abs() < 1e-8 * expected.abs()); // midpoint rule, 20 000 points, |cos|³ has a jump in its 3rd derivative
    }

    #[test]
    fn damping_never_drives_and_is_odd() {
        for k in 0..500 {
            let state = Trial::random(k);
            let force = state.force(&EFFECT, &[2.0]);
            assert!(force * state.rate <= 0.0);
            assert_eq!(Trial { rate: -state.rate, ..state }.force(&EFFECT, &[2.0]), -force);
        }
    }
}
