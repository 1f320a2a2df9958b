//! Friction in proportion to the rate.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Viscous friction: `F = −c q'`.
pub static EFFECT: Effect = Effect {
    kind: "joint_viscous",
    title: "Viscous friction in a joint",
    sites: &[SiteKind::Joint],
    parameters: &[EffectParameter::new("damping", "J s/*^2", [0.0, 1e6], 0.05, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "F = -c q'; lubricant shear, back-emf of a shorted motor, eddy currents.",
    signature: "Joint torque residual in phase with the joint rate, 90 degrees from the angle, growing with frequency; free motion decays \
                exponentially.",
    confounders: "The joint's own viscous friction where it has a prior (identical); joint_coulomb (one speed level), joint_quadratic_damping, joint_cubic_damping (one amplitude); the controller's own \
                  rate gain where the torque is not recorded.",
    experiment: "Amplitude ladder at one frequency: the equivalent damping stays the same at every step.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force -= local.rate.scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn damping_takes_pi_c_omega_a_squared_of_work_a_cycle() {
        let (c, a, omega) = (0.7, 0.3, 2.0);
        let work = work_of_a_cycle(&EFFECT, &[c], a, omega);
        assert!((work + core::f64::consts::PI * c * omega * a * a).abs() < 1e-12); // the midpoint rule is exact on a full period
        assert_eq!(Trial { rate: 2.0, ..Trial::default() }.force(&EFFECT, &[3.0]), -6.0);
    }

    #[test]
    fn damping_never_drives() {
        for k in 0..500 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0]) * state.rate <= 0.0);
        }
    }
}
