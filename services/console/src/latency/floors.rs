//! What the machine itself needs to hand something to another core: a cache line, a futex, a pipe,
//! a Unix domain socket. Each is a ping-pong between two threads; one way is half a round trip.

use runtime::latency::LatencyHistogram;
use runtime::sys::monotonic_ns;
use rustix::thread::{CpuSet, futex, sched_getaffinity, sched_setaffinity};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Bytes of a message through a pipe or a socket.
pub const MESSAGE_BYTES: usize = 64;

/// Binds the calling thread to the `place`-th processor that it may use; false with fewer than two.
pub fn pin(place: usize) -> bool {
    let Ok(allowed) = sched_getaffinity(None) else { return false };
    let processors: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| allowed.is_set(cpu)).collect();
    let Some(&cpu) = processors.get(place) else { return false };
    let mut one = CpuSet::new();
    one.set(cpu);
    sched_setaffinity(None, &one).is_ok()
}

/// A thread that answers while `ping` measures in another one, each on its own core.
pub fn ping_pong(
    rounds: u64,
    mut ping: impl FnMut(u64) + Send,
    mut pong: impl FnMut(u64) + Send,
    into: &mut LatencyHistogram,
) {
    std::thread::scope(|scope| {
        scope.spawn(move || {
            pin(1);
            (1..=rounds).for_each(&mut pong);
        });
        scope.spawn(move || {
            pin(0);
            for round in 1..=rounds {
                let begin_ns = monotonic_ns();
                ping(round);
                into.record((monotonic_ns() - begin_ns) / 2);
            }
        });
    });
}

/// Each counter in a cache line of its own.
#[repr(align(128))]
#[derive(Default)]
struct Line(AtomicU64);

/// One cache line there, one back.
pub fn cache_line(rounds: u64, into: &mut LatencyHistogram) {
    let (there, back) = (Line::default(), Line::default());
    let wait = |line: &Line, round| {
        while line.0.load(Ordering::Acquire) != round {
            std::hint::spin_loop();
        }
    };
    let ping = |round| {
        there.0.store(round, Ordering::Release);
        wait(&back, round);
    };
    let pong = |round| {
        wait(&there, round);
        back.0.store(round, Ordering::Release);
    };
    ping_pong(rounds, ping, pong, into);
}

/// One wake-up there, one back.
pub fn futex_wake(rounds: u64, into: &mut LatencyHistogram) {
    let (there, back) = (AtomicU32::new(0), AtomicU32::new(0));
    let wait = |word: &AtomicU32, round: u32| {
        let mut seen = word.load(Ordering::Acquire);
        while seen != round {
            let _ = futex::wait(word, futex::Flags::empty(), seen, None);
            seen = word.load(Ordering::Acquire);
        }
    };
    let wake = |word: &AtomicU32, round: u32| {
        word.store(round, Ordering::Release);
        let _ = futex::wake(word, futex::Flags::empty(), 1);
    };
    let ping = |round: u64| {
        wake(&there, round as u32);
        wait(&back, round as u32);
    };
    let pong = |round: u64| {
        wait(&there, round as u32);
        wake(&back, round as u32);
    };
    ping_pong(rounds, ping, pong, into);
}

/// A message through a pipe there, one back, blocking.
///
/// # Errors
/// When the system gives no pipe.
pub fn pipe(rounds: u64, into: &mut LatencyHistogram) -> std::io::Result<()> {
    let ((mut there_out, mut there_in), (mut back_out, mut back_in)) = (std::io::pipe()?, std::io::pipe()?);
    let ping = |_| {
        let mut message = [0; MESSAGE_BYTES];
        let _ = there_in.write_all(&message).and_then(|()| back_out.read_exact(&mut message));
    };
    let pong = |_| {
        let mut message = [0; MESSAGE_BYTES];
        let _ = there_out.read_exact(&mut message).and_then(|()| back_in.write_all(&message));
    };
    ping_pong(rounds, ping, pong, into);
    Ok(())
}

/// A message through a Unix domain socket there, one back, blocking.
///
/// # Errors
/// When the system gives no socket.
pub fn socket(rounds: u64, into: &mut LatencyHistogram) -> std::io::Result<()> {
    let (mut one, mut other) = UnixStream::pair()?;
    let ping = |_| {
        let mut message = [0; MESSAGE_BYTES];
        let _ = one.write_all(&message).and_then(|()| one.read_exact(&mut message));
    };
    let pong = |_| {
        let mut message = [0; MESSAGE_BYTES];
        let _ = other.read_exact(&mut message).and_then(|()| other.write_all(&message));
    };
    ping_pong(rounds, ping, pong, into);
    Ok(())
}
