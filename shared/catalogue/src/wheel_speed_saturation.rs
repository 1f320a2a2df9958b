//! A wheel that can turn no faster.

use super::applies::wheel;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Speed limit of a wheel: a torque that accelerates the rotor fades to zero at `W_max`.
pub static EFFECT: Effect = Effect {
    kind: "wheel_speed_saturation",
    title: "Speed limit of a wheel",
    sites: &[SiteKind::Actuator],
    applies: wheel,
    parameters: &[
        EffectParameter::new("inverse_limit", "s/rad", [0.0, 1.0], 0.02, "one over the largest speed W_max")
            .amplitude(),
        EffectParameter::new("band", "1", [1e-3, 0.5], 0.02, "share of W_max over which the torque fades before it"),
    ],
    law: Law::Actuator(both!(law)),
    family: Family::Actuation,
    what: "A torque that would make the rotor faster is multiplied by (1 - |W|/W_max) / band where that is below one, and is zero above \
           W_max; a torque that brakes it passes: supply voltage over back-emf. The inverse is the amplitude: zero is no limit.",
    signature: "The wheel stays at one speed and its torque on the body vanishes while the command goes on; the controller winds up.",
    confounders: "actuator_saturation (which limits torque, not speed), motor_constant_error near the limit, actuator_stuck.",
    experiment: "Spin up to the limit, then command the other way: braking is as it was.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (inverse, band) = (p[0], p[1]);
    let left = (T::one() - local.rate.abs().scale(inverse)).scale(1.0 / band);
    // the torque on the body is the reaction of that on the rotor
    let faster = action.value.value() * local.rate.value() < 0.0;
    if faster && left.value() < 1.0 {
        action.value = if left.value() > 0.0 { action.value * left } else { T::zero() };
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::{Trial, plant};
    use dynamics::description::{Quantity, Signal, SignalKind};
    use simulation::Simulator;

    #[test]
    fn torque_fades_towards_the_limit_and_braking_passes() {
        let value = |rate, command| Trial { rate, command, ..Trial::default() }.value(&EFFECT, &[0.01, 0.1]);
        assert_eq!([value(50.0, -2.0), value(89.0, -2.0), value(120.0, -2.0)], [-2.0, -2.0, 0.0]);
        assert!((value(95.0, -2.0) + 1.0).abs() < 1e-14); // half way through the band; rounding
        assert_eq!([value(120.0, 2.0), value(-120.0, 2.0), value(-120.0, -2.0)], [2.0, 0.0, -2.0]);
    }

    #[test]
    fn the_wheel_stays_below_its_limit_and_its_push_ends_there() {
        let mut plant = plant();
        let kind = SignalKind::Constant { value: Quantity::known(-1.0) };
        plant.actuators[1].command = vec![Signal { kind, begin_s: Quantity::known(0.0), end_s: None }];
        plant
            .add_effect("wheel_speed_saturation", &"actuator:rw".parse().unwrap(), &[("inverse_limit", 0.01)])
            .unwrap();
        let mut simulator = Simulator::new(&plant, 1, "test").unwrap();
        let wheel = simulator.system().states().iter().position(|state| state.name == "wheel:rw").unwrap();
        for _ in 0..1000 {
            simulator.step();
            // the body turns under the rotor by up to 1 N m / 80 kg m^2 for 10 s, and its panel
            // swings
            assert!(simulator.truth().state[wheel].abs() <= 100.25);
        }
        // 1 N m on 0.02 kg m^2 is 50 rad/s^2: the limit after 2 s, nearly reached after 10 s
        assert!(simulator.truth().state[wheel].abs() > 99.5);
    }
}
