//! A plant as the vehicle of an experiment: its simulator, and which channel goes into which
//! sample.

use crate::craft;
use crate::wrench::{Wrench, is_hub, wrench};
use dynamics::description::{Joint, Plant, Sensor, SensorKind};
use runtime::Outputs;
use serde::Serialize;
use simulation::{Row, SimulationError, Simulator, SimulatorState};
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Actuators, BATCH_MAX, CRAFT, IMU, Imu, JOINTS,
    Joints, Sample,
};

const RATE_VALID_X: u64 = 1;
const ACCELERATION_VALID_X: u64 = 1 << 3;
/// Joints that a sample has room for.
const JOINTS_MAX: usize = 4;

/// Where a channel stands in the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    /// Body axis, and whether the sensor looks along it (1) or against it (-1).
    Rate(usize, f64),
    Acceleration(usize, f64),
    JointAngle(usize),
    JointRate(usize),
    JointTorque(usize),
    Array(usize),
    /// No flying partition takes it.
    Unused,
}

impl Slot {
    /// The same number of the same sample.
    fn is_taken_by(self, other: Self) -> bool {
        match (self, other) {
            (Slot::Rate(a, _), Slot::Rate(b, _)) | (Slot::Acceleration(a, _), Slot::Acceleration(b, _)) => a == b,
            (Slot::Unused, _) => false,
            (a, b) => a == b,
        }
    }
}

/// Why a plant cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum VehicleError {
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error("its control period of {period_s} s is not a whole number of frames of {frame_s} s")]
    Period { period_s: f64, frame_s: f64 },
    #[error("sensor '{name}' gives {rows} samples a control period: {needs}")]
    Rows { name: String, rows: f64, needs: String },
    #[error("sensors '{name}' and '{other}' would stand in the same place of a sample")]
    Taken { name: String, other: String },
    #[error("sensor '{name}': a sample holds at most {limit} {what}")]
    TooMany { name: String, what: &'static str, limit: usize },
    #[error("sensor '{name}' looks along {axis:?}: samples have room for the hub's x, y and z axes alone")]
    Skew { name: String, axis: [f64; 3] },
    #[error("joint '{joint}' of sensor '{name}' slides: samples have room for angles alone")]
    Slides { name: String, joint: String },
}

/// The simulator of an experiment and the way of its channels into samples.
pub struct Vehicle {
    simulator: Simulator,
    slots: Vec<Slot>,
    /// Per actuator; `None`: it acts within a joint, whose torque sensor shows it, or on no hub.
    wrenches: Vec<Option<Wrench>>,
    array_interval_s: Option<f64>,
    joints: usize,
    period_s: f64,
    frame_s: f64,
    /// Of a craft whose rows go out, too.
    craft: Option<Plant>,
}

impl Vehicle {
    /// The vehicle of `plant`, read once a frame of `frame_s` or once in several.
    ///
    /// # Errors
    /// See [`VehicleError`].
    pub fn new(plant: &Plant, frame_s: f64, seed: u64, stream: &str) -> Result<Self, VehicleError> {
        let period_s = plant.simulation.period_s;
        let frames = period_s / frame_s;
        if frames < 0.5 || (frames - frames.round()).abs() > 1e-6 {
            return Err(VehicleError::Period { period_s, frame_s });
        }
        let slots = slots(plant)?;
        let array_interval_s = array_interval_s(plant, &slots)?;
        let joint = |slot: &Slot| match slot {
            Slot::JointAngle(joint) | Slot::JointRate(joint) | Slot::JointTorque(joint) => joint + 1,
            _ => 0,
        };
        Ok(Vehicle {
            joints: slots.iter().map(joint).max().unwrap_or(0),
            wrenches: plant.actuators.iter().map(|actuator| wrench(plant, &actuator.kind)).collect(),
            simulator: Simulator::new(plant, seed, stream)?,
            slots,
            array_interval_s,
            period_s,
            frame_s,
            craft: None,
        })
    }

    /// Publishes the rows of `craft`, whose simulator this is, too.
    pub fn with_rows(self, craft: Plant) -> Self {
        Self { craft: Some(craft), ..self }
    }

    /// Noise from the streams of `seed` and `stream` from now on: see [`Simulator::draw_from`].
    pub fn draw_from(&mut self, seed: u64, stream: &str) {
        self.simulator.draw_from(seed, stream);
    }

    /// Frames of a control period; its samples go out in the last of them, when they are known.
    pub fn frames(&self) -> u64 {
        (self.period_s / self.frame_s).round() as u64
    }

    /// State of plant, sensors and noise for a checkpoint.
    pub fn state(&self) -> impl Serialize + '_ {
        self.simulator.state()
    }

    /// Takes up what [`Vehicle::state`] returned.
    ///
    /// # Errors
    /// The state is that of another plant.
    pub fn restore(&mut self, state: &SimulatorState) -> Result<(), SimulationError> {
        self.simulator.restore(state)
    }

    /// One control period that began at `t_ns`, as samples.
    pub fn step(&mut self, excited: bool, t_ns: u64, out: &mut Outputs) {
        self.simulator.set_excited(excited);
        self.simulator.step();
        if let Err(error) = self.simulator.check_finite() {
            // values that are not finite would pass for silent sensors
            panic!("the simulation ends: {error}");
        }
        let row = self.simulator.row();
        let mut actuators = Actuators::zeroed_at(t_ns);
        actuators.interval_s = self.period_s;
        actuators.excited = u64::from(excited);
        for (command, wrench) in row.commands.iter().zip(&self.wrenches) {
            let Some(wrench) = wrench else { continue };
            for axis in 0..3 {
                actuators.force_b_n[axis] += wrench.force_n[axis] * command;
                actuators.torque_b_nm[axis] += wrench.torque_nm[axis] * command;
            }
        }
        if self.wrenches.iter().any(Option::is_some) {
            out.publish(ACTUATORS, &actuators);
        }
        publish_imu(row, &self.slots, self.period_s, t_ns, out);
        publish_joints(row, &self.slots, self.joints, t_ns, out);
        if let Some(interval_s) = self.array_interval_s {
            publish_array(row, &self.slots, interval_s, t_ns, out);
        }
        if let Some(plant) = &self.craft {
            out.publish(CRAFT, &craft::row(plant, row, self.period_s, t_ns));
        }
    }
}

fn publish_imu(row: &Row, slots: &[Slot], interval_s: f64, t_ns: u64, out: &mut Outputs) {
    let mut imu = Imu::zeroed_at(t_ns);
    imu.interval_s = interval_s;
    for sample in &row.samples {
        match slots[sample.channel] {
            Slot::Rate(axis, sign) => {
                imu.omega_bi_b_rad_s[axis] = sign * sample.value;
                imu.valid |= RATE_VALID_X << axis;
            }
            Slot::Acceleration(axis, sign) => {
                imu.acceleration_b_m_s2[axis] = sign * sample.value;
                imu.valid |= ACCELERATION_VALID_X << axis;
            }
            _ => {}
        }
    }
    if imu.valid != 0 {
        out.publish(IMU, &imu);
    }
}

fn publish_joints(row: &Row, slots: &[Slot], count: usize, t_ns: u64, out: &mut Outputs) {
    if count == 0 {
        return;
    }
    let mut joints = Joints::zeroed_at(t_ns);
    joints.count = count as u64;
    for sample in &row.samples {
        match slots[sample.channel] {
            Slot::JointAngle(joint) => joints.angle_rad[joint] = sample.value,
            Slot::JointRate(joint) => joints.rate_rad_s[joint] = sample.value,
            Slot::JointTorque(joint) => {
                joints.torque_nm[joint] = sample.value;
                joints.torque_valid |= 1 << joint;
            }
            _ => {}
        }
    }
    out.publish(JOINTS, &joints);
}

/// Rows in the order of time; a channel's n-th sample of the period stands in row n.
fn publish_array(row: &Row, slots: &[Slot], interval_s: f64, t_ns: u64, out: &mut Outputs) {
    let mut batch = Accelerometers::zeroed_at(t_ns);
    batch.interval_ns = (interval_s * 1e9).round() as u64;
    let mut rows = [0; ACCELEROMETERS_MAX];
    for sample in &row.samples {
        if let Slot::Array(channel) = slots[sample.channel] {
            batch.acceleration_m_s2[rows[channel]][channel] = sample.value;
            rows[channel] += 1;
        }
    }
    batch.channels = rows.iter().filter(|rows| **rows > 0).count() as u32;
    batch.count = rows.iter().copied().max().unwrap_or(0) as u32;
    for (n, offset) in batch.offset_ns.iter_mut().enumerate().take(batch.count as usize) {
        *offset = n as u32 * batch.interval_ns as u32;
    }
    out.publish(ACCELEROMETERS, &batch);
}

/// A place for each channel; two in one place are an error.
fn slots(plant: &Plant) -> Result<Vec<Slot>, VehicleError> {
    let mut slots: Vec<Slot> = Vec::with_capacity(plant.sensors.len());
    let joints = measured_joints(plant);
    for sensor in &plant.sensors {
        let array = slots.iter().filter(|slot| matches!(slot, Slot::Array(_))).count();
        let slot = slot(plant, sensor, &joints, array)?;
        if let Some(taken) = slots.iter().position(|other| other.is_taken_by(slot)) {
            return Err(VehicleError::Taken { name: sensor.name.clone(), other: plant.sensors[taken].name.clone() });
        }
        slots.push(slot);
    }
    Ok(slots)
}

/// Joints that some sensor measures, in the order of the bodies they carry.
fn measured_joints(plant: &Plant) -> Vec<&str> {
    let of = |sensor: &Sensor| match &sensor.kind {
        SensorKind::Encoder { joint } | SensorKind::JointRate { joint } | SensorKind::JointTorque { joint } => {
            Some(joint.clone())
        }
        _ => None,
    };
    let measured: Vec<String> = plant.sensors.iter().filter_map(of).collect();
    let names = plant.bodies.iter().map(|body| body.joint.name.as_str());
    names.filter(|name| measured.iter().any(|joint| joint == name)).collect()
}

fn slot(plant: &Plant, sensor: &Sensor, joints: &[&str], array: usize) -> Result<Slot, VehicleError> {
    let too_many = |what, limit| VehicleError::TooMany { name: sensor.name.clone(), what, limit };
    let number = |joint: &str| {
        let index = joints.iter().position(|known| *known == joint).unwrap_or(JOINTS_MAX);
        if plant.joint(joint).is_some_and(Joint::is_prismatic) {
            return Err(VehicleError::Slides { name: sensor.name.clone(), joint: joint.to_string() });
        }
        let index = if index < JOINTS_MAX { Ok(index) } else { Err(too_many("joints", JOINTS_MAX)) };
        once_a_period(plant, sensor).and(index)
    };
    let along = |body: &str, axis: [f64; 3]| {
        if !is_hub(plant, body) {
            return Ok(None);
        }
        let found = axis_index(axis).ok_or_else(|| VehicleError::Skew { name: sensor.name.clone(), axis })?;
        once_a_period(plant, sensor).map(|()| Some(found))
    };
    Ok(match &sensor.kind {
        SensorKind::Gyro { body, axis } => {
            along(body, *axis)?.map_or(Slot::Unused, |(axis, sign)| Slot::Rate(axis, sign))
        }
        SensorKind::Accelerometer { body, point: None, axis, .. } => {
            along(body, *axis)?.map_or(Slot::Unused, |(axis, sign)| Slot::Acceleration(axis, sign))
        }
        SensorKind::Accelerometer { point: Some(_), .. } if array < ACCELEROMETERS_MAX => Slot::Array(array),
        SensorKind::Accelerometer { point: Some(_), .. } => {
            return Err(too_many("accelerometers on appendages", ACCELEROMETERS_MAX));
        }
        SensorKind::Encoder { joint } => Slot::JointAngle(number(joint)?),
        SensorKind::JointRate { joint } => Slot::JointRate(number(joint)?),
        SensorKind::JointTorque { joint } => Slot::JointTorque(number(joint)?),
        _ => Slot::Unused,
    })
}

fn interval_s(plant: &Plant, sensor: &Sensor) -> f64 {
    sensor.period_s.map_or(plant.simulation.period_s, |period| period.value)
}

/// A sample a period: the inertial measurement unit and the joints have no room for more, and none
/// is made up for less.
fn once_a_period(plant: &Plant, sensor: &Sensor) -> Result<(), VehicleError> {
    let rows = plant.simulation.period_s / interval_s(plant, sensor);
    let once = (rows - 1.0).abs() < 1e-9;
    let needs = || "one is needed, as the control period is that of the samples".to_string();
    if once { Ok(()) } else { Err(VehicleError::Rows { name: sensor.name.clone(), rows, needs: needs() }) }
}

/// The interval that all accelerometers on appendages share; a whole number of them makes a period.
fn array_interval_s(plant: &Plant, slots: &[Slot]) -> Result<Option<f64>, VehicleError> {
    let mut array = plant.sensors.iter().zip(slots).filter(|(_, slot)| matches!(slot, Slot::Array(_))).peekable();
    let Some((first, _)) = array.peek() else { return Ok(None) };
    let shared_s = interval_s(plant, first);
    for (sensor, _) in array {
        let rows = plant.simulation.period_s / interval_s(plant, sensor);
        let whole = (rows - rows.round()).abs() < 1e-9 && (1.0..=BATCH_MAX as f64).contains(&rows);
        if !whole || interval_s(plant, sensor) != shared_s {
            let needs = format!("all sensors on appendages need the same whole number, 1 to {BATCH_MAX}");
            return Err(VehicleError::Rows { name: sensor.name.clone(), rows, needs });
        }
    }
    Ok(Some(shared_s))
}

/// Which body axis a unit vector is, and whether it points along (1) or against it (-1).
fn axis_index(axis: [f64; 3]) -> Option<(usize, f64)> {
    let index = axis.iter().position(|component| (component.abs() - 1.0).abs() < 1e-9)?;
    Some((index, axis[index].signum()))
}
