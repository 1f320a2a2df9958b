//! Trajectory B with the systematic errors that the data sheets of the sensors allow, drawn anew
//! for every record: gyro bias and scale, joint rate scales and zeros, latency. Intervals from the
//! noise alone, and from noise and data sheet together (Schmidt's consider covariance).

use super::{Inertial, NAMES, truth};
use crate::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::consider_batch::{ConsideredEstimate, consider};
use crate::momentum_methods::weighted;
use dynamics::noise::Stream;
use estimation::consistency::nees;
use nalgebra::SMatrix;
use physics::consider::SensorSheet;
use physics::momentum::MomentumSample;

/// One sigma of each, as a calibrated navigation-grade set states them.
const SHEET: SensorSheet = SensorSheet {
    gyro_bias_rad_s: 4.8e-6, // 1 deg/h
    gyro_scale: 1e-4,
    joint_rate_scale: [3e-4; 2],
    joint_zero_rad: [1e-4; 2],
    latency_s: 5e-4,
};
const METHODS: &[Method] =
    &[Method { name: "noise alone", paper_percent: &[] }, Method { name: "noise and sheet", paper_percent: &[] }];

/// Perfect knowledge of the noise, and what the data sheet allows besides.
#[derive(Clone, Debug)]
pub struct Sheet {
    arm: Inertial<8, 9>,
    /// Of the base with perfect sensors [rad/s²].
    acceleration_rad_s2: Vec<f64>,
}

impl Sheet {
    /// The arm of BP1A with the systematic errors of its sensors' data sheets.
    pub fn bp1a() -> Self {
        let arm = Inertial::bp1a();
        let (clean, dt) = (arm.noise_free(), arm.interval_s());
        let slope = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(clean.len() - 1));
            (clean[after].omega0_z_rad_s - clean[before].omega0_z_rad_s) / ((after - before) as f64 * dt)
        };
        let acceleration_rad_s2 = (0..clean.len()).map(slope).collect();
        Self { arm, acceleration_rad_s2 }
    }

    /// What sensors with such errors would have said.
    fn record(&self, seed: u64, record: usize) -> Vec<MomentumSample> {
        let stream = Stream::new(seed, &format!("record{record}.sheet"));
        let draw = |i: u64| stream.normal(i);
        let mut samples = self.arm.record(seed, record);
        for (sample, acceleration) in samples.iter_mut().zip(&self.acceleration_rad_s2) {
            sample.omega0_z_rad_s += SHEET.gyro_bias_rad_s * draw(0)
                + SHEET.gyro_scale * draw(1) * sample.omega0_z_rad_s
                - SHEET.latency_s * draw(6) * acceleration;
            for joint in 0..2 {
                sample.joint_rate_rad_s[joint] *= 1.0 + SHEET.joint_rate_scale[joint] * draw(2 + joint as u64);
                sample.joint_angle_rad[joint] += SHEET.joint_zero_rad[joint] * draw(4 + joint as u64);
            }
        }
        samples
    }

    fn found(&self, samples: &[MomentumSample]) -> Option<ConsideredEstimate<8>> {
        let (settings, momentum) = (&self.arm.settings, self.arm.momentum());
        let (fit, _) = weighted(samples, momentum, &settings.sigma, &settings.prior_alpha).ok()?;
        consider(samples, self.arm.interval_s(), momentum, &settings.sigma, &SHEET, &fit.alpha).ok()
    }

    fn answer(&self, found: &ConsideredEstimate<8>, covariance: &SMatrix<f64, 8, 8>) -> Answer {
        let alpha = &found.estimate.alpha;
        Answer {
            found: (0..8).map(|i| Some(Found { value: alpha[i], sigma: Some(covariance[(i, i)].sqrt()) })).collect(),
            nees: nees(&(alpha - truth(&self.arm.plant)), covariance),
            ..Answer::default()
        }
    }
}

impl Benchmark for Sheet {
    fn name(&self) -> &'static str {
        "bp1a with errors of the sensors' sheets"
    }

    /// Bound: noise and data sheet together along the motion with perfect sensors.
    fn parameters(&self) -> Option<Vec<Parameter>> {
        let truth = truth::<8>(&self.arm.plant);
        let total = self.found(&self.arm.noise_free())?.total();
        Some((0..8).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: total[(i, i)].sqrt() }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        match self.found(&self.record(seed, record)) {
            Some(found) => {
                vec![self.answer(&found, &found.estimate.covariance), self.answer(&found, &found.total())]
            }
            None => vec![Answer::none(8), Answer::none(8)],
        }
    }

    fn costs(&self) -> Vec<Cost> {
        let samples = self.record(0, 0);
        let fit = || cost(samples.len(), || self.found(&samples), |_| ());
        vec![fit(), fit()]
    }
}
