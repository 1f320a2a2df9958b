//! The recorder's own records against those of the crate `mcap`.

use crate::samples::everything;
use crate::scratch;
use mcap::records::{MessageHeader, Metadata};
use recording::McapRecorder;
use std::collections::BTreeMap;
use std::io::Cursor;
use telemetry::{Header, TOPICS};
use zerocopy::{FromBytes, IntoBytes};

/// Samples between two flushes: less than a chunk holds, and more.
const FLUSH_EVERY: [usize; 3] = [40, 500, usize::MAX];
const SCENARIO: &[u8] = b"format = 1\n";

#[test]
fn a_recording_is_byte_for_byte_what_the_crate_mcap_writes() {
    let run = everything(200);
    let samples: Vec<_> = run.samples().skip(3).collect();
    let facts = BTreeMap::from([("seed".to_string(), "7".to_string()), ("name".to_string(), "short".to_string())]);
    for flush_every in FLUSH_EVERY {
        let path = scratch(&format!("bytes-{flush_every}.mcap"));
        let mut recorder = McapRecorder::create(&path).unwrap();
        recorder.metadata("run", &facts).unwrap();
        recorder.attach("scenario.toml", "application/toml", SCENARIO).unwrap();
        for (count, sample) in (1..).zip(&samples) {
            recorder.write(sample.topic, sample.stamps, sample.payload).unwrap();
            if count % flush_every == 0 {
                recorder.flush().unwrap();
            }
        }
        recorder.metadata("end", &BTreeMap::new()).unwrap();
        recorder.finish().unwrap();
        let ours = std::fs::read(&path).unwrap();
        // What a reader of another program finds in it is what it is written with again.
        let summary = mcap::Summary::read(&ours).unwrap().expect("a summary");
        assert_eq!(summary.channels.len(), TOPICS.len());
        assert!(summary.chunk_indexes.len() > 1);
        assert_eq!(summary.stats.as_ref().unwrap().message_count, samples.len() as u64);

        let mut theirs = writer();
        theirs.write_metadata(&Metadata { name: "run".into(), metadata: facts.clone() }).unwrap();
        let (name, media_type) = ("scenario.toml".into(), "application/toml".into());
        let scenario = mcap::Attachment { log_time: 0, create_time: 0, name, media_type, data: SCENARIO.into() };
        theirs.attach(&scenario).unwrap();
        for (count, sample) in (1..).zip(&samples) {
            let channel = summary.channels.values().find(|channel| channel.topic == TOPICS[sample.topic].name).unwrap();
            let schema = channel.schema.as_ref().unwrap();
            theirs.add_schema_with_id(schema.id, &schema.name, &schema.encoding, &schema.data).unwrap();
            let (id, encoding) = (channel.id, &channel.message_encoding);
            theirs.add_channel_with_id(id, schema.id, &channel.topic, encoding, &channel.metadata).unwrap();
            let (header, _) = Header::read_from_prefix(sample.payload).unwrap();
            let (sequence, log_time) = (header.seq as u32, sample.stamps.sent_ns);
            let header = MessageHeader { channel_id: id, sequence, log_time, publish_time: header.t_meas_ns };
            let message = [sample.stamps.as_bytes(), sample.payload].concat();
            theirs.write_to_known_channel(&header, &message).unwrap();
            if count % flush_every == 0 {
                theirs.flush().unwrap();
            }
        }
        theirs.write_metadata(&Metadata { name: "end".into(), metadata: BTreeMap::new() }).unwrap();
        theirs.finish().unwrap();
        let theirs = theirs.into_inner().into_inner();
        let differs = ours.iter().zip(&theirs).position(|(own, other)| own != other);
        assert_eq!((differs, ours.len()), (None, theirs.len()), "flushed every {flush_every}");
    }
}

fn writer() -> mcap::Writer<Cursor<Vec<u8>>> {
    let options = mcap::WriteOptions::new()
        .profile("ros1")
        .library(concat!("obsid ", env!("CARGO_PKG_VERSION")))
        .disable_seeking(true)
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(1)
        .compression_threads(0);
    options.create(Cursor::new(Vec::new())).unwrap()
}
