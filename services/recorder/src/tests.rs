//! The file is written in memory that was taken at the beginning.

use recording::McapRecorder;
use runtime::sys::{CountingAllocator, allocations};
use std::collections::BTreeMap;
use telemetry::{Header, Stamps, TOPICS};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn no_chunk_full_or_flushed_and_no_topic_that_begins_late_takes_memory() {
    let path = std::env::temp_dir().join(format!("obsid-recorder-{}.mcap", std::process::id()));
    let mut payloads: Vec<Vec<u8>> = TOPICS.iter().map(|info| vec![0; info.size]).collect();
    let mut file = McapRecorder::create(&path).unwrap();
    file.metadata("run", &BTreeMap::new()).unwrap();
    let before = allocations();
    for round in 0..3000_u64 {
        for (topic, payload) in payloads.iter_mut().enumerate() {
            // Bytes that do not compress: every chunk is as large as one can be.
            for (k, word) in payload[size_of::<Header>()..].chunks_exact_mut(8).enumerate() {
                let noise = (round << 32 | k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                word.copy_from_slice(&(noise ^ noise >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9).to_le_bytes());
            }
            if round >= 100 * topic as u64 {
                file.write(topic, &Stamps { epoch: 0, crc32: 0, sent_ns: round }, payload).unwrap();
            }
        }
        if round < 500 && round % 10 == 9 {
            file.flush().unwrap();
        }
    }
    assert_eq!(allocations() - before, 0);
    file.finish().unwrap();
    assert!(std::fs::metadata(&path).unwrap().len() > (20 << 20), "many chunks");
    std::fs::remove_file(&path).unwrap();
}
