//! BP3: modes of a flexible appendage on a hub, from ten accelerometers along it.
//!
//! BP3A: a pulse of torque on a free hub; the truth are the **hub-free** modes. BP3B: a sampled
//! loop makes the hub climb a staircase. Methods that know the torque are held against the same
//! hub-free modes. Methods that see only outputs between the steps find the modes of the **closed
//! loop**, which are another truth (damping of the first mode 20 % instead of 0.8 %), and are held
//! against that. The bound is that of the record with residues, direct terms and biases of every
//! channel unknown.

mod bound;
mod hub;
mod linear;

use crate::campaign::{Answer, Benchmark, Campaign, Cost, Found, Method, Parameter, cost};
use crate::simulated::{built_in, number, periods, sample_sigma, simulator, without_noise};
use crate::truth;
use bound::Decays;
use dynamics::description::Plant;
pub use linear::TrueMode;
use modal::mac::modal_assurance_criterion;
use modal::maximum_likelihood::{self, Model};
use modal::methods::{Deviation, Estimate, Settings, method};
use modal::record::Record;
use modal::{Config, ModalIdentifier};
use physics::appendage::{Appendage, MODES};
use std::ops::Range;

/// Accelerometers along the appendage.
pub const SENSORS: usize = 10;
/// An identified mode farther than this from every true one is not one of them.
const SAME_MODE_SHARE: f64 = 0.05;
const MODAL_PARAMETERS: usize = 2 * MODES;
const NAMES: [&str; MODAL_PARAMETERS] = ["f1", "zeta1", "f2", "zeta2"];
/// Lines taken by the method that works on lines: around the modes that are expected.
const BAND_HZ: (f64, f64) = (0.5, 10.0);
/// The identifier as it flies, which finds the order by itself.
const FLIGHT: &str = "ssi-cov in flight";

/// Tables IX and XI of the paper.
const TABLE_IX: &[Method] = &[
    Method { name: "ml", paper_percent: &[] },
    Method { name: "lsce", paper_percent: &[0.77, 1.65, 0.26, 8.48] },
    Method { name: "rfp", paper_percent: &[0.50, 0.46, 0.11, 0.97] },
    Method { name: "ssi-cov", paper_percent: &[0.02, 0.02, 0.00, 0.03] },
    Method { name: "ssi-data", paper_percent: &[0.06, 0.37, 0.01, 0.69] },
    Method { name: "era", paper_percent: &[] },
    Method { name: "po-moesp", paper_percent: &[] },
    Method { name: FLIGHT, paper_percent: &[0.02, 0.02, 0.00, 0.03] },
];
const TABLE_XI_INPUT: &[Method] = &[
    Method { name: "ml", paper_percent: &[] },
    Method { name: "rfp", paper_percent: &[0.12, 1.27, 0.01, 0.33] },
    Method { name: "po-moesp", paper_percent: &[] },
];
const TABLE_XI_OUTPUT: &[Method] = &[
    Method { name: "lsce", paper_percent: &[0.05, 0.05, 0.04, 1.15] },
    Method { name: "ssi-cov", paper_percent: &[0.01, 0.01, 0.00, 0.01] },
    Method { name: "ssi-data", paper_percent: &[0.05, 0.63, 0.01, 0.56] },
    Method { name: "era", paper_percent: &[] },
];

const TABLE_X: &str = "MAC of the paper (Table X, two digits; ours is 1 less `largest 1 - MAC`), mode 1 and 2: lsce 1.00 1.00, rfp 0.99 0.99,\nssi-cov 1.00 1.00, ssi-data 1.00 1.00. Errors beside ours: Table IX.";
const TABLE_XII: &str = "MAC of the paper (Table XII, two digits; ours is 1 less `largest 1 - MAC`), mode 1 and 2: lsce 0.99 1.00, rfp 1.00 0.99,\nssi-cov 1.00 1.00, ssi-data 1.00 0.99. Errors beside ours: Table XI; the paper does not say of which modes they are.";

/// Which modes are the truth, and what is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Truth {
    /// Hub-free modes, torque known.
    HubFree,
    /// Modes of the loop, outputs alone between the steps.
    ClosedLoop,
}

/// An appendage, what moves it, and what the methods know.
#[derive(Clone, Debug)]
pub struct Modes {
    name: &'static str,
    /// With its pulse of torque or its loop, and accelerometers.
    pub plant: Plant,
    /// Of the identifier in flight.
    pub config: Config,
    /// Where the first segment without torque or step begins.
    pub segment_start_s: f64,
    /// Length of each segment; none: to the end of the record.
    step_s: Option<f64>,
    samples: usize,
    settings: Settings,
    truth: Truth,
    methods: Vec<Method>,
    /// What the paper says of the shapes.
    paper: &'static str,
}

impl Modes {
    /// 2 Nm for one second, five seconds at 200 Hz.
    pub fn bp3a() -> Self {
        let plant = built_in("hub_appendage");
        assert!(accelerometers(&plant).len() == SENSORS);
        Self {
            name: "bp3a (hub-free modes)",
            config: Config::new(SENSORS, rate_hz(&plant)),
            segment_start_s: pulse_end_s(&plant),
            step_s: None,
            samples: periods(&plant),
            settings: Settings { band_hz: Some(BAND_HZ), ..Settings::new(MODES) },
            truth: Truth::HubFree,
            methods: TABLE_IX.to_vec(),
            paper: TABLE_X,
            plant,
        }
    }

    /// Five steps of half a degree, one per second, torque known: hub-free modes.
    pub fn bp3b() -> Self {
        let plant = built_in("hub_appendage_closed_loop");
        assert!(accelerometers(&plant).len() == SENSORS);
        Self {
            name: "bp3b, torque known (hub-free modes)",
            config: Config::new(SENSORS, rate_hz(&plant)),
            segment_start_s: 0.0,
            step_s: Some(STEP_S),
            samples: (STAIRCASE_STEPS as f64 * STEP_S * rate_hz(&plant)).round() as usize,
            settings: Settings { band_hz: Some(BAND_HZ), ..Settings::new(MODES) },
            truth: Truth::HubFree,
            methods: TABLE_XI_INPUT.to_vec(),
            paper: TABLE_XII,
            plant,
        }
    }

    /// The same records, outputs alone between the steps: modes of the closed loop.
    pub fn bp3b_outputs() -> Self {
        Self {
            name: "bp3b, outputs alone between the steps (closed-loop modes)",
            // Loop and integrator add two states each; two more, as neither is known to the method.
            // Rows of the Hankel matrix over half of a segment: poles of a short decay scatter
            // least where the rows are a third to a half of its samples (Hua & Sarkar 1990).
            settings: Settings { block_rows: OUTPUT_ONLY_BLOCK_ROWS, ..Settings::new(4) },
            truth: Truth::ClosedLoop,
            methods: TABLE_XI_OUTPUT.to_vec(),
            ..Self::bp3b()
        }
    }

    /// Bp3a with the identifier that flies alone.
    pub fn flight() -> Self {
        Self::bp3a().only(&[FLIGHT.into()])
    }

    /// With some of its methods.
    #[must_use]
    pub fn only(mut self, names: &[String]) -> Self {
        if !names.is_empty() {
            self.methods.retain(|method| names.iter().any(|name| name == method.name));
        }
        self
    }

    /// What the sensors and the actuator say of a whole record.
    fn rows(&self, seed: u64, record: usize) -> (Vec<[f64; SENSORS]>, Vec<f64>) {
        let mut simulator = simulator(&self.plant, seed, record);
        let accelerometers = accelerometers(&self.plant);
        let (mut rows, mut torque) = (Vec::with_capacity(self.samples), Vec::with_capacity(self.samples));
        for _ in 0..self.samples {
            let row = simulator.step();
            rows.push(core::array::from_fn(|k| row.value(accelerometers[k])));
            torque.push(row.commands[0]);
        }
        (rows, torque)
    }

    /// A record as the methods take it.
    #[must_use]
    pub fn record(&self, seed: u64, record: usize) -> Record {
        let (rows, torque) = self.rows(seed, record);
        let outputs = Record::of_outputs(rate_hz(&self.plant), SENSORS, rows.concat()).with_segments(self.segments());
        match self.truth {
            Truth::HubFree => outputs.with_input(1, torque),
            Truth::ClosedLoop => outputs,
        }
    }

    /// Samples between two changes of what acts from outside.
    fn segments(&self) -> Vec<Range<usize>> {
        let length = self.step_s.map_or(self.samples, |step| (step * rate_hz(&self.plant)).round() as usize);
        let starts = (self.segment_start()..self.samples).step_by(length);
        starts.map(|start| start..(start + length).min(self.samples)).collect()
    }

    /// What perfect sensors would say from the end of the pulse on.
    #[must_use]
    pub fn noise_free_decay(&self) -> Vec<[f64; SENSORS]> {
        let perfect = Self { plant: without_noise(&self.plant), ..self.clone() };
        perfect.rows(0, 0).0.split_off((pulse_end_s(&self.plant) * rate_hz(&self.plant)).round() as usize)
    }

    /// The record as the partition feeds it: the segment is closed while torque acts.
    fn in_flight(&self, record: &Record) -> ModalIdentifier {
        let mut identifier = ModalIdentifier::new(self.config.clone());
        identifier.close_segment();
        let first = self.segment_start();
        for (k, sample) in record.outputs.chunks_exact(SENSORS).enumerate() {
            if k == first {
                identifier.open_segment();
            }
            identifier.push(sample);
        }
        identifier
    }

    /// Sample at which the first segment begins.
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

    /// Hub and beam in closed form; `None` when the plant is not of that form.
    fn nominal(&self) -> Option<Appendage> {
        let [panel] = &self.plant.appendages[..] else { return None };
        let [a, b] = &panel.modes[..] else { return None };
        let locked = [a, b].map(|mode| physics::appendage::Mode {
            frequency_hz: mode.frequency_hz.value,
            damping_ratio: mode.damping_ratio.value,
        });
        let hub = self.plant.bodies.first()?;
        // About the axis of the bearing, which goes through the origin of the hub's frame.
        let [x, y, _] = hub.com_m.each_ref().map(|of| of.value);
        let inertia_kg_m2 = hub.inertia_com_kg_m2[2].value + hub.mass_kg.value * (x * x + y * y);
        Some(Appendage { inertia_kg_m2, coupling: [a, b].map(|mode| mode.rotation_sqrt_kg_m[2].value), locked })
    }

    /// All poles that the noise-free record holds.
    fn poles(&self) -> Vec<TrueMode> {
        let accelerometers = accelerometers(&self.plant);
        let found = match self.truth {
            Truth::HubFree => linear::open_loop(&self.plant, &accelerometers),
            Truth::ClosedLoop => linear::closed_loop(&self.plant, &accelerometers),
        };
        found.expect("the benchmark's plant is linear, with one controller at most")
    }

    /// The two modes that are sought.
    #[must_use]
    pub fn true_modes(&self) -> Vec<TrueMode> {
        let all = self.poles().into_iter();
        let mut sought: Vec<TrueMode> = all.filter(|mode| mode.pole.im > BAND_HZ.0 * core::f64::consts::TAU).collect();
        sought.truncate(MODES);
        sought
    }

    /// Standard deviations of (f, ζ) of both modes that no unbiased method can undercut.
    fn bounds(&self) -> Option<Vec<(f64, f64)>> {
        let perfect = Self { plant: without_noise(&self.plant), ..self.clone() }.record(0, 0);
        let sigma = sample_sigma(&self.plant, "acceleration_1");
        match self.truth {
            Truth::HubFree => {
                let poles: Vec<modal::c64> = self.true_modes().iter().map(|mode| mode.pole).collect();
                let n = 2 * poles.len();
                let all = maximum_likelihood::bound(&perfect, Model::FORCED, &poles, &[sigma; SENSORS])?;
                Some(
                    (0..poles.len())
                        .map(|k| (all[2 * k * (n + 1)].sqrt(), all[(2 * k + 1) * (n + 1)].sqrt()))
                        .collect(),
                )
            }
            Truth::ClosedLoop => {
                let rows: Vec<Vec<f64>> = perfect.outputs.chunks_exact(SENSORS).map(<[f64]>::to_vec).collect();
                let segments = self.segments().into_iter().map(|segment| &rows[segment]).collect();
                let poles = self.poles();
                let all = Decays { modes: &poles, segments, rate_hz: rate_hz(&self.plant) }.bounds(sigma)?;
                let vibrations = poles.iter().filter(|mode| mode.pole.im > 1e-6).zip(all);
                let sought = self.true_modes();
                let is_sought = |mode: &TrueMode| sought.iter().any(|other| other.pole == mode.pole);
                Some(vibrations.filter(|(mode, _)| is_sought(mode)).map(|(_, bound)| bound).collect())
            }
        }
    }

    /// The bound of the free decay after the pulse alone, what output-only methods have on BP3A.
    #[must_use]
    pub fn decay_bounds(&self) -> Option<Vec<(f64, f64)>> {
        let decay: Vec<Vec<f64>> = self.noise_free_decay().iter().map(|row| row.to_vec()).collect();
        let sigma = sample_sigma(&self.plant, "acceleration_1");
        let decays = Decays { modes: &self.true_modes(), segments: vec![&decay], rate_hz: rate_hz(&self.plant) };
        decays.bounds(sigma)
    }

    fn answer(&self, name: &str, record: &Record, truth: &[TrueMode]) -> Answer {
        if name == FLIGHT {
            let modes = self.in_flight(record).identify().unwrap_or_default();
            let found: Vec<Estimate> = modes.iter().map(Estimate::from).collect();
            let answer = judge(truth, &found);
            let there = answer.found.iter().flatten().count() / 2;
            return Answer { spurious: (found.len() - there) as u32, ..answer };
        }
        let method = method(name).expect("the tables name methods of the list");
        match (method.identify)(record, &self.settings) {
            // Orders are given: what else a method finds are the states that were to spare.
            Ok(found) => judge(truth, &found),
            Err(_) => Answer::none(MODAL_PARAMETERS),
        }
    }
}

/// Estimates beside the truth.
fn judge(truth: &[TrueMode], found: &[Estimate]) -> Answer {
    let mut answer = Answer { nees: Some(0.0), ..Answer::default() };
    for mode in truth {
        let (f, zeta) = (mode.frequency_hz(), mode.damping_ratio());
        let apart = |candidate: &&Estimate| (candidate.frequency_hz / f - 1.0).abs();
        // In a strongly damped loop a spare state may lie nearer in frequency: the pole decides.
        let distance = |candidate: &&Estimate| apart(candidate).hypot(candidate.damping_ratio - zeta);
        let near = found.iter().filter(|candidate| apart(candidate) < SAME_MODE_SHARE);
        let Some(nearest) = near.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
            answer.found.extend([None, None]);
            answer.shape_errors.push(None);
            answer.nees = None;
            continue;
        };
        let sigma = nearest.deviation;
        answer.found.push(Some(Found { value: nearest.frequency_hz, sigma: sigma.map(|d| d.frequency_hz) }));
        answer.found.push(Some(Found { value: nearest.damping_ratio, sigma: sigma.map(|d| d.damping_ratio) }));
        answer.shape_errors.push(Some(1.0 - modal_assurance_criterion(&nearest.mode_shape, &mode.shape)));
        // Of the covariances between modes nothing is published.
        let of_mode = sigma.map(|d| square(&d, nearest.frequency_hz - f, nearest.damping_ratio - zeta));
        answer.nees = answer.nees.zip(of_mode).map(|(sum, of_mode)| sum + of_mode);
    }
    answer
}

/// Normalised square of the errors of one mode.
fn square(d: &Deviation, e_f: f64, e_zeta: f64) -> f64 {
    let (x, y, r) = (e_f / d.frequency_hz, e_zeta / d.damping_ratio, d.correlation);
    (x * x - 2.0 * r * x * y + y * y) / (1.0 - r * r)
}

impl Benchmark for Modes {
    fn name(&self) -> &'static str {
        self.name
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bounds) = (self.true_modes(), self.bounds()?);
        let both = truth.iter().zip(&bounds);
        let numbers = both.flat_map(|(mode, bound)| [(mode.frequency_hz(), bound.0), (mode.damping_ratio(), bound.1)]);
        Some(NAMES.iter().zip(numbers).map(|(name, (truth, bound))| Parameter { name, truth, bound }).collect())
    }

    fn methods(&self) -> &[Method] {
        &self.methods
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let (record, truth) = (self.record(seed, record), self.true_modes());
        self.methods.iter().map(|method| self.answer(method.name, &record, &truth)).collect()
    }

    fn remarks(&self, campaign: &Campaign) -> Vec<String> {
        let mut remarks = vec![self.paper.into()];
        if self.truth == Truth::HubFree && self.methods.iter().any(|method| method.name == "ml") {
            remarks.extend(hub::remark(self, campaign));
        }
        remarks
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        let of_method = |of: &Method| match of.name {
            FLIGHT => cost(record.free_samples(), || self.in_flight(&record), ModalIdentifier::identify),
            name => {
                let method = method(name).expect("the tables name methods of the list");
                cost(record.samples(), || (), |()| (method.identify)(&record, &self.settings).is_ok())
            }
        };
        self.methods.iter().map(of_method).collect()
    }
}

const STAIRCASE_STEPS: usize = 5;
/// A quarter of the 200 samples between two steps: past and future together are half of them.
const OUTPUT_ONLY_BLOCK_ROWS: usize = 50;
const STEP_S: f64 = 1.0;

fn rate_hz(plant: &Plant) -> f64 {
    1.0 / plant.simulation.period_s
}

/// Channels of the accelerometers, in the order of the file.
fn accelerometers(plant: &Plant) -> Vec<usize> {
    let is_one = |k: &usize| plant.sensors[*k].name.starts_with("acceleration_");
    (0..plant.sensors.len()).filter(is_one).collect()
}

/// The torque ends here, and the decay begins.
fn pulse_end_s(plant: &Plant) -> f64 {
    number(plant, "torque.command.1.width")
}
