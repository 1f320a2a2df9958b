//! MCAP: round trip, recovery after a killed writer, rejection of foreign files and other layouts.

use crate::samples::{everything, listed, random, seal};
use crate::{Numbers, scratch};
use recording::{Imported, McapRecorder, RecordingError, read_mcap, read_mcap_topics, write_mcap};
use std::collections::BTreeMap;
use telemetry::{EVENT, IMU, Imu, TOPICS};

#[test]
fn what_is_written_is_read_in_order_with_metadata_and_attachments() {
    let run = everything(50);
    let path = scratch("round.mcap");
    let mut recorder = McapRecorder::create(&path).unwrap();
    recorder.metadata("run", &BTreeMap::from([("seed".into(), "7".into())])).unwrap();
    recorder.attach("scenario.toml", "application/toml", b"format = 1\n").unwrap();
    for sample in run.samples() {
        recorder.write(sample.topic, sample.stamps, sample.payload).unwrap();
    }
    recorder.metadata("end", &BTreeMap::from([("frames".into(), "50".into())])).unwrap();
    recorder.finish().unwrap();
    let Imported::Run(read) = recording::read(&path).unwrap() else { panic!("a run") };
    assert_eq!(listed(&read), listed(&run));
    assert_eq!(read.metadata()["run"]["seed"], "7");
    assert_eq!(read.metadata()["end"]["frames"], "50");
    assert_eq!(read.attachments()[0].name, "scenario.toml");
    assert_eq!(read.attachments()[0].bytes, b"format = 1\n");
    assert_eq!(read.of(IMU).count(), 50);
    assert_eq!(read.of(IMU).last().unwrap().1.header.seq, 50);

    let again = scratch("again.mcap");
    write_mcap(&read, &again).unwrap();
    let copy = read_mcap(&again).unwrap();
    assert_eq!((listed(&copy), copy.metadata()), (listed(&run), read.metadata()));
    let few = read_mcap_topics(&path, |topic| topic == IMU.id).unwrap();
    assert_eq!(few.len(), 50);
}

#[test]
fn the_same_samples_give_the_same_file() {
    let run = everything(20);
    let (a, b) = (scratch("same-a.mcap"), scratch("same-b.mcap"));
    write_mcap(&run, &a).unwrap();
    write_mcap(&run, &b).unwrap();
    assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
}

#[test]
fn a_killed_writer_loses_nothing_flushed_and_recovery_goes_on_behind_it() {
    let samples = listed(&everything(40));
    let path = scratch("killed.mcap");
    let mut recorder = McapRecorder::create(&path).unwrap();
    recorder.metadata("run", &BTreeMap::from([("seed".into(), "7".into())])).unwrap();
    recorder.attach("scenario", "text/plain", b"text").unwrap();
    // Fewer behind the flush than fill a chunk, which is written when it is full.
    let (flushed, written) = (300, 350);
    for (i, (topic, stamps, payload)) in samples[..written].iter().enumerate() {
        if i == flushed {
            recorder.flush().unwrap();
        }
        recorder.write(*topic, stamps, payload).unwrap();
    }
    // What is on the device when the writer is killed now: nothing is closed, dropped or finished.
    let on_device = std::fs::read(&path).unwrap();
    std::mem::forget(recorder);
    for cut in [on_device.len(), on_device.len() - 1, on_device.len() / 2, 9, 8, 3, 0] {
        std::fs::write(&path, &on_device[..cut]).unwrap();
        if cut > 0 {
            let error = recording::read(&path).unwrap_err().explain();
            assert!(error.contains("killed.mcap: byte ") && error.contains("truncated"), "{error}");
            assert!(error.contains("samples before that are readable") && error.contains("mcap recover"), "{error}");
        }
        let (mut recorder, found) = McapRecorder::recover(&path, |topic, _, _| topic != EVENT.id).unwrap();
        assert!(found.damaged_at.is_some_and(|at| at <= cut as u64));
        let readable = (found.kept + found.dropped) as usize;
        if cut == on_device.len() {
            assert_eq!(readable, flushed, "exactly what was flushed");
        }
        for (topic, stamps, payload) in &samples[readable..] {
            recorder.write(*topic, stamps, payload).unwrap();
        }
        recorder.finish().unwrap();
        let run = read_mcap(&path).unwrap();
        let kept = |i: usize| i >= readable || samples[i].0 != EVENT.id;
        let expected: Vec<_> = (0..samples.len()).filter(|i| kept(*i)).map(|i| samples[i].clone()).collect();
        assert!(listed(&run) == expected, "cut at {cut}");
        if cut == on_device.len() {
            assert_eq!(run.metadata()["run"]["seed"], "7");
            assert_eq!(run.attachments().len(), 1);
        }
    }
    assert!(!scratch("killed.mcap.recovering").exists());
}

#[test]
fn recovering_a_complete_file_keeps_everything() {
    let run = everything(10);
    let path = scratch("complete.mcap");
    write_mcap(&run, &path).unwrap();
    let (recorder, found) = McapRecorder::recover(&path, |_, _, _| true).unwrap();
    assert_eq!((found.kept, found.dropped, found.bad, found.damaged_at), (run.len() as u64, 0, 0, None));
    recorder.finish().unwrap();
    assert_eq!(listed(&read_mcap(&path).unwrap()), listed(&run));
}

#[test]
fn a_truncated_file_names_the_byte_and_the_readable_samples() {
    let run = everything(100);
    let path = scratch("cut.mcap");
    write_mcap(&run, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    match read_mcap(&path).unwrap_err() {
        RecordingError::McapTruncated { offset, readable, .. } => {
            assert_eq!(readable, run.len() as u64);
            assert!(offset < bytes.len() as u64);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn another_layout_is_refused_with_both_hashes() {
    let (topic, mut stamps, mut payload) = seal(IMU, random::<Imu>(&mut Numbers(1), 0), 1, 0);
    payload[..4].copy_from_slice(&0x1234_5678u32.to_le_bytes());
    stamps.crc32 = telemetry::crc32(&payload);
    let path = scratch("layout.mcap");
    let mut recorder = McapRecorder::create(&path).unwrap();
    recorder.write(topic, &stamps, &payload).unwrap();
    recorder.finish().unwrap();
    let error = recording::read(&path).unwrap_err().explain();
    assert!(error.contains("layout hash 0x12345678"), "{error}");
    assert!(error.contains(&format!("this build has {:#010x}", TOPICS[IMU.id].layout)), "{error}");
    assert!(error.contains("build that wrote it"), "{error}");
}

#[test]
fn a_sample_damaged_before_it_was_recorded_is_refused_and_left_out_by_recovery() {
    let path = scratch("crc.mcap");
    let mut recorder = McapRecorder::create(&path).unwrap();
    for seq in 1..=3 {
        let (topic, stamps, mut payload) = seal(IMU, random::<Imu>(&mut Numbers(seq), 0), seq, 0);
        if seq == 2 {
            payload[40] ^= 1;
        }
        recorder.write(topic, &stamps, &payload).unwrap();
    }
    recorder.finish().unwrap();
    let error = recording::read(&path).unwrap_err().explain();
    assert!(error.contains("topic `imu`, seq 2: CRC-32"), "{error}");
    let (recorder, found) = McapRecorder::recover(&path, |_, _, _| true).unwrap();
    assert_eq!((found.kept, found.bad), (2, 1));
    recorder.finish().unwrap();
    assert_eq!(read_mcap(&path).unwrap().len(), 2);
}

#[test]
fn a_foreign_mcap_is_refused_with_what_is_supported() {
    let path = scratch("foreign.mcap");
    let mut writer = mcap::Writer::new(std::fs::File::create(&path).unwrap()).unwrap();
    let schema = writer.add_schema("sensor_msgs/Imu", "ros1msg", b"float64 x").unwrap();
    let channel = writer.add_channel(schema, "/imu/data", "ros1", &BTreeMap::new()).unwrap();
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &[0; 8]).unwrap();
    writer.flush().unwrap();
    // Named in a later chunk, which is not decoded any more.
    let schema = writer.add_schema("sensor_msgs/JointState", "ros1msg", b"float64 x").unwrap();
    writer.add_channel(schema, "/joint_states", "ros1", &BTreeMap::new()).unwrap();
    writer.finish().unwrap();
    let error = recording::read_mcap(&path).unwrap_err().explain();
    for part in [
        "channels: `/imu/data` (sensor_msgs/Imu), `/joint_states` (sensor_msgs/JointState)",
        "`ros1/ros1msg`",
        "`sensor_msgs/Imu`",
        "not recorded by obsid",
        "obsid/Recorded*",
        "CSV",
    ] {
        assert!(error.contains(part), "{error}");
    }
    let before = std::fs::read(&path).unwrap();
    assert!(McapRecorder::recover(&path, |_, _, _| true).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), before, "recovery leaves a foreign file alone");
}

#[test]
fn a_payload_of_another_size_is_not_written() {
    let mut recorder = McapRecorder::create(&scratch("size.mcap")).unwrap();
    let (topic, stamps, payload) = seal(IMU, random::<Imu>(&mut Numbers(1), 0), 1, 0);
    let error = recorder.write(topic, &stamps, &payload[8..]).unwrap_err().to_string();
    assert!(error.contains("`imu`") && error.contains("its type has"), "{error}");
}
