//! A torque against spin, with its square.

use super::geometry::{norm, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic damping of spin: `T = −c |ω| ω`, body axes.
pub static EFFECT: Effect = Effect {
    kind: "aerodynamic_spin_damping",
    title: "Quadratic damping of spin (air)",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new("coefficient", "N m s^2/rad^2", [0.0, 100.0], 1e-3, "coefficient c").amplitude()],
    law: Law::Body(both!(law)),
    family: Family::Aerodynamics,
    what: "T = -c |w| w; air drag of panels on a turning body.",
    signature: "Spin decays as one over time, not exponentially.",
    confounders: "spin_damping at one rate, joint_quadratic_damping where the body only turns about its joint.",
    experiment: "Spin down from two rates; vacuum.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let omega = local.body.omega_rad_s;
    let size = norm(omega).scale(-p[0]);
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], omega.map(|w| w * size));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_opposes_the_spin_with_its_square() {
        let mut state = Trial::default();
        state.body.omega_rad_s = [3.0, 0.0, -4.0];
        assert_eq!(state.wrench(&EFFECT, &[0.5]), [-7.5, 0.0, 10.0, 0.0, 0.0, 0.0]);
        assert!((0..100).all(|k| Trial::random(k).body_power(&EFFECT, &[0.5]) <= 0.0));
    }
}
