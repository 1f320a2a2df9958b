//! The same estimator without a designed input: the arm holds its posture, then slews one joint
//! slowly, as in station keeping and a move.
//!
//! The prior is what is believed of the arm, drawn anew for every record. Each parameter is said to
//! be identified, left at its prior, or not excited, by what the data did to the prior's sigma.

use super::{Inertial, NAMES, sigma, truth};
use crate::campaign::{Answer, Benchmark, Campaign, Cost, Found, Method, Parameter, cost};
use dynamics::description::{Quantity, Signal, SignalKind};
use dynamics::noise::Stream;
use estimation::consistency::nees;
use estimation::cramer_rao::FisherInformation;
use estimation::identifiability::Identifiability;
use nalgebra::SVector;
use physics::inertial_estimator::{InertialEstimate, InertialEstimator, InertialSettings};
use physics::momentum::{MomentumSample, noisy_momentum_row};

const METHODS: &[Method] = &[Method { name: "momentum-wls-bc-recursive", paper_percent: &[] }];
/// Sigma of the prior, relative.
const OPERATIONAL_PRIOR_RELATIVE_SD: f64 = 0.05;
/// The elbow's posture, and the shoulder's slow move.
const POSTURE_RAD: [f64; 2] = [0.4, -0.9];
const SLEW_RAD: f64 = 0.5;
const SLEW_BEGIN_S: f64 = 20.0;
const SLEW_S: f64 = 25.0;

/// A minute of an ordinary day.
#[derive(Clone, Debug)]
pub struct Operational {
    arm: Inertial<8, 9>,
}

impl Operational {
    /// The arm of BP1A in a posture, with one slow move of the shoulder.
    pub fn bp1a() -> Self {
        let mut arm = Inertial::bp1a();
        let known = Quantity::known;
        let always = |kind| Signal { kind, begin_s: known(0.0), end_s: None };
        for (controller, posture) in arm.plant.controllers.iter_mut().zip(POSTURE_RAD) {
            controller.reference = vec![always(SignalKind::Constant { value: known(posture) })];
        }
        let slew = SignalKind::Slew { size: known(SLEW_RAD), width_s: known(SLEW_S) };
        arm.plant.controllers[0].reference.push(Signal { begin_s: known(SLEW_BEGIN_S), ..always(slew) });
        Self { arm }
    }

    fn settings(&self, stream: Option<&Stream>) -> InertialSettings<8> {
        let drawn = |i: usize| stream.map_or(0.0, |stream| stream.normal(i as u64));
        let truth = truth::<8>(&self.arm.plant);
        let prior_alpha = SVector::from_fn(|i, _| truth[i] * (1.0 + OPERATIONAL_PRIOR_RELATIVE_SD * drawn(i)));
        InertialSettings { prior_alpha, prior_relative_sd: OPERATIONAL_PRIOR_RELATIVE_SD, ..self.arm.settings }
    }

    fn found(&self, samples: &[MomentumSample], settings: &InertialSettings<8>) -> Option<InertialEstimate<8>> {
        let mut estimator = InertialEstimator::new(settings).expect("the momentum of the benchmark is known");
        for sample in samples {
            estimator.push(sample).expect("simulated samples are finite");
        }
        estimator.estimate().ok()
    }
}

impl Benchmark for Operational {
    fn name(&self) -> &'static str {
        "bp1a without a designed input"
    }

    /// Data and prior together.
    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, prior) = (truth::<8>(&self.arm.plant), self.settings(None).prior_sd());
        let (h_nms, channels) = (self.arm.settings.h_nms, sigma(&self.arm.plant).in_channel_order());
        let mut information = FisherInformation::<8>::default();
        (0..8)
            .for_each(|i| information.push(&SVector::from_fn(|j, _| f64::from(u8::from(i == j))), prior[i] * prior[i]));
        for sample in self.arm.noise_free() {
            let row = noisy_momentum_row::<8>(&sample, h_nms, &channels);
            information.push(&row.regressor, row.residual_variance(&truth));
        }
        let bound = information.sigmas()?;
        Some((0..8).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let stream = Stream::new(seed, &format!("record{record}.prior"));
        let found = self.found(&self.arm.record(seed, record), &self.settings(Some(&stream)));
        vec![found.map_or_else(
            || Answer::none(8),
            |found| {
                let sigma = |i: usize| Some(found.covariance[(i, i)].sqrt());
                Answer {
                    found: (0..8).map(|i| Some(Found { value: found.alpha[i], sigma: sigma(i) })).collect(),
                    nees: nees(&(found.alpha - truth(&self.arm.plant)), &found.covariance),
                    ..Answer::default()
                }
            },
        )]
    }

    fn costs(&self) -> Vec<Cost> {
        let (samples, settings) = (self.arm.record(0, 0), self.settings(None));
        vec![cost(samples.len(), || self.found(&samples, &settings), |_| ())]
    }

    fn remarks(&self, campaign: &Campaign) -> Vec<String> {
        let stream = Stream::new(campaign.seed, "record0.prior");
        let settings = self.settings(Some(&stream));
        let Some(found) = self.found(&self.arm.record(campaign.seed, 0), &settings) else { return Vec::new() };
        let prior = settings.prior_sd();
        let said = |i: usize| {
            let ratio = found.noise_covariance[(i, i)].sqrt() / prior[i];
            let word = Identifiability::of(ratio, 1.0).text();
            format!("{} {word} ({ratio:.3})", NAMES[i])
        };
        let all: Vec<String> = (0..8).map(said).collect();
        vec![format!("Record 0, sigma after over sigma before: {}.", all.join(", "))]
    }
}
