//! A gyro that feels acceleration.

use super::applies::gyro;
use super::geometry::{constant, direction, dot};
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "gyro_g_sensitivity",
    title: "Acceleration sensitivity of a gyro",
    sites: &[SiteKind::Sensor],
    applies: gyro,
    parameters: &[
        EffectParameter::new("sensitivity", "rad s/m", [-0.01, 0.01], 1e-5, "rate read per specific force"),
        EffectParameter::new("azimuth", "rad", [-3.2, 3.2], 0.0, "direction it feels, from body x towards y"),
        EffectParameter::new("elevation", "rad", [-1.6, 1.6], 0.0, "direction it feels, towards body z"),
    ],
    hidden_states: 0,
    law: Law::Sensor(both!(law)),
    what: "y = w + s n . f, f the specific force of the body's origin (IEEE Std 528: g-sensitive drift); 0.1 deg/s/g is 1.8e-4 rad s/m.",
    signature: "Gyro residual in step with an accelerometer: thrust, slosh and vibration appear as rate.",
    confounders: "sensor_misalignment of the gyro under coupled motion, sensor_bias on a bench at one attitude.",
    experiment: "Push without turning; on a bench, turn the gyro over.",
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let felt = dot(constant(direction(p[1], p[2])), local.body.specific_force_m_s2);
    action.value += felt.scale(p[0]);
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn the_gyro_reads_its_share_of_the_specific_force_it_feels() {
        let mut state = Trial { reading: 0.5, ..Trial::default() };
        state.body.specific_force_m_s2 = [2.0, 4.0, 9.81];
        assert_eq!(state.value(&EFFECT, &[0.125, 0.0, 0.0]), 0.75);
        let up = state.value(&EFFECT, &[0.01, 0.0, core::f64::consts::FRAC_PI_2]);
        assert!((up - 0.5981).abs() < 1e-15); // rounding
    }
}
