//! Damping with the cube of the rate.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Cubic damping: `F = −c q'³`.
pub static EFFECT: Effect = Effect {
    kind: "joint_cubic_damping",
    title: "Cubic damping in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[EffectParameter::new("damping", "J s^3/*^4", [0.0, 1e6], 0.05, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "F = -c q'^3; the next odd term of any smooth damper (Nayfeh and Mook 1979).",
    signature: "Equivalent damping 3 c (a w)^2 / 4 grows with the square of the amplitude; third harmonic in phase with the rate.",
    confounders: "joint_viscous at one amplitude; joint_quadratic_damping over less than a decade of amplitude.",
    experiment: "Amplitude ladder over a decade: exponent two in equivalent damping against one for quadratic.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force -= (local.rate * local.rate * local.rate).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn damping_takes_three_quarters_pi_c_omega_cubed_a_to_the_fourth_of_work_a_cycle() {
        let (c, a, omega) = (0.7f64, 0.3f64, 2.0f64);
        let work = work_of_a_cycle(&EFFECT, &[c], a, omega);
        let expected = -0.75 * core::f64::consts::PI * c * omega.powi(3) * a.powi(4);
        assert!((work - expected).abs() < 1e-11 * expected.abs()); // the midpoint rule is exact on a full period; rounding of 20 000 terms
    }

    #[test]
    fn damping_never_drives() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0]) * state.rate <= 0.0);
        }
    }
}
