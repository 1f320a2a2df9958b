//! A computation on a thread of its own, whose end is known by what it has counted, not by a clock.

use identification::work::Watch;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// How often the count is looked at while it is waited for: a fraction of a frame.
const LOOK_EVERY: Duration = Duration::from_micros(500);

type Job = Box<dyn FnOnce() + Send>;

/// The thread: a process may start none later. It ends when this is dropped.
pub struct Thread(SyncSender<Job>);

impl Thread {
    pub fn start() -> Self {
        let (sender, jobs) = sync_channel::<Job>(1);
        // a job that panics is a result that does not come
        std::thread::spawn(move || jobs.into_iter().for_each(|job| job()));
        Self(sender)
    }
}

/// One computation. Nothing more of it is begun once this is dropped.
pub struct Computation<T> {
    watch: Watch,
    stop: Arc<AtomicBool>,
    results: Receiver<T>,
    result: Option<T>,
}

impl<T: Send + 'static> Computation<T> {
    /// Begins `compute`, which counts its work in the watch.
    pub fn start(thread: &Thread, compute: impl FnOnce(&Watch) -> T + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let watch = Watch::stopped_by(stop.clone());
        let (sender, results) = sync_channel(1);
        let own = watch.clone();
        let job = move || _ = sender.send(compute(&own));
        // a thread that has ended is a result that does not come
        let _ = thread.0.send(Box::new(job));
        Self { watch, stop, results, result: None }
    }

    /// The result, if it cost no more than `most`. Waits until that is known.
    ///
    /// # Panics
    /// If the computation did.
    pub fn within(&mut self, most: f64) -> Option<T> {
        while self.result.is_none() {
            // what it has counted is never less
            if self.watch.counted() > most {
                return None;
            }
            match self.results.recv_timeout(LOOK_EVERY) {
                Ok(result) => self.result = Some(result),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => panic!("the thread of the diagnosis panicked"),
            }
        }
        if self.watch.counted() > most { None } else { self.result.take() }
    }
}

impl<T> Drop for Computation<T> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identification::work::Work;

    /// Counts ten times ten with pauses; says how often.
    fn counted(watch: &Watch, pause: Duration) -> u32 {
        let work = Work::watched(1e9, watch.clone());
        let count = |_: &u32| {
            std::thread::sleep(pause);
            work.add(10.0);
            !work.is_stopped()
        };
        (0..10).take_while(count).count() as u32
    }

    #[test]
    fn a_result_is_there_once_its_cost_is_granted_however_fast_it_came() {
        for pause in [Duration::ZERO, Duration::from_millis(2)] {
            let mut computation = Computation::start(&Thread::start(), move |watch| counted(watch, pause));
            let early = (0..12).map(|k| computation.within(9.0 * f64::from(k)));
            assert!(early.collect::<Vec<_>>().iter().all(Option::is_none), "{pause:?}");
            assert_eq!(computation.within(100.0), Some(10), "{pause:?}");
        }
    }

    #[test]
    fn a_computation_that_nobody_waits_for_is_stopped() {
        let (sender, results) = sync_channel(1);
        let pause = Duration::from_millis(20);
        drop(Computation::start(&Thread::start(), move |watch| sender.send(counted(watch, pause))));
        assert!(results.recv().unwrap() < 9);
    }

    #[test]
    #[should_panic(expected = "panicked")]
    fn a_panic_of_the_computation_is_one_of_whoever_waits() {
        Computation::<()>::start(&Thread::start(), |_| panic!("on purpose")).within(1.0);
    }
}
