//! A sensor with a constant offset.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Bias of a sensor: `y = h + b`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_bias",
    title: "Bias of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("bias", "*", [-10.0, 10.0], 1e-3, "offset b of the reading").amplitude()],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = h + b, the same in every sample (IEEE Std 952).",
    signature: "Only this channel is shifted, by the same amount throughout; the physics of the others does not follow.",
    confounders: "The sensor's own bias where it has a prior (identical); constant_force for an accelerometer, constant_torque or actuator_bias for a gyro in short records, sensor_warm_up.",
    experiment: "A quiet record, or two attitudes of the sensor.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += T::constant(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_bias_is_added_to_every_reading() {
        assert_eq!(Trial { reading: 2.0, ..Trial::default() }.value(&EFFECT, &[-0.25]), 1.75);
    }
}
