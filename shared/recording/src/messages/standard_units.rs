//! Units of the fields of standard messages: type, field, unit. A unit holds for all that is inside
//! the field.

/// The unit of `field` in messages of `kind`, where the standard states one.
pub(crate) fn unit_of(kind: &str, field: &str) -> Option<&'static str> {
    UNITS.iter().find(|(of, name, _)| *of == kind && *name == field).map(|(.., unit)| *unit)
}

/// One table for ROS 1 and ROS 2: type names are without `msg/`.
const UNITS: &[(&str, &str, &str)] = &[
    ("geometry_msgs/Accel", "linear", "m/s^2"),
    ("geometry_msgs/Accel", "angular", "rad/s^2"),
    ("geometry_msgs/Inertia", "m", "kg"),
    ("geometry_msgs/Inertia", "com", "m"),
    ("geometry_msgs/Inertia", "ixx", "kg*m^2"),
    ("geometry_msgs/Inertia", "ixy", "kg*m^2"),
    ("geometry_msgs/Inertia", "ixz", "kg*m^2"),
    ("geometry_msgs/Inertia", "iyy", "kg*m^2"),
    ("geometry_msgs/Inertia", "iyz", "kg*m^2"),
    ("geometry_msgs/Inertia", "izz", "kg*m^2"),
    ("geometry_msgs/PointStamped", "point", "m"),
    ("geometry_msgs/Pose", "position", "m"),
    ("geometry_msgs/Pose", "orientation", "-"),
    ("geometry_msgs/Pose2D", "x", "m"),
    ("geometry_msgs/Pose2D", "y", "m"),
    ("geometry_msgs/Pose2D", "theta", "rad"),
    ("geometry_msgs/QuaternionStamped", "quaternion", "-"),
    ("geometry_msgs/Transform", "translation", "m"),
    ("geometry_msgs/Transform", "rotation", "-"),
    ("geometry_msgs/Twist", "linear", "m/s"),
    ("geometry_msgs/Twist", "angular", "rad/s"),
    ("geometry_msgs/Wrench", "force", "N"),
    ("geometry_msgs/Wrench", "torque", "N*m"),
    ("sensor_msgs/BatteryState", "voltage", "V"),
    ("sensor_msgs/BatteryState", "temperature", "degC"),
    ("sensor_msgs/BatteryState", "current", "A"),
    ("sensor_msgs/BatteryState", "percentage", "-"),
    ("sensor_msgs/BatteryState", "cell_voltage", "V"),
    ("sensor_msgs/BatteryState", "cell_temperature", "degC"),
    ("sensor_msgs/FluidPressure", "fluid_pressure", "Pa"),
    ("sensor_msgs/Imu", "orientation", "-"),
    ("sensor_msgs/Imu", "angular_velocity", "rad/s"),
    ("sensor_msgs/Imu", "linear_acceleration", "m/s^2"),
    ("sensor_msgs/MagneticField", "magnetic_field", "T"),
    ("sensor_msgs/NavSatFix", "latitude", "deg"),
    ("sensor_msgs/NavSatFix", "longitude", "deg"),
    ("sensor_msgs/NavSatFix", "altitude", "m"),
    ("sensor_msgs/Range", "field_of_view", "rad"),
    ("sensor_msgs/Range", "min_range", "m"),
    ("sensor_msgs/Range", "max_range", "m"),
    ("sensor_msgs/Range", "range", "m"),
    ("sensor_msgs/RelativeHumidity", "relative_humidity", "-"),
    ("sensor_msgs/Temperature", "temperature", "degC"),
];
