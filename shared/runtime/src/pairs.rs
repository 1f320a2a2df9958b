//! Samples of different sensors that belong together, and what a command says: the same rule for
//! every partition.

use crate::partition::Frame;
use telemetry::{ACTUATORS, Actuators, IMU, Imu, JOINTS, Joints};

const RATE_VALID_Z: u64 = 1 << 2;
const ACCELERATION_VALID_X: u64 = 1 << 3;

/// Base rates about z with the joints of the same instant; a sample without its partner is left
/// out.
pub fn rates_with_joints<'a>(frame: &'a Frame<'_>) -> impl Iterator<Item = (&'a Imu, &'a Joints)> {
    let joints = frame.samples(JOINTS);
    frame.samples(IMU).iter().filter(|imu| imu.valid & RATE_VALID_Z != 0).filter_map(|imu| {
        let of_same_time = joints.iter().find(|j| j.header.t_meas_ns == imu.header.t_meas_ns && j.count >= 2);
        Some((imu, of_same_time?))
    })
}

/// Accelerations along `axis` (0 to 2) with the forces held over the same interval; a sample
/// without its partner is left out.
pub fn accelerations_with_forces<'a>(
    frame: &'a Frame<'_>,
    axis: usize,
) -> impl Iterator<Item = (&'a Imu, &'a Actuators)> {
    let forces = frame.samples(ACTUATORS);
    frame
        .samples(IMU)
        .iter()
        .filter(move |imu| imu.valid & (ACCELERATION_VALID_X << axis) != 0)
        .filter_map(|imu| Some((imu, forces.iter().find(|force| force.header.t_meas_ns == imu.header.t_meas_ns)?)))
}

/// Whether an excitation acts over the sample's interval: announced, and commanded. A vehicle may
/// announce an experiment whose pulse is over, and a measured torque shows noise where nothing was
/// announced.
#[must_use]
pub fn is_excited(command: &Actuators) -> bool {
    command.excited != 0 && command.torque_b_nm.iter().chain(&command.force_b_n).any(|&value| value != 0.0)
}
