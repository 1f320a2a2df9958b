//! A torque against spin, in proportion to it.

use super::geometry::push;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Linear damping of spin: `T = −c ω`, body axes.
pub static EFFECT: Effect = Effect {
    kind: "spin_damping",
    title: "Linear damping of spin (eddy currents, film)",
    sites: &[SiteKind::Body],
    parameters: &[EffectParameter::new("coefficient", "N m s/rad", [0.0, 100.0], 1e-3, "coefficient c").amplitude()],
    law: Law::Body(both!(law)),
    family: Family::Aerodynamics,
    what: "T = -c w; eddy currents in the Earth's field (Smith 1962), an air bearing's film.",
    signature: "Spin decays exponentially.",
    confounders: "aerodynamic_spin_damping at one rate, joint_viscous where the body only turns about its joint, wheel_viscous.",
    experiment: "Spin down from two rates.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let torque = local.body.omega_rad_s.map(|w| w.scale(-p[0]));
    push(&mut action.wrench, [0.0; 3], [T::zero(); 3], torque);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_torque_opposes_the_spin_in_proportion() {
        let mut state = Trial::default();
        state.body.omega_rad_s = [1.0, 0.0, -2.0];
        assert_eq!(state.wrench(&EFFECT, &[0.5]), [-0.5, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((0..100).all(|k| Trial::random(k).body_power(&EFFECT, &[0.5]) <= 0.0));
    }
}
