//! BP1A: inertial parameters of a floating arm from the conservation of momentum and from the
//! dynamic equation, before and after capture.
//!
//! Every method is held against the bound of the model it fits, accumulated along the true motion
//! of the arm in closed loop with noise-free sensors, not along the reference it follows: momentum
//! known, torques with the momentum unknown, or both.

pub mod flying;
pub mod late;
mod methods;
pub mod operational;
pub mod sheet;
pub mod target;
pub mod wheel;

use crate::arm_parameters::minimal_parameters;
use crate::arm_smoother::{self, SmootherSettings, SmootherStep};
use crate::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::momentum_methods::KnownMomentum;
use crate::simulated::{built_in, channel, number, periods, sample_sigma, simulator, without_noise};
use dynamics::description::{Plant, Quantity, SignalKind};
use dynamics::noise::Stream;
use estimation::consistency::nees;
use estimation::cramer_rao::FisherInformation;
use estimation::weighted_least_squares::Estimate;
use methods::Estimator;
use nalgebra::{SMatrix, SVector};
use physics::dynamic_equation::ArmSample;
use physics::excitation::{FourierJoint, FourierTrajectory};
use physics::free_floating::PlanarArm;
use physics::inertial_estimator::InertialSettings;
use physics::momentum::{ChannelSigma, MomentumSample, noisy_momentum_row};
use simulation::Row;

/// The channels that momentum needs, then those of the dynamic equation.
const CHANNELS: [&str; 5] = ["gyro", "shoulder_rate", "elbow_rate", "shoulder_angle", "elbow_angle"];
const TORQUES: [&str; 2] = ["shoulder_torque", "elbow_torque"];
/// Where estimators with a start begin, relative to the truth.
const START_SHARE: f64 = 0.55;
/// Prior: a number to start from, information 1e-6/a².
const FLAT_PRIOR_RELATIVE_SD: f64 = 1000.0;
/// Sigma of a momentum called exact, relative: far below any sensor, far above rounding.
const EXACT: f64 = 1e-8;

/// Sigma of the torque sensors' common scale where a method models one, and of what is believed of
/// the momentum then; relative.
const TORQUE_SCALE_SD: f64 = 1e-3;
const BELIEVED_MOMENTUM_SD: f64 = 0.1;

const NAMES: [&str; 9] = ["a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9"];

/// Which model a method fits, and with it which bound it is measured against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Momentum, known exactly.
    Momentum,
    /// The same with `a4 a7 = a5 a6`.
    RankOne,
    /// Motion and torques, momentum unknown.
    Torque,
    /// The same, the torque sensors' common scale known to `TORQUE_SCALE_SD`.
    ScaledTorque,
    /// Motion, torques and the momentum.
    Joint,
}

/// An arm, its experiment, and the prior knowledge of the estimators; `P` parameters, `A = P + 1`.
#[derive(Clone, Debug)]
pub struct Inertial<const P: usize, const A: usize> {
    pub name: &'static str,
    /// With its controllers, sensors, initial momentum and duration.
    pub plant: Plant,
    pub settings: InertialSettings<P>,
    /// How measurements become the estimators' samples.
    pub wiring: fn(MomentumSample) -> MomentumSample,
    estimators: Vec<Estimator<P, A>>,
    methods: Vec<Method>,
}

/// One record and what the estimators know with it.
pub(crate) struct Record {
    pub samples: Vec<ArmSample>,
    pub motions: Vec<MomentumSample>,
    pub unknown: Unknown,
}

/// What is drawn anew for every record besides the noise: by so much, relative, the torque sensors
/// and the belief of the momentum are off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Unknown {
    pub torque_scale: f64,
    pub momentum: f64,
}

impl Unknown {
    fn of_record(seed: u64, record: usize) -> Self {
        let stream = Stream::new(seed, &format!("record{record}.unknown"));
        Self { torque_scale: TORQUE_SCALE_SD * stream.normal(0), momentum: BELIEVED_MOMENTUM_SD * stream.normal(1) }
    }
}

impl Inertial<8, 9> {
    /// Table II, trajectory B, 60 s, momentum exact.
    pub fn bp1a() -> Self {
        Self::new("bp1a", built_in("free_floating_arm"), methods::before_capture())
    }
}

impl Inertial<9, 10> {
    /// The same arm holding 150 kg off its axis, 120 s.
    pub fn mated() -> Self {
        Self::new("bp1a mated", built_in("mated"), methods::after_capture())
    }
}

impl<const P: usize, const A: usize> Inertial<P, A> {
    fn new(name: &'static str, plant: Plant, estimators: Vec<Estimator<P, A>>) -> Self {
        let settings = InertialSettings {
            h_nms: number(&plant, "initial.momentum.z"),
            sigma_h_nms: 0.0,
            sigma: sigma(&plant),
            prior_alpha: truth(&plant) * START_SHARE,
            prior_relative_sd: FLAT_PRIOR_RELATIVE_SD,
        };
        let methods = estimators.iter().map(|estimator| estimator.method).collect();
        Self { name, plant, settings, wiring: |measured| measured, estimators, methods }
    }

    /// The same with these methods only, in the order given.
    ///
    /// # Panics
    /// There is no method of such a name.
    #[must_use]
    pub fn only(mut self, names: &[&str]) -> Self {
        let find = |name: &&str| {
            let found = self.estimators.iter().find(|estimator| estimator.method.name == *name);
            found.cloned().unwrap_or_else(|| panic!("no method '{name}'"))
        };
        self.estimators = names.iter().map(find).collect();
        self.methods = self.estimators.iter().map(|estimator| estimator.method).collect();
        self
    }

    /// The same arm and sensors in another experiment.
    #[must_use]
    pub fn flying(self, plant: Plant) -> Self {
        Self { plant, ..self }
    }

    /// The same from another start, relative to the truth.
    #[must_use]
    pub fn starting_at(mut self, share: f64) -> Self {
        self.settings.prior_alpha = truth(&self.plant) * share;
        self
    }

    /// What gyro and encoders say.
    pub fn record(&self, seed: u64, record: usize) -> Vec<MomentumSample> {
        self.arm_record(seed, record).into_iter().map(|sample| sample.motion).collect()
    }

    /// What all sensors say.
    pub fn arm_record(&self, seed: u64, record: usize) -> Vec<ArmSample> {
        let mut simulator = simulator(&self.plant, seed, record);
        (0..periods(&self.plant)).map(|_| self.arm_sample(simulator.step())).collect()
    }

    fn arm_sample(&self, row: &Row) -> ArmSample {
        let value = |name: &str| row.value(channel(&self.plant, name));
        let [omega0_z_rad_s, rate_1, rate_2, angle_1, angle_2] = CHANNELS.map(value);
        let motion =
            MomentumSample { omega0_z_rad_s, joint_rate_rad_s: [rate_1, rate_2], joint_angle_rad: [angle_1, angle_2] };
        ArmSample { motion, torque_n_m: TORQUES.map(value) }
    }

    /// What perfect sensors would say, the loop closed over them.
    #[must_use]
    pub fn noise_free(&self) -> Vec<MomentumSample> {
        self.perfect().into_iter().map(|sample| sample.motion).collect()
    }

    /// What all perfect sensors would say.
    pub(crate) fn perfect(&self) -> Vec<ArmSample> {
        self.without_noise().arm_record(0, 0)
    }

    fn without_noise(&self) -> Self {
        Self { plant: without_noise(&self.plant), ..self.clone() }
    }

    fn wired(&self, mut samples: Vec<ArmSample>) -> Record {
        samples.iter_mut().for_each(|sample| sample.motion = (self.wiring)(sample.motion));
        let motions = samples.iter().map(|sample| sample.motion).collect();
        Record { motions, samples, unknown: Unknown::default() }
    }

    fn momentum(&self) -> KnownMomentum {
        KnownMomentum { h_nms: self.settings.h_nms, sigma_h_nms: self.settings.sigma_h_nms }
    }

    fn interval_s(&self) -> f64 {
        self.plant.simulation.period_s
    }

    fn torque_sigma_n_m(&self) -> f64 {
        sample_sigma(&self.plant, TORQUES[0])
    }

    fn smoother_settings(&self, momentum_known: bool) -> SmootherSettings {
        let h_nms = self.settings.h_nms;
        SmootherSettings {
            sigma: self.settings.sigma,
            torque_sigma_n_m: self.torque_sigma_n_m(),
            interval_s: self.interval_s(),
            momentum_nms: momentum_known.then_some((h_nms, EXACT * h_nms.abs())),
        }
    }

    fn answer(&self, estimate: &Estimate<P>) -> Answer {
        let found = |i: usize| Found { value: estimate.alpha[i], sigma: Some(estimate.covariance[(i, i)].sqrt()) };
        Answer {
            found: (0..P).map(|i| Some(found(i))).collect(),
            nees: nees(&(estimate.alpha - truth(&self.plant)), &estimate.covariance),
            spurious: 0,
            ..Answer::default()
        }
    }

    fn momentum_information(&self) -> FisherInformation<P> {
        let (truth, sigma) = (truth::<P>(&self.plant), sigma(&self.plant).in_channel_order());
        let mut information = FisherInformation::<P>::default();
        for sample in self.noise_free() {
            let row = noisy_momentum_row::<P>(&sample, number(&self.plant, "initial.momentum.z"), &sigma);
            information.push(&row.regressor, row.residual_variance(&truth));
        }
        information
    }

    fn bound(
        &self,
        model: Model,
        smoother: fn(&Self, &[ArmSample], bool) -> Option<SMatrix<f64, P, P>>,
    ) -> Option<SVector<f64, P>> {
        let covariance = match model {
            Model::Momentum => self.momentum_information().bound()?,
            Model::RankOne => methods::rank_one_bound(&truth(&self.plant), &self.momentum_information().bound()?)?,
            Model::Torque => smoother(self, &self.perfect(), false)?,
            Model::ScaledTorque => {
                let truth = truth::<P>(&self.plant);
                let scale = truth * truth.transpose() * (TORQUE_SCALE_SD * TORQUE_SCALE_SD);
                smoother(self, &self.perfect(), false)? + scale
            }
            Model::Joint => smoother(self, &self.perfect(), true)?,
        };
        Some(covariance.diagonal().map(f64::sqrt))
    }

    /// Bound of motion and torques together along `perfect`; `X = P + 5`.
    fn smoother_bound<const X: usize>(
        &self,
        perfect: &[ArmSample],
        momentum_known: bool,
    ) -> Option<SMatrix<f64, P, P>> {
        let settings = SmootherSettings { sigma: sigma(&self.plant), ..self.smoother_settings(momentum_known) };
        let mut steps = vec![SmootherStep::<X>::default(); perfect.len()];
        arm_smoother::bound(perfect, &truth::<P>(&self.plant), &settings, &mut steps).ok()
    }
}

impl<const P: usize, const A: usize> Benchmark for Inertial<P, A> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bound) = (truth::<P>(&self.plant), self.momentum_information().sigmas()?);
        Some((0..P).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &[Method] {
        &self.methods
    }

    fn method_bounds(&self) -> Option<Vec<Vec<f64>>> {
        let mut known: Vec<(Model, SVector<f64, P>)> = Vec::new();
        let of = |estimator: &Estimator<P, A>| {
            if let Some((_, bound)) = known.iter().find(|(model, _)| *model == estimator.model) {
                return Some(bound.as_slice().to_vec());
            }
            let bound = self.bound(estimator.model, estimator.smoother_bound)?;
            known.push((estimator.model, bound));
            Some(bound.as_slice().to_vec())
        };
        self.estimators.iter().map(of).collect()
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let unknown = Unknown::of_record(seed, record);
        let record = Record { unknown, ..self.wired(self.arm_record(seed, record)) };
        self.estimators.iter().map(|estimator| (estimator.find)(self, &record)).collect()
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.wired(self.arm_record(0, 0));
        let samples = record.samples.len();
        self.estimators.iter().map(|estimator| cost(samples, || (estimator.find)(self, &record), |_| ())).collect()
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

/// The arm as the closed forms describe it, its base measured from its own centre of mass.
///
/// # Panics
/// The plant has no hub with two links: it is not the benchmark's.
#[must_use]
pub fn planar_arm(plant: &Plant) -> PlanarArm {
    let at = |name: &str| number(plant, name);
    PlanarArm {
        mass_kg: ["hub.mass", "link_1.mass", "link_2.mass"].map(at),
        inertia_com_kg_m2: ["hub.inertia.zz", "link_1.inertia.zz", "link_2.inertia.zz"].map(at),
        base_to_joint_m: ["x", "y"]
            .map(|axis| at(&format!("shoulder.position.{axis}")) - at(&format!("hub.com.{axis}"))),
        joint_to_com_m: ["link_1.com.x", "link_2.com.x"].map(at),
        com_to_next_m: at("elbow.position.x") - at("link_1.com.x"),
    }
}

/// Standard deviation of one sample of each sensor; quantisation adds lsb²/12.
#[must_use]
pub fn sigma(plant: &Plant) -> ChannelSigma {
    let [omega0_rad_s, rate_1, rate_2, angle_1, angle_2] = CHANNELS.map(|name| sample_sigma(plant, name));
    ChannelSigma { omega0_rad_s, joint_rate_rad_s: [rate_1, rate_2], joint_angle_rad: [angle_1, angle_2] }
}

/// The commanded motion of the two joints.
///
/// # Panics
/// The plant's controllers do not follow Fourier references of one period and five harmonics: it is
/// not the benchmark's.
#[must_use]
pub fn commanded(plant: &Plant) -> FourierTrajectory {
    let five = |values: &[Quantity]| -> [f64; 5] {
        core::array::from_fn(|k| values.get(k).map_or(0.0, |quantity| quantity.value))
    };
    let joint = |index: usize| {
        let terms = plant.controllers.get(index).map_or(&[][..], |controller| &controller.reference);
        let fourier = terms.iter().find_map(|term| match &term.kind {
            SignalKind::Fourier { offset, period_s, sine, cosine } => Some((
                period_s.value,
                FourierJoint { offset_rad: offset.value, cosine_rate_rad_s: five(sine), sine_rate_rad_s: five(cosine) },
            )),
            _ => None,
        });
        fourier.expect("the benchmark's joints follow Fourier references")
    };
    let ((period_s, first), (_, second)) = (joint(0), joint(1));
    FourierTrajectory { period_s, joints: [first, second] }
}
