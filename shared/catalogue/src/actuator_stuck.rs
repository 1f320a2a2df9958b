//! An actuator that no longer follows its command.

use super::applies::effort;
use dynamics::description::SiteKind;
use dynamics::effect::{Effect, EffectParameter, Family, Law};
use dynamics::lags::FilterKind;

/// Actuator that holds its last value: `u_acting = u + share (u(t0) − u)` from `t0` on.
pub static EFFECT: Effect = Effect {
    kind: "actuator_stuck",
    title: "Actuator that holds its last value",
    sites: &[SiteKind::Actuator],
    applies: effort,
    parameters: &[
        EffectParameter::new("share", "1", [0.0, 1.0], 1.0, "share of the command that sticks; 1: all of it")
            .amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 1.0, "time t0 from which it sticks").onset(),
    ],
    law: Law::ActuatorFilter(filter),
    family: Family::Actuation,
    what: "u_acting = u + share (u(t0) - u) from t0 on, before delays and lags; a valve that stays open or shut, a driver that no longer \
           takes commands. A share below one: one of several units in parallel.",
    signature: "From one instant on this actuator's command has no effect, and a constant push stays.",
    confounders: "motor_constant_error with actuator_bias after t0 (the same, were it not for its beginning); thruster_leak; \
                  actuator_saturation while the command stays high.",
    experiment: "Command this actuator alone, both ways, late in the record.",
    ..Effect::PLAIN
};

fn filter(p: &[f64]) -> FilterKind {
    if p[0] == 0.0 { FilterKind::None } else { FilterKind::Stuck { share: p[0], begin_s: p[1] } }
}

#[cfg(test)]
mod tests {
    use crate::trial::plant;
    use dynamics::description::{Quantity, Signal, SignalKind};
    use simulation::Simulator;

    #[test]
    fn from_its_time_on_the_push_stays_what_it_was() {
        let mut plant = plant();
        let kind = SignalKind::Sine {
            amplitude: Quantity::known(4.0),
            frequency_hz: Quantity::known(0.5),
            phase_rad: Quantity::known(0.0),
        };
        plant.actuators[2].command = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
        let acting = |plant: &dynamics::description::Plant| -> Vec<[f64; 2]> {
            let mut simulator = Simulator::new(plant, 1, "test").unwrap();
            (0..100)
                .map(|_| {
                    let row = simulator.step();
                    [row.commands[2], row.inputs[2]]
                })
                .collect()
        };
        let free = acting(&plant);
        plant.add_effect("actuator_stuck", &"actuator:drive".parse().unwrap(), &[("begin", 0.5)]).unwrap();
        let stuck = acting(&plant);
        let last = free[49][1];
        for (k, (free, stuck)) in free.iter().zip(&stuck).enumerate() {
            assert_eq!(free[0], stuck[0]); // the record shows the command
            assert_eq!(stuck[1], if k < 50 { free[1] } else { last }, "{k}");
        }
        assert!(last > 3.9);
    }
}
