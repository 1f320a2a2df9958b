//! Pulses too short to be fired.

use super::applies::thruster;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};
use dynamics::lags::FilterKind;

/// Minimum impulse bit of a thruster: a command with `|u| P < I` over a control period P is not
/// fired.
pub static EFFECT: Effect = Effect {
    kind: "thruster_minimum_impulse_bit",
    title: "Minimum impulse bit of a thruster",
    sites: &[SiteKind::Actuator],
    applies: thruster,
    parameters: &[
        EffectParameter::new("impulse", "N s", [0.0, 10.0], 0.02, "smallest impulse I of one pulse").amplitude()
    ],
    law: Law::ActuatorFilter(filter),
    family: Family::Actuation,
    what: "A command u held over one control period P is one pulse of the impulse u P; |u| P < I is not fired. Wertz 1978. It acts on the \
           command, before delays and lags; the mean over the period acts, not the pulse.",
    signature: "No response to small commands, all of large ones (a dead zone falls short of those as well); limit cycle in fine pointing.",
    confounders: "actuator_dead_zone, joint_coulomb of a bench; thruster_rise_tail_off on short pulses.",
    experiment: "Pulse-width ladder from below the shortest pulse.",
    ..Effect::PLAIN
};

/// The control period is filled in where the plant is known.
fn filter(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::MinimumImpulse { impulse_n_s: p[0], interval_s: 1.0 } }
}

#[cfg(test)]
mod tests {
    use crate::trial::plant;
    use dynamics::description::{Quantity, Signal, SignalKind};
    use simulation::Simulator;

    #[test]
    fn a_command_is_fired_by_its_impulse_over_the_control_period_before_the_valve_lags() {
        let mut plant = plant();
        plant.simulation.period_s = 0.1;
        let kind = SignalKind::Staircase { step: Quantity::known(0.3), every_s: Quantity::known(0.1) };
        plant.actuators[0].command = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
        let thruster = "actuator:main".parse().unwrap();
        // 0.3, 0.6, 0.9 N for 0.1 s: the first two are below 0.07 N s
        plant.add_effect("thruster_minimum_impulse_bit", &thruster, &[("impulse", 0.07)]).unwrap();
        let acting = |plant: &dynamics::description::Plant| -> Vec<f64> {
            let mut simulator = Simulator::new(plant, 1, "test").unwrap();
            (0..4).map(|_| simulator.step().inputs[0]).collect()
        };
        let fired = acting(&plant);
        assert_eq!(fired[..2], [0.0, 0.0]);
        assert!((fired[2] - 0.9).abs() < 1e-12 && (fired[3] - 1.2).abs() < 1e-12); // rounding
        // behind the gate a lag brings the pulse late; before it, 0.9 N (1 - e^-1) would not have
        // been fired in the third period
        plant.add_effect("actuator_lag", &thruster, &[("time_constant", 0.1)]).unwrap();
        let lagged = acting(&plant);
        assert_eq!(lagged[..2], [0.0, 0.0]);
        assert!(lagged[2] > 0.0 && lagged[2] < 0.63 * 0.9);
    }
}
