//! How much a diagnosis has computed, counted the same on every machine, so that its time is
//! bounded and its answer is not a matter of time.
//!
//! Counted are passes of the plant and likelihoods, by the size of the plant, the filter and the
//! recording; the unit is about a nanosecond of one core. What the search would do next is left
//! out, and said to be, where there is no room for as much as it cost last. Only code that runs
//! alone may ask: what threads have counted is the same in the end and not on the way.

use dynamics::system::System;
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a diagnosis may cost before it ends with what it has: about two minutes of one core with
/// what it then finishes.
pub const MOST: f64 = 1e11;
/// Of that, the most that the check of the channel metadata may cost.
pub const LABELS: f64 = 0.2 * MOST;
/// Evaluation of the equations of motion, for each state; of articulated bodies and of coordinates
/// apart.
const COST_ARTICULATED: f64 = 130.0;
const COST_DECOUPLED: f64 = 60.0;
/// An event of a recursion, and each of its products.
const COST_EVENT: f64 = 200.0;
const COST_PRODUCT: f64 = 0.5;

/// Count of one diagnosis.
#[derive(Debug)]
pub struct Work {
    most: f64,
    spent: AtomicU64,
    left_out: Mutex<BTreeSet<&'static str>>,
}

impl Default for Work {
    fn default() -> Self {
        Self::of(MOST)
    }
}

impl Work {
    /// A budget of `most` units of work (about nanoseconds of one core), none of them spent.
    pub fn of(most: f64) -> Self {
        Self { most, spent: AtomicU64::new(0), left_out: Mutex::default() }
    }

    /// Counts work as spent; threads may count at once, the sum does not depend on their order.
    pub fn add(&self, work: f64) {
        self.spent.fetch_add(work as u64, Ordering::Relaxed);
    }

    /// Work spent so far.
    pub fn spent(&self) -> f64 {
        self.spent.load(Ordering::Relaxed) as f64
    }

    /// There is room for so much more; else `what` is left out.
    pub fn allows(&self, more: f64, what: &'static str) -> bool {
        let allows = self.spent() + more <= self.most;
        if !allows {
            self.leave_out(what);
        }
        allows
    }

    /// What is spent once a share of what is left is.
    pub fn until(&self, share: f64) -> f64 {
        let spent = self.spent();
        spent + share * (self.most - spent).max(0.0)
    }

    /// How many of one `cost` there is room for; where for none, `what` is left out.
    pub fn pays_for(&self, cost: f64, what: &'static str) -> usize {
        let many = ((self.most - self.spent()) / cost.max(1.0)).max(0.0) as usize;
        if many == 0 {
            self.leave_out(what);
        }
        many
    }

    /// Notes work that the budget did not allow; the same note twice counts once.
    pub fn leave_out(&self, what: &'static str) {
        if let Ok(mut list) = self.left_out.lock() {
            list.insert(what);
        }
    }

    /// How many of one `cost` a share of all pays for.
    pub fn affords(&self, share: f64, cost: f64) -> f64 {
        share * self.most / cost.max(1.0)
    }

    /// The work that was left out, if any was.
    pub fn note(&self) -> Option<String> {
        let list = self.left_out.lock().ok()?;
        let all: Vec<&str> = list.iter().copied().collect();
        (!all.is_empty()).then(|| format!("to bound the work these were left out: {}", all.join("; ")))
    }
}

/// Of `evaluations` of the equations of motion.
pub fn of_evaluations(evaluations: usize, system: &System) -> f64 {
    let each = if system.is_apart() { COST_DECOUPLED } else { COST_ARTICULATED };
    evaluations as f64 * each * system.states().len().max(1) as f64
}

/// Of gains for a run and `columns` whitened by them: states, noise inputs, numbers of the filter,
/// events and samples.
pub fn of_whitening([n, m, z]: [usize; 3], [events, samples]: [usize; 2], columns: usize) -> f64 {
    let of_event = 2 * n * z * (n + m) + columns * n * (n + m);
    let of_sample = 2 * z * z + 2 * columns * z;
    events as f64 * (COST_EVENT + COST_PRODUCT * of_event as f64) + COST_PRODUCT * (samples * of_sample) as f64
}

/// Of all products of `columns` with each other.
pub fn of_products(samples: usize, columns: usize) -> f64 {
    COST_PRODUCT * (samples * columns * columns / 2) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_said_once_and_nothing_that_there_is_room_for() {
        let work = Work::of(100.0);
        work.add(40.0);
        assert!(work.allows(60.0, "a") && work.note().is_none() && work.affords(0.5, 10.0) == 5.0);
        work.add(20.0);
        assert!(
            !work.allows(60.0, "b") && !work.allows(50.0, "a") && !work.allows(60.0, "b") && work.allows(40.0, "c")
        );
        assert!(work.pays_for(20.0, "d") == 2 && work.pays_for(30.0, "d") == 1 && work.pays_for(41.0, "b") == 0);
        assert!((work.spent() - 60.0).abs() < 1e-9);
        assert_eq!(work.note().unwrap(), "to bound the work these were left out: a; b");
    }
}
