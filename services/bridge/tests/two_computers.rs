//! Two runs in two network namespaces, over a line that loses a tenth of all packets, delays the
//! others by 300 ms and is cut for 10 s: every result comes over once and in order, or is declared
//! lost; a command goes the other way.
//!
//! As root, with `ip`, `python3`, `/dev/net/tun` and a built `obsid`; elsewhere it is skipped, and
//! `OBSID_REQUIRE=namespaces` turns that into a failure.

mod computers;

use computers::{Computers, Reader};
use std::time::{Duration, Instant};
use telemetry::{
    ESTIMATE_INERTIAL, ESTIMATE_INERTIAL_TORQUE, ESTIMATE_MODAL, ESTIMATE_SLOSH, MODE, Sample, Topic, VERDICT,
};

/// Seeds of the runs and of the line.
const SEEDS: [u64; 3] = [401, 402, 40_300];

const ENDPOINT: &str = "tcp/10.91.0.1:7447";

#[test]
fn over_a_poor_line_that_is_cut_every_result_comes_once_and_in_order_and_a_command_gets_through() {
    let Some(obsid) = computers::program() else { return };
    let mut world = Computers::new(&obsid, SEEDS[2]);
    let runs = [0, 1].map(|side| world.start_run(side, SEEDS[side]));
    let bridges = [("--listen", 0), ("--connect", 1)]
        .map(|(end, side)| world.start_bridge(side, &[end, ENDPOINT], &runs[side].folder));
    let mut readers = [0, 1].map(|side| Reader::of(&world.mirror(side)));
    world.cut_from_now();
    let began = Instant::now();
    let mut pinged = None;
    while began.elapsed() < Duration::from_secs(240) && !bridges.iter().all(|bridge| world.has_ended(*bridge)) {
        readers.iter_mut().for_each(Reader::look);
        // A partition that reports little: where a busy computer makes another one report sixteen
        // missed deadlines a second, its answer waits behind them.
        if began.elapsed() > Duration::from_secs(24) && pinged.is_none() {
            pinged = Some(world.start_command(1, &["command", "ping", "slosh-id", "--timeout", "20", "--json"]));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let totals = bridges.map(|bridge| world.output(bridge));
    let answer = world.output(pinged.expect("the runs last longer than the cut"));
    assert!(answer.contains("executed"), "{answer}");
    for side in [0, 1] {
        let far = 1 - side;
        assert!(world.output(runs[far].process).contains("\"digest\""));
        let recorded = recording::read_mcap(&world.record(far)).unwrap();
        let mut count = 0;
        let mut check = |name: &str, recorded: Vec<Vec<u8>>, seen: Vec<Vec<u8>>| {
            assert!(seen == recorded, "{name}: {} of {} came", seen.len(), recorded.len());
            count += seen.len();
        };
        fn bytes<T: Sample>(recorded: &recording::RecordedRun, topic: Topic<T>) -> Vec<Vec<u8>> {
            recorded.of(topic).map(|(_, sample)| sample.as_bytes().to_vec()).collect()
        }
        let reader = &readers[side];
        check("estimate/inertial", bytes(&recorded, ESTIMATE_INERTIAL), reader.of_topic(ESTIMATE_INERTIAL.id));
        check(
            "estimate/inertial-torque",
            bytes(&recorded, ESTIMATE_INERTIAL_TORQUE),
            reader.of_topic(ESTIMATE_INERTIAL_TORQUE.id),
        );
        check("estimate/slosh", bytes(&recorded, ESTIMATE_SLOSH), reader.of_topic(ESTIMATE_SLOSH.id));
        check("estimate/modal", bytes(&recorded, ESTIMATE_MODAL), reader.of_topic(ESTIMATE_MODAL.id));
        check("verdict", bytes(&recorded, VERDICT), reader.of_topic(VERDICT.id));
        check("mode", bytes(&recorded, MODE), reader.of_topic(MODE.id));
        assert!(count > 20, "only {count} results");
        println!("side {side}: {count} results, all once and in order; bridge {}", totals[side].trim());
    }
    println!("line: {}", world.end_line());
}
