//! A slosh spring that hardens or softens with amplitude.

use super::geometry::{constant, dot};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Cubic stiffness of a slosh mode: `F = −k3 |s|² s`, s along all slosh axes.
pub static EFFECT: Effect = Effect {
    kind: "slosh_cubic",
    title: "Cubic stiffness of a slosh mode",
    sites: &[SiteKind::Tank],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^4", [-1e7, 1e7], 100.0, "coefficient k3; negative softens").amplitude()
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Slosh,
    what: "F = -k3 |s|^2 s, s the displacement along all slosh axes; finite-amplitude waves soften or harden with fill (Abramson 1966, SP-106; Faltinsen and \
           Timokha 2009).",
    signature: "Slosh frequency moves with the square of its amplitude.",
    confounders: "slosh_quadratic_damping, slosh_pendulum; the nominal slosh frequency absorbs 80 to 95 percent at one amplitude.",
    experiment: "Amplitude ladder of the same excitation, then free decay.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let s = local.displacement;
    action.force -= (dot(s, s) * dot(constant(local.surroundings.site_axis), s)).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_force_is_an_odd_cubic_and_conserves_over_a_cycle() {
        let force = |coordinate| Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[3.0]);
        assert_eq!(force(2.0), -24.0);
        assert_eq!(force(-2.0), 24.0);
        assert!(work_of_a_cycle(&EFFECT, &[3.0], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
