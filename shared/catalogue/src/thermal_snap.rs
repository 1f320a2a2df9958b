//! A kick of torque at eclipse that gives its momentum back.

use super::geometry::{constant, push};
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Effect, EffectParameter, Family, Law, Limit, Local, Prior, Scan, Spread};
use dynamics::real::Real;

/// Thermal snap: `T = A (1 − s) e^−s`, `s = (t − t0) / T`; its impulse is zero.
pub static EFFECT: Effect = Effect {
    kind: "thermal_snap",
    title: "Thermal snap",
    sites: &[SiteKind::Body],
    parameters: &[
        EffectParameter::new("torque_x", "N m", [-100.0, 100.0], 0.0, "torque A at the start, body x")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("torque_y", "N m", [-100.0, 100.0], 0.0, "torque A at the start, body y")
            .amplitude()
            .out_of_plane(),
        EffectParameter::new("torque_z", "N m", [-100.0, 100.0], 0.02, "torque A at the start, body z").amplitude(),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time t0 of the snap").onset(),
        EffectParameter::new("time_constant", "s", [1e-3, 1e4], 3.0, "time T in which the appendage bends")
            .width(Scan::DurationOver(5.0))
            .with_prior(Prior::Free(Spread::Relative(1.0))),
    ],
    law: Law::Body(both!(law)),
    family: Family::Disturbance,
    limits: &[Limit { kind: "constant_torque", at: &[("begin", 0.0), ("time_constant", 1e4)] }],
    what: "T = A (1 - s) e^-s, s = (t - t0) / T, the derivative of A T s e^-s: an appendage that bends as it cools swings the body and \
           brings it to rest again, so that the impulse is zero and an angle A T^2 / I stays (Foster, Tinker, Nurre and Till 1995). Its \
           ringing is mode_thermal_snap.",
    signature: "Located in time only: body rate rises and returns at eclipse entry or exit, attitude keeps a step.",
    confounders: "sensor_step of an attitude; thruster_leak and sensor_step of the gyro only in records shorter than T; mode_thermal_snap.",
    experiment: "The next eclipse: it repeats there.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let s = (local.t_s - p[3]) / p[4];
    if s >= 0.0 {
        let size = (1.0 - s) * libm::exp(-s);
        push(&mut action.wrench, [0.0; 3], [T::zero(); 3], constant([p[0] * size, p[1] * size, p[2] * size]));
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::trial::Trial;

    #[test]
    fn the_rate_returns_and_the_angle_stays() {
        let torque = |t_s| Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &[0.0, 0.0, 2.0, 10.0, 4.0])[2];
        assert_eq!(torque(9.999), 0.0);
        assert_eq!(torque(10.0), 2.0);
        let (steps, dt) = (200_000u32, 1e-3);
        let (mut rate, mut angle) = (0.0, 0.0);
        for k in 0..steps {
            let kick = dt * torque(10.0 + dt * (f64::from(k) + 0.5));
            angle += dt * (rate + 0.5 * kick);
            rate += kick;
        }
        assert!(rate.abs() < 1e-6, "{rate}"); // midpoint rule: A dt^2 / T / 24 per unit of slope
        assert!((angle - 2.0 * 16.0).abs() < 1e-4, "{angle}"); // A T^2 for unit inertia
    }
}
