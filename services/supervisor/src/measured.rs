//! What the samples of a frame say: base rate, which inputs are alive, the rows of the held-out test.

use crate::held_out::{HeldOut, InertialHeldOut, ModalHeldOut, SloshHeldOut, Window};
use crate::mission::Mission;
use physics::momentum::MomentumSample;
use runtime::Frame;
use runtime::experiment::{ESTIMATES_SPARSE_EVERY, ExperimentWindow};
use serde::{Deserialize, Serialize};
use telemetry::{ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Domain, Estimate, Experiment, IMU, JOINTS, Phase};

/// A sensor that has not spoken for so many frames is not alive.
const SILENT_FRAMES: u64 = 50;
/// Rows a held-out record keeps.
const HELD_OUT_ROWS: usize = 1024;
/// Samples per frame the held-out records are laid out for.
const ROWS_PER_FRAME: u64 = 1;
const ARRAY_ROWS_PER_FRAME: u64 = 2;
const RATE_VALID_Z: u64 = 1 << 2;
const ACCELERATION_VALID: u64 = 0b111 << 3;

/// Whether the array shows a free decay: only behind a commanded excitation are amplitudes initial conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Decay {
    forced: bool,
    behind_excitation: bool,
}

/// When each kind of input last spoke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct LastSeen {
    rate: Option<u64>,
    acceleration: Option<u64>,
    joints: Option<u64>,
    actuators: Option<u64>,
    array: Option<u64>,
}

/// Everything measured, with what a restart needs of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    base_rate_rad_s: f64,
    last_seen: LastSeen,
    generation: u32,
    inertial: InertialHeldOut,
    slosh: Option<SloshHeldOut>,
    /// Made with the first rows, which say how many channels there are.
    modal: Option<ModalHeldOut>,
    decay: Decay,
    /// Momentum samples of the present frame.
    momentum: Vec<(u64, MomentumSample)>,
}

impl Measured {
    pub fn new(mission: &Mission) -> Self {
        let gyro = mission.inertial.as_ref().or(mission.mated.as_ref()).map_or(0.0, |arm| arm.sigma.omega0_rad_s);
        let slosh = mission.slosh.as_ref().map(|known| {
            let noise = known.accelerometer_vrw_m_s_sqrt_h / 60.0 / known.interval_s.sqrt();
            SloshHeldOut::new(HELD_OUT_ROWS, mission.frame_period_s, known.m_0_kg, noise)
        });
        Measured {
            base_rate_rad_s: f64::NAN,
            last_seen: LastSeen::default(),
            generation: 0,
            inertial: InertialHeldOut::new(HELD_OUT_ROWS, ROWS_PER_FRAME, gyro),
            slosh,
            modal: None,
            decay: Decay::default(),
            momentum: Vec::with_capacity(16),
        }
    }

    /// Newest measured base rate about z; NaN before the first.
    pub fn base_rate_rad_s(&self) -> f64 {
        self.base_rate_rad_s.abs()
    }

    /// Momentum samples of this frame.
    pub fn momentum(&self) -> &[(u64, MomentumSample)] {
        &self.momentum
    }

    /// Whether every sensor of the domain's experiment has spoken recently.
    pub fn inputs_alive(&self, domain: Domain, frame: u64) -> bool {
        let seen = &self.last_seen;
        let alive = |last: Option<u64>| last.is_some_and(|last| frame < last + SILENT_FRAMES);
        match domain {
            Domain::Inertial => alive(seen.rate) && alive(seen.joints),
            Domain::Slosh => alive(seen.acceleration) && alive(seen.actuators),
            Domain::Modal => alive(seen.array),
        }
    }

    /// Takes the samples of a frame.
    pub fn take(&mut self, frame: &Frame<'_>, window: &ExperimentWindow, mission: &Mission) {
        self.begin_with(window);
        self.note_seen(frame);
        self.take_momentum(frame);
        self.take_slosh(frame, mission);
        self.take_array(frame, window, mission);
    }

    /// An estimate of a running experiment.
    pub fn offer(&mut self, domain: Domain, estimate: &Estimate) {
        match domain {
            Domain::Inertial => self.inertial.offer(estimate),
            Domain::Slosh => self.slosh.iter_mut().for_each(|slosh| slosh.offer(estimate)),
            Domain::Modal => self.modal.iter_mut().for_each(|modal| modal.offer(estimate)),
        }
    }

    /// The held-out test of the experiment that has ended.
    pub fn close(&self, domain: Domain, phase: Phase, mission: &Mission) -> Option<HeldOut> {
        match domain {
            Domain::Inertial => self.inertial.close(mission.arm(phase)?.h_nms),
            Domain::Slosh => self.slosh.as_ref()?.close(),
            Domain::Modal => self.modal.as_ref()?.close(),
        }
    }

    fn begin_with(&mut self, window: &ExperimentWindow) {
        if window.experiment == Experiment::None || window.generation == self.generation {
            return;
        }
        self.generation = window.generation;
        let held_out = held_out_window(window);
        self.inertial.begin(held_out);
        (self.modal, self.decay) = (None, Decay::default());
        if let Some(slosh) = &mut self.slosh {
            slosh.begin(held_out);
        }
    }

    fn note_seen(&mut self, frame: &Frame<'_>) {
        let now = Some(frame.number);
        for imu in frame.samples(IMU) {
            if imu.valid & RATE_VALID_Z != 0 {
                self.last_seen.rate = now;
                self.base_rate_rad_s = imu.omega_bi_b_rad_s[2];
            }
            if imu.valid & ACCELERATION_VALID != 0 {
                self.last_seen.acceleration = now;
            }
        }
        let spoke = |count: usize, last: Option<u64>| if count > 0 { now } else { last };
        self.last_seen.joints = spoke(frame.samples(JOINTS).len(), self.last_seen.joints);
        self.last_seen.actuators = spoke(frame.samples(ACTUATORS).len(), self.last_seen.actuators);
        self.last_seen.array = spoke(frame.samples(ACCELEROMETERS).len(), self.last_seen.array);
    }

    fn take_momentum(&mut self, frame: &Frame<'_>) {
        self.momentum.clear();
        let joints = frame.samples(JOINTS);
        for imu in frame.samples(IMU).iter().filter(|imu| imu.valid & RATE_VALID_Z != 0) {
            let Some(joints) = joints.iter().find(|j| j.header.t_meas_ns == imu.header.t_meas_ns && j.count >= 2)
            else {
                continue;
            };
            let sample = MomentumSample {
                omega0_z_rad_s: imu.omega_bi_b_rad_s[2],
                joint_rate_rad_s: [joints.rate_rad_s[0], joints.rate_rad_s[1]],
                joint_angle_rad: [joints.angle_rad[0], joints.angle_rad[1]],
            };
            self.inertial.push(frame.number, &sample);
            self.momentum.push((imu.header.t_meas_ns, sample));
        }
    }

    fn take_slosh(&mut self, frame: &Frame<'_>, mission: &Mission) {
        let (Some(slosh), Some(known)) = (&mut self.slosh, &mission.slosh) else { return };
        let axis = known.axis.index();
        let forces = frame.samples(ACTUATORS);
        for imu in frame.samples(IMU).iter().filter(|imu| imu.valid >> (3 + axis) & 1 == 1) {
            let Some(force) = forces.iter().find(|force| force.header.t_meas_ns == imu.header.t_meas_ns) else {
                continue;
            };
            let begin_s = imu.header.t_meas_ns as f64 * 1e-9;
            slosh.push(frame.number, begin_s, imu.interval_s, force.force_b_n[axis], imu.acceleration_b_m_s2[axis]);
        }
    }

    fn take_array(&mut self, frame: &Frame<'_>, window: &ExperimentWindow, mission: &Mission) {
        for command in frame.samples(ACTUATORS) {
            self.decay.forced = command.torque_b_nm.iter().chain(&command.force_b_n).any(|&value| value != 0.0);
            self.decay.behind_excitation |= self.decay.forced;
        }
        let decays = self.decay.behind_excitation && !self.decay.forced;
        for batch in frame.samples(ACCELEROMETERS).iter().filter(|_| decays) {
            let channels = (batch.channels as usize).min(ACCELEROMETERS_MAX);
            if channels == 0 {
                continue;
            }
            let modal = self.modal.get_or_insert_with(|| {
                let mut modal =
                    ModalHeldOut::new(HELD_OUT_ROWS, ARRAY_ROWS_PER_FRAME, channels, mission.modal_noise_m_s2);
                modal.begin(held_out_window(window));
                modal
            });
            for (row, offset_ns) in batch.acceleration_m_s2.iter().zip(batch.offset_ns).take(batch.count as usize) {
                let t_s = (batch.header.t_meas_ns + u64::from(offset_ns)) as f64 * 1e-9;
                modal.push(frame.number, t_s, row);
            }
        }
    }
}

fn held_out_window(window: &ExperimentWindow) -> Window {
    Window {
        start_frame: window.begin_frame,
        duration_frames: window.end_frame - window.begin_frame,
        generation: window.generation,
        lead_frames: ESTIMATES_SPARSE_EVERY,
    }
}
