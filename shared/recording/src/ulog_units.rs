//! Units of PX4's messages, where the definition of the message states one.

/// Topics, fields without their index, unit.
const UNITS: &[(&[&str], &[&str], &str)] = &[
    (&["sensor_accel", "vehicle_acceleration"], &["x", "y", "z", "xyz"], "m/s^2"),
    (&["sensor_gyro", "vehicle_angular_velocity"], &["x", "y", "z", "xyz"], "rad/s"),
    (&["vehicle_angular_velocity"], &["xyz_derivative"], "rad/s^2"),
    (&["sensor_accel", "sensor_gyro", "sensor_baro"], &["temperature"], "degC"),
    (&["sensor_combined"], &["gyro_rad"], "rad/s"),
    (&["sensor_combined"], &["accelerometer_m_s2"], "m/s^2"),
    (&["sensor_combined"], &["gyro_integral_dt", "accelerometer_integral_dt"], "us"),
    (&["sensor_baro"], &["pressure"], "Pa"),
    (&["vehicle_air_data"], &["baro_alt_meter"], "m"),
    (&["vehicle_air_data"], &["baro_pressure_pa"], "Pa"),
    (&["vehicle_air_data"], &["ambient_temperature", "baro_temp_celcius"], "degC"),
    (&["vehicle_local_position"], &["x", "y", "z", "ref_alt", "dist_bottom", "eph", "epv"], "m"),
    (&["vehicle_local_position"], &["vx", "vy", "vz", "z_deriv", "evh", "evv"], "m/s"),
    (&["vehicle_local_position"], &["ax", "ay", "az"], "m/s^2"),
    (&["vehicle_local_position"], &["heading"], "rad"),
    (&["battery_status"], &["voltage_v", "voltage_filtered_v", "voltage_cell_v"], "V"),
    (&["battery_status"], &["current_a", "current_filtered_a", "current_average_a"], "A"),
];

/// The unit of a field of a topic; times of every topic are in microseconds.
pub(crate) fn unit(topic: &str, field: &str) -> Option<&'static str> {
    let field = field.split('[').next().unwrap_or(field);
    if matches!(field, "timestamp" | "timestamp_sample") {
        return Some("us");
    }
    let states = |(topics, fields, _): &&(&[&str], &[&str], &str)| topics.contains(&topic) && fields.contains(&field);
    UNITS.iter().find(states).map(|(.., unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_known_by_topic_and_field_and_by_nothing_else() {
        assert_eq!(unit("sensor_gyro", "x"), Some("rad/s"));
        assert_eq!(unit("vehicle_angular_velocity", "xyz[2]"), Some("rad/s"));
        assert_eq!(unit("vehicle_local_position", "x"), Some("m"));
        assert_eq!(unit("sensor_accel", "clip_counter[0]"), None);
        assert_eq!(unit("my_topic", "x"), None);
        assert_eq!(unit("my_topic", "timestamp"), Some("us"));
    }
}
