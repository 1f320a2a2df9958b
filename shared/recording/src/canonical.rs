//! Canonical channels: the one list, the column each is found under, and what can be identified
//! from them.

use crate::error::{Place, RecordingError};
use crate::map::ChannelMap;
use crate::table::Table;
use crate::units::{NOT_STATED, accepted_for};
use core::ops::Range;

/// A quantity obsid knows what to do with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Column names under which it is found when there is no map, in order of preference.
    pub columns: &'static [&'static str],
}

const fn c(name: &'static str, unit: &'static str, columns: &'static [&'static str]) -> ChannelInfo {
    ChannelInfo { name, unit, columns }
}

/// Every channel.
pub static CHANNELS: &[ChannelInfo] = &[
    c("imu.rate_x", "rad/s", &["rate_x"]),
    c("imu.rate_y", "rad/s", &["rate_y"]),
    c("imu.rate_z", "rad/s", &["rate_z", "rate"]),
    c("imu.accel_x", "m/s^2", &["acceleration_x"]),
    c("imu.accel_y", "m/s^2", &["acceleration_y"]),
    c("imu.accel_z", "m/s^2", &["acceleration_z"]),
    c("force.x", "N", &["force_x"]),
    c("force.y", "N", &["force_y"]),
    c("force.z", "N", &["force_z"]),
    c("torque.x", "N*m", &["torque_x"]),
    c("torque.y", "N*m", &["torque_y"]),
    c("torque.z", "N*m", &["torque_z", "torque"]),
    c("wheel.momentum", "N*m*s", &["wheel_momentum"]),
    c("joint1.angle", "rad", &["joint1_angle"]),
    c("joint2.angle", "rad", &["joint2_angle"]),
    c("joint3.angle", "rad", &["joint3_angle"]),
    c("joint4.angle", "rad", &["joint4_angle"]),
    c("joint1.rate", "rad/s", &["joint1_rate"]),
    c("joint2.rate", "rad/s", &["joint2_rate"]),
    c("joint3.rate", "rad/s", &["joint3_rate"]),
    c("joint4.rate", "rad/s", &["joint4_rate"]),
    c("joint1.torque", "N*m", &["joint1_torque"]),
    c("joint2.torque", "N*m", &["joint2_torque"]),
    c("joint3.torque", "N*m", &["joint3_torque"]),
    c("joint4.torque", "N*m", &["joint4_torque"]),
    c("accel.1", "m/s^2", &["acceleration_1"]),
    c("accel.2", "m/s^2", &["acceleration_2"]),
    c("accel.3", "m/s^2", &["acceleration_3"]),
    c("accel.4", "m/s^2", &["acceleration_4"]),
    c("accel.5", "m/s^2", &["acceleration_5"]),
    c("accel.6", "m/s^2", &["acceleration_6"]),
    c("accel.7", "m/s^2", &["acceleration_7"]),
    c("accel.8", "m/s^2", &["acceleration_8"]),
    c("accel.9", "m/s^2", &["acceleration_9"]),
    c("accel.10", "m/s^2", &["acceleration_10"]),
    c("accel.11", "m/s^2", &["acceleration_11"]),
    c("accel.12", "m/s^2", &["acceleration_12"]),
];

pub(crate) const RATE: Range<usize> = 0..3;
pub(crate) const ACCELERATION: Range<usize> = 3..6;
pub(crate) const FORCE: Range<usize> = 6..9;
pub(crate) const TORQUE: Range<usize> = 9..12;
pub(crate) const WHEEL: usize = 12;
pub(crate) const ANGLE: Range<usize> = 13..17;
pub(crate) const JOINT_RATE: Range<usize> = 17..21;
pub(crate) const JOINT_TORQUE: Range<usize> = 21..25;
pub(crate) const ARRAY: Range<usize> = 25..37;

/// The channel that a column of this name feeds when there is no map.
#[must_use]
pub fn default_channel(column: &str) -> Option<&'static ChannelInfo> {
    CHANNELS.iter().find(|channel| channel.columns.contains(&column))
}

/// What can be identified from a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Domains {
    /// Base rate about z and at least two joints with angle and rate.
    pub inertial: bool,
    /// Force and acceleration along one axis at least.
    pub slosh: bool,
    /// An accelerometer array.
    pub modal: bool,
}

/// Which column of a table feeds which channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channels {
    /// Per entry of [`CHANNELS`]: index into the table's columns.
    columns: Vec<Option<usize>>,
    joints: usize,
    array: Vec<usize>,
    /// Channels that were found but cannot be used, and what was read in a second way.
    notes: Vec<String>,
}

impl Channels {
    /// Finds the channels by the map, or by default column names when there is none.
    ///
    /// # Errors
    /// A column with a unit of another dimension; a map that names a column the table does not
    /// have; with a map, a joint or an accelerometer array given in part.
    pub fn find(table: &Table, map: Option<&ChannelMap>) -> Result<Self, RecordingError> {
        let columns = match map {
            Some(map) => map.columns(table)?,
            None => CHANNELS
                .iter()
                .map(|channel| channel.columns.iter().find_map(|name| table.column_named(name)))
                .collect(),
        };
        for (channel, column) in CHANNELS.iter().zip(&columns) {
            if let Some(column) = *column {
                check_unit(table, channel, column)?;
            }
        }
        let mut channels = Channels { columns, joints: 0, array: Vec::new(), notes: Vec::new() };
        channels.joints = channels.complete_joints(table, map.is_some())?;
        channels.array = channels.complete_array(table, map.is_some())?;
        channels.accelerations_as_array();
        Ok(channels)
    }

    /// Column of a channel, by its index in [`CHANNELS`].
    pub(crate) fn column(&self, channel: usize) -> Option<usize> {
        self.columns[channel]
    }

    pub(crate) fn any(&self, range: Range<usize>) -> bool {
        self.columns[range].iter().any(Option::is_some)
    }

    /// Joints that have angle and rate; those without torque are replayed with torque 0, not valid.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Columns of the accelerometer array.
    #[must_use]
    pub fn array(&self) -> &[usize] {
        &self.array
    }

    /// What was repaired or assumed when channels were matched, one sentence each.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Names of the channels found, with the column of each.
    pub fn found(&self) -> impl Iterator<Item = (&'static ChannelInfo, usize)> + '_ {
        CHANNELS.iter().zip(&self.columns).filter_map(|(channel, column)| Some((channel, (*column)?)))
    }

    /// What can be identified from these channels.
    #[must_use]
    pub fn identifiable(&self) -> Domains {
        let along = |axis: usize| self.columns[FORCE.start + axis].and(self.columns[ACCELERATION.start + axis]);
        Domains {
            inertial: self.columns[RATE.start + 2].is_some() && self.joints >= 2,
            slosh: (0..3).any(|axis| along(axis).is_some()),
            modal: !self.array.is_empty(),
        }
    }

    fn complete_joints(&mut self, table: &Table, strict: bool) -> Result<usize, RecordingError> {
        let given = |range: &Range<usize>, joint: usize| self.columns[range.start + joint].is_some();
        let parts = [ANGLE, JOINT_RATE, JOINT_TORQUE];
        let count = (0..4).rev().find(|joint| parts.iter().any(|part| given(part, *joint))).map_or(0, |j| j + 1);
        let missing = (0..count).flat_map(|joint| [ANGLE.start + joint, JOINT_RATE.start + joint]);
        match missing.into_iter().find(|channel| self.columns[*channel].is_none()) {
            None => Ok(count),
            Some(channel) => self.incomplete(table, strict, "joint group", channel),
        }
    }

    fn complete_array(&mut self, table: &Table, strict: bool) -> Result<Vec<usize>, RecordingError> {
        let given = &self.columns[ARRAY];
        let count = given.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        match given[..count].iter().position(Option::is_none) {
            None => Ok(given[..count].iter().flatten().copied().collect()),
            Some(hole) => self.incomplete(table, strict, "accelerometer array", ARRAY.start + hole).map(|_| Vec::new()),
        }
    }

    /// A group with a hole is rejected where a map asked for it, and left out with a note where
    /// only names matched.
    fn incomplete(
        &mut self,
        table: &Table,
        strict: bool,
        group: &str,
        channel: usize,
    ) -> Result<usize, RecordingError> {
        let missing = CHANNELS[channel].name;
        if strict {
            return Err(RecordingError::MissingChannel { file: table.file.clone(), group: group.into(), missing });
        }
        self.notes.push(format!("{group} left out: `{missing}` is missing"));
        Ok(0)
    }

    /// Accelerations alone are a vibration record: x, y, z also serve as array, so that modes can
    /// be identified.
    fn accelerations_as_array(&mut self) {
        let others = [RATE, FORCE, TORQUE, ANGLE, JOINT_RATE, JOINT_TORQUE, ARRAY, WHEEL..WHEEL + 1];
        if self.any(ACCELERATION) && !others.into_iter().any(|range| self.any(range)) {
            self.array = self.columns[ACCELERATION].iter().flatten().copied().collect();
            self.notes.push("accelerations only: read as accelerometer array too, in the order x, y, z".into());
        }
    }
}

fn check_unit(table: &Table, channel: &'static ChannelInfo, column: usize) -> Result<(), RecordingError> {
    let found = &table.columns[column];
    if found.unit == channel.unit {
        return Ok(());
    }
    // Column 1 is the time.
    let place = Box::new(Place { file: table.file.clone(), line: 1, column: column + 2, name: found.header() });
    if found.unit == NOT_STATED {
        let (name, unit) = (&found.name, channel.unit);
        let cure =
            format!("say it: --channel '{} = {name} [{unit}]', if {unit} is what the numbers are in", channel.name);
        return Err(RecordingError::UnitNotStated { place, channel: channel.name, cure });
    }
    Err(RecordingError::ChannelUnit {
        place,
        found: found.unit_in_file.clone(),
        channel: channel.name,
        accepted: accepted_for(channel.unit),
    })
}
