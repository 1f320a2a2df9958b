//! A mode that hardens or softens.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Cubic stiffness of a mode: modal force `−k3 η³`.
pub static EFFECT: Effect = Effect {
    kind: "mode_duffing",
    title: "Cubic stiffness of a mode",
    sites: &[SiteKind::Mode],
    parameters: &[EffectParameter::new(
        "stiffness",
        "1/(kg m^2 s^2)",
        [-1e6, 1e6],
        10.0,
        "coefficient k3; positive hardens",
    )
    .amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Stiffness,
    what: "Modal force = -k3 h^3; Duffing 1918: large deflection, hinges, cables.",
    signature: "Modal frequency moves with the square of amplitude; resonance leans over; third harmonic.",
    confounders: "mode_left_out close by; mode_coulomb (softens with amplitude as well).",
    experiment: "Amplitude ladder at resonance, or a long free decay: frequency against amplitude.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let eta = local.coordinate;
    action.force -= (eta * eta * eta).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn the_force_is_an_odd_cubic_and_conserves_over_a_cycle() {
        let force = |coordinate| Trial { coordinate, ..Trial::default() }.force(&EFFECT, &[3.0]);
        assert_eq!([force(2.0), force(-2.0)], [-24.0, 24.0]);
        assert!(work_of_a_cycle(&EFFECT, &[3.0], 0.7, 2.0).abs() < 1e-13); // rounding of 20 000 terms
    }
}
