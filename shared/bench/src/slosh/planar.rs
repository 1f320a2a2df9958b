//! BP2 in the plane: slosh mass on two springs off the centre, from accelerometer and gyro under
//! thrusters and a torque.

use super::method;
use crate::campaign::{Answer, Benchmark, Campaign, Cost, Found, Method, Parameter, cost};
use crate::simulated::{built_in, channel, number, periods, sample_sigma, simulator};
use crate::slosh_calibration::{ThrustCalibration, calibrate_thrust};
use crate::slosh_planar::{PlanarHub, Wrench};
use crate::slosh_planar_fit::bound;
use crate::slosh_planar_id::{PlanarAnswer, PlanarSearch, SPRINGS, STARTS_MAX, springs};
use crate::slosh_planar_record::{PlanarNoise, PlanarRecord};
use crate::slosh_planar_scan::PlanarSample;
use crate::slosh_planar_thrust::{
    SPRINGS_AND_THRUST, calibrated, identify_springs_and_thrust, scale_of, springs_and_thrust,
};
use dynamics::description::{Plant, Quantity, Signal, SignalKind, TankModel};
use estimation::consistency::nees;
use nalgebra::{SVector, Vector2};
use physics::slosh_arc::SloshSample;

const NAMES: [&str; SPRINGS] = ["m_s", "k_x", "k_y", "c_x", "c_y", "b_x", "b_y"];
const METHODS: &[Method] = &[method("ml", &[])];

/// What is not known of the thrusters along x and y before their calibration.
const SCALE_ERROR: [f64; 2] = [0.01, -0.006];
/// Amplitude, frequency and length of a calibration burst.
const CALIBRATION: (f64, f64, f64) = (44.0, 0.5, 60.0);
/// Bursts from which the remark on the calibration is made.
const BURSTS: usize = 200;
/// The bursts along x and along y come before the record: sensor noise of their own, from other
/// seeds.
const BURST_SEEDS: [u64; 2] = [1 << 32, 2 << 32];

/// Bias of accelerometers and gyro, unknown to the estimators.
const BIAS: [f64; 3] = [1e-5, -2e-5, 3e-6];

/// Slosh between 4 and 30 mHz, a tank within a metre of the centre of mass.
pub(super) const SEARCH: PlanarSearch = PlanarSearch { band_hz: [0.004, 0.03], reach_m: 1.0, starts: STARTS_MAX };

/// A planar tank and what is known of its hub.
#[derive(Clone, Debug)]
pub struct Planar {
    pub plant: Plant,
    pub hub: PlanarHub,
    pub noise: PlanarNoise,
}

impl Planar {
    /// 1800 s, three cycles along x, along y and about z within 0.52 m of stroke (benchmark page 2,
    /// section 4).
    pub fn bp2() -> Self {
        let mut plant = built_in("tank_planar");
        plant.simulation.duration_s = 1800.0;
        plant.simulation.period_s = 1.0;
        plant.simulation.step_s = 0.5; // fourth order: hidden by any noise
        plant.tanks[0].model = TankModel::Spring {
            axes: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            stiffness_n_m: vec![Quantity::known(0.16), Quantity::known(0.12)],
            damping_n_s_m: vec![Quantity::known(0.03), Quantity::known(0.025)],
        };
        for (actuator, amplitude, frequency_hz, begin_s) in
            [(0, 0.14, 0.0121, 0.0), (1, 0.112, 0.01046, 300.0), (2, 0.12, 0.01046, 650.0)]
        {
            plant.actuators[actuator].command = vec![Signal {
                kind: SignalKind::Square {
                    amplitude: Quantity::known(amplitude),
                    frequency_hz: Quantity::known(frequency_hz),
                },
                begin_s: Quantity::known(begin_s),
                end_s: Some(Quantity::known(begin_s + 3.0 / frequency_hz)),
            }];
        }
        Self { hub: hub(&plant), noise: noise(&plant), plant }
    }

    fn truth(&self) -> SVector<f64, SPRINGS> {
        let tank = &self.plant.tanks[0];
        let TankModel::Spring { stiffness_n_m: k, damping_n_s_m: c, .. } = &tank.model else {
            unreachable!("the benchmark's tank has springs");
        };
        let [x, y, _] = &tank.position_m;
        [tank.mass_kg.value, k[0].value, k[1].value, c[0].value, c[1].value, x.value, y.value].into()
    }

    /// What the sensors say, biased, and what was commanded.
    pub fn record(&self, seed: u64, record: usize) -> Vec<PlanarSample> {
        let mut samples = samples(&self.plant, seed, record, BIAS);
        for sample in &mut samples {
            for (axis, error) in SCALE_ERROR.into_iter().enumerate() {
                sample.wrench.force_n[axis] /= 1.0 + error;
            }
        }
        samples
    }

    /// The minute of fast thrust along x (0) or y (1) that comes before: its samples, as the
    /// calibration receives them.
    fn calibration_burst(&self, seed: u64, record: usize, axis: usize) -> Vec<SloshSample> {
        let (amplitude_n, frequency_hz, duration_s) = CALIBRATION;
        let mut plant = self.plant.clone();
        (plant.simulation.duration_s, plant.simulation.period_s, plant.simulation.step_s) = (duration_s, 0.1, 0.05);
        let quarter_s = 0.25 / frequency_hz;
        plant.actuators.iter_mut().for_each(|actuator| actuator.command.clear());
        let square = |amplitude: f64, begin_s: f64, end_s: f64| Signal {
            kind: SignalKind::Square {
                amplitude: Quantity::known(amplitude),
                frequency_hz: Quantity::known(frequency_hz),
            },
            begin_s: Quantity::known(begin_s),
            end_s: Some(Quantity::known(end_s)),
        };
        plant.actuators[axis].command =
            vec![square(amplitude_n, 0.0, quarter_s), square(-amplitude_n, quarter_s, duration_s)];
        let sigma_m_s2 = sample_sigma(&plant, ["acceleration_x", "acceleration_y"][axis]);
        let on_axis = |sample: PlanarSample| SloshSample {
            interval_s: plant.simulation.period_s,
            force_n: sample.wrench.force_n[axis] / (1.0 + SCALE_ERROR[axis]),
            acceleration_m_s2: sample.acceleration_m_s2[axis],
            sigma_m_s2,
        };
        samples(&plant, seed ^ BURST_SEEDS[axis], record, BIAS).into_iter().map(on_axis).collect()
    }

    /// What the bursts of a record tell of the thrusters.
    pub fn calibrations(&self, seed: u64, record: usize) -> Option<[ThrustCalibration; 2]> {
        let along =
            |axis| calibrate_thrust(&self.calibration_burst(seed, record, axis), self.hub.mass_kg, Some(0.0)).ok();
        Some([along(0)?, along(1)?])
    }

    /// RMSE of the scale over some bursts, the sigma they state, and the bound were scales and
    /// delays known.
    fn calibration_remark(&self, seed: u64) -> Option<String> {
        let found: Vec<ThrustCalibration> =
            (0..BURSTS).map(|record| self.calibrations(seed, record).map(|both| both[0])).collect::<Option<_>>()?;
        let mean = |of: &dyn Fn(&ThrustCalibration) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
        let rmse = mean(&|one| (one.scale_error - SCALE_ERROR[0]).powi(2)).sqrt();
        let sigma = mean(&|one| one.scale_sigma * one.scale_sigma).sqrt();
        let late = mean(&|one| one.delay_s * one.delay_s).sqrt();
        let (with, without) = (self.bounds(self.noise, 1.0)?, self.bounds(self.noise, 1e-3)?);
        let part: Vec<String> = (0..SPRINGS).map(|i| format!("{:.3}", with[i] / without[i])).collect();
        Some(format!(
            "A minute of {} N at {} Hz along x and one along y tell the thrusters' scales ({} and {} % unknown): RMSE along x {:.3} % over {BURSTS} bursts, {:.3} % stated, delay to {:.3} ms.\nTheir error is part of every sigma: bounds over those with known thrusters {}.",
            CALIBRATION.0,
            CALIBRATION.1,
            100.0 * SCALE_ERROR[0],
            100.0 * SCALE_ERROR[1],
            100.0 * rmse,
            100.0 * sigma,
            1e3 * late,
            part.join(" / ")
        ))
    }

    /// Springs and thrust scales from one record; `None` where search or fit fail.
    pub fn identify(
        &self,
        samples: &[PlanarSample],
        calibrations: &[ThrustCalibration; 2],
    ) -> Option<PlanarAnswer<SPRINGS_AND_THRUST>> {
        identify_springs_and_thrust(&self.record_of(samples), self.hub, &SEARCH, calibrations).ok()
    }

    fn record_of<'a>(&self, samples: &'a [PlanarSample]) -> PlanarRecord<'a> {
        PlanarRecord::new(samples, self.plant.simulation.period_s, self.noise)
    }

    /// Bound of each number [same unit], with these sensors and bursts whose sigmas are `share` of
    /// the real ones.
    fn bounds(&self, noise: PlanarNoise, share: f64) -> Option<SVector<f64, SPRINGS>> {
        let samples = self.record(0, 0);
        let mut prior = calibrated(&self.calibrations(0, 0)?)?;
        prior.information /= share * share;
        let mut truth = SVector::<f64, SPRINGS_AND_THRUST>::zeros();
        truth.fixed_rows_mut::<SPRINGS>(0).copy_from(&self.truth());
        (truth[SPRINGS], truth[SPRINGS + 2]) = (1.0 + SCALE_ERROR[0], 1.0 + SCALE_ERROR[1]);
        let record = PlanarRecord { noise, ..self.record_of(&samples) };
        let craft = |theta: &SVector<f64, SPRINGS_AND_THRUST>| springs_and_thrust(self.hub, theta);
        let covariance = bound(&record, &craft, (&truth, &scale_of(&truth)), &prior)?;
        Some(covariance.fixed_view::<SPRINGS, SPRINGS>(0, 0).diagonal().map(f64::sqrt))
    }

    /// Greatest displacement of the slosh mass.
    fn stroke_m(&self) -> f64 {
        let craft = springs(self.hub, &self.truth()).expect("the truth exists");
        let (mut state, mut worst) = (craft.start, 0.0);
        for sample in samples(&self.plant, 0, 0, BIAS) {
            state.step(&craft.hub, &craft.masses, &sample.wrench, self.plant.simulation.period_s);
            worst = f64::max(worst, state.place[0].norm());
        }
        worst
    }
}

/// What is known of the hub of a plant with tanks.
pub(super) fn hub(plant: &Plant) -> PlanarHub {
    let dynamics::description::SensorKind::Accelerometer { position_m: [x, y, _], .. } =
        &plant.sensors[channel(plant, "acceleration_x")].kind
    else {
        unreachable!("the channel is an accelerometer");
    };
    PlanarHub {
        mass_kg: number(plant, "hub.mass"),
        inertia_com_kg_m2: number(plant, "hub.inertia.zz"),
        sensor_m: Vector2::new(x.value, y.value),
    }
}

pub(super) fn noise(plant: &Plant) -> PlanarNoise {
    PlanarNoise { acceleration_m_s2: sample_sigma(plant, "acceleration_x"), rate_rad_s: sample_sigma(plant, "rate") }
}

/// Record number `record`, `bias` added.
pub(super) fn samples(plant: &Plant, seed: u64, record: usize, bias: [f64; 3]) -> Vec<PlanarSample> {
    let mut simulator = simulator(plant, seed, record);
    let channels = ["acceleration_x", "acceleration_y", "rate"].map(|name| channel(plant, name));
    let step = |_| {
        let row = simulator.step();
        let [x, y, rate] = std::array::from_fn(|i| row.value(channels[i]) + bias[i]);
        PlanarSample {
            wrench: Wrench { force_n: Vector2::new(row.commands[0], row.commands[1]), torque_n_m: row.commands[2] },
            acceleration_m_s2: Vector2::new(x, y),
            rate_rad_s: rate,
            ..PlanarSample::default()
        }
    };
    (0..periods(plant)).map(step).collect()
}

/// Means of neighbouring samples.
pub fn summed(samples: &[PlanarSample], count: usize) -> Vec<PlanarSample> {
    samples.chunks_exact(count).map(PlanarSample::mean).collect()
}

impl Benchmark for Planar {
    fn name(&self) -> &'static str {
        "bp2-planar"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        let (truth, bound) = (self.truth(), self.bounds(self.noise, 1.0)?);
        Some((0..SPRINGS).map(|i| Parameter { name: NAMES[i], truth: truth[i], bound: bound[i] }).collect())
    }

    fn methods(&self) -> &'static [Method] {
        METHODS
    }

    /// A minimum that χ² does not accept is no answer.
    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let calibrations = self.calibrations(seed, record);
        let answer = calibrations.and_then(|both| self.identify(&self.record(seed, record), &both));
        let Some(PlanarAnswer { estimate, is_explained: true, .. }) = answer else {
            return vec![Answer::none(SPRINGS)];
        };
        let (theta, sigmas) = (estimate.theta.fixed_rows::<SPRINGS>(0).into_owned(), estimate.sigmas());
        let covariance = estimate.covariance.fixed_view::<SPRINGS, SPRINGS>(0, 0).into_owned();
        vec![Answer {
            found: (0..SPRINGS).map(|i| Some(Found { value: theta[i], sigma: Some(sigmas[i]) })).collect(),
            nees: nees(&(theta - self.truth()), &covariance),
            spurious: 0,
            ..Answer::default()
        }]
    }

    fn costs(&self) -> Vec<Cost> {
        let record = self.record(0, 0);
        let calibrations = self.calibrations(0, 0).expect("the burst excites");
        vec![cost(record.len(), || (), |()| self.identify(&record, &calibrations))]
    }

    fn remarks(&self, campaign: &Campaign) -> Vec<String> {
        let truth = self.truth();
        let percent = |noise| {
            let bound = self.bounds(noise, 1.0).map(|bound| bound.component_div(&truth.abs()) * 100.0);
            bound.map_or("-".into(), |b| b.iter().map(|v| format!("{v:.2}")).collect::<Vec<_>>().join(" / "))
        };
        let blind = PlanarNoise { rate_rad_s: f64::INFINITY, ..self.noise };
        let still = PlanarNoise { acceleration_m_s2: f64::INFINITY, ..self.noise };
        let mut remarks = vec![
            format!(
                "The slosh mass moves {:.2} m. Every record starts from the scan alone; bias and trend of every channel are unknown, thrusters as calibrated.",
                self.stroke_m()
            ),
            format!("Bound % without gyro:          {}", percent(blind)),
            format!("Bound % without accelerometer: {}", percent(still)),
        ];
        remarks.extend(self.calibration_remark(campaign.seed));
        remarks
    }
}
