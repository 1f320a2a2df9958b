//! A burst of torque at eclipse.

use super::applies::anywhere;
use super::geometry::{constant, direction, push};
use super::law::both;
use super::{Action, Effect, EffectParameter, Law, Local};
use crate::description::SiteKind;
use crate::real::Real;

pub static EFFECT: Effect = Effect {
    kind: "thermal_snap",
    title: "Thermal snap",
    sites: &[SiteKind::Body],
    applies: anywhere,
    parameters: &[
        EffectParameter::new("torque", "N m", [-100.0, 100.0], 0.02, "torque A at the start"),
        EffectParameter::new("begin", "s", [0.0, 1e6], 10.0, "time t0 of the snap"),
        EffectParameter::new("decay", "s", [1e-3, 1e4], 3.0, "time constant T"),
        EffectParameter::new("frequency", "Hz", [0.0, 50.0], 0.0, "frequency f of its ringing; zero: none"),
        EffectParameter::new("azimuth", "rad", [-3.2, 3.2], 0.0, "its axis, from body x towards y"),
        EffectParameter::new("elevation", "rad", [-1.6, 1.6], core::f64::consts::FRAC_PI_2, "its axis, towards body z"),
    ],
    hidden_states: 0,
    law: Law::Body(both!(law)),
    what: "T = A e^(-(t-t0)/T) cos 2 pi f (t-t0) from t0 on; appendages that bend as they cool (Foster, Tinker, Nurre and Till 1995).",
    signature: "Located in time only: a burst of body rate at eclipse entry or exit.",
    confounders: "thruster_leak, sensor_step of the gyro, mode_thermal_snap.",
    experiment: "The next eclipse: it repeats there.",
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    let (torque, begin, decay, frequency) = (p[0], p[1], p[2], p[3]);
    let since = local.t_s - begin;
    if since >= 0.0 {
        let size = torque * libm::exp(-since / decay) * libm::cos(core::f64::consts::TAU * frequency * since);
        let axis = direction(p[4], p[5]).map(|component| size * component);
        push(&mut action.wrench, [0.0; 3], [T::zero(); 3], constant(axis));
    }
}

#[cfg(test)]
mod tests {
    use super::EFFECT;
    use crate::effects::trial::Trial;

    #[test]
    fn the_burst_begins_at_its_time_rings_and_decays() {
        let torque = |t_s| Trial { t_s, ..Trial::default() }.wrench(&EFFECT, &[2.0, 10.0, 4.0, 0.5, 0.0, 0.0])[0];
        assert_eq!(torque(9.999), 0.0);
        assert_eq!(torque(10.0), 2.0);
        assert!((torque(11.0) + 2.0 * libm::exp(-0.25)).abs() < 1e-15); // half a ringing period; rounding
        assert!((torque(14.0) - 2.0 * libm::exp(-1.0)).abs() < 1e-15);
    }
}
