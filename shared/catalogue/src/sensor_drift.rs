//! A bias that grows with time.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Drift of a sensor's bias: `y = h + r t`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_drift",
    title: "Drift of a sensor's bias",
    sites: &[SiteKind::Sensor],
    parameters: &[EffectParameter::new("rate", "*/s", [-1.0, 1.0], 1e-5, "change of bias per time").amplitude()],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = h + r t; the deterministic part of bias instability, temperature ramps.",
    signature: "Residual of one channel grows linearly.",
    confounders: "constant_torque for a gyro, constant_force for a velocity, mass_depletion and payload_drift; sensor_warm_up at its start.",
    experiment: "Quiet records at the start and the end; a longer record.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += T::constant(p[0] * local.t_s);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_bias_is_the_rate_times_the_time() {
        assert_eq!(Trial { t_s: 20.0, reading: 1.0, ..Trial::default() }.value(&EFFECT, &[0.125]), 3.5);
    }
}
