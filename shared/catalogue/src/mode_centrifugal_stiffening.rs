//! A mode whose frequency depends on the body's spin.

use super::geometry::dot;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Centrifugal stiffening of a mode: modal force `−b |ω|² η`, ω the body's rate.
pub static EFFECT: Effect = Effect {
    kind: "mode_centrifugal_stiffening",
    title: "Centrifugal stiffening of a mode",
    sites: &[SiteKind::Mode],
    parameters: &[EffectParameter::new("coefficient", "1", [-3.0, 10.0], 1.0, "share b; negative softens").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Stiffness,
    what: "Modal force = -b |w|^2 h, w the body's rate: w_mode^2 grows by b |w|^2 (Southwell 1921; Kane, Ryan and Banerjee 1987).",
    signature: "Modal frequency rises with spin rate, not with amplitude.",
    confounders: "mode_duffing where spin and amplitude grow together; the nominal frequency at one spin rate.",
    experiment: "The same excitation at two spin rates.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let omega = local.body.omega_rad_s;
    action.force -= (dot(omega, omega) * local.coordinate).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_spring_is_the_coefficient_times_the_square_of_the_spin() {
        let mut state = Trial { coordinate: 0.5, ..Trial::default() };
        state.body.omega_rad_s = [0.0, 0.0, 3.0];
        assert_eq!(state.force(&EFFECT, &[2.0]), -9.0);
        state.body.omega_rad_s = [0.0, 0.0, -3.0];
        assert_eq!(state.force(&EFFECT, &[2.0]), -9.0);
    }
}
