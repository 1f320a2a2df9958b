//! Slosh damping that grows with amplitude: baffles.

use super::geometry::{constant, dot, norm};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic damping of a slosh mode: `F = −c |s'| s'`, s along all slosh axes.
pub static EFFECT: Effect = Effect {
    kind: "slosh_quadratic_damping",
    title: "Quadratic damping of a slosh mode (baffles)",
    sites: &[SiteKind::Tank],
    parameters: &[EffectParameter::new("damping", "J s^2/*^3", [0.0, 1e6], 10.0, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "F = -c |s'| s', s' the rate along all slosh axes; drag of a ring baffle (Miles 1958).",
    signature: "Slosh decays fast while large, slowly once small: damping ratio in proportion to amplitude.",
    confounders: "The nominal slosh damper at one amplitude (absorbs 80 to 95 percent); slosh_cubic; slosh_contact_line at small amplitude.",
    experiment: "Amplitude ladder, or one long free decay over a decade of amplitude.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let rate = local.displacement_rate;
    action.force -= (norm(rate) * dot(constant(local.surroundings.site_axis), rate)).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::damps_with_the_square_of_the_rate;

    #[test]
    fn damping_takes_eight_thirds_c_omega_squared_a_cubed_of_work_a_cycle_and_never_drives() {
        damps_with_the_square_of_the_rate(&EFFECT);
    }
}
