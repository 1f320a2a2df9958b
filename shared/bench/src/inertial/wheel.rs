//! Nine parameters after capture when the momentum is unknown: a wheel of known momentum is
//! modulated, and the total is one more unknown.
//!
//! The wheel takes 10 N m s from the body and gives them back, twenty seconds a cycle:
//! `Y_h α − h = −h_w(t)`. What the wheel has taken is the sum of the commanded torques, held over
//! each period.

use super::{Inertial, NAMES, sigma, truth};
use crate::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::momentum_extended::with_wheel_modulation;
use crate::simulated::{number, periods, simulator};
use dynamics::description::{Actuator, ActuatorKind, Quantity, Signal, SignalKind};
use estimation::consistency::nees;
use estimation::cramer_rao::FisherInformation;
use estimation::weighted_least_squares::Estimate;
use nalgebra::SVector;
use physics::momentum::{MomentumSample, momentum_regressor, noisy_momentum_row};

const WHEEL: &str = "wheel";
const AMPLITUDE_NMS: f64 = 10.0;
const FREQUENCY_HZ: f64 = 0.05;
const METHODS: &[Method] = &[Method { name: "momentum-wls-bc-wheel", paper_percent: &[] }];

/// The mated experiment with a wheel that is modulated.
#[derive(Clone, Debug)]
pub struct Wheel {
    pub mated: Inertial<9, 10>,
}

impl Wheel {
    /// The arm after capture with the wheel on its base.
    pub fn mated() -> Self {
        let mut mated = Inertial::mated();
        let known = Quantity::known;
        let omega = 2.0 * core::f64::consts::PI * FREQUENCY_HZ;
        mated.plant.actuators.push(Actuator {
            name: WHEEL.into(),
            kind: ActuatorKind::BodyTorque { body: "hub".into(), direction: [0.0, 0.0, 1.0] },
            command: vec![Signal {
                kind: SignalKind::Sine {
                    amplitude: known(-AMPLITUDE_NMS * omega),
                    frequency_hz: known(FREQUENCY_HZ),
                    phase_rad: known(core::f64::consts::FRAC_PI_2),
                },
                begin_s: known(0.0),
                end_s: None,
            }],
            noise: known(0.0),
            range: None,
            recorded: true,
        });
        Self { mated }
    }

    /// Gyro and joints, and what the wheel holds at each sample.
    fn record(&self, experiment: &Inertial<9, 10>, seed: u64, record: usize) -> (Vec<MomentumSample>, Vec<f64>) {
        let plant = &experiment.plant;
        let mut simulator = simulator(plant, seed, record);
        let wheel = plant.actuators.iter().position(|actuator| actuator.name == WHEEL).expect("it was added");
        let mut held_nms = 0.0;
        let step = |_| {
            let row = simulator.step();
            let sample = (experiment.arm_sample(row).motion, held_nms);
            held_nms -= row.commands[wheel] * plant.simulation.period_s;
            sample
        };
        (0..periods(plant)).map(step).unzip()
    }

    /// Nine parameters and the momentum from one record; `None` where the wheel's variation does
    /// not determine the scale.
    pub fn found(&self, seed: u64, record: usize) -> Option<Estimate<10>> {
        let (samples, wheel) = self.record(&self.mated, seed, record);
        let settings = &self.mated.settings;
        let found = with_wheel_modulation::<9, 10>(&samples, |k| wheel[k], &settings.sigma, &settings.prior_alpha);
        found.ok().map(|(estimate, _)| estimate)
    }

    fn truth(&self) -> SVector<f64, 10> {
        let alpha = truth::<9>(&self.mated.plant);
        SVector::from_fn(|i, _| if i < 9 { alpha[i] } else { number(&self.mated.plant, "initial.momentum.z") })
    }

    /// Bound of the ten along the motion with perfect sensors.
    pub fn information(&self) -> FisherInformation<10> {
        let (samples, wheel) = self.record(&self.mated.without_noise(), 0, 0);
        let (alpha, channels) = (truth::<9>(&self.mated.plant), sigma(&self.mated.plant).in_channel_order());
        let mut information = FisherInformation::default();
        for (sample, wheel_nms) in samples.iter().zip(wheel) {
            let variance = noisy_momentum_row::<9>(sample, -wheel_nms, &channels).residual_variance(&alpha);
            let row = momentum_regressor::<9>(sample);
            information.push(&SVector::<f64, 10>::from_fn(|i, _| if i < 9 { row[i] } else { -1.0 }), variance);
        }
        information
    }
}

impl Benchmark for Wheel {
    fn name(&self) -> &'static str {
        "bp1a mated, momentum unknown, wheel modulated"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bound) = (self.truth(), self.information().sigmas()?);
        let name = |i: usize| NAMES.get(i).copied().unwrap_or("h");
        Some((0..10).map(|i| Parameter { name: name(i), truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let Some(estimate) = self.found(seed, record) else { return vec![Answer::none(10)] };
        let found = |i: usize| Found { value: estimate.alpha[i], sigma: Some(estimate.covariance[(i, i)].sqrt()) };
        vec![Answer {
            found: (0..10).map(|i| Some(found(i))).collect(),
            nees: nees(&(estimate.alpha - self.truth()), &estimate.covariance),
            ..Answer::default()
        }]
    }

    fn costs(&self) -> Vec<Cost> {
        let (samples, wheel) = self.record(&self.mated, 0, 0);
        let settings = &self.mated.settings;
        let fit = || with_wheel_modulation::<9, 10>(&samples, |k| wheel[k], &settings.sigma, &settings.prior_alpha);
        vec![cost(samples.len(), fit, |_| ())]
    }
}
