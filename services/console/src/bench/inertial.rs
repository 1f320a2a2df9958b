//! BP1A: inertial parameters of a free-floating arm from the conservation of angular momentum, before and after capture.
//!
//! The bound is accumulated along the true motion of the arm in closed loop with noise-free sensors, not along the
//! reference it follows.

use super::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use estimation::consistency::nees;
use estimation::cramer_rao::FisherInformation;
use estimation::total_least_squares::TotalLeastSquares;
use nalgebra::{SMatrix, SVector};
use physics::inertial_estimator::{InertialEstimator, InertialSettings};
use physics::momentum::{ChannelSigma, MomentumSample, momentum_regressor, noisy_momentum_row};
use plant::arm::{ArmMeasurement, ArmNoise, FreeFloatingArm};
use plant::arm_parameters::{ArmParameters, Target};
use plant::fourier_reference::FourierReference;
use plant::sensor::random_walk_sample_sigma;

const PERIOD_S: f64 = 0.01;
const H_CM_NMS: f64 = 68.0;
const SAMPLES_PER_S: u32 = 100;
/// Where the recursive estimator starts, relative to the truth.
const START_SHARE: f64 = 0.55;
/// Prior: a number to start from, information 1e-6/a².
const PRIOR_RELATIVE_SD: f64 = 1000.0;

const NAMES: [&str; 9] = ["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9"];
/// Table III of the paper, TLS and IV alike.
const TABLE_III_PERCENT: &[f64] = &[0.09, 0.28, 0.25, 0.57, 0.18, 0.10, 0.38, 0.02];
const METHODS: &[Method] = &[
    Method { name: "AMC LS", paper_percent: TABLE_III_PERCENT },
    Method { name: "AMC TLS", paper_percent: TABLE_III_PERCENT },
    Method { name: "AMC WLS-BC recursive", paper_percent: TABLE_III_PERCENT },
];
/// Place of the estimator that flies in the list of methods.
pub const FLIGHT: usize = 2;

/// An arm, its experiment, and what the estimator is told; `P` parameters, `A = P + 1`.
#[derive(Clone, Debug)]
pub struct Inertial<const P: usize, const A: usize> {
    pub name: &'static str,
    pub arm: ArmParameters,
    pub reference: FourierReference,
    pub seconds: u32,
    pub settings: InertialSettings<P>,
    /// How measurements become the estimator's samples.
    pub wiring: fn(&ArmMeasurement) -> MomentumSample,
}

impl Inertial<8, 9> {
    /// Table II, trajectory B, 60 s, momentum exact.
    pub fn bp1a() -> Self {
        Self::new("bp1a", ArmParameters::paper_table_ii(), FourierReference::trajectory_b(), 60)
    }
}

impl Inertial<9, 10> {
    /// The same arm holding 150 kg off its axis, 120 s.
    pub fn mated() -> Self {
        let target = Target { mass_kg: 150.0, com_from_grasp_m: [0.60, 0.15], inertia_com_kg_m2: 40.0 };
        let arm = ArmParameters::paper_table_ii().with_target(target);
        Self::new("bp1a mated", arm, FourierReference::mated(), 120)
    }
}

impl<const P: usize, const A: usize> Inertial<P, A> {
    fn new(name: &'static str, arm: ArmParameters, reference: FourierReference, seconds: u32) -> Self {
        let settings = InertialSettings {
            h_nms: H_CM_NMS,
            sigma_h_nms: 0.0,
            sigma: sigma(&ArmNoise::default()),
            prior_alpha: truth(&arm) * START_SHARE,
            prior_relative_sd: PRIOR_RELATIVE_SD,
        };
        Self { name, arm, reference, seconds, settings, wiring: momentum_sample }
    }

    fn simulator(&self, noise: &ArmNoise, seed: u64, record: usize) -> FreeFloatingArm {
        let prefix = format!("record{record}.arm");
        FreeFloatingArm::new(&self.arm, self.reference, noise, H_CM_NMS, PERIOD_S, seed, &prefix)
    }

    /// What the sensors say.
    pub fn record(&self, noise: &ArmNoise, seed: u64, record: usize) -> Vec<ArmMeasurement> {
        let mut arm = self.simulator(noise, seed, record);
        (0..self.seconds * SAMPLES_PER_S).map(|_| arm.step(true)).collect()
    }

    fn recursive(&self, record: &[ArmMeasurement]) -> InertialEstimator<P> {
        let mut estimator = InertialEstimator::new(&self.settings).expect("the momentum of the benchmark is known");
        for measurement in record {
            estimator.push(&(self.wiring)(measurement)).expect("simulated samples are finite");
        }
        estimator
    }

    fn recursive_answer(&self, estimator: &InertialEstimator<P>) -> Answer {
        let Ok(estimate) = estimator.estimate() else { return Answer::none(P) };
        let found = |i: usize| Found { value: estimate.alpha[i], sigma: Some(estimate.covariance[(i, i)].sqrt()) };
        Answer {
            found: (0..P).map(|i| Some(found(i))).collect(),
            nees: nees(&(estimate.alpha - truth(&self.arm)), &estimate.covariance),
            spurious: 0,
        }
    }

    fn least_squares(&self, record: &[ArmMeasurement]) -> LeastSquares<P> {
        let mut sums = LeastSquares { yy: SMatrix::zeros(), yb: SVector::zeros() };
        for measurement in record {
            let row = momentum_regressor::<P>(&(self.wiring)(measurement));
            sums.yy += row * row.transpose();
            sums.yb += row * self.settings.h_nms;
        }
        sums
    }

    fn total_least_squares(&self, record: &[ArmMeasurement]) -> TotalLeastSquares<P, A> {
        let mut factor = TotalLeastSquares::default();
        for measurement in record {
            factor.push(&momentum_regressor::<P>(&(self.wiring)(measurement)), self.settings.h_nms);
        }
        factor
    }
}

impl<const P: usize, const A: usize> Benchmark for Inertial<P, A> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, sigma) = (truth::<P>(&self.arm), sigma(&ArmNoise::default()).in_channel_order());
        let mut information = FisherInformation::<P>::default();
        let mut arm = self.simulator(&ArmNoise::none(), 0, 0);
        for _ in 0..self.seconds * SAMPLES_PER_S {
            let at = arm.truth();
            let sample = MomentumSample {
                omega0_z_rad_s: at.omega0_z_rad_s,
                joint_rate_rad_s: at.joint_rate_rad_s,
                joint_angle_rad: at.joint_angle_rad,
            };
            let row = noisy_momentum_row::<P>(&sample, H_CM_NMS, &sigma);
            information.push(&row.regressor, row.residual_variance(&truth));
            arm.step(true);
        }
        let bound = information.sigmas()?;
        Some((0..P).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let record = self.record(&ArmNoise::default(), seed, record);
        let bare = |alpha: Option<SVector<f64, P>>| match alpha {
            Some(alpha) => Answer::bare(alpha.iter().copied()),
            None => Answer::none(P),
        };
        vec![
            bare(self.least_squares(&record).solve()),
            bare(self.total_least_squares(&record).estimate().ok()),
            self.recursive_answer(&self.recursive(&record)),
        ]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(&ArmNoise::default(), 0, 0);
        let samples = record.len();
        vec![
            cost(samples, || self.least_squares(&record), |sums| sums.solve()),
            cost(samples, || self.total_least_squares(&record), |factor| factor.estimate()),
            cost(samples, || self.recursive(&record), |estimator| estimator.estimate()),
        ]
    }
}

struct LeastSquares<const P: usize> {
    yy: SMatrix<f64, P, P>,
    yb: SVector<f64, P>,
}

impl<const P: usize> LeastSquares<P> {
    fn solve(&self) -> Option<SVector<f64, P>> {
        Some(self.yy.cholesky()?.solve(&self.yb))
    }
}

/// The simulator's minimal parameters, the first `P` of nine.
pub fn truth<const P: usize>(arm: &ArmParameters) -> SVector<f64, P> {
    let nine = arm.mated_inertial_parameters_truth();
    SVector::from_fn(|i, _| nine[i])
}

/// Gyro, joint rates and joint angles, as sensors and estimator name them.
pub fn momentum_sample(measured: &ArmMeasurement) -> MomentumSample {
    MomentumSample {
        omega0_z_rad_s: measured.omega0_z_rad_s,
        joint_rate_rad_s: measured.joint_rate_rad_s,
        joint_angle_rad: measured.joint_angle_rad,
    }
}

/// Standard deviation of one sample; quantisation adds lsb²/12.
pub fn sigma(noise: &ArmNoise) -> ChannelSigma {
    let (angle, lsb) = (noise.joint_angle_sigma_rad, noise.joint_angle_lsb_rad);
    ChannelSigma {
        omega0_rad_s: random_walk_sample_sigma(noise.gyro_arw_rad_sqrt_s, PERIOD_S),
        joint_rate_rad_s: [noise.joint_rate_sigma_rad_s; 2],
        joint_angle_rad: [(angle * angle + lsb * lsb / 12.0).sqrt(); 2],
    }
}
