//! Thrust that falls as the tank empties.

use super::applies::thruster;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::fired;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Blow-down of a thruster: `u_acting = u e^(−a J)`, `J' = |u_acting|`.
pub static EFFECT: Effect = Effect {
    kind: "thruster_blow_down",
    title: "Blow-down of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[EffectParameter::new(
        "decay",
        "1/(N s)",
        [0.0, 0.1],
        1e-4,
        "relative loss a of thrust per impulse delivered",
    )
    .amplitude()
    .multimodal()],
    hidden_states: 1,
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "u_acting = u e^(-a J), J' = |u_acting|, noise apart: hence e^(-a J) = 1 / (1 + a integral |u|); tank pressure falls with what left it.",
    signature: "Gain of this thruster falls with its own integrated firing, not with time.",
    confounders: "motor_constant_error over a short record; mass_depletion, which acts the other way.",
    experiment: "A long burn, then the same manoeuvre as before it.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let pressure = (-local.hidden[0].scale(p[0])).exp();
    let surroundings = local.surroundings;
    action.hidden_rate[0] = fired(action.value, surroundings.one_sided, surroundings.quiet) * pressure;
    action.value *= pressure;
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn a_steady_burn_decays_as_one_over_one_plus_the_commanded_impulse() {
        let (a, command, dt, steps) = (0.01, 5.0, 1e-3, 40_000);
        let mut hidden = [0.0; 4];
        for _ in 0..steps {
            let half = Trial { command, hidden, ..Trial::default() }.act(&EFFECT, &[a]).hidden_rate[0];
            let middle = [hidden[0] + 0.5 * dt * half, 0.0, 0.0, 0.0];
            hidden[0] += dt * Trial { command, hidden: middle, ..Trial::default() }.act(&EFFECT, &[a]).hidden_rate[0];
        }
        let thrust = Trial { command, hidden, ..Trial::default() }.value(&EFFECT, &[a]);
        assert!((thrust - command / (1.0 + a * command * 40.0)).abs() < 1e-9); // midpoint rule: (a u dt)² = 2.5e-9 per time constant
    }
}
