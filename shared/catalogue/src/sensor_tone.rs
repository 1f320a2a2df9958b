//! A tone from outside the plant.

use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Periodic pick-up of a sensor: `y = h + A sin(2π f t + φ)`.
pub static EFFECT: Effect = Effect {
    kind: "sensor_tone",
    title: "Periodic pick-up of a sensor",
    sites: &[SiteKind::Sensor],
    parameters: &[
        EffectParameter::new("amplitude", "*", [0.0, 10.0], 1e-3, "amplitude A").amplitude(),
        EffectParameter::new(
            "frequency",
            "Hz",
            [0.01, 1e4],
            50.0,
            "frequency f of the source, also above half the sample rate",
        )
        .frequency(),
        EffectParameter::new("phase", "rad", [-3.2, 3.2], 0.0, "phase at t = 0").direction(1.0),
    ],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = h + A sin(2 pi f t + phase); mains hum, a pump or cooler on the mount. Above half the sample rate it reads as its alias.",
    signature: "A narrow line in one channel that never decays nor moves with any state.",
    confounders: "mode_left_out or wheel_imbalance_static where the source is near a plant frequency.",
    experiment: "Change the sample rate: an alias moves, a true line stays. Record with all actuators off.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (amplitude, frequency, phase) = (p[0], p[1], p[2]);
    action.value += T::constant(amplitude * libm::sin(core::f64::consts::TAU * frequency * local.t_s + phase));
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn sampled_too_slowly_the_tone_reads_as_its_alias() {
        for k in 0..50 {
            let state = Trial { t_s: f64::from(k) / 20.0, ..Trial::default() };
            let (tone, alias) = (state.value(&EFFECT, &[1.0, 21.0, 0.3]), state.value(&EFFECT, &[1.0, 1.0, 0.3]));
            assert!((tone - alias).abs() < 1e-12); // rounding of phases up to 330 rad
        }
    }
}
