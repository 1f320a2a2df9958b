//! The link of the partitions, as a ping-pong of real samples between two threads.
//!
//! A topic has one producer, so that there are two runs: one carries the sample there, the other
//! one back. In each run one thread joins as `sensor-sim` and the other as `recorder`.

use super::floors::pin;
use runtime::RunConfig;
use runtime::latency::LatencyHistogram;
use runtime::link::{Link, LinkError};
use runtime::rundir::OwnedRunDir;
use runtime::shm::{Role, ShmLink};
use runtime::sys::monotonic_ns;
use std::path::Path;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use telemetry::{PartitionId, Stamps, TOPICS, TopicId};

/// How the receiver waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// It looks again and again.
    Poll,
    /// It sleeps in the listener of its wake service until it is woken, as in flight.
    WaitSet,
}

/// A wake-up that is lost ends the wait all the same.
const WAIT_MAX: Duration = Duration::from_millis(200);

/// One thread's ends: what it sends goes out on one run, what it gets comes in on the other.
struct Ends<'a> {
    out: ShmLink,
    into: ShmLink,
    topic: TopicId,
    mode: Mode,
    /// The other thread has given up.
    failed: &'a AtomicBool,
}

impl<'a> Ends<'a> {
    /// Makes the services of `out`, then opens those of `into`; both threads wait for each other at
    /// `made` twice, whatever happens.
    fn join(
        [out, into]: [&OwnedRunDir; 2],
        (topic, mode): (TopicId, Mode),
        made: &Barrier,
        failed: &'a AtomicBool,
    ) -> Result<Self, LinkError> {
        let join = |run: &OwnedRunDir, id, role| {
            ShmLink::join(&run.dir().prefix(), &run.dir().iceoryx_root(), id, &[topic], role)
        };
        let out = join(out, PartitionId::SensorSim, Role::Creates);
        made.wait();
        let into = out.is_ok().then(|| join(into, PartitionId::Recorder, Role::Opens));
        made.wait();
        let mut ends = Ends { out: out?, into: into.expect("joined where the first was made")?, topic, mode, failed };
        ends.out.refresh()?;
        Ok(ends)
    }

    fn send(&mut self, payload: &[u8]) -> Result<(), LinkError> {
        send(&mut self.out, (self.topic, self.mode), payload)
    }

    /// Waits for samples and hands each to `take` with the way out, as soon as it has come: the
    /// look for a further one comes after that. How many; 0 when the other thread has failed.
    fn receive(
        &mut self,
        mut take: impl FnMut(&mut ShmLink, &[u8]) -> Result<(), LinkError>,
    ) -> Result<u64, LinkError> {
        let (mut count, mut outcome) = (0, Ok(()));
        while count == 0 && !self.failed.load(Ordering::Relaxed) {
            let out = &mut self.out;
            self.into.drain(self.topic, &mut |_, payload| {
                count += 1;
                outcome = take(out, payload);
            })?;
            match self.mode {
                _ if count > 0 => {}
                Mode::Poll => std::hint::spin_loop(),
                Mode::WaitSet => self.into.wait(WAIT_MAX)?,
            }
        }
        outcome.map(|()| count)
    }
}

fn send(out: &mut ShmLink, (topic, mode): (TopicId, Mode), payload: &[u8]) -> Result<(), LinkError> {
    let stamps = Stamps { epoch: 0, crc32: 0, sent_ns: out.now_ns() };
    out.publish(topic, &stamps, payload)?;
    if mode == Mode::WaitSet {
        out.wake(PartitionId::Recorder);
    }
    Ok(())
}

/// One way of `rounds` round trips of samples of `topic`.
///
/// # Errors
/// When a run cannot be made below `root` or joined.
pub fn ping_pong(
    run: &RunConfig,
    root: &Path,
    way: (TopicId, Mode),
    rounds: u64,
    into: &mut LatencyHistogram,
) -> Result<(), String> {
    let make = || OwnedRunDir::create(root, run).map_err(|error| error.to_string());
    let (there, back) = (make()?, make()?);
    let (made, over, failed) = (Barrier::new(2), Barrier::new(2), AtomicBool::new(false));
    let payload = vec![0x5A_u8; TOPICS[way.0].size];
    // Ends are closed when both threads are done.
    let until_both = |place, runs, act: &mut dyn FnMut(&mut Ends<'_>) -> Result<(), LinkError>| {
        pin(place);
        let mut ends = Ends::join(runs, way, &made, &failed);
        let outcome =
            ends.as_mut().map_err(|error| error.to_string()).and_then(|ends| act(ends).map_err(|e| e.to_string()));
        failed.fetch_or(outcome.is_err(), Ordering::Relaxed);
        over.wait();
        outcome
    };
    let mut answer = |ends: &mut Ends<'_>| {
        let mut copy = payload.clone();
        let mut send_back = |out: &mut ShmLink, payload: &[u8]| {
            copy.copy_from_slice(payload);
            send(out, way, &copy)
        };
        // The next question may come while the link looks for it behind the answer to the last one.
        let mut answered = 0;
        while answered < rounds && !failed.load(Ordering::Relaxed) {
            answered += ends.receive(&mut send_back)?;
        }
        Ok(())
    };
    let mut ask = |ends: &mut Ends<'_>| {
        let mut copy = payload.clone();
        (0..rounds).try_for_each(|_| {
            let begin_ns = monotonic_ns();
            let mut end_ns = begin_ns;
            ends.send(&payload)?;
            ends.receive(|_, payload| {
                copy.copy_from_slice(payload);
                end_ns = monotonic_ns();
                Ok(())
            })?;
            into.record((end_ns - begin_ns) / 2);
            Ok(())
        })
    };
    std::thread::scope(|scope| {
        let answering = scope.spawn(|| until_both(1, [&back, &there], &mut answer));
        let asking = scope.spawn(|| until_both(0, [&there, &back], &mut ask));
        let lost = || Err("a thread of the ping-pong ended".to_string());
        let (asked, answered) = (asking.join().unwrap_or_else(|_| lost()), answering.join().unwrap_or_else(|_| lost()));
        asked.and(answered)
    })
}
