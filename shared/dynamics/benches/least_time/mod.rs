//! Time of a call that other processes disturb least.

use std::time::Instant;

/// Calls of a batch: some tens of microseconds, shorter than a time slice of the scheduler.
const BATCH: u32 = 200;
/// Batches, of which the fastest counts.
const BATCHES: u32 = 2000;

/// Nanoseconds a call, of the fastest of many batches.
pub fn least_time_ns(mut call: impl FnMut()) -> f64 {
    let batch = |_| {
        let begin = Instant::now();
        (0..BATCH).for_each(|_| call());
        begin.elapsed().as_secs_f64() * 1e9 / f64::from(BATCH)
    };
    (0..BATCHES).map(batch).fold(f64::INFINITY, f64::min)
}
