//! Claims about the arc: sums survive, gaps and rejected samples are named, memory is bounded.

use super::*;

fn sample(k: u32) -> SloshSample {
    let t = f64::from(k);
    SloshSample {
        interval_s: 0.1,
        force_n: 44.0 * libm::sin(0.07 * t),
        acceleration_m_s2: 0.01 * libm::cos(0.03 * t),
        sigma_m_s2: 4.2e-4,
    }
}

#[test]
fn sums_and_moments_survive_every_merge() {
    let mut small = SloshArc::<16>::default();
    let (mut impulse, mut moment, mut delta_v, mut variance) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..1000 {
        let one = sample(k);
        small.push(&one).expect("finite");
        let mid = (f64::from(k) + 0.5) * 0.1;
        impulse += one.force_n * 0.1;
        moment += one.force_n * 0.1 * mid;
        delta_v += one.acceleration_m_s2 * 0.1;
        variance += 4.2e-5 * 4.2e-5;
    }
    let mut start = 0.0;
    let mut found = [0.0; 4];
    for block in small.blocks() {
        let mid = start + block.length_s / 2.0;
        found[0] += block.force.impulse_n_s;
        found[1] += block.force.impulse_n_s * mid + block.force.first_moment_n_s2;
        found[2] += block.delta_v_m_s;
        found[3] += block.variance_m2_s2;
        start += block.length_s;
    }
    assert!(small.len() <= 16 && (start - 100.0).abs() < 1e-9);
    for (value, expected) in found.into_iter().zip([impulse, moment, delta_v, variance]) {
        assert!((value - expected).abs() < 1e-10 * expected.abs().max(1.0)); // rounding of 1000 sums
    }
}

#[test]
fn broken_samples_are_counted_and_leave_no_trace() {
    let mut arc = SloshArc::<16>::default();
    arc.push(&sample(1)).expect("finite");
    let before: SloshBlock = arc.blocks().next().expect("one");
    for broken in [
        SloshSample { acceleration_m_s2: f64::NAN, ..sample(2) },
        SloshSample { interval_s: 0.0, ..sample(2) },
        SloshSample { interval_s: -0.1, ..sample(2) },
        SloshSample { sigma_m_s2: 0.0, ..sample(2) },
    ] {
        assert!(arc.push(&broken).is_err());
    }
    assert_eq!((arc.samples(), arc.rejected, arc.len()), (1, 4, 1));
    assert_eq!(arc.blocks().next(), Some(before));
}

#[test]
fn a_checkpoint_continues_bit_for_bit() {
    let mut original = SloshArc::<64>::default();
    for k in 0..777 {
        original.push(&sample(k)).expect("finite");
    }
    let bytes = postcard::to_stdvec(&original).expect("plain numbers");
    let mut restored: SloshArc<64> = postcard::from_bytes(&bytes).expect("own bytes");
    for k in 777..1500 {
        original.push(&sample(k)).expect("finite");
        restored.push(&sample(k)).expect("finite");
    }
    assert_eq!(original, restored);
}

#[test]
fn a_missing_sample_begins_a_segment_and_jitter_does_not() {
    let mut arc = SloshArc::<64>::default();
    for k in (0..30).filter(|k| *k != 10 && *k != 20) {
        let jitter = 0.02 * f64::from(k % 3 - 1);
        arc.push_at(0.1 * f64::from(k) + jitter, &sample(k as u32)).expect("in order");
    }
    assert_eq!(arc.segments(), 3);
    assert_eq!((0..3).map(|i| arc.segment(i)).collect::<std::vec::Vec<_>>(), [(0, 10), (10, 19), (19, 28)]);
    assert!((arc.duration_s() - 2.8).abs() < 1e-9);
}

#[test]
fn a_sample_from_before_the_end_is_refused() {
    let mut arc = SloshArc::<64>::default();
    arc.push_at(5.0, &sample(0)).expect("first");
    for begin_s in [5.0, 4.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(arc.push_at(begin_s, &sample(1)).is_err());
    }
    assert_eq!((arc.samples(), arc.segments()), (1, 1));
}

#[test]
fn merging_never_sums_across_a_gap_and_memory_stays_bounded_by_any_number_of_gaps() {
    let mut arc = SloshArc::<64>::default();
    let (mut begin_s, mut taken) = (0.0, 0);
    for k in 0..5000_u32 {
        if k % 97 == 96 {
            begin_s += 1.0;
        }
        arc.push_at(begin_s, &sample(k)).expect("in order");
        begin_s += 0.1;
        taken += 1;
        assert!(arc.len() <= 65 && arc.segments() <= SEGMENTS_MAX);
        let covered: usize = (0..arc.segments()).map(|i| arc.segment(i)).map(|(from, until)| until - from).sum();
        assert_eq!(covered, arc.len(), "after {k}");
        let held: f64 = arc.blocks().map(|block| block.length_s).sum();
        assert!((held - arc.duration_s()).abs() < 1e-6); // rounding of 5000 sums
        for i in 0..arc.segments() {
            let length: f64 = arc.blocks_of(arc.segment(i)).map(|block| block.length_s).sum();
            assert!(length < 9.7 + 1e-6, "a segment longer than the record between two gaps: {length}");
        }
    }
    assert_eq!(arc.samples(), taken);
}

#[test]
fn what_is_left_after_forgetting_is_what_came_last() {
    let mut arc = SloshArc::<64>::default();
    for k in 0..60 {
        arc.push_at(0.1 * f64::from(k) + if k >= 20 { 3.0 } else { 0.0 }, &sample(k)).expect("in order");
    }
    let all: std::vec::Vec<SloshBlock> = arc.blocks().collect();
    arc.forget_oldest(16);
    assert!(arc.has_forgotten_the_start());
    assert_eq!(arc.blocks().collect::<std::vec::Vec<_>>(), all[16..]);
    assert_eq!((arc.segment(0), arc.segment(1)), ((0, 4), (4, 44)));
    arc.forget_oldest(4); // The whole first segment.
    assert_eq!((arc.segments(), arc.segment(0)), (1, (0, 40)));
}

#[test]
fn thrust_without_acceleration_drives_and_does_not_weigh() {
    let mut arc = SloshArc::<64>::default();
    arc.push(&sample(1)).expect("finite");
    arc.push(&SloshSample::thrust_alone(0.1, 7.0)).expect("finite");
    let last = arc.blocks().last().expect("two");
    assert_eq!((arc.segments(), last.weight(), last.is_measured()), (1, 0.0, false));
    assert_eq!(last.force.impulse_n_s, 7.0 * 0.1);
}
