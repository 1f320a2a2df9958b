//! Sensors as data sheets state them, and the clocks of their sources.

use super::{Orientation, Quantity};

/// White noise of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Standard deviation of one sample [SI unit of the channel].
    PerSample(Quantity),
    /// Density [unit·√s], i.e. angle or velocity random walk: one sample has N/√Δt.
    Density(Quantity),
}

impl Default for Noise {
    fn default() -> Self {
        Self::PerSample(Quantity::known(0.0))
    }
}

/// Relation of a sample to time: an instant or a mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reading {
    /// The value at the instant.
    #[default]
    Instant,
    /// Mean over the sample interval that begins at the time stamp (angle and velocity increments
    /// divided by Δt; for an accelerometer the inertial velocity increment in body axes at
    /// mid-interval).
    Mean,
}

/// Measured quantity, with its place and axis.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorKind {
    /// Inertial angular rate along `axis` [rad/s].
    Gyro {
        body: String,
        axis: [f64; 3],
    },
    /// Specific force (acceleration minus gravity) along `axis` at `position_m` [m/s²]; `point`: of
    /// an appendage, whose modes then add.
    Accelerometer {
        body: String,
        position_m: [Quantity; 3],
        axis: [f64; 3],
        point: Option<(String, String)>,
    },
    /// Joint angle \[rad\] or displacement \[m\].
    Encoder {
        joint: String,
    },
    JointRate {
        joint: String,
    },
    /// Torque [N m] or force \[N\] in the joint's axis that its actuators apply, or that imposes
    /// its motion; friction and springs are not in it.
    JointTorque {
        joint: String,
    },
    /// Force \[N\] transmitted through a joint along `axis` of the outboard body.
    Force {
        joint: String,
        axis: [f64; 3],
    },
    /// Torque [N m] transmitted through a joint about `axis` of the outboard body, at the joint's
    /// origin.
    Torque {
        joint: String,
        axis: [f64; 3],
    },
    /// Inertial position of a point along `axis` of inertial space \[m\].
    Position {
        body: String,
        position_m: [Quantity; 3],
        axis: [f64; 3],
    },
    /// Inertial velocity of a point along `axis` of inertial space [m/s].
    Velocity {
        body: String,
        position_m: [Quantity; 3],
        axis: [f64; 3],
    },
    /// Rotation vector component along `axis` of body relative to inertial space \[rad\]; planar:
    /// the angle.
    Attitude {
        body: String,
        axis: [f64; 3],
    },
    /// Speed of a wheel's rotor relative to its body [rad/s].
    WheelSpeed {
        actuator: String,
    },
}

impl SensorKind {
    /// Whether it has a sensitive axis that a misalignment can turn; in a plane an axis along z has
    /// none.
    pub const fn has_direction(&self, planar: bool) -> bool {
        match self {
            Self::Accelerometer { .. } | Self::Force { .. } | Self::Position { .. } | Self::Velocity { .. } => true,
            Self::Gyro { .. } | Self::Torque { .. } | Self::Attitude { .. } => !planar,
            Self::Encoder { .. } | Self::JointRate { .. } | Self::JointTorque { .. } | Self::WheelSpeed { .. } => false,
        }
    }
}

/// One scalar channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    pub name: String,
    pub kind: SensorKind,
    pub noise: Noise,
    pub bias: Quantity,
    /// Relative error of scale: reading = (1 + scale) × value + bias.
    pub scale: Quantity,
    /// Small turn of the sensitive axis, and the body axis about which it turns.
    pub misalignment: Orientation,
    pub range: Option<Quantity>,
    /// Quantisation step; zero: none.
    pub resolution: Quantity,
    /// Cut-off of a first-order low-pass \[Hz\]; `None`: none.
    pub low_pass_hz: Option<Quantity>,
    pub delay_s: Quantity,
    /// Time between samples; `None`: the record's.
    pub period_s: Option<Quantity>,
    pub reading: Reading,
    /// Name of the clock it is stamped by.
    pub source: Option<String>,
}

/// A source of samples with its own clock: stamped time = (1 + skew) t + offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    pub name: String,
    pub clock_offset_s: Quantity,
    pub clock_skew: Quantity,
}
