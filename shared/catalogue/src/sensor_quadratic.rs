//! A sensor with a quadratic non-linearity.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Quadratic non-linearity of a sensor: `y = h + k2 h²`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_quadratic",
    title: "Quadratic non-linearity of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("coefficient", "1/*", [-1.0, 1.0], 1e-3, "coefficient k2").amplitude()],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = h + k2 h^2; second-order coefficient of an accelerometer (IEEE Std 1293), vibration rectification.",
    signature: "Even harmonics in one channel; its mean shifts with vibration.",
    confounders: "sensor_bias under steady vibration, joint_quadratic_stiffness (which other channels would see).",
    experiment: "Two vibration levels: the mean moves with the square.",
    ..Effect::PLAIN
};

fn law<T: Real>(_: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += (action.value * action.value).scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_error_is_even_in_the_reading() {
        let value = |reading| Trial { reading, ..Trial::default() }.value(&EFFECT, &[0.125]);
        assert_eq!(value(2.0), 2.5);
        assert_eq!(value(-2.0), -1.5);
    }
}
