//! A sensor whose scale factor is off.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Scale factor error of a sensor: `y = (1 + e) h`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_scale",
    title: "Scale factor error of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("error", "1", [-0.3, 0.3], 0.01, "relative error e of the scale").amplitude()],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = (1 + e) h, the same in every sample (IEEE Std 952).",
    signature: "This channel's residual is proportional to its own reading.",
    confounders: "The sensor's own scale where it has a prior and the total mass for an accelerometer (mass_error of all bodies, exactly, without a mass known from elsewhere), inertia for a gyro, motor_constant_error \
                  where all sensors of an actuator's response share it.",
    experiment: "A second sensor of the same motion, a known mass, a turn by a known angle.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value = action.value.scale(1.0 + p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_reading_is_stretched_by_one_factor() {
        assert_eq!(Trial { reading: -2.0, ..Trial::default() }.value(&EFFECT, &[0.25]), -2.5);
    }
}
