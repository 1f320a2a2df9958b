//! A thrown disc with an IMU inside: lever arm and spin-down left out.

use crate::desk::{diagnosed, folder, read, rig};

#[test]
fn the_flight_is_diagnosed() {
    let Some(folder) = folder("flatball_freeflight") else { return };
    let whole = &read(&folder, "throw_imu.csv")[0];
    let _found = diagnosed("thrown disc", &rig("thrown_disc"), core::slice::from_ref(whole), &[]);
}
