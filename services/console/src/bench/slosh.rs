//! BP2: slosh mass, stiffness and damping from the seed's sine of thrust and an accelerometer.
//!
//! Beside the estimator that flies stands the published one, total least squares on a twice integrated accelerometer,
//! so that its failure on the damping is seen on the same records:
//!
//! `a − f/m0 = −c* v0 − k* x0 + c*/(m0+ms) ∫f + k*/(m0+ms) ∬f`,  `c* = cs/μ`, `k* = ks/μ`, `ms = k*/a4 − m0`.

use super::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use super::simulated::{built_in, channel, number, periods, sample_sigma, simulator};
use crate::truth;
use estimation::consistency::nees;
use estimation::total_least_squares::TotalLeastSquares;
use nalgebra::{Vector3, Vector4};
use physics::slosh::SloshParameters;
use physics::slosh_arc::SloshSample;
use physics::slosh_estimator::{SloshEstimator, SloshPlan, SloshSettings, predicted_sigma};
use physics::slosh_likelihood::{SloshHypothesis, SloshUnknowns};
use plant::description::Plant;

const ACCELEROMETER: &str = "accelerometer";
const PARAMETERS: usize = 3;
const NAMES: [&str; PARAMETERS] = ["m_s", "k_s", "c_s"];

/// Table VI of the paper, TLS.
const TABLE_VI_PERCENT: &[f64] = &[2.44, 1.08, 348.84];
const METHODS: &[Method] = &[
    Method { name: "TLS (seed form)", paper_percent: TABLE_VI_PERCENT },
    Method { name: "ML arc", paper_percent: TABLE_VI_PERCENT },
];
/// Place of the published estimator in the list of methods.
pub const SEED_FORM: usize = 0;
/// Place of the estimator that flies.
pub const FLIGHT: usize = 1;

/// A tank and what the estimator is told.
#[derive(Clone, Debug)]
pub struct Slosh {
    /// With its thrust, accelerometer and duration.
    pub plant: Plant,
    pub settings: SloshSettings,
    /// Of one accelerometer sample, as the estimator believes.
    pub sigma_m_s2: f64,
    /// Samples by which the estimator's thrust lags the true one.
    pub thrust_lag_samples: usize,
}

impl Slosh {
    /// Table V: 44 N at 0.01 Hz for 1000 s, sampled at 10 Hz, quiescent start.
    pub fn bp2() -> Self {
        let plant = built_in("tank_1d");
        Self {
            settings: SloshSettings { base_mass_kg: base_mass_kg(&plant), unknowns: SloshUnknowns::Parameters },
            sigma_m_s2: sample_sigma(&plant, ACCELEROMETER),
            thrust_lag_samples: 0,
            plant,
        }
    }

    /// Mass, stiffness and damping of the slosh mass that is simulated.
    fn truth(&self) -> Vector3<f64> {
        Vector3::from(truth::tank(&self.plant).expect("the benchmark's plant has one tank on a spring"))
    }

    /// Thrust and accelerometer, as the estimator receives them.
    pub fn record(&self, seed: u64, record: usize) -> Vec<SloshSample> {
        let (mut simulator, channel) = (simulator(&self.plant, seed, record), channel(&self.plant, ACCELEROMETER));
        let step = |_| {
            let row = simulator.step();
            SloshSample {
                interval_s: self.plant.simulation.period_s,
                force_n: row.commands[0],
                acceleration_m_s2: row.value(channel),
                sigma_m_s2: self.sigma_m_s2,
            }
        };
        let mut samples: Vec<SloshSample> = (0..periods(&self.plant)).map(step).collect();
        for k in (self.thrust_lag_samples..samples.len()).rev() {
            samples[k].force_n = samples[k - self.thrust_lag_samples].force_n;
        }
        samples
    }

    fn flight(&self, record: &[SloshSample]) -> Box<SloshEstimator> {
        let mut estimator = Box::new(SloshEstimator::new(self.settings));
        for sample in record {
            estimator.push(sample).expect("simulated samples are finite");
        }
        estimator
    }

    fn flight_answer(&self, estimator: &mut SloshEstimator) -> Answer {
        let Ok(estimate) = estimator.estimate() else { return Answer::none(PARAMETERS) };
        let SloshParameters { slosh_mass_kg, stiffness_n_m, damping_n_s_m } = estimate.hypothesis.parameters;
        let values = Vector3::new(slosh_mass_kg, stiffness_n_m, damping_n_s_m);
        let found = |i: usize| Found { value: values[i], sigma: Some(estimate.sigmas()[i]) };
        Answer {
            found: (0..PARAMETERS).map(|i| Some(found(i))).collect(),
            nees: nees(&(values - self.truth()), &estimate.covariance),
            spurious: 0,
        }
    }

    fn seed_form(&self, record: &[SloshSample]) -> TotalLeastSquares<4, 5> {
        let mut factor = TotalLeastSquares::default();
        let (mut velocity, mut impulse) = (Integrals::default(), Integrals::default());
        for SloshSample { interval_s, force_n, acceleration_m_s2, .. } in record {
            let dt = *interval_s;
            let (v, x) = velocity.at_half(*acceleration_m_s2, dt);
            let (p, q) = impulse.at_half(*force_n, dt);
            factor.push(&Vector4::new(-v, -x, p, q), acceleration_m_s2 - force_n / self.settings.base_mass_kg);
            velocity.advance(*acceleration_m_s2, dt);
            impulse.advance(*force_n, dt);
        }
        factor
    }

    fn seed_form_answer(&self, factor: &TotalLeastSquares<4, 5>) -> Answer {
        let Ok(alpha) = factor.estimate() else { return Answer::none(PARAMETERS) };
        let (m_0, c_star, k_star) = (self.settings.base_mass_kg, alpha[0], alpha[1]);
        let m_s = k_star / alpha[3] - m_0;
        let mu = m_0 * m_s / (m_0 + m_s);
        Answer::bare([m_s, k_star * mu, c_star * mu])
    }
}

impl Benchmark for Slosh {
    fn name(&self) -> &'static str {
        "bp2"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let truth = self.truth();
        let parameters = SloshParameters { slosh_mass_kg: truth[0], stiffness_n_m: truth[1], damping_n_s_m: truth[2] };
        let hypothesis = SloshHypothesis { parameters, ..Default::default() };
        let settings = SloshSettings { base_mass_kg: base_mass_kg(&self.plant), unknowns: SloshUnknowns::Parameters };
        let interval_s = self.plant.simulation.period_s;
        let plan = SloshPlan {
            amplitude_n: number(&self.plant, "thrust.command.1.amplitude"),
            frequency_hz: number(&self.plant, "thrust.command.1.frequency"),
            duration_s: self.plant.simulation.duration_s,
            interval_s,
            velocity_random_walk_m_s_per_sqrt_s: sample_sigma(&self.plant, ACCELEROMETER) * interval_s.sqrt(),
        };
        let bound = predicted_sigma(&hypothesis, &settings, &plan)?;
        Some((0..PARAMETERS).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let record = self.record(seed, record);
        vec![self.seed_form_answer(&self.seed_form(&record)), self.flight_answer(&mut self.flight(&record))]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        vec![
            cost(record.len(), || self.seed_form(&record), |factor| factor.estimate()),
            cost(record.len(), || self.flight(&record), |estimator| estimator.estimate()),
        ]
    }
}

/// Of the craft without the slosh mass.
fn base_mass_kg(plant: &Plant) -> f64 {
    number(plant, "craft.mass")
}

/// First and second integral of a quantity held over each interval.
#[derive(Clone, Copy, Default)]
struct Integrals {
    first: f64,
    second: f64,
}

impl Integrals {
    fn at_half(&self, held: f64, dt: f64) -> (f64, f64) {
        (self.first + held * dt / 2.0, self.second + self.first * dt / 2.0 + held * dt * dt / 8.0)
    }

    fn advance(&mut self, held: f64, dt: f64) {
        self.second += self.first * dt + held * dt * dt / 2.0;
        self.first += held * dt;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::simulated::without_noise;

    #[test]
    fn the_published_form_is_right_without_noise_so_its_failure_is_the_noise() {
        let slosh = Slosh::bp2();
        let quiet = Slosh { plant: without_noise(&slosh.plant), ..slosh.clone() };
        let record = quiet.record(0, 0);
        let answer = slosh.seed_form_answer(&slosh.seed_form(&record));
        for (found, truth) in answer.found.iter().zip(slosh.truth().iter()) {
            let value = found.expect("generic").value;
            // The mean acceleration stands for the one at mid-interval: (ω dt)²/24 = 2e-6, times the gain 36 of ms.
            assert!((value / truth - 1.0).abs() < 1e-3, "{value} {truth}");
        }
    }
}
