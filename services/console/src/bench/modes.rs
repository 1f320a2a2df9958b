//! BP3A: modes of a flexible appendage on a free hub, from ten accelerometers in the free decay after a torque pulse.
//!
//! The truth are the hub-free modes, eigenvalues of the simulated system. The bound is that of the decay with
//! amplitude, phase and bias of every channel unknown.

use super::campaign::{Answer, Benchmark, Cost, Found, Method, Parameter, cost};
use super::simulated::{built_in, number, periods, sample_sigma, simulator, without_noise};
use crate::truth;
use modal::{Config, ModalIdentifier, Mode};
use nalgebra::{SMatrix, SVector};
use physics::appendage::{ChannelAmplitude, FreeDecay, MODES, predicted_sigma};
use plant::description::Plant;

/// Accelerometers along the appendage: all sensors of the plant.
pub const SENSORS: usize = 10;
/// An identified mode farther than this from every true one is not one of them.
const SAME_MODE_SHARE: f64 = 0.05;
const PARAMETERS: usize = 2 * MODES;
const NAMES: [&str; PARAMETERS] = ["f1", "zeta1", "f2", "zeta2"];

/// Table IX of the paper, SSI-COV.
const METHODS: &[Method] = &[Method { name: "SSI-COV streaming", paper_percent: &[0.02, 0.02, 0.00, 0.03] }];

/// An appendage and what the identifier is told.
#[derive(Clone, Debug)]
pub struct Modes {
    /// With its pulse of torque, accelerometers and duration.
    pub plant: Plant,
    pub config: Config,
    /// Where the identifier's segment begins.
    pub segment_start_s: f64,
}

impl Modes {
    /// 2 Nm for one second, five seconds at 200 Hz; the identifier as it flies, order found by itself.
    pub fn bp3a() -> Self {
        let plant = built_in("hub_appendage");
        assert!(plant.sensors.len() == SENSORS);
        let config = Config::new(SENSORS, rate_hz(&plant));
        Self { config, segment_start_s: pulse_end_s(&plant), plant }
    }

    /// Accelerations of the whole record.
    pub fn record(&self, seed: u64, record: usize) -> Vec<[f64; SENSORS]> {
        let mut simulator = simulator(&self.plant, seed, record);
        let step = |_| {
            let row = simulator.step();
            core::array::from_fn(|channel| row.value(channel))
        };
        (0..periods(&self.plant)).map(step).collect()
    }

    /// What perfect sensors would say from the end of the pulse on.
    #[must_use]
    pub fn noise_free_decay(&self) -> Vec<[f64; SENSORS]> {
        let perfect = Self { plant: without_noise(&self.plant), ..self.clone() };
        perfect.record(0, 0).split_off((pulse_end_s(&self.plant) * rate_hz(&self.plant)).round() as usize)
    }

    /// The record as the partition feeds it: the segment is closed while torque acts.
    fn flight(&self, record: &[[f64; SENSORS]]) -> ModalIdentifier {
        let mut identifier = ModalIdentifier::new(self.config.clone());
        identifier.close_segment();
        let first = self.segment_start();
        for (k, sample) in record.iter().enumerate() {
            if k == first {
                identifier.open_segment();
            }
            identifier.push(sample);
        }
        identifier
    }

    /// Sample at which the identifier's segment begins.
    fn segment_start(&self) -> usize {
        (self.segment_start_s * rate_hz(&self.plant)).round() as usize
    }

    /// Modes of hub and appendage together.
    ///
    /// # Panics
    /// The plant has not two modes.
    #[must_use]
    pub fn truth(&self) -> [physics::appendage::Mode; MODES] {
        let found = truth::modes(&self.plant).expect("the benchmark's plant has modes");
        let modes = found
            .chunks_exact(2)
            .map(|mode| physics::appendage::Mode { frequency_hz: mode[0], damping_ratio: mode[1] });
        let modes: Vec<physics::appendage::Mode> = modes.collect();
        modes.try_into().expect("the benchmark's appendage has two modes")
    }

    fn flight_answer(&self, identifier: &mut ModalIdentifier) -> Answer {
        let modes = identifier.identify().unwrap_or_default();
        let matched = match_modes(&self.truth(), &modes);
        let spurious = modes.len() - matched.iter().flatten().count();
        let mut answer = Answer { spurious: spurious as u32, ..Answer::default() };
        let mut nees = Some(0.0);
        for (truth, mode) in self.truth().iter().zip(matched) {
            let Some(mode) = mode else {
                answer.found.extend([None, None]);
                nees = None;
                continue;
            };
            let frequency = Found { value: mode.frequency_hz, sigma: Some(mode.sigma_frequency_hz) };
            let damping = Found { value: mode.damping_ratio, sigma: Some(mode.sigma_damping) };
            answer.found.extend([Some(frequency), Some(damping)]);
            // Only the two variances of a mode are published; f and ζ of a light mode hardly correlate.
            let square = |error: f64, sigma: f64| (error / sigma) * (error / sigma);
            nees = nees.map(|sum| {
                sum + square(mode.frequency_hz - truth.frequency_hz, mode.sigma_frequency_hz)
                    + square(mode.damping_ratio - truth.damping_ratio, mode.sigma_damping)
            });
        }
        answer.nees = nees;
        answer
    }

    /// Amplitudes of the noise-free decay, by least squares on the true poles.
    fn amplitudes(&self) -> Option<Vec<ChannelAmplitude>> {
        let (decay, truth) = (self.noise_free_decay(), self.truth());
        let (mut gram, mut moments) = (SMatrix::<f64, 4, 4>::zeros(), [SVector::<f64, 4>::zeros(); SENSORS]);
        for (k, sample) in decay.iter().enumerate() {
            let columns = decay_columns(&truth, k as f64 / rate_hz(&self.plant));
            gram += columns * columns.transpose();
            for (moment, value) in moments.iter_mut().zip(sample) {
                *moment += columns * *value;
            }
        }
        let factor = gram.cholesky()?;
        let amplitude = |moment: &SVector<f64, 4>| {
            let fit = factor.solve(moment);
            ChannelAmplitude { cosine_m_s2: [fit[0], fit[2]], sine_m_s2: [fit[1], fit[3]] }
        };
        Some(moments.iter().map(amplitude).collect())
    }
}

impl Benchmark for Modes {
    fn name(&self) -> &'static str {
        "bp3a"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let decay = FreeDecay {
            samples: self.noise_free_decay().len() as u32,
            rate_hz: rate_hz(&self.plant),
            sigma_m_s2: sample_sigma(&self.plant, "acceleration_1"),
        };
        let truth = self.truth();
        let bound = predicted_sigma(&truth, &self.amplitudes()?, &decay)?;
        let numbers = |modes: &[physics::appendage::Mode; MODES]| {
            let [first, second] = modes;
            [first.frequency_hz, first.damping_ratio, second.frequency_hz, second.damping_ratio]
        };
        let (truth, bound) = (numbers(&truth), numbers(&bound));
        Some((0..PARAMETERS).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let record = self.record(seed, record);
        vec![self.flight_answer(&mut self.flight(&record))]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        vec![cost(record.len() - self.segment_start(), || self.flight(&record), ModalIdentifier::identify)]
    }
}

fn rate_hz(plant: &Plant) -> f64 {
    1.0 / plant.simulation.period_s
}

/// The torque ends here, and the decay begins.
fn pulse_end_s(plant: &Plant) -> f64 {
    number(plant, "torque.command.1.width")
}

/// `e^{−σt}(cos ωt, sin ωt)` of both modes.
fn decay_columns(modes: &[physics::appendage::Mode; MODES], time_s: f64) -> SVector<f64, 4> {
    let mut columns = SVector::zeros();
    for (k, mode) in modes.iter().enumerate() {
        let omega = core::f64::consts::TAU * mode.frequency_hz;
        let (sine, cosine) = libm::sincos(omega * libm::sqrt(1.0 - mode.damping_ratio * mode.damping_ratio) * time_s);
        let envelope = libm::exp(-mode.damping_ratio * omega * time_s);
        columns[2 * k] = envelope * cosine;
        columns[2 * k + 1] = envelope * sine;
    }
    columns
}

/// The nearest identified mode of each true one, within [`SAME_MODE_SHARE`] of its frequency.
fn match_modes<'a>(truth: &[physics::appendage::Mode; MODES], found: &'a [Mode]) -> [Option<&'a Mode>; MODES] {
    truth.map(|mode| {
        let apart = |candidate: &Mode| (candidate.frequency_hz / mode.frequency_hz - 1.0).abs();
        found.iter().filter(|candidate| apart(candidate) < SAME_MODE_SHARE).min_by(|a, b| apart(a).total_cmp(&apart(b)))
    })
}
