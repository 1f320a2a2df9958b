//! A gyro that feels acceleration.

use super::applies::gyro;
use super::geometry::{constant, dot};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;

/// Acceleration sensitivity of a gyro: `y = ω + s · f`, f the specific force of the body's origin.
pub static EFFECT: Effect = Effect {
    kind: "gyro_g_sensitivity",
    title: "Acceleration sensitivity of a gyro",
    sites: &[SiteKind::Sensor],
    applies: gyro,
    parameters: &[
        EffectParameter::new(
            "sensitivity_x",
            "rad s/m",
            [-0.01, 0.01],
            1e-05,
            "rate read per specific force, along body x",
        )
        .amplitude(),
        EffectParameter::new(
            "sensitivity_y",
            "rad s/m",
            [-0.01, 0.01],
            0.0,
            "rate read per specific force, along body y",
        )
        .amplitude(),
        EffectParameter::new(
            "sensitivity_z",
            "rad s/m",
            [-0.01, 0.01],
            0.0,
            "rate read per specific force, along body z",
        )
        .amplitude()
        .out_of_plane(),
    ],
    law: Law::Sensor(both!(law)),
    family: Family::SensorError,
    what: "y = w + s . f, f the specific force of the body's origin (IEEE Std 528: g-sensitive drift); 0.1 deg/s/g is 1.8e-4 rad s/m.",
    signature: "Gyro residual in step with an accelerometer: thrust, slosh and vibration appear as rate.",
    confounders: "sensor_misalignment of the gyro under coupled motion, sensor_bias on a bench at one attitude.",
    experiment: "Push without turning; on a bench, turn the gyro over.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.value += dot(constant([p[0], p[1], p[2]]), local.body.specific_force_m_s2);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_gyro_reads_its_share_of_the_specific_force_it_feels() {
        let mut state = Trial { reading: 0.5, ..Trial::default() };
        state.body.specific_force_m_s2 = [2.0, 4.0, 9.81];
        assert_eq!(state.value(&EFFECT, &[0.125, 0.0, 0.0]), 0.75);
        let up = state.value(&EFFECT, &[0.0, 0.0, 0.01]);
        assert!((up - 0.5981).abs() < 1e-15); // rounding
    }
}
