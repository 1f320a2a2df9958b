//! Work side by side on threads; results are in the order of their indices.

use std::sync::atomic::{AtomicUsize, Ordering};

/// `f(0), …, f(count − 1)` on `threads` threads, each taking the next that is free.
pub fn parallel<T: Send>(count: usize, threads: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = threads.clamp(1, count.max(1));
    if threads == 1 {
        return (0..count).map(f).collect();
    }
    let mut slots: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        let taken = core::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed)).take_while(|i| *i < count);
        taken.map(|i| (i, f(i))).collect::<Vec<_>>()
    };
    std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        for handle in handles {
            for (i, value) in handle.join().expect("a pass does not panic") {
                slots[i] = Some(value);
            }
        }
    });
    slots.into_iter().map(|slot| slot.expect("every index has its thread")).collect()
}
