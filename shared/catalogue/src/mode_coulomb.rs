//! Dry friction in a structure: hinges, latches.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Coulomb damping of a mode: modal force `−F tanh(η'/v0)`.
pub static EFFECT: Effect = Effect {
    kind: "mode_coulomb",
    title: "Coulomb damping of a mode",
    sites: &[SiteKind::Mode],
    parameters: &[
        EffectParameter::new("force", "sqrt(kg) m/s^2", [0.0, 100.0], 0.01, "modal force F while moving").amplitude(),
        EffectParameter::new(
            "smooth_rate",
            "sqrt(kg) m/s",
            [1e-6, 0.1],
            1e-3,
            "modal rate v0 over which the sign turns",
        )
        .smoothing(),
    ],
    law: Law::Coordinate(both!(law)),
    family: Family::Friction,
    what: "Modal force = -F tanh(h'/v0); friction of hinges and latches.",
    signature: "Decay is linear at small amplitude; damping ratio falls as amplitude grows.",
    confounders: "The nominal damping ratio at one amplitude; mode_quadratic_damping has the opposite trend.",
    experiment: "Free decay over a decade of amplitude.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (force, v_0) = (p[0], p[1]);
    action.force -= local.rate.scale(1.0 / v_0).tanh().scale(force);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, work_of_a_cycle};

    #[test]
    fn friction_takes_four_amplitudes_of_work_a_cycle_and_never_drives() {
        let work = work_of_a_cycle(&EFFECT, &[0.3, 1e-3], 0.5, 2.0);
        assert!((work + 0.6).abs() < 0.6 * 1e-6); // the smoothing lacks (v0 / a ω)² π²/12
        for k in 0..200 {
            let state = Trial::random(k);
            assert!(state.force(&EFFECT, &[2.0, 0.1]) * state.rate <= 0.0);
        }
    }
}
