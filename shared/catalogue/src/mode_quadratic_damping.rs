//! Modal damping that grows with amplitude: air.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic damping of a mode: modal force `−c |η'| η'`.
pub static EFFECT: Effect = Effect {
    kind: "mode_quadratic_damping",
    title: "Quadratic damping of a mode (air)",
    sites: &[SiteKind::Mode],
    parameters: &[EffectParameter::new("damping", "1/(sqrt(kg) m)", [0.0, 1e3], 0.1, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "Modal force = -c |h'| h'; air drag of a panel in a ground test.",
    signature: "Damping ratio grows in proportion to amplitude.",
    confounders: "The nominal damping ratio at one amplitude; mode_coulomb has the opposite trend.",
    experiment: "Free decay over a decade of amplitude; vacuum.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force -= (local.rate.abs() * local.rate).scale(p[0]);
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
