//! BP1A: inertial parameters of a free-floating arm from the conservation of angular momentum, before and after capture.
//!
//! The bound is accumulated along the true motion of the arm in closed loop with noise-free sensors, not along the
//! reference it follows.

use super::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use super::simulated::{built_in, channel, number, periods, sample_sigma, simulator, without_noise};
use estimation::consistency::nees;
use estimation::cramer_rao::FisherInformation;
use estimation::total_least_squares::TotalLeastSquares;
use nalgebra::{SMatrix, SVector};
use physics::inertial_estimator::{InertialEstimator, InertialSettings};
use physics::momentum::{ChannelSigma, MomentumSample, momentum_regressor, noisy_momentum_row};
use plant::arm_parameters::minimal_parameters;
use plant::description::Plant;

/// The channels that momentum needs.
const CHANNELS: [&str; 5] = ["gyro", "shoulder_rate", "elbow_rate", "shoulder_angle", "elbow_angle"];
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
    /// With its controllers, sensors, initial momentum and duration.
    pub plant: Plant,
    pub settings: InertialSettings<P>,
    /// How measurements become the estimator's samples.
    pub wiring: fn(MomentumSample) -> MomentumSample,
}

impl Inertial<8, 9> {
    /// Table II, trajectory B, 60 s, momentum exact.
    pub fn bp1a() -> Self {
        Self::new("bp1a", built_in("free_floating_arm"))
    }
}

impl Inertial<9, 10> {
    /// The same arm holding 150 kg off its axis, 120 s.
    pub fn mated() -> Self {
        Self::new("bp1a mated", built_in("mated"))
    }
}

impl<const P: usize, const A: usize> Inertial<P, A> {
    fn new(name: &'static str, plant: Plant) -> Self {
        let settings = InertialSettings {
            h_nms: number(&plant, "initial.momentum.z"),
            sigma_h_nms: 0.0,
            sigma: sigma(&plant),
            prior_alpha: truth(&plant) * START_SHARE,
            prior_relative_sd: PRIOR_RELATIVE_SD,
        };
        Self { name, plant, settings, wiring: |measured| measured }
    }

    /// What the sensors say.
    pub fn record(&self, seed: u64, record: usize) -> Vec<MomentumSample> {
        let (mut simulator, channels) =
            (simulator(&self.plant, seed, record), CHANNELS.map(|name| channel(&self.plant, name)));
        let step = |_| {
            let row = simulator.step();
            let [omega0_z_rad_s, rate_1, rate_2, angle_1, angle_2] = channels.map(|channel| row.value(channel));
            MomentumSample { omega0_z_rad_s, joint_rate_rad_s: [rate_1, rate_2], joint_angle_rad: [angle_1, angle_2] }
        };
        (0..periods(&self.plant)).map(step).collect()
    }

    /// What perfect sensors would say, the loop closed over them.
    #[must_use]
    pub fn noise_free(&self) -> Vec<MomentumSample> {
        Self { plant: without_noise(&self.plant), ..self.clone() }.record(0, 0)
    }

    fn recursive(&self, record: &[MomentumSample]) -> InertialEstimator<P> {
        let mut estimator = InertialEstimator::new(&self.settings).expect("the momentum of the benchmark is known");
        for measurement in record {
            estimator.push(&(self.wiring)(*measurement)).expect("simulated samples are finite");
        }
        estimator
    }

    fn recursive_answer(&self, estimator: &InertialEstimator<P>) -> Answer {
        let Ok(estimate) = estimator.estimate() else { return Answer::none(P) };
        let found = |i: usize| Found { value: estimate.alpha[i], sigma: Some(estimate.covariance[(i, i)].sqrt()) };
        Answer {
            found: (0..P).map(|i| Some(found(i))).collect(),
            nees: nees(&(estimate.alpha - truth(&self.plant)), &estimate.covariance),
            spurious: 0,
        }
    }

    fn least_squares(&self, record: &[MomentumSample]) -> LeastSquares<P> {
        let mut sums = LeastSquares { yy: SMatrix::zeros(), yb: SVector::zeros() };
        for measurement in record {
            let row = momentum_regressor::<P>(&(self.wiring)(*measurement));
            sums.yy += row * row.transpose();
            sums.yb += row * self.settings.h_nms;
        }
        sums
    }

    fn total_least_squares(&self, record: &[MomentumSample]) -> TotalLeastSquares<P, A> {
        let mut factor = TotalLeastSquares::default();
        for measurement in record {
            factor.push(&momentum_regressor::<P>(&(self.wiring)(*measurement)), self.settings.h_nms);
        }
        factor
    }
}

impl<const P: usize, const A: usize> Benchmark for Inertial<P, A> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, sigma) = (truth::<P>(&self.plant), sigma(&self.plant).in_channel_order());
        let mut information = FisherInformation::<P>::default();
        for sample in self.noise_free() {
            let row = noisy_momentum_row::<P>(&sample, self.settings.h_nms, &sigma);
            information.push(&row.regressor, row.residual_variance(&truth));
        }
        let bound = information.sigmas()?;
        Some((0..P).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let record = self.record(seed, record);
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
        let record = self.record(0, 0);
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

/// Minimal parameters of the arm that is simulated, the first `P` of nine.
///
/// # Panics
/// The plant is no free-floating arm of two links.
pub fn truth<const P: usize>(plant: &Plant) -> SVector<f64, P> {
    let nine = minimal_parameters(plant).expect("the benchmark's plant is a free-floating arm of two links");
    SVector::from_fn(|i, _| nine[i])
}

/// Standard deviation of one sample of each sensor; quantisation adds lsb²/12.
#[must_use]
pub fn sigma(plant: &Plant) -> ChannelSigma {
    let [omega0_rad_s, rate_1, rate_2, angle_1, angle_2] = CHANNELS.map(|name| sample_sigma(plant, name));
    ChannelSigma { omega0_rad_s, joint_rate_rad_s: [rate_1, rate_2], joint_angle_rad: [angle_1, angle_2] }
}
