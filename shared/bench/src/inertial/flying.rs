//! BP1B: the same arm on a base that thrusts. Eight parameters, all linear, the total mass among
//! them, absolute.
//!
//! The bound contains the noise of every sensor and of the actuators, unlike the bound with perfect
//! kinematics; it comes from a covariance recursion of its own along the motion with perfect
//! sensors (`crate::flying_bound`), its prior a hundred times wider than what is found.

use super::{CHANNELS, TORQUES, planar_arm, sigma};
use crate::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use crate::flying_bound;
use crate::flying_filter::{FlyingFilter, FlyingSample, FlyingSettings, weak_form};
use crate::simulated::{built_in, channel, number, periods, sample_sigma, simulator, without_noise};
use dynamics::description::{Plant, Quantity};
use estimation::consistency::nees;
use estimation::weighted_least_squares::Estimate;
use physics::free_floating::PlanarArm;
use physics::free_flying::{FlyingGeometry, Pi, parameters};
use physics::momentum::MomentumSample;

const NAMES: [&str; 8] = ["M", "pi2", "pi3", "pi4", "pi5", "pi6", "pi7", "pi8"];
const METHODS: &[Method] =
    &[Method { name: "de-weak", paper_percent: &[] }, Method { name: "ukf", paper_percent: &[] }];
const ACCELEROMETER: [&str; 2] = ["accelerometer_x", "accelerometer_y"];
const BASE_ACTUATORS: [&str; 3] = ["force_x", "force_y", "torque"];
/// Where the filter would begin if the record said nothing, and how well that is believed.
const START_SHARE: f64 = 0.55;
const FLYING_PRIOR_RELATIVE_SD: f64 = 0.3;
/// Windows of the weak form; those of the start are shorter than the stretch they see.
const WINDOW_S: f64 = 4.0;
const START_WINDOW_S: f64 = 2.0;
const START_S: f64 = 20.0;
/// Sigmas of the start: its information is counted twice by a hundredth.
const START_SIGMAS: f64 = 10.0;
/// Prior of the bound, relative.
const BOUND_PRIOR: f64 = 0.01;

/// An arm on a base with thrusters, and its experiment.
#[derive(Clone, Debug)]
pub struct Flying {
    pub plant: Plant,
}

impl Flying {
    /// Trajectory B, two forces and a torque on the base, 60 s.
    pub fn bp1b() -> Self {
        Self { plant: built_in("free_flying_arm") }
    }

    /// The arm as the closed form describes it, and the base's centre of mass from the
    /// accelerometer.
    fn arm(&self) -> (PlanarArm, [f64; 2]) {
        let base_com_m = ["hub.com.x", "hub.com.y"].map(|name| number(&self.plant, name));
        (planar_arm(&self.plant), base_com_m)
    }

    /// π of the arm that is simulated.
    #[must_use]
    pub fn truth(&self) -> Pi {
        let (arm, base_com_m) = self.arm();
        parameters(&arm, base_com_m)
    }

    fn settings(&self, start: Pi, start_sd: Pi) -> FlyingSettings {
        let (arm, base_com_m) = self.arm();
        let of_actuator = |name: &str| number(&self.plant, &format!("{name}.noise"));
        let [force_x, force_y, torque] = BASE_ACTUATORS.map(of_actuator);
        let [tau_1, tau_2] = TORQUES.map(|name| sample_sigma(&self.plant, name));
        FlyingSettings {
            geometry: FlyingGeometry::of(&arm, base_com_m),
            start,
            start_sd,
            scale: self.truth().abs(),
            sigma: sigma(&self.plant),
            acceleration_sigma_m_s2: sample_sigma(&self.plant, ACCELEROMETER[0]),
            wrench_sigma: [force_x, force_y, torque, tau_1, tau_2],
            interval_s: self.plant.simulation.period_s,
        }
    }

    /// Readings of the sensors and commands to the base.
    pub fn record(&self, seed: u64, record: usize) -> Vec<FlyingSample> {
        let mut simulator = simulator(&self.plant, seed, record);
        let motion = CHANNELS.map(|name| channel(&self.plant, name));
        let accelerometer = ACCELEROMETER.map(|name| channel(&self.plant, name));
        let torques = TORQUES.map(|name| channel(&self.plant, name));
        let commands = BASE_ACTUATORS.map(|name| {
            let found = self.plant.actuators.iter().position(|actuator| actuator.name == name);
            found.unwrap_or_else(|| panic!("the plant '{}' has no actuator '{name}'", self.plant.name))
        });
        let step = |_| {
            let row = simulator.step();
            let [omega0_z_rad_s, rate_1, rate_2, angle_1, angle_2] = motion.map(|channel| row.value(channel));
            let [force_x, force_y, torque] = commands.map(|actuator| row.commands[actuator]);
            let [tau_1, tau_2] = torques.map(|channel| row.value(channel));
            FlyingSample {
                motion: MomentumSample {
                    omega0_z_rad_s,
                    joint_rate_rad_s: [rate_1, rate_2],
                    joint_angle_rad: [angle_1, angle_2],
                },
                acceleration_m_s2: accelerometer.map(|channel| row.value(channel)),
                wrench: [force_x, force_y, torque, tau_1, tau_2],
            }
        };
        (0..periods(&self.plant)).map(step).collect()
    }

    fn perfect(&self) -> Vec<FlyingSample> {
        let mut plant = without_noise(&self.plant);
        plant.actuators.iter_mut().for_each(|actuator| actuator.noise = Quantity::known(0.0));
        Self { plant }.record(0, 0)
    }

    fn weak(&self, record: &[FlyingSample], window_s: f64) -> Option<Estimate<8>> {
        let truth = self.truth();
        let settings = self.settings(truth, truth);
        weak_form(record, &settings, 2 * (0.5 * window_s / settings.interval_s).round() as usize)
    }

    /// The filter's estimate from the record alone.
    pub fn filtered(&self, record: &[FlyingSample]) -> Option<Estimate<8>> {
        let truth = self.truth();
        let stretch = ((START_S / self.plant.simulation.period_s) as usize).min(record.len());
        let prior_sd = truth.map(|value| FLYING_PRIOR_RELATIVE_SD * value.abs());
        let own = self.weak(&record[..stretch], START_WINDOW_S).and_then(|found| {
            let sd = found.covariance.diagonal().map(|variance| START_SIGMAS * variance.sqrt());
            sd.iter().zip(prior_sd.iter()).all(|(sd, prior)| sd < prior).then_some((found.alpha, sd))
        });
        let (start, sd) = own.unwrap_or((truth * START_SHARE, prior_sd));
        let mut filter = FlyingFilter::new(&self.settings(start, sd));
        record.iter().try_for_each(|sample| filter.push(sample)).ok()?;
        Some(filter.estimate())
    }

    /// Covariance no estimator can beat, from a recursion of its own.
    #[must_use]
    pub fn bound(&self) -> Option<Estimate<8>> {
        let truth = self.truth();
        let settings = self.settings(truth, truth.map(|value| BOUND_PRIOR * value.abs()));
        Some(Estimate { alpha: truth, covariance: flying_bound::bound(&self.perfect(), &settings)? })
    }

    fn answer(&self, estimate: Option<Estimate<8>>, honest: bool) -> Answer {
        let Some(estimate) = estimate else { return Answer::none(8) };
        let sigma = |i: usize| honest.then(|| estimate.covariance[(i, i)].sqrt());
        Answer {
            found: (0..8).map(|i| Some(Found { value: estimate.alpha[i], sigma: sigma(i) })).collect(),
            nees: honest.then(|| nees(&(estimate.alpha - self.truth()), &estimate.covariance)).flatten(),
            spurious: 0,
            ..Answer::default()
        }
    }
}

impl Benchmark for Flying {
    fn name(&self) -> &'static str {
        "bp1b"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bound) = (self.truth(), self.bound()?.covariance.diagonal().map(f64::sqrt));
        Some((0..8).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &[Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let record = self.record(seed, record);
        vec![self.answer(self.weak(&record, WINDOW_S), false), self.answer(self.filtered(&record), true)]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        vec![
            cost(record.len(), || self.weak(&record, WINDOW_S), |_| ()),
            cost(record.len(), || self.filtered(&record), |_| ()),
        ]
    }
}
