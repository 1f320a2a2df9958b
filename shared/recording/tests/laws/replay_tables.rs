//! Replay of tables: every row in its frame, once, with its values; limits.

use crate::file;
use recording::csv::read_csv;
use recording::{ChannelMap, Column, ReplayFrames, ReplaySample, Table};

const PERIOD_NS: u64 = 10_000_000;

fn table(interval_s: f64, rows: usize, names: &[(&str, &'static str)]) -> Table {
    let time = (0..rows).map(|i| i as f64 * interval_s).collect();
    let columns = names.iter().enumerate().map(|(c, (name, unit))| {
        Column::si(name, unit, (0..rows).map(|i| i as f64 + 1000.0 * (c + 1) as f64).collect())
    });
    Table::from_columns("table.csv", time, columns.collect()).unwrap()
}

fn samples(frames: &ReplayFrames, k: u64) -> Vec<ReplaySample> {
    let mut all = Vec::new();
    frames.frame(k, &mut |sample| all.push(sample));
    all
}

#[test]
fn every_row_is_emitted_once_in_the_frame_of_its_time_in_any_order_of_asking() {
    for interval_s in [0.001, 0.004, 0.01, 0.0371, 0.5] {
        let table = table(interval_s, 777, &[("rate", "rad/s"), ("acceleration_x", "m/s^2"), ("force_x", "N")]);
        let frames = ReplayFrames::from_table(&table, None, PERIOD_NS).unwrap();
        assert_eq!(frames.frame_count(), (776.0 * interval_s * 1e9).round() as u64 / PERIOD_NS + 1);
        let mut row = 0;
        for k in 0..frames.frame_count() {
            for sample in samples(&frames, k) {
                let ReplaySample::Imu(imu) = sample else { continue };
                assert_eq!(imu.header.t_meas_ns, (row as f64 * interval_s * 1e9).round() as u64);
                assert_eq!(imu.header.t_meas_ns / PERIOD_NS, k);
                assert_eq!(imu.omega_bi_b_rad_s, [0.0, 0.0, 1000.0 + f64::from(row)]);
                assert_eq!(imu.acceleration_b_m_s2, [2000.0 + f64::from(row), 0.0, 0.0]);
                assert_eq!(imu.valid, 0b00_1100);
                assert_eq!(imu.interval_s, interval_s);
                row += 1;
            }
        }
        assert_eq!(row, 777);
        let k = frames.frame_count() / 2;
        assert_eq!(samples(&frames, k), samples(&frames, k));
        assert!(samples(&frames, frames.frame_count()).is_empty());
        assert!(samples(&frames, u64::MAX).is_empty());
    }
}

#[test]
fn actuators_and_joints_carry_their_columns() {
    let names = [
        ("force_y", "N"),
        ("torque", "N*m"),
        ("wheel_momentum", "N*m*s"),
        ("joint1_angle", "rad"),
        ("joint1_rate", "rad/s"),
        ("joint1_torque", "N*m"),
        ("joint2_angle", "rad"),
        ("joint2_rate", "rad/s"),
    ];
    let frames = ReplayFrames::from_table(&table(0.005, 20, &names), None, PERIOD_NS).unwrap();
    let [ReplaySample::Joints(joints), ReplaySample::Actuators(actuators), ..] = samples(&frames, 1)[..] else {
        panic!("{:?}", samples(&frames, 1))
    };
    assert_eq!(joints.count, 2);
    assert_eq!(joints.angle_rad, [4002.0, 7002.0, 0.0, 0.0]);
    assert_eq!(joints.rate_rad_s, [5002.0, 8002.0, 0.0, 0.0]);
    assert_eq!((joints.torque_nm, joints.torque_valid), ([6002.0, 0.0, 0.0, 0.0], 0b0001));
    assert_eq!(actuators.force_b_n, [0.0, 1002.0, 0.0]);
    assert_eq!(actuators.torque_b_nm, [0.0, 0.0, 2002.0]);
    // Force and torque rise evenly and never pause: nothing is behind them.
    assert_eq!((actuators.wheel_momentum_nms, actuators.excited), (3002.0, 0));
    assert_eq!(actuators.interval_s, 0.005);
}

#[test]
fn excitation_is_on_in_the_rows_of_the_pulse_although_the_measured_torque_is_never_zero() {
    let pulse = |n: usize| if (20..60).contains(&n) { 2.0 } else { 1e-3 * (1.0 + (n % 7) as f64) };
    let time = (0..300).map(|n| n as f64 * 0.005).collect();
    let columns = vec![Column::si("torque_z", "N*m", (0..300).map(pulse).collect())];
    let table = Table::from_columns("pulse.csv", time, columns).unwrap();
    let frames = ReplayFrames::from_table(&table, None, PERIOD_NS).unwrap();
    let excited: Vec<u64> = (0..frames.frame_count())
        .flat_map(|k| samples(&frames, k))
        .filter_map(
            |sample| if let ReplaySample::Actuators(actuators) = sample { Some(actuators.excited) } else { None },
        )
        .collect();
    assert_eq!(excited, (0..300).map(|n| u64::from((20..60).contains(&n))).collect::<Vec<_>>());
}

#[test]
fn accelerations_alone_become_batches_too() {
    let table =
        table(0.002, 101, &[("acceleration_x", "m/s^2"), ("acceleration_y", "m/s^2"), ("acceleration_z", "m/s^2")]);
    let frames = ReplayFrames::from_table(&table, None, PERIOD_NS).unwrap();
    assert!(frames.identifiable().modal);
    let all = samples(&frames, 3);
    assert_eq!(all.len(), 6);
    let ReplaySample::Accelerometers(batch) = all[5] else { panic!("the batch comes last") };
    assert_eq!((batch.count, batch.channels, batch.interval_ns), (5, 3, 2_000_000));
    assert_eq!(batch.header.t_meas_ns, 30_000_000);
    assert_eq!(batch.offset_ns[..6], [0, 2_000_000, 4_000_000, 6_000_000, 8_000_000, 0]);
    assert_eq!(batch.acceleration_m_s2[4][..4], [1019.0, 2019.0, 3019.0, 0.0]);
    assert_eq!(batch.acceleration_m_s2[5], [0.0; 12]);
}

#[test]
fn a_fast_vibration_record_is_replayed_as_array_only() {
    let frames =
        ReplayFrames::from_table(&table(0.0002, 500, &[("acceleration_x", "m/s^2")]), None, PERIOD_NS).unwrap();
    let [ReplaySample::Accelerometers(batch)] = samples(&frames, 2)[..] else { panic!() };
    assert_eq!(batch.count, 50);
    assert!(frames.notes().iter().any(|note| note.contains("accelerometer array only")));
}

#[test]
fn more_rows_than_a_frame_carries_is_an_error_whose_cure_works() {
    let fast = table(1.0 / 1024.0, 2048, &[("force_x", "N"), ("acceleration_x", "m/s^2")]);
    let error = ReplayFrames::from_table(&fast, None, PERIOD_NS).unwrap_err().explain();
    for part in [
        "table.csv: frame ",
        "of 10 ms has 11 rows of imu (1024.0 Hz), a frame carries 10",
        "period of 9.7 ms or less",
        "decimate",
    ] {
        assert!(error.contains(part), "{error}");
    }
    assert!(ReplayFrames::from_table(&fast, None, 9_700_000).is_ok());
    let faster = table(1e-4, 5000, &[("acceleration_1", "m/s^2")]);
    let error = ReplayFrames::from_table(&faster, None, PERIOD_NS).unwrap_err().explain();
    assert!(error.contains("100 rows of accelerometers") && error.contains("carries 64"), "{error}");
    assert!(error.contains("6.3 ms or less"), "{error}");
    assert!(ReplayFrames::from_table(&faster, None, 6_300_000).is_ok());
}

#[test]
fn a_gap_is_empty_frames_and_its_interval_is_the_regular_one() {
    let text = "time [s],rate [rad/s]\n0,1\n0.01,1\n0.02,1\n0.08,1\n0.09,1\n";
    let frames = ReplayFrames::from_table(&read_csv(&file("gapreplay.csv", text)).unwrap(), None, PERIOD_NS).unwrap();
    let counts: Vec<usize> = (0..frames.frame_count()).map(|k| samples(&frames, k).len()).collect();
    assert_eq!(counts, [1, 1, 1, 0, 0, 0, 0, 0, 1, 1]);
    let ReplaySample::Imu(imu) = samples(&frames, 2)[0] else { panic!() };
    assert_eq!(imu.interval_s, 0.01);
    assert!(frames.notes()[0].contains("gap"));
}

#[test]
fn uneven_stamps_give_every_row_its_own_interval() {
    let text = "time [s],rate [rad/s]\n0,1\n0.0105,1\n0.02,1\n0.0305,1\n0.04,1\n";
    let frames = ReplayFrames::from_table(&read_csv(&file("uneven.csv", text)).unwrap(), None, 100_000_000).unwrap();
    let intervals: Vec<f64> = samples(&frames, 0)
        .iter()
        .map(|sample| if let ReplaySample::Imu(imu) = sample { imu.interval_s } else { panic!() })
        .collect();
    assert_eq!(intervals, [0.0105, 0.0095, 0.0105, 0.0095, 0.01]);
}

#[test]
fn a_table_without_channels_and_a_senseless_period_are_refused() {
    let table = table(0.01, 5, &[("angle", "rad"), ("height", "m")]);
    let error = ReplayFrames::from_table(&table, None, PERIOD_NS).unwrap_err().explain();
    assert!(error.contains("columns: angle [rad], height [m]") && error.contains("map file"), "{error}");
    let map = ChannelMap::parse("m", "[channels]\njoint1.angle = \"angle\"\njoint1.rate = \"angle\"").unwrap();
    let error = ReplayFrames::from_table(&table, Some(&map), PERIOD_NS).unwrap_err().explain();
    assert!(error.contains("unit `rad` does not measure `joint1.rate`"), "{error}");
    for period in [0, 5_000_000_000] {
        assert!(ReplayFrames::from_table(&table, None, period).unwrap_err().explain().contains("1 ns to 4.29 s"));
    }
}
