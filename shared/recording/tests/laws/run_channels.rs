//! A recorded run as channels: every valid number its source measured, under its own name and unit,
//! once.

use crate::samples::{everything, random, seal};
use crate::{Numbers, scratch};
use recording::{Imported, RecordedRun, read, series, write_mcap, write_series};
use telemetry::{ACCELEROMETERS, Accelerometers, Header, IMU, Imu, JOINTS, Joints};

fn run(samples: &[(usize, telemetry::Stamps, Vec<u8>)]) -> RecordedRun {
    let mut run = RecordedRun::new("memory");
    for (topic, stamps, payload) in samples {
        run.push(*topic, stamps, payload).unwrap();
    }
    run
}

#[test]
fn channels_carry_the_fields_of_the_telemetry_where_they_are_valid() {
    let mut numbers = Numbers(3);
    let mut samples = Vec::new();
    for seq in 1..=4_u64 {
        let t_ns = seq * 10_000_000;
        // Rate z always, acceleration x in the first two.
        let valid = if seq <= 2 { 0b00_1100 } else { 0b00_0100 };
        let imu =
            Imu { interval_s: 0.01, omega_bi_b_rad_s: [9.0, 9.0, seq as f64], valid, ..random(&mut numbers, t_ns) };
        samples.push(seal(IMU, imu, seq, 0));
        samples.push(seal(JOINTS, Joints { count: 2, ..random(&mut numbers, t_ns) }, seq, 0));
        let mut batch = Accelerometers { count: 2, channels: 3, ..random(&mut numbers, t_ns) };
        (batch.offset_ns[0], batch.offset_ns[1]) = (0, 5_000_000);
        (batch.acceleration_m_s2[0][2], batch.acceleration_m_s2[1][2]) = (seq as f64, seq as f64 + 0.5);
        samples.push(seal(ACCELEROMETERS, batch, seq, 0));
    }
    // A restarted source sends the first two again.
    samples.extend_from_within(..2);
    let path = scratch("channels.mcap");
    write_mcap(&run(&samples), &path).unwrap();
    let set = series(read(&path).unwrap()).unwrap();
    let named = |name: &str| set.recording.channel_named(name).unwrap_or_else(|| panic!("{name} in {:?}", names(&set)));
    let rate = named("imu.omega_bi_b.z");
    assert_eq!(
        (rate.unit.as_str(), &rate.time_s[..], &rate.value[..]),
        ("rad/s", &[0.01, 0.02, 0.03, 0.04][..], &[1.0, 2.0, 3.0, 4.0][..])
    );
    assert_eq!(named("imu.acceleration_b.x").time_s, [0.01, 0.02]);
    assert_eq!(named("imu.interval").value, [0.01; 4]);
    assert_eq!(named("joints.torque.2").unit, "N*m");
    let array = named("accelerometers.acceleration.3");
    assert_eq!(array.time_s, [0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.045]);
    assert_eq!(array.value, [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5]);
    for absent in ["imu.omega_bi_b.x", "joints.angle.3", "accelerometers.acceleration.4", "imu.valid"] {
        assert!(set.recording.channel_named(absent).is_none(), "{absent} was never valid");
    }
    let again = scratch("channels.csv");
    write_series(&set.recording, &again).unwrap();
    assert_eq!(series(read(&again).unwrap()).unwrap().recording.channels, set.recording.channels);
}

fn names(set: &recording::SeriesSet) -> Vec<&str> {
    set.recording.channels.iter().map(|channel| channel.name.as_str()).collect()
}

#[test]
fn every_measured_field_has_a_unit_of_the_table_and_results_are_no_measurements() {
    let mut samples = Vec::new();
    for sample in everything(3).samples() {
        // One row a batch: its random offsets are no times.
        if sample.topic != ACCELEROMETERS.id {
            samples.push((sample.topic, *sample.stamps, sample.payload.to_vec()));
        }
    }
    let batch = Accelerometers { header: Header::at(0), count: 1, channels: 12, ..random(&mut Numbers(1), 0) };
    samples.push(seal(ACCELEROMETERS, batch, 1, 0));
    let set = series(Imported::Run(run(&samples))).unwrap();
    for name in
        ["actuators.force_b.x", "actuators.torque_b.y", "actuators.wheel_momentum", "accelerometers.acceleration.12"]
    {
        assert!(set.recording.channel_named(name).is_some(), "{name} in {:?}", names(&set));
    }
    assert_eq!(set.recording.channel_named("actuators.wheel_momentum").unwrap().unit, "N*m*s");
    let measured = ["imu.", "joints.", "actuators.", "accelerometers."];
    assert!(names(&set).iter().all(|name| measured.iter().any(|topic| name.starts_with(topic))));
    let error = series(Imported::Run(RecordedRun::new("memory"))).unwrap_err().explain();
    assert!(error.contains("no sample of imu") && error.contains("--record"), "{error}");
}
