//! Trajectory B with two unmodelled effects: the gyro is 5 ms late and an external torque of 1e-3 N
//! m acts on the base.
//!
//! Plain weighted least squares beside the fit with the two columns, each against the bound of its
//! own model: the eight alone, as if nothing were hidden, and all ten together.

use super::{Inertial, NAMES, truth};
use crate::campaign::{Answer, Benchmark, Campaign, Cost, Found, Method, Parameter, cost};
use crate::momentum_extended::{EXTERNAL_TORQUE, LATENCY, with_latency_and_drift};
use crate::momentum_methods::{KnownMomentum, weighted};
use estimation::consistency::nees;
use estimation::weighted_least_squares::Estimate;
use nalgebra::SVector;
use physics::momentum::MomentumSample;
use plant_file::parse_effect;

const HIDDEN: [&str; 2] = ["sensor_delay@sensor:gyro delay=5ms", "constant_torque@body:hub torque_z=0.001N*m"];
const LATE_S: f64 = 5e-3;
const TORQUE_N_M: f64 = 1e-3;
const METHODS: &[Method] = &[
    Method { name: "momentum-wls-bc", paper_percent: &[] },
    Method { name: "with latency, drift", paper_percent: &[] },
];
/// What a record must be recovered to.
const LATENCY_LIMIT_S: f64 = 0.5e-3;
const TORQUE_LIMIT_N_M: f64 = 2e-4;

/// The arm as modelled, and as it is.
#[derive(Clone, Debug)]
pub struct Late {
    modelled: Inertial<8, 9>,
    actual: Inertial<8, 9>,
}

impl Late {
    /// The arm of BP1A with hidden gyro latency and external torque.
    pub fn bp1a() -> Self {
        let modelled = Inertial::bp1a();
        let mut actual = modelled.clone();
        for text in HIDDEN {
            let effect = parse_effect(&actual.plant, text).expect("the benchmark's plant has these sites");
            actual.plant.effects.push(effect);
        }
        Self { modelled, actual }
    }

    fn truth(&self) -> SVector<f64, 10> {
        let alpha = truth::<8>(&self.modelled.plant);
        SVector::from_fn(|i, _| match i {
            LATENCY => LATE_S,
            EXTERNAL_TORQUE => TORQUE_N_M,
            _ => alpha[i],
        })
    }

    fn momentum(&self) -> KnownMomentum {
        self.modelled.momentum()
    }

    fn with_columns(&self, samples: &[MomentumSample]) -> Option<(Estimate<10>, f64)> {
        let settings = &self.modelled.settings;
        let (interval_s, start) = (self.modelled.interval_s(), &settings.prior_alpha);
        with_latency_and_drift(samples, interval_s, self.momentum(), &settings.sigma, start).ok()
    }

    fn without(&self, samples: &[MomentumSample]) -> Option<(Estimate<8>, f64)> {
        let settings = &self.modelled.settings;
        weighted(samples, self.momentum(), &settings.sigma, &settings.prior_alpha).ok()
    }
}

impl Benchmark for Late {
    fn name(&self) -> &'static str {
        "bp1a with 5 ms of gyro latency and 1e-3 N m from outside"
    }

    /// The bound: covariance of the fit along the motion with perfect sensors.
    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, perfect) = (self.truth(), self.actual.noise_free());
        let bound = self.with_columns(&perfect)?.0.covariance;
        let name = |i: usize| match i {
            LATENCY => "latency",
            EXTERNAL_TORQUE => "torque",
            _ => NAMES[i],
        };
        Some((0..10).map(|i| Parameter { name: name(i), truth: truth[i], bound: bound[(i, i)].sqrt() }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn method_bounds(&self) -> Option<Vec<Vec<f64>>> {
        let ten: Vec<f64> = self.parameters()?.iter().map(|parameter| parameter.bound).collect();
        let eight = self.actual.momentum_information().sigmas()?;
        // the plain fit says nothing of the last two
        let plain = eight.iter().chain(&ten[LATENCY..]).copied().collect();
        Some(vec![plain, ten])
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let samples = self.actual.record(seed, record);
        let plain = self.without(&samples).map_or_else(
            || Answer::none(10),
            |(estimate, _)| {
                let found = |i: usize| {
                    let sigma = (i < 8).then(|| estimate.covariance[(i, i)].sqrt())?;
                    Some(Found { value: estimate.alpha[i], sigma: Some(sigma) })
                };
                Answer { found: (0..10).map(found).collect(), ..Answer::default() }
            },
        );
        let full = self.with_columns(&samples).map_or_else(
            || Answer::none(10),
            |(estimate, _)| {
                let found = |i: usize| {
                    Some(Found { value: estimate.alpha[i], sigma: Some(estimate.covariance[(i, i)].sqrt()) })
                };
                let error = nees(&(estimate.alpha - self.truth()), &estimate.covariance);
                Answer { found: (0..10).map(found).collect(), nees: error, ..Answer::default() }
            },
        );
        vec![plain, full]
    }

    fn costs(&self) -> Vec<Cost> {
        let samples = self.actual.record(0, 0);
        vec![
            cost(samples.len(), || self.without(&samples), |_| ()),
            cost(samples.len(), || self.with_columns(&samples), |_| ()),
        ]
    }

    fn remarks(&self, campaign: &Campaign) -> Vec<String> {
        let trials = campaign.trials.min(200);
        let (mut inside, mut blind, mut seeing) = (0, 0.0, 0.0);
        let mut outside_band = 0;
        for record in 0..trials {
            let samples = self.actual.record(campaign.seed, record);
            let (Some((_, without)), Some((found, with))) = (self.without(&samples), self.with_columns(&samples))
            else {
                continue;
            };
            let late = (found.alpha[LATENCY] - LATE_S).abs() <= LATENCY_LIMIT_S;
            let torque = (found.alpha[EXTERNAL_TORQUE] - TORQUE_N_M).abs() <= TORQUE_LIMIT_N_M;
            inside += usize::from(late && torque);
            outside_band += usize::from(!(0.95..=1.05).contains(&with));
            blind += without / trials as f64;
            seeing += with / trials as f64;
        }
        vec![format!(
            "Of {trials} records {inside} give latency within {:.1} ms and torque within {TORQUE_LIMIT_N_M:.0e} N m; mean chi2/N {blind:.3} \
             without the two columns, {seeing:.3} with them ({outside_band} outside 0.95 to 1.05).",
            1e3 * LATENCY_LIMIT_S
        )]
    }
}
