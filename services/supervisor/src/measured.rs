//! What the samples of a frame say: base rate, which inputs are alive, the rows of the held-out
//! test.

use crate::held_out::{HeldOut, InertialHeldOut, ModalHeldOut, SloshHeldOut, Window};
use crate::mission::Mission;
use physics::momentum::MomentumSample;
use runtime::Frame;
use runtime::experiment::{ESTIMATES_SPARSE_EVERY, ExperimentWindow};
use runtime::pairs::{accelerations_with_forces, is_excited, rates_with_joints};
use serde::{Deserialize, Serialize};
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, AnyEstimate, Domain, Experiment, IMU, JOINTS, Phase, Reason,
};

/// A sensor that has not spoken for so many frames, or for three of its intervals, is not alive.
const SILENT_FRAMES: u64 = 50;
const SILENT_INTERVALS: f64 = 3.0;
/// Rows a held-out record keeps.
const HELD_OUT_ROWS: usize = 1024;
/// Seconds in an hour, square root: data sheets state random walks per √h.
const SQRT_HOUR_S: f64 = 60.0;
const RATE_VALID_Z: u64 = 1 << 2;
const ACCELERATION_VALID: u64 = 0b111 << 3;

/// Whether the array shows a free decay: only behind a commanded excitation are amplitudes initial
/// conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Decay {
    forced: bool,
    behind_excitation: bool,
}

/// When a kind of input last spoke, and how long it may be silent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Heard {
    last_frame: Option<u64>,
    patience_frames: u64,
}

impl Heard {
    /// It speaks in `frame`, every `interval_frames` or more often.
    fn now(&mut self, frame: u64, interval_frames: f64) {
        *self = Self { last_frame: Some(frame), patience_frames: patience_frames(interval_frames) };
    }

    /// Its experiment may call for a slower beat than the one last heard: `expected_frames` between
    /// samples.
    fn alive(&self, frame: u64, expected_frames: f64) -> bool {
        let patience = self.patience_frames.max(patience_frames(expected_frames));
        self.last_frame.is_some_and(|last| frame < last + patience)
    }
}

/// A cast of NaN is 0: an unknown interval adds no patience.
fn patience_frames(interval_frames: f64) -> u64 {
    SILENT_FRAMES.max((SILENT_INTERVALS * interval_frames).ceil() as u64)
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Inputs {
    rate: Heard,
    acceleration: Heard,
    joints: Heard,
    actuators: Heard,
    array: Heard,
}

/// Everything measured, with what a restart needs of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    base_rate_rad_s: f64,
    heard: Inputs,
    frame_period_s: f64,
    /// Between samples of the slosh and of the modal experiment, as the scenario says [frames].
    slosh_interval_frames: f64,
    array_interval_frames: f64,
    generation: u32,
    inertial: InertialHeldOut,
    slosh: Option<SloshHeldOut>,
    /// Begins with the first rows, which say how many channels there are.
    modal: ModalHeldOut,
    decay: Decay,
    /// Momentum samples of the present frame with the averaging interval of the gyro \[s\].
    momentum: Vec<(f64, MomentumSample)>,
}

impl Measured {
    /// Takes the memory for the held-out rows; of the modal model for all channels that are used,
    /// or that there can be.
    pub fn new(mission: &Mission) -> Self {
        let slosh = mission.slosh.as_ref().map(|known| {
            SloshHeldOut::new(HELD_OUT_ROWS, known.m_0_kg, known.accelerometer_vrw_m_s_sqrt_h / SQRT_HOUR_S)
        });
        let period_s = mission.frame_period_s;
        let (array_rate_hz, array_sigma) = (mission.modal.rate_hz, mission.modal.accelerometer_sigma_m_s2);
        let channels_max = match mission.modal.channels.len() {
            0 => ACCELEROMETERS_MAX,
            stated => stated.min(ACCELEROMETERS_MAX),
        };
        Measured {
            base_rate_rad_s: f64::NAN,
            heard: Inputs::default(),
            frame_period_s: period_s,
            slosh_interval_frames: mission.slosh.as_ref().map_or(0.0, |known| known.interval_s / period_s),
            array_interval_frames: if array_rate_hz > 0.0 { 1.0 / (array_rate_hz * period_s) } else { 0.0 },
            generation: 0,
            inertial: InertialHeldOut::new(HELD_OUT_ROWS),
            slosh,
            modal: ModalHeldOut::new(HELD_OUT_ROWS, channels_max, array_sigma),
            decay: Decay::default(),
            momentum: Vec::with_capacity(16),
        }
    }

    /// Newest measured base rate about z; NaN before the first.
    pub fn base_rate_rad_s(&self) -> f64 {
        self.base_rate_rad_s.abs()
    }

    /// Momentum samples of this frame with the averaging interval of the gyro \[s\].
    pub fn momentum(&self) -> &[(f64, MomentumSample)] {
        &self.momentum
    }

    /// Whether every sensor of the domain's experiment has spoken recently.
    pub fn inputs_alive(&self, domain: Domain, frame: u64) -> bool {
        let heard = &self.heard;
        let alive = |inputs: [Heard; 2], expected: f64| inputs.iter().all(|input| input.alive(frame, expected));
        match domain {
            Domain::Inertial => alive([heard.rate, heard.joints], 1.0),
            Domain::Slosh => alive([heard.acceleration, heard.actuators], self.slosh_interval_frames),
            Domain::Modal => heard.array.alive(frame, self.array_interval_frames),
        }
    }

    /// Takes the samples of a frame.
    pub fn take(&mut self, frame: &Frame<'_>, window: &ExperimentWindow, mission: &Mission) {
        self.begin_with(window);
        self.note_heard(frame);
        self.take_momentum(frame);
        self.take_slosh(frame, mission);
        self.take_array(frame, window, mission);
    }

    /// An estimate of a running experiment.
    pub fn offer(&mut self, estimate: AnyEstimate<'_>) {
        match estimate {
            AnyEstimate::Inertial(sample) => self.inertial.offer(&sample.estimate),
            AnyEstimate::Slosh(sample) => self.slosh.iter_mut().for_each(|slosh| slosh.offer(sample)),
            AnyEstimate::Modal(sample) => self.modal.offer(&sample.estimate),
        }
    }

    /// The held-out test of the experiment that has ended, or why there is none.
    pub fn close(&self, domain: Domain, phase: Phase, mission: &Mission) -> Result<HeldOut, Reason> {
        let tested = match domain {
            Domain::Inertial => mission
                .arm(phase)
                .and_then(|known| self.inertial.close(known.h_nms, |interval_s| known.sigma(interval_s).omega0_rad_s)),
            Domain::Slosh => self.slosh.as_ref().and_then(SloshHeldOut::close),
            Domain::Modal if !self.decay.behind_excitation => return Err(Reason::OperationalRecord),
            Domain::Modal => self.modal.close(),
        };
        tested.ok_or(Reason::NoHeldOutData)
    }

    fn begin_with(&mut self, window: &ExperimentWindow) {
        if window.experiment == Experiment::None || window.generation == self.generation {
            return;
        }
        self.generation = window.generation;
        let held_out = held_out_window(window, self.frame_period_s);
        self.inertial.begin(held_out);
        self.decay = Decay::default();
        self.modal.forget();
        if let Some(slosh) = &mut self.slosh {
            slosh.begin(held_out);
        }
    }

    fn note_heard(&mut self, frame: &Frame<'_>) {
        let (now, period_s) = (frame.number, self.frame_period_s);
        for imu in frame.samples(IMU) {
            let interval_frames = imu.interval_s / period_s;
            if imu.valid & RATE_VALID_Z != 0 {
                self.heard.rate.now(now, interval_frames);
                self.base_rate_rad_s = imu.omega_bi_b_rad_s[2];
            }
            if imu.valid & ACCELERATION_VALID != 0 {
                self.heard.acceleration.now(now, interval_frames);
            }
        }
        // Joints state no interval: they are read with the gyro.
        if !frame.samples(JOINTS).is_empty() {
            self.heard.joints.now(now, 0.0);
            self.heard.joints.patience_frames = self.heard.rate.patience_frames.max(SILENT_FRAMES);
        }
        for command in frame.samples(ACTUATORS) {
            self.heard.actuators.now(now, command.interval_s / period_s);
        }
        for batch in frame.samples(ACCELEROMETERS) {
            self.heard.array.now(now, f64::from(batch.count.max(1)) * batch.interval_ns as f64 * 1e-9 / period_s);
        }
    }

    fn take_momentum(&mut self, frame: &Frame<'_>) {
        self.momentum.clear();
        for (imu, joints) in rates_with_joints(frame) {
            let sample = MomentumSample {
                omega0_z_rad_s: imu.omega_bi_b_rad_s[2],
                joint_rate_rad_s: [joints.rate_rad_s[0], joints.rate_rad_s[1]],
                joint_angle_rad: [joints.angle_rad[0], joints.angle_rad[1]],
            };
            let interval_s = if imu.interval_s > 0.0 { imu.interval_s } else { self.frame_period_s };
            self.inertial.push(frame.number, interval_s, &sample);
            self.momentum.push((interval_s, sample));
        }
    }

    fn take_slosh(&mut self, frame: &Frame<'_>, mission: &Mission) {
        let (Some(slosh), Some(known)) = (&mut self.slosh, &mission.slosh) else { return };
        let axis = known.axis.index();
        for (imu, force) in accelerations_with_forces(frame, axis) {
            let begin_s = imu.header.t_meas_ns as f64 * 1e-9;
            slosh.push(frame.number, begin_s, imu.interval_s, force.force_b_n[axis], imu.acceleration_b_m_s2[axis]);
        }
    }

    fn take_array(&mut self, frame: &Frame<'_>, window: &ExperimentWindow, mission: &Mission) {
        let commands = frame.samples(ACTUATORS);
        if !commands.is_empty() {
            self.decay.forced = commands.iter().any(is_excited);
            self.decay.behind_excitation |= self.decay.forced;
        }
        let decays = self.decay.behind_excitation && !self.decay.forced;
        for batch in frame.samples(ACCELEROMETERS).iter().filter(|_| decays) {
            if !self.modal.has_begun() {
                let channels = mission.modal.channels_of((batch.channels as usize).min(ACCELEROMETERS_MAX));
                self.modal.begin(held_out_window(window, mission.frame_period_s), channels);
            }
            if !self.modal.has_begun() {
                continue;
            }
            let interval_s = batch.interval_ns as f64 * 1e-9;
            for (row, offset_ns) in batch.acceleration_m_s2.iter().zip(batch.offset_ns).take(batch.count as usize) {
                let t_s = (batch.header.t_meas_ns + u64::from(offset_ns)) as f64 * 1e-9;
                self.modal.push(frame.number, t_s, interval_s, row);
            }
        }
    }
}

fn held_out_window(window: &ExperimentWindow, frame_period_s: f64) -> Window {
    Window {
        start_frame: window.begin_frame,
        duration_frames: window.end_frame - window.begin_frame,
        generation: window.generation,
        frame_period_s,
        lead_frames: ESTIMATES_SPARSE_EVERY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_is_silent_after_half_a_second_of_frames_or_three_of_its_own_intervals() {
        let mut heard = Heard::default();
        assert!(!heard.alive(0, 1.0), "it never spoke");
        heard.now(1000, 1.0);
        assert!(heard.alive(1049, 0.0) && !heard.alive(1050, 0.0));
        heard.now(1000, 100.0);
        assert!(heard.alive(1299, 0.0) && !heard.alive(1300, 0.0));
        // Heard every 10 ms before the experiment, every second in it: the first sample comes after
        // 100 frames.
        heard.now(1000, 1.0);
        assert!(heard.alive(1299, 100.0) && !heard.alive(1300, 100.0));
        heard.now(1000, f64::NAN);
        assert!(!heard.alive(1050, 0.0));
    }
}
