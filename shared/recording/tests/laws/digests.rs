//! The digest is the identity of what was published, not of how it travelled.

use crate::Numbers;
use crate::samples::{listed, random, seal};
use recording::{DigestBuilder, RecordedRun, digest};
use telemetry::{
    ESTIMATE_INERTIAL, ESTIMATE_MODAL, IMU, Imu, InertialEstimate, MODE, ModalEstimate, Mode, VERDICT, Verdict,
};

type Sealed = (usize, telemetry::Stamps, Vec<u8>);

fn results() -> Vec<Sealed> {
    let mut numbers = Numbers(5);
    let mut all = Vec::new();
    for seq in 1..=20 {
        let t = seq * 1_000;
        let (mut inertial, mut modal): (InertialEstimate, ModalEstimate) =
            (random(&mut numbers, t), random(&mut numbers, t));
        (inertial.estimate.frame, modal.estimate.frame) = (10 * seq, 10 * seq);
        all.push(seal(ESTIMATE_INERTIAL, inertial, seq, 0));
        all.push(seal(ESTIMATE_MODAL, modal, seq, 0));
        all.push(seal(VERDICT, Verdict { frame: 10 * seq + 1, ..random(&mut numbers, t) }, seq, 0));
        all.push(seal(MODE, Mode { frame: 7 * seq, ..random(&mut numbers, t) }, seq, 0));
        all.push(seal(IMU, random::<Imu>(&mut numbers, t), seq, 0));
    }
    all
}

fn hex(samples: &[Sealed]) -> String {
    let mut builder = DigestBuilder::new();
    for (topic, _, payload) in samples {
        builder.add(*topic, payload).unwrap();
    }
    builder.finish().hex
}

#[test]
fn order_of_arrival_duplicates_epochs_and_sensor_samples_do_not_matter() {
    let samples = results();
    let reference = hex(&samples);
    let mut shuffled = samples.clone();
    let mut numbers = Numbers(9);
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, numbers.below(i + 1));
    }
    shuffled.extend_from_slice(&samples[..30]);
    shuffled.retain(|(topic, ..)| *topic != IMU.id);
    assert_eq!(hex(&shuffled), reference);

    let mut run = RecordedRun::new("memory");
    for (topic, stamps, payload) in &shuffled {
        let stamps = telemetry::Stamps { epoch: 3, sent_ns: 12345, ..*stamps };
        run.push(*topic, &stamps, payload).unwrap();
    }
    let digest = digest(&run).unwrap();
    assert_eq!(digest.hex, reference);
    assert_eq!(digest.counts["estimate/inertial"], 20);
    assert_eq!(digest.counts.values().sum::<u64>(), 80);
    assert_eq!(listed(&run).len(), shuffled.len());
}

#[test]
fn any_changed_byte_of_seq_time_or_body_and_any_lost_sample_changes_it() {
    let samples = results();
    let reference = hex(&samples);
    let mut numbers = Numbers(13);
    for _ in 0..200 {
        let mut changed = samples.clone();
        let at = numbers.below(changed.len());
        if changed[at].0 == IMU.id {
            continue;
        }
        // Behind layout, source and flags, which a digest does not cover.
        let byte = 8 + numbers.below(changed[at].2.len() - 8);
        changed[at].2[byte] ^= 1 << numbers.below(8);
        if let Ok(()) = changed.iter().try_fold(DigestBuilder::new(), |mut b, s| b.add(s.0, &s.2).map(|()| b)).map(drop)
        {
            assert_ne!(hex(&changed), reference, "sample {at} byte {byte}");
        }
    }
    for lost in (0..samples.len()).filter(|i| samples[*i].0 != IMU.id) {
        let mut fewer = samples.clone();
        fewer.remove(lost);
        assert_ne!(hex(&fewer), reference);
    }
}

#[test]
fn one_number_with_two_contents_is_a_conflict() {
    let samples = results();
    let (topic, _, mut payload) = samples[0].clone();
    payload[100] ^= 1;
    let mut builder = DigestBuilder::new();
    builder.add(topic, &samples[0].2).unwrap();
    let error = builder.add(topic, &payload).unwrap_err().explain();
    assert!(error.contains("`estimate/inertial`, seq 1") && error.contains("byte 100"), "{error}");
}
