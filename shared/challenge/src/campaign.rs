//! All cases of a seed: sealed, then diagnosed, then opened; folded in index order for any number
//! of threads.

use crate::answer::{Answer, ask};
use crate::case::{Sealed, Truth, case, control, digest};
use crate::score::Opened;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Callbacks of a campaign: progress, a clock (the crate has none), and the digests.
pub struct Watch<'a> {
    pub progress: &'a (dyn Fn(&str, usize, usize) + Sync),
    pub seconds: &'a (dyn Fn() -> f64 + Sync),
    /// Receives all digests before the first diagnosis.
    pub sealed: &'a mut dyn FnMut(&[Sealed]),
}

/// Which cases are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Draws {
    /// Nulls, single effects, pairs, laws outside the catalogue.
    #[default]
    Blind,
    /// Complete plants with a small remainder.
    Controls,
}

/// Carries out `cases` cases of `seed` on `threads` threads.
///
/// # Errors
/// The digest of a truth differs from its digest before the diagnosis.
pub fn campaign(
    cases: u64,
    (seed, draws): (u64, Draws),
    threads: usize,
    watch: &mut Watch<'_>,
) -> Result<Vec<Opened>, String> {
    let n = cases as usize;
    let (progress, seconds) = (watch.progress, watch.seconds);
    let timed = |start: f64| seconds() - start;
    let drawn = each(
        n,
        threads,
        &|i| {
            let start = seconds();
            let one = if draws == Draws::Controls { control } else { case };
            (one(seed, i as u64), timed(start))
        },
        &|done| progress("sealed", done, n),
    );
    let (sealed, drawing): (Vec<Sealed>, Vec<f64>) = drawn.into_iter().unzip();
    (watch.sealed)(&sealed);
    let answers: Vec<(Answer, f64)> = each(
        n,
        threads,
        &|i| {
            let start = seconds();
            (ask(&sealed[i].exam), timed(start))
        },
        &|done| progress("diagnosed", done, n),
    );
    let opened = sealed.into_iter().zip(answers).zip(drawing).map(|((sealed, (answer, asking)), drawing)| {
        if digest(&sealed.truth) != sealed.digest {
            return Err(format!("the truth of digest {} was changed", sealed.digest));
        }
        let truth: Truth = open(&sealed.truth)?;
        Ok(Opened { truth, digest: sealed.digest, answer, seconds: [drawing, asking] })
    });
    opened.collect()
}

/// Deserialises the truth of a sealed case.
///
/// # Errors
/// The bytes are not a serialised truth.
pub fn open(bytes: &[u8]) -> Result<Truth, String> {
    serde_json::from_slice(bytes).map_err(|error| error.to_string())
}

/// `work` of every index on `threads` threads, results in index order.
fn each<T: Send>(
    n: usize,
    threads: usize,
    work: &(dyn Fn(usize) -> T + Sync),
    done: &(dyn Fn(usize) + Sync),
) -> Vec<T> {
    let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let slots: Vec<Mutex<Option<T>>> = (0..n).map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, n.max(1)) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= n {
                        return;
                    }
                    let result = work(i);
                    *slots[i].lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(result);
                    done(finished.fetch_add(1, Ordering::Relaxed) + 1);
                }
            });
        }
    });
    let take = |slot: Mutex<Option<T>>| slot.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    slots.into_iter().map(|slot| take(slot).expect("every index was worked on before the scope ended")).collect()
}
