//! A plant as the vehicle of an experiment: its simulator, and which channel goes into which sample.

use plant::description::{ActuatorKind, JointKind, Plant, Quantity, Sensor, SensorKind};
use plant::simulation::{Row, SimulationError, Simulator, SimulatorState};
use runtime::Outputs;
use telemetry::{
    ACCELEROMETERS, ACCELEROMETERS_MAX, ACTUATORS, Accelerometers, Actuators, BATCH_MAX, IMU, Imu, JOINTS, Joints,
    Sample,
};

const RATE_VALID_X: u64 = 1;
const ACCELERATION_VALID_X: u64 = 1 << 3;
/// Joints that a sample has room for.
const JOINTS_MAX: usize = 4;

/// Where a channel stands in the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Rate(usize),
    Acceleration(usize),
    JointAngle(usize),
    JointRate(usize),
    JointTorque(usize),
    Array(usize),
    /// No flying partition takes it.
    Unused,
}

/// Where a command stands in the sample of the actuators.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrench {
    Force(usize),
    Torque(usize),
    /// Within a joint: its torque sensor shows it.
    Internal,
}

/// Why a plant cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum VehicleError {
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    #[error("its control period of {period_s} s is not a whole number of frames of {frame_s} s")]
    Period { period_s: f64, frame_s: f64 },
    #[error("sensor '{name}' gives {rows} samples a frame: a frame brings a whole number of rows, 1 to {BATCH_MAX}")]
    Rows { name: String, rows: f64 },
    #[error("sensors '{name}' and '{other}' would stand in the same place of a sample")]
    Taken { name: String, other: String },
    #[error("sensor '{name}': a sample holds at most {limit} {what}")]
    TooMany { name: String, what: &'static str, limit: usize },
}

/// The simulator of an experiment and the way of its channels into samples.
pub struct Vehicle {
    simulator: Simulator,
    slots: Vec<Slot>,
    wrenches: Vec<Wrench>,
    array_interval_s: Option<f64>,
    joints: usize,
    period_s: f64,
    frame_s: f64,
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
        })
    }

    /// Frames of a control period; its samples go out in the last of them, when they are known.
    pub fn frames(&self) -> u64 {
        (self.period_s / self.frame_s).round() as u64
    }

    pub fn state(&self) -> SimulatorState {
        self.simulator.state()
    }

    /// # Errors
    /// The state is that of another plant.
    pub fn restore(&mut self, state: &SimulatorState) -> Result<(), SimulationError> {
        self.simulator.restore(state)
    }

    /// One control period that began at `t_ns`, as samples.
    pub fn step(&mut self, excited: bool, t_ns: u64, out: &mut Outputs) {
        self.simulator.set_excited(excited);
        let row = self.simulator.step();
        let mut actuators = Actuators::zeroed_at(t_ns);
        actuators.interval_s = self.period_s;
        actuators.excited = u64::from(excited);
        for (command, wrench) in row.commands.iter().zip(&self.wrenches) {
            match *wrench {
                Wrench::Force(axis) => actuators.force_b_n[axis] += command,
                Wrench::Torque(axis) => actuators.torque_b_nm[axis] += command,
                Wrench::Internal => {}
            }
        }
        if self.wrenches.iter().any(|wrench| *wrench != Wrench::Internal) {
            out.publish(ACTUATORS, &actuators);
        }
        publish_imu(row, &self.slots, self.period_s, t_ns, out);
        publish_joints(row, &self.slots, self.joints, t_ns, out);
        if let Some(interval_s) = self.array_interval_s {
            publish_array(row, &self.slots, interval_s, t_ns, out);
        }
    }
}

fn publish_imu(row: &Row, slots: &[Slot], interval_s: f64, t_ns: u64, out: &mut Outputs) {
    let mut imu = Imu::zeroed_at(t_ns);
    imu.interval_s = interval_s;
    for sample in &row.samples {
        match slots[sample.channel] {
            Slot::Rate(axis) => {
                imu.omega_bi_b_rad_s[axis] = sample.value;
                imu.valid |= RATE_VALID_X << axis;
            }
            Slot::Acceleration(axis) => {
                imu.acceleration_b_m_s2[axis] = sample.value;
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
            Slot::JointTorque(joint) => joints.torque_nm[joint] = sample.value,
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
    let mut joints: Vec<&str> = Vec::new();
    let mut array = 0;
    for sensor in &plant.sensors {
        let slot = slot(sensor, &mut joints, &mut array)?;
        if let Some(taken) = slots.iter().position(|other| *other == slot && slot != Slot::Unused) {
            return Err(VehicleError::Taken { name: sensor.name.clone(), other: plant.sensors[taken].name.clone() });
        }
        slots.push(slot);
    }
    Ok(slots)
}

fn slot<'a>(sensor: &'a Sensor, joints: &mut Vec<&'a str>, array: &mut usize) -> Result<Slot, VehicleError> {
    let too_many = |what, limit| VehicleError::TooMany { name: sensor.name.clone(), what, limit };
    let mut number = |joint: &'a str| {
        let found = joints.iter().position(|known| *known == joint);
        let index = found.unwrap_or_else(|| {
            joints.push(joint);
            joints.len() - 1
        });
        if index < JOINTS_MAX { Ok(index) } else { Err(too_many("joints", JOINTS_MAX)) }
    };
    Ok(match &sensor.kind {
        SensorKind::Gyro { axis, .. } => axis_index(*axis).map_or(Slot::Unused, Slot::Rate),
        SensorKind::Accelerometer { point: None, axis, .. } => {
            axis_index(*axis).map_or(Slot::Unused, Slot::Acceleration)
        }
        SensorKind::Accelerometer { point: Some(_), .. } => {
            *array += 1;
            if *array > ACCELEROMETERS_MAX {
                return Err(too_many("accelerometers on appendages", ACCELEROMETERS_MAX));
            }
            Slot::Array(*array - 1)
        }
        SensorKind::Encoder { joint } => Slot::JointAngle(number(joint)?),
        SensorKind::JointRate { joint } => Slot::JointRate(number(joint)?),
        SensorKind::JointTorque { joint } => Slot::JointTorque(number(joint)?),
        _ => Slot::Unused,
    })
}

/// The interval that all accelerometers on appendages share; a whole number of them makes a period.
fn array_interval_s(plant: &Plant, slots: &[Slot]) -> Result<Option<f64>, VehicleError> {
    let mut array = plant.sensors.iter().zip(slots).filter(|(_, slot)| matches!(slot, Slot::Array(_))).peekable();
    let interval_s =
        |sensor: &Sensor| sensor.period_s.map_or(plant.simulation.period_s, |period: Quantity| period.value);
    let Some((first, _)) = array.peek() else { return Ok(None) };
    let shared_s = interval_s(first);
    for (sensor, _) in array {
        let rows = plant.simulation.period_s / interval_s(sensor);
        let whole = (rows - rows.round()).abs() < 1e-9 && (1.0..=BATCH_MAX as f64).contains(&rows);
        if !whole || interval_s(sensor) != shared_s {
            return Err(VehicleError::Rows { name: sensor.name.clone(), rows });
        }
    }
    Ok(Some(shared_s))
}

/// A joint between inertial space and a body drives the hub itself.
fn wrench(plant: &Plant, kind: &ActuatorKind) -> Wrench {
    let of_hub = |joint: &str| plant.bodies.iter().find(|body| body.joint.name == joint && body.parent.is_none());
    match kind {
        ActuatorKind::BodyForce { direction, .. } | ActuatorKind::Thruster { direction, .. } => {
            axis_index(*direction).map_or(Wrench::Internal, Wrench::Force)
        }
        ActuatorKind::BodyTorque { direction, .. } => axis_index(*direction).map_or(Wrench::Internal, Wrench::Torque),
        ActuatorKind::JointTorque { joint } => match of_hub(joint).map(|body| body.joint.kind) {
            Some(JointKind::Revolute { axis }) => axis_index(axis).map_or(Wrench::Internal, Wrench::Torque),
            Some(JointKind::Prismatic { axis }) => axis_index(axis).map_or(Wrench::Internal, Wrench::Force),
            _ => Wrench::Internal,
        },
        _ => Wrench::Internal,
    }
}

/// Which body axis a unit vector is; `None` when it is none of them, or points backwards.
fn axis_index(axis: [f64; 3]) -> Option<usize> {
    axis.iter().position(|component| (component - 1.0).abs() < 1e-9)
}
