//! A spring that hardens or softens.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local, Scan};
use dynamics::real::Real;

/// Cubic stiffness: `F = −k3 (q − q0)³`.
pub static EFFECT: Effect = Effect {
    kind: "joint_cubic_stiffness",
    title: "Cubic stiffness across a joint",
    sites: &[SiteKind::Joint],
    parameters: &[
        EffectParameter::new("stiffness", "J/*^4", [-1e12, 1e12], 0.05, "coefficient k3; positive hardens").amplitude(),
        EffectParameter::new("rest", "*", [-3.2, 3.2], 0.0, "coordinate q0 about which it is odd")
            .scanned(Scan::Inside),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Stiffness,
    what: "F = -k3 (q - q0)^3; Duffing 1918. The range reaches to a rail of 1e6 N/m that doubles its stiffness within a millimetre.",
    signature: "Third harmonic in phase with the angle; natural frequency moves with amplitude, resonance leans over.",
    confounders: "joint_stiffness at one amplitude; joint_end_stop and joint_backlash, nearly the same until the stop is swept on both sides.",
    experiment: "Amplitude ladder: the frequency shift grows with the square of the amplitude and has no threshold.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let stretch = local.coordinate - T::constant(p[1]);
    action.force -= (stretch * stretch * stretch).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_force_is_an_odd_cubic_about_its_rest_and_conserves_over_a_cycle() {
        let force = |coordinate| Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[3.0, 0.5]);
        assert_eq!(force(2.5), -24.0);
        assert_eq!(force(2.5), -force(-1.5));
        assert!(work_of_a_cycle(&EFFECT, &[3.0, 0.5], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
