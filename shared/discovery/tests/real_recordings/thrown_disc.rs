//! A thrown disc with an IMU inside: lever arm and spin-down left out.

use crate::desk::{diagnosed, folder, read, rig};

#[test]
fn the_lever_arm_of_the_sensor_and_the_slowing_spin_are_found() {
    let Some(folder) = folder("flatball_freeflight") else { return };
    let whole = &read(&folder, "throw_imu.csv")[0];
    let found = diagnosed("thrown disc", &rig("thrown_disc"), whole);
    let named = |kinds: &[&str]| found.effects.iter().find(|effect| kinds.contains(&effect.kind.as_str()));
    // about a free body a sensor off the centre and a centre off the sensor are the same
    let arm = named(&["com_shift", "sensor_lever_arm"]).unwrap_or_else(|| panic!("{:?}", found.effects));
    let size = arm.parameters.iter().map(|p| p.value * p.value).sum::<f64>().sqrt();
    // the documentation's regression: 19.3, 6.5, 0.3 mm
    assert!((size - 0.0204).abs() < 0.002, "{size}");
    assert!(named(&["aerodynamic_spin_damping", "spin_damping"]).is_some(), "{:?}", found.effects);
}
