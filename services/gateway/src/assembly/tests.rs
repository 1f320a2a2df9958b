use super::{Assembly, Held, Timing};
use runtime::feed::FeedCounts;
use telemetry::{IMU, Imu, JOINTS, Joints, Layout, Sample};
use zerocopy::IntoBytes;

const MS: u64 = 1_000_000;
const TIMING: Timing = Timing { period_ns: 10 * MS, lateness_ns: 20 * MS, silence_ns: 500 * MS, ahead_ns: 1000 * MS };

fn imu(t_ns: u64) -> Vec<u8> {
    let mut sample = Imu::zeroed_at(t_ns);
    sample.header.layout = Imu::HASH;
    sample.acceleration_b_m_s2[0] = t_ns as f64;
    sample.as_bytes().to_vec()
}

/// Frames that close while samples of these times arrive, and the counts at the end.
fn frames(times_ns: impl IntoIterator<Item = u64>) -> (Vec<Vec<u64>>, FeedCounts) {
    let (mut assembly, mut formed, mut frames) = (Assembly::default(), Vec::new(), Vec::new());
    for t_ns in times_ns {
        assembly.offer(IMU.id, &imu(t_ns), &TIMING, 0);
        while assembly.is_complete(&TIMING, 0) {
            assembly.close(&TIMING, &mut formed);
            assert!(formed.iter().all(|held: &Held| held.bytes == imu(held.t_ns)));
            frames.push(formed.iter().map(|held| held.t_ns / MS).collect());
        }
    }
    (frames, assembly.counts)
}

/// Numbers that look random and are the same every time.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

#[test]
fn samples_within_the_lateness_limit_give_the_same_frames_in_any_order() {
    let in_order: Vec<u64> = (0..1000).map(|k| k * MS).collect();
    let (expected, counts) = frames(in_order.iter().copied());
    assert_eq!(counts, FeedCounts { received: 1000, ..FeedCounts::default() });
    assert!(expected.len() == 97 && expected.iter().all(|frame| frame.len() == 10));
    for seed in 1..20 {
        let mut state = seed;
        // Sorted by a time that is up to 19 ms wrong; the first sample sets the origin.
        let mut keyed: Vec<(u64, u64)> =
            in_order[1..].iter().map(|t| (t + random(&mut state) % (19 * MS), *t)).collect();
        keyed.sort_unstable();
        let (got, counts) = frames([0].into_iter().chain(keyed.iter().map(|(_, t)| *t)));
        assert_eq!((got, counts.late, counts.duplicates), (expected.clone(), 0, 0), "seed {seed}");
    }
}

#[test]
fn a_sample_is_late_by_the_order_of_arrival_however_slowly_frames_are_taken() {
    let (mut at_once, mut late) = (Assembly::default(), 0);
    for t_ns in (0..200).map(|k| k * MS) {
        at_once.offer(IMU.id, &imu(t_ns), &TIMING, 0);
        if t_ns >= 50 * MS && t_ns % (10 * MS) == 0 {
            at_once.offer(IMU.id, &imu(t_ns - 50 * MS), &TIMING, 0);
            late += 1;
        }
    }
    assert_eq!((at_once.counts.late, at_once.counts.duplicates, at_once.held()), (late, 0, 200));
}

#[test]
fn late_and_repeated_samples_are_counted_and_change_no_frame() {
    let clean: Vec<u64> = (0..500).map(|k| k * MS).collect();
    let mut spoilt = Vec::new();
    for &t in &clean {
        spoilt.push(t);
        // Every tenth again at once; every fiftieth again after 100 ms.
        spoilt.extend((t % (10 * MS) == 0).then_some(t));
        spoilt.extend((t >= 100 * MS && t % (50 * MS) == 0).then(|| t - 100 * MS));
    }
    let ((expected, _), (got, counts)) = (frames(clean), frames(spoilt));
    assert_eq!(got, expected);
    assert_eq!((counts.duplicates, counts.late, counts.received), (50, 8, 558));
}

#[test]
fn more_samples_than_a_frame_may_carry_are_counted_and_dropped() {
    let (frames, counts) = frames((0..200).map(|k| k * MS / 2));
    assert!(frames.iter().all(|frame| frame.len() == 10));
    assert_eq!(counts, FeedCounts { received: 200, surplus: 100, ..FeedCounts::default() });
}

#[test]
fn a_value_that_is_not_finite_and_a_time_far_ahead_are_counted_and_move_no_watermark() {
    let mut assembly = Assembly::default();
    assembly.offer(IMU.id, &imu(0), &TIMING, 0);
    let mut wild = Imu::zeroed_at(MS);
    wild.omega_bi_b_rad_s[1] = f64::NAN;
    assembly.offer(IMU.id, wild.as_bytes(), &TIMING, 0);
    assembly.offer(IMU.id, &imu(1001 * MS), &TIMING, 0);
    let joints = Joints { count: 5, ..Joints::zeroed_at(MS) };
    assembly.offer(JOINTS.id, joints.as_bytes(), &TIMING, 0);
    assert_eq!((assembly.counts.bad, assembly.held()), (3, 1));
    assert!(!assembly.is_complete(&TIMING, 0));
    // After a silence the clock has gone on, and so may the sensor's.
    assembly.offer(IMU.id, &imu(1001 * MS), &TIMING, 900 * MS);
    assert_eq!((assembly.counts.bad, assembly.held()), (3, 2));
}

#[test]
fn frames_close_by_the_clock_when_a_sensor_falls_silent_and_are_counted() {
    let (mut assembly, mut formed) = (Assembly::default(), Vec::new());
    assert!(!assembly.is_complete(&TIMING, 3_600_000 * MS), "before the first sample there is no frame 0");
    assembly.offer(IMU.id, &imu(0), &TIMING, 0);
    assert!(!assembly.is_complete(&TIMING, 529 * MS) && assembly.is_complete(&TIMING, 530 * MS));
    assembly.close(&TIMING, &mut formed);
    assert!(!assembly.is_complete(&TIMING, 539 * MS) && assembly.is_complete(&TIMING, 540 * MS));
    assembly.close(&TIMING, &mut formed);
    assert_eq!((formed.len(), assembly.counts.empty_frames), (0, 1));
}

#[test]
fn a_restart_goes_on_behind_the_frames_that_were_sent() {
    let (mut assembly, mut formed) = (Assembly::default(), Vec::new());
    (0..45).for_each(|k| assembly.offer(IMU.id, &imu(k * MS), &TIMING, 0));
    let counts = FeedCounts { received: 99, late: 3, ..FeedCounts::default() };
    assembly.resume(3, 0, counts, &TIMING);
    assembly.offer(IMU.id, &imu(29 * MS), &TIMING, 0);
    assembly.close(&TIMING, &mut formed);
    assert_eq!(formed.iter().map(|held| held.t_ns / MS).collect::<Vec<_>>(), (30..40).collect::<Vec<_>>());
    assert_eq!((assembly.counts.late, assembly.counts.received, assembly.closed()), (4, 100, 4));
}
