//! Sloshing propellant as a mass on a spring and damper along one axis: the truth of BP2.
//!
//! Two point masses in absolute coordinates, `m_0 ẍ_0 = f + F`, `m_s ẍ_s = −F`,
//! `F = k (x_s − x_0) + c (v_s − v_0)`, advanced by one exact matrix exponential while the thrust
//! is held. Nothing is reduced to the relative coordinate, so momentum is a test and not an
//! assumption.
//!
//! The accelerometer returns velocity increments: the mean acceleration over the interval with
//! white noise of `N/√Δt`. Frame: one axis, positive along the thrust. No gravity; starts at rest.

use crate::oracle::sensor::Channel;
use crate::sensor::random_walk_sample_sigma;
use dynamics::noise::Stream;
use dynamics::zero_order_hold::discretise;
use nalgebra::{DMatrix, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// Velocity random walk of the benchmark's accelerometer, 0.008 (m/s)/√h, in (m/s)/√s.
pub const ACCELEROMETER_VRW_M_S_SQRT_S: f64 = 0.008 / 60.0;

/// Bus and tank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SloshParameters {
    /// Spacecraft without the slosh mass.
    pub m_0_kg: f64,
    pub m_s_kg: f64,
    pub k_s_n_m: f64,
    pub c_s_n_s_m: f64,
}

impl SloshParameters {
    /// The benchmark's tank.
    pub const fn benchmark() -> Self {
        Self { m_0_kg: 1004.5, m_s_kg: 28.7, k_s_n_m: 0.16, c_s_n_s_m: 0.03 }
    }
}

/// One interval: the thrust held over it, and the mean acceleration measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshMeasurement {
    pub force_n: f64,
    pub acceleration_m_s2: f64,
}

/// Everything that changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SloshState {
    /// x_0, x_s [m], v_0, v_s [m/s], inertial.
    pub x: SVector<f64, 4>,
    pub sample: u64,
}

/// The simulator.
#[derive(Clone, Debug)]
pub struct SloshTruth {
    transition: SMatrix<f64, 4, 4>,
    input: SVector<f64, 4>,
    interval_s: f64,
    accelerometer: Channel,
    state: SloshState,
}

impl SloshTruth {
    /// Craft at rest. `vrw_m_s_sqrt_s` is the accelerometer's velocity random walk; its stream is
    /// `{stream_prefix}.accelerometer.x`.
    pub fn new(
        parameters: &SloshParameters,
        interval_s: f64,
        vrw_m_s_sqrt_s: f64,
        seed: u64,
        stream_prefix: &str,
    ) -> Self {
        let (a, b) = state_space(parameters);
        let (transition, input) = discretise(&a, &b, interval_s);
        let stream = Stream::new(seed, &format!("{stream_prefix}.accelerometer.x"));
        Self {
            transition: transition.fixed_view::<4, 4>(0, 0).into_owned(),
            input: input.fixed_view::<4, 1>(0, 0).into_owned(),
            interval_s,
            accelerometer: Channel::white(stream, random_walk_sample_sigma(vrw_m_s_sqrt_s, interval_s)),
            state: SloshState { x: SVector::zeros(), sample: 0 },
        }
    }

    /// Holds `force_n` over one interval and measures the mean acceleration over it.
    pub fn step(&mut self, force_n: f64) -> SloshMeasurement {
        let next = self.transition * self.state.x + self.input * force_n;
        let mean_acceleration = (next[2] - self.state.x[2]) / self.interval_s;
        let measurement = SloshMeasurement {
            force_n,
            acceleration_m_s2: self.accelerometer.measure(mean_acceleration, self.state.sample),
        };
        self.state = SloshState { x: next, sample: self.state.sample + 1 };
        measurement
    }

    /// The changing part, for a checkpoint; another initial state is set by `restore`.
    pub fn state(&self) -> SloshState {
        self.state
    }

    /// Continues from a checkpoint of a simulator built with the same configuration.
    pub fn restore(&mut self, state: SloshState) {
        self.state = state;
    }

    /// Displacement of the slosh mass relative to the craft [m].
    pub fn stroke_m(&self) -> f64 {
        self.state.x[1] - self.state.x[0]
    }
}

/// The seed's thrust: `amplitude · sin(2π f t)`, to be sampled at the middle of the interval over
/// which it is held.
pub fn sine_force_n(t_mid_s: f64, amplitude_n: f64, frequency_hz: f64) -> f64 {
    amplitude_n * libm::sin(core::f64::consts::TAU * frequency_hz * t_mid_s)
}

fn state_space(parameters: &SloshParameters) -> (DMatrix<f64>, DMatrix<f64>) {
    let SloshParameters { m_0_kg: m_0, m_s_kg: m_s, k_s_n_m: k, c_s_n_s_m: c } = *parameters;
    assert!(m_0 > 0.0 && m_s > 0.0);
    #[rustfmt::skip]
    let a = DMatrix::from_row_slice(4, 4, &[
        0.0,      0.0,      1.0,      0.0,
        0.0,      0.0,      0.0,      1.0,
        -k / m_0, k / m_0,  -c / m_0, c / m_0,
        k / m_s,  -k / m_s, c / m_s,  -c / m_s,
    ]);
    (a, DMatrix::from_row_slice(4, 1, &[0.0, 0.0, 1.0 / m_0, 0.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TANK: SloshParameters = SloshParameters::benchmark();

    fn quiet(interval_s: f64) -> SloshTruth {
        SloshTruth::new(&TANK, interval_s, 0.0, 0, "craft")
    }

    #[test]
    fn thrust_goes_into_momentum_and_nothing_else_does() {
        let mut craft = quiet(0.1);
        let (mut impulse, mut exchanged) = (0.0, 0.0);
        for k in 0..10_000 {
            let force = sine_force_n(0.1 * (f64::from(k) + 0.5), 44.0, 0.01);
            craft.step(force);
            impulse += force * 0.1;
            exchanged += force.abs() * 0.1;
            let x = craft.state().x;
            let momentum = TANK.m_0_kg * x[2] + TANK.m_s_kg * x[3];
            // rounding of 10⁴ additions
            assert!((momentum - impulse).abs() < 1e-11 * exchanged.max(1.0), "step {k}");
        }
    }

    /// Runge–Kutta on Newton's two equations, written here.
    #[test]
    fn exact_hold_equals_a_fine_integration_of_newtons_equations() {
        let slope = |x: [f64; 4], f: f64| {
            let spring = TANK.k_s_n_m * (x[1] - x[0]) + TANK.c_s_n_s_m * (x[3] - x[2]);
            [x[2], x[3], (f + spring) / TANK.m_0_kg, -spring / TANK.m_s_kg]
        };
        let moved = |x: [f64; 4], k: [f64; 4], h: f64| core::array::from_fn(|i| x[i] + h * k[i]);
        let mut craft = quiet(1.0);
        let mut x = [0.0; 4];
        for k in 0..1000 {
            let force = if k % 83 < 41 { 44.0 } else { -44.0 };
            let v_before = x[2];
            for _ in 0..100 {
                let h = 0.01;
                let k_1 = slope(x, force);
                let k_2 = slope(moved(x, k_1, 0.5 * h), force);
                let k_3 = slope(moved(x, k_2, 0.5 * h), force);
                let k_4 = slope(moved(x, k_3, h), force);
                x = core::array::from_fn(|i| x[i] + h / 6.0 * (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]));
            }
            let measured = craft.step(force).acceleration_m_s2;
            // RK4: (ωh)⁵/120 = 2e-18 per step; what is left is the rounding of 10⁵ steps, 1e-13
            // relative at random signs, on velocities of a few m/s and positions of up to a few
            // hundred metres
            assert!((measured - (x[2] - v_before)).abs() < 1e-12, "interval {k}: {}", measured - (x[2] - v_before));
            assert!((craft.stroke_m() - (x[1] - x[0])).abs() < 1e-9);
        }
        assert!(craft.stroke_m().abs() > 1.0, "the mode must have been excited");
    }

    #[test]
    fn ring_down_has_the_frequency_and_damping_of_the_reduced_mass() {
        // μ = m0 ms / (m0 + ms): 0.012052 Hz, ζ = 0.00710 in the benchmark's description
        let mut craft = quiet(0.1);
        craft.restore(SloshState { x: SVector::from([0.0, 1.0, 0.0, 0.0]), sample: 0 });
        let mut crossings = Vec::new();
        let mut before = craft.stroke_m();
        for k in 0..100_000 {
            craft.step(0.0);
            let now = craft.stroke_m();
            if before > 0.0 && now <= 0.0 {
                crossings.push(0.1 * (f64::from(k) + before / (before - now)));
            }
            before = now;
        }
        let cycles = (crossings.len() - 1) as f64;
        let frequency = cycles / (crossings[crossings.len() - 1] - crossings[0]);
        // printed digits; linear interpolation of a crossing is good to 1e-7 s here
        assert!((frequency - 0.012_052).abs() < 0.5e-6 + 0.012_052 * 2.6e-5, "{frequency}"); // √(1 − ζ²) = 1 − 2.5e-5
    }

    #[test]
    fn the_first_row_of_the_seed_sine_is_the_mid_interval_value() {
        assert!((sine_force_n(0.05, 44.0, 0.01) - 44.0 * (core::f64::consts::TAU * 0.01 * 0.05).sin()).abs() < 1e-15);
        // 44 N sin(2π 0.01 · 0.05) on 1004.5 kg: 1.376e-4 m/s² before the slosh has moved
        let first = quiet(0.1).step(sine_force_n(0.05, 44.0, 0.01)).acceleration_m_s2;
        assert!((first - 1.376_103_596_6e-4).abs() < 1e-13, "{first:e}");
    }

    #[test]
    fn noise_is_a_density_of_the_velocity_increment() {
        for interval in [0.1, 1.0] {
            let mut craft = SloshTruth::new(&TANK, interval, ACCELEROMETER_VRW_M_S_SQRT_S, 4, "craft");
            let n = 40_000;
            let sum: f64 = (0..n).map(|_| craft.step(0.0).acceleration_m_s2).map(|a| a * a).sum();
            let density = (sum / f64::from(n) * interval).sqrt();
            // relative standard error 1/√(2N) = 0.35 %; 4.5 of them
            assert!((density / (0.008 / 60.0) - 1.0).abs() < 0.016, "{density:e}");
        }
    }

    #[test]
    fn a_checkpoint_continues_with_the_same_bits() {
        let fresh = || SloshTruth::new(&TANK, 0.1, ACCELEROMETER_VRW_M_S_SQRT_S, 4, "craft");
        let mut undisturbed = fresh();
        (0..77).for_each(|_| {
            undisturbed.step(10.0);
        });
        let bytes = postcard::to_allocvec(&undisturbed.state()).unwrap();
        let mut restarted = fresh();
        restarted.restore(postcard::from_bytes(&bytes).unwrap());
        (0..100).for_each(|_| assert_eq!(undisturbed.step(-3.0), restarted.step(-3.0)));
    }
}
