//! Replay of recorded runs: the source's samples, in the frames in which they were flown.

use crate::samples::{random, seal};
use crate::{Numbers, scratch};
use recording::{ChannelMap, Imported, RecordedRun, ReplayFrames, ReplaySample, read_mcap, write_mcap};
use telemetry::{ACCELEROMETERS, ACTUATORS, Accelerometers, Actuators, Header, IMU, Imu, TICK, TOPICS_MAX, Tick};

const PERIOD_NS: u64 = 10_000_000;

/// A run of `frames` frames, two IMU samples and a batch each; the second IMU sample of frame 4 is
/// flown in frame 5.
fn flown(frames: u64, ticks: bool) -> RecordedRun {
    let mut numbers = Numbers(21);
    let mut run = RecordedRun::new("run");
    let mut seq = [0u64; TOPICS_MAX];
    let mut add = |(topic, stamps, payload): (usize, telemetry::Stamps, Vec<u8>)| {
        run.push(topic, &stamps, &payload).unwrap();
    };
    for frame in 0..frames {
        let t = frame * PERIOD_NS;
        for half in 0..2 {
            seq[IMU.id] += 1;
            add(seal(IMU, Imu { valid: 63, ..random(&mut numbers, t + half * PERIOD_NS / 2) }, seq[IMU.id], 0));
        }
        seq[ACTUATORS.id] += 1;
        add(seal(ACTUATORS, random::<Actuators>(&mut numbers, t), seq[ACTUATORS.id], 0));
        seq[ACCELEROMETERS.id] += 1;
        let mut batch = Accelerometers { count: 3, channels: 2, ..random(&mut numbers, t) };
        batch.offset_ns[3..].fill(0);
        for (i, row) in batch.acceleration_m_s2.iter_mut().enumerate() {
            if i >= 3 { row.fill(0.0) } else { row[2..].fill(0.0) }
        }
        add(seal(ACCELEROMETERS, batch, seq[ACCELEROMETERS.id], 0));
        let mut last_seq = seq;
        if frame == 4 {
            last_seq[IMU.id] -= 1;
        }
        if ticks {
            let tick = Tick { header: Header::at(t), frame, t_ns: t, flags: 0, last_seq };
            add(seal(TICK, tick, frame + 1, 0));
        }
    }
    run
}

fn imus(frames: &ReplayFrames, k: u64) -> Vec<u64> {
    let mut times = Vec::new();
    frames.frame(k, &mut |sample| {
        if let ReplaySample::Imu(imu) = sample {
            times.push(imu.header.t_meas_ns);
        }
    });
    times
}

#[test]
fn samples_come_in_the_frame_in_which_their_tick_let_them_through() {
    let path = scratch("flown.mcap");
    write_mcap(&flown(10, true), &path).unwrap();
    let run = read_mcap(&path).unwrap();
    let frames = ReplayFrames::from_run(&run, PERIOD_NS).unwrap();
    assert_eq!(frames.frame_count(), 10);
    let at = |k: u64, half: u64| k * PERIOD_NS + half * PERIOD_NS / 2;
    assert_eq!(imus(&frames, 3), [at(3, 0), at(3, 1)]);
    assert_eq!(imus(&frames, 4), [at(4, 0)]);
    assert_eq!(imus(&frames, 5), [at(4, 1), at(5, 0), at(5, 1)]);
    let domains = frames.identifiable();
    assert_eq!((domains.inertial, domains.slosh, domains.modal), (false, true, true));
}

#[test]
fn samples_are_replayed_with_the_bytes_they_were_recorded_with() {
    let run = flown(10, true);
    let frames = ReplayFrames::from_run(&run, PERIOD_NS).unwrap();
    let (mut imu, mut actuators, mut batches) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..frames.frame_count() {
        frames.frame(k, &mut |sample| match sample {
            ReplaySample::Imu(sample) => imu.push(sample),
            ReplaySample::Actuators(sample) => actuators.push(sample),
            ReplaySample::Accelerometers(sample) => batches.push(sample),
            ReplaySample::Joints(_) => panic!("none was recorded"),
        });
    }
    let bare = |header: &Header| Header::at(header.t_meas_ns);
    let recorded: Vec<Imu> = run.of(IMU).map(|(_, s)| Imu { header: bare(&s.header), ..*s }).collect();
    assert_eq!(imu, recorded);
    let recorded: Vec<Actuators> =
        run.of(ACTUATORS).map(|(_, s)| Actuators { header: bare(&s.header), ..*s }).collect();
    assert_eq!(actuators, recorded);
    let recorded: Vec<_> =
        run.of(ACCELEROMETERS).map(|(_, s)| Accelerometers { header: bare(&s.header), ..*s }).collect();
    assert_eq!(batches, recorded);
}

#[test]
fn what_a_restarted_source_sent_again_is_replayed_once() {
    let run = flown(10, true);
    let mut twice = RecordedRun::new("run");
    for (i, sample) in run.samples().enumerate() {
        twice.push(sample.topic, sample.stamps, sample.payload).unwrap();
        if i == 30 {
            for old in run.samples().take(30) {
                twice.push(old.topic, old.stamps, old.payload).unwrap();
            }
        }
    }
    let (a, b) = (ReplayFrames::from_run(&run, PERIOD_NS).unwrap(), ReplayFrames::from_run(&twice, PERIOD_NS).unwrap());
    for k in 0..10 {
        assert_eq!(imus(&a, k), imus(&b, k));
    }
    assert!(b.notes().is_empty());
}

#[test]
fn without_ticks_time_decides_and_missing_samples_are_counted() {
    let run = flown(10, false);
    let frames = ReplayFrames::from_run(&run, PERIOD_NS).unwrap();
    assert_eq!(imus(&frames, 4).len(), 2);
    let mut holed = RecordedRun::new("run");
    for (i, sample) in run.samples().enumerate() {
        if i != 4 {
            holed.push(sample.topic, sample.stamps, sample.payload).unwrap();
        }
    }
    let frames = ReplayFrames::from_run(&holed, PERIOD_NS).unwrap();
    assert!(frames.notes()[0].contains("1 sample(s) of `imu` are missing"), "{:?}", frames.notes());
}

#[test]
fn another_period_a_map_and_a_run_without_source_samples_are_refused() {
    let run = flown(10, true);
    let error = ReplayFrames::from_run(&run, 20_000_000).unwrap_err().explain();
    assert!(error.contains("20000000 ns was asked for") && error.contains("flown with 10000000 ns"), "{error}");
    assert!(error.contains("control period of 10 ms"), "{error}");
    let map = ChannelMap::parse("m", "[channels]\nforce.x = \"f\"").unwrap();
    let imported = Imported::Run(run);
    assert!(ReplayFrames::new(&imported, None, PERIOD_NS).is_ok());
    let error = ReplayFrames::new(&imported, Some(&map), PERIOD_NS).unwrap_err().explain();
    assert!(error.contains("does not apply to a recorded run"), "{error}");
    assert!(ReplayFrames::from_run(&RecordedRun::new("empty"), PERIOD_NS).unwrap_err().to_string().contains("empty"));
}
