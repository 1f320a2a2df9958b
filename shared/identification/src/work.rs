//! How much a diagnosis has computed, counted the same on every machine, so that its time is
//! bounded and its answer is not a matter of time.
//!
//! Counted are passes of the plant and likelihoods, by the size of the plant, the filter and the
//! recording; the unit is about a nanosecond of one core. What the search would do next is left
//! out, and said to be, where there is no room for as much as it cost last. Only code that runs
//! alone may ask: what threads have counted is the same in the end and not on the way.
//!
//! A search ends at its limit; the fits that it has begun end beyond it, by [`OVERRUN`] at most.
//! Code on several threads has a [part](Work::part) of its own for each task, granted before they
//! begin.
//!
//! A [`Watch`] lets another thread see the count and stop the search: from then on there is no room
//! for anything, as if the limit were met.

mod outlook;

pub use outlook::{Plan, share_done};

use dynamics::system::System;
use outlook::Plans;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// What a diagnosis of normal effort may cost before it ends with what it has: 70 to 100 s of one
/// core, two minutes with what it then finishes.
pub const NORMAL_WORK: f64 = 2e11;
/// Work at which a fit ends wherever it is, in limits: half a limit for what a search finishes.
pub const OVERRUN: f64 = 1.5;
/// The least that a user can ask for: a fifth.
pub const QUICK_WORK: f64 = 0.2 * NORMAL_WORK;
/// Of all work, the most that the check of the channel metadata may cost.
pub const LABEL_CHECK_SHARE: f64 = 0.2;
/// The beginning of a note on what the limit did not allow, and of one on what an interruption did
/// not.
pub const LIMIT_NOTE: &str = "to bound the work these were left out: ";
const FIT_STEPS: &str = "the last steps of fits";
const STOPPED_NOTE: &str = "for the interruption these were left out: ";
/// Evaluation of the equations of motion, for each state; of articulated bodies and of coordinates
/// apart.
const COST_ARTICULATED: f64 = 130.0;
const COST_DECOUPLED: f64 = 60.0;
/// An event of a recursion, and each of its products.
const COST_EVENT: f64 = 200.0;
const COST_PRODUCT: f64 = 0.5;

/// How another thread sees several counts go on, and stops them. Clones are the same watch.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    counted: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    plans: Plans,
}

impl Watch {
    /// A watch that stops its counts once `stop` is set.
    pub fn stopped_by(stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..Self::default() }
    }

    /// What all its counts have spent, together.
    pub fn counted(&self) -> f64 {
        self.counted.load(Ordering::Relaxed) as f64
    }

    /// Plans `now` more work for the part that is being done, and `then` after it.
    pub fn plan(&self, now: f64, then: f64) {
        self.plans.make(self.counted(), now, then);
    }

    /// Plans `now` more work for the part that is being done; what follows it stays.
    pub fn plan_now(&self, now: f64) {
        self.plans.renew(self.counted(), now);
    }

    /// Everything that was planned so far, in order.
    pub fn plans(&self) -> Vec<Plan> {
        self.plans.all()
    }

    /// Share of the planned work that is done; it never goes back.
    pub fn share(&self) -> f64 {
        share_done(&self.plans(), self.counted())
    }

    /// Share of the planned work that is done by the last plan alone.
    pub fn outlook(&self) -> f64 {
        let counted = self.counted();
        let whole = self.plans.last().whole(counted);
        if whole > 0.0 { (counted / whole).min(1.0) } else { 0.0 }
    }

    /// Its counts have no room any more.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Count of one diagnosis.
#[derive(Debug)]
pub struct Work {
    most: f64,
    /// At which fits end.
    end: f64,
    /// Counts what this one does.
    whole: Option<Arc<Work>>,
    spent: AtomicU64,
    watch: Watch,
    left_out: Mutex<BTreeSet<&'static str>>,
}

impl Default for Work {
    fn default() -> Self {
        Self::of(NORMAL_WORK)
    }
}

impl Work {
    /// A budget of `most` units of work (about nanoseconds of one core), none of them spent.
    pub fn of(most: f64) -> Self {
        Self::watched(most, Watch::default())
    }

    /// As [`Work::of`], seen and stopped by `watch`.
    pub fn watched(most: f64, watch: Watch) -> Self {
        let (spent, left_out) = (AtomicU64::new(0), Mutex::default());
        Self { most, end: OVERRUN * most, whole: None, spent, watch, left_out }
    }

    /// Fits end as under a limit of `most` at least, however little the search may cost.
    #[must_use]
    pub fn with_fits_of(self, most: f64) -> Self {
        Self { end: self.end.max(OVERRUN * most), ..self }
    }

    /// A task of `whole` that has a share of all that is left; counted and noted there, too.
    pub fn part(whole: &Arc<Self>, share: f64) -> Arc<Self> {
        let left = |end: f64| share * (end - whole.spent()).max(0.0);
        let (most, end) = (left(whole.most()), left(whole.end));
        let own = Self { end, whole: Some(whole.clone()), ..Self::watched(most, whole.watch.clone()) };
        Arc::new(own)
    }

    /// Plans `now` more for the part that is being done, within what fits may still cost, and
    /// `then` after it.
    pub fn plan(&self, now: f64, then: f64) {
        self.watch.plan(now.min((self.end - self.spent()).max(0.0)), then);
    }

    /// Plans `now` more for the part that is being done; what follows it stays.
    pub fn plan_now(&self, now: f64) {
        self.watch.plan_now(now.min((self.end - self.spent()).max(0.0)));
    }

    /// Share of the planned work that is done.
    pub fn share_planned(&self) -> f64 {
        self.watch.share()
    }

    /// Work that is seen with this one's, by a limit of its own: what it costs leaves nothing out
    /// here, and no interruption ends it.
    #[must_use]
    pub fn beside(&self) -> Arc<Self> {
        let watch = Watch { stop: Arc::default(), ..self.watch.clone() };
        Arc::new(Self::watched(NORMAL_WORK, watch))
    }

    /// Counts work as spent; threads may count at once, the sum does not depend on their order.
    pub fn add(&self, work: f64) {
        self.spent.fetch_add(work as u64, Ordering::Relaxed);
        match &self.whole {
            Some(whole) => whole.add(work),
            None => _ = self.watch.counted.fetch_add(work as u64, Ordering::Relaxed),
        }
    }

    /// A fit may go on for so much more; else its further steps are left out.
    pub fn allows_step(&self, more: f64) -> bool {
        let allows = self.spent() + more <= self.end;
        if !allows {
            self.leave_out(FIT_STEPS);
        }
        allows
    }

    /// The budget; none once the watch has stopped it.
    fn most(&self) -> f64 {
        if self.is_stopped() { 0.0 } else { self.most }
    }

    /// The watch has stopped it: nothing more is to be begun.
    pub fn is_stopped(&self) -> bool {
        self.watch.is_stopped()
    }

    /// It is not stopped; else `what` is left out.
    pub fn goes_on(&self, what: &'static str) -> bool {
        let goes_on = !self.is_stopped();
        if !goes_on {
            self.leave_out(what);
        }
        goes_on
    }

    /// Work spent so far.
    pub fn spent(&self) -> f64 {
        self.spent.load(Ordering::Relaxed) as f64
    }

    /// There is room for so much more; else `what` is left out.
    pub fn allows(&self, more: f64, what: &'static str) -> bool {
        let allows = self.spent() + more <= self.most();
        if !allows {
            self.leave_out(what);
        }
        allows
    }

    /// What is spent once a share of what is left is.
    pub fn until(&self, share: f64) -> f64 {
        let spent = self.spent();
        spent + share * (self.most() - spent).max(0.0)
    }

    /// Notes work that the budget did not allow; the same note twice counts once.
    pub fn leave_out(&self, what: &'static str) {
        if let Ok(mut list) = self.left_out.lock() {
            list.insert(what);
        }
        if let Some(whole) = &self.whole {
            whole.leave_out(what);
        }
    }

    /// How many of one `cost` a share of all pays for; of a part's, a share of the whole.
    pub fn affords(&self, share: f64, cost: f64) -> f64 {
        self.whole.as_ref().map_or_else(|| share * self.most() / cost.max(1.0), |whole| whole.affords(share, cost))
    }

    /// The work that was left out, if any was.
    pub fn note(&self) -> Option<String> {
        let list = self.left_out.lock().ok()?;
        let all: Vec<&str> = list.iter().copied().collect();
        let why = if self.is_stopped() { STOPPED_NOTE } else { LIMIT_NOTE };
        (!all.is_empty()).then(|| format!("{why}{}", all.join("; ")))
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
        assert!((work.spent() - 60.0).abs() < 1e-9);
        assert_eq!(work.note().unwrap(), "to bound the work these were left out: a; b");
    }

    #[test]
    fn a_part_ends_at_its_share_of_what_is_left_and_the_whole_counts_it() {
        let whole = Arc::new(Work::of(100.0));
        whole.add(50.0);
        let part = Work::part(&whole, 0.5);
        part.add(20.0);
        assert!(part.allows(5.0, "a") && !part.allows(6.0, "b") && (whole.spent() - 70.0).abs() < 1e-9);
        // half of what is left to the end at one and a half limits
        assert!(part.allows_step(30.0) && !part.allows_step(31.0) && whole.allows_step(80.0));
        assert_eq!(whole.note().unwrap(), "to bound the work these were left out: b; the last steps of fits");
    }

    #[test]
    fn a_stopped_count_has_no_room_and_its_watch_sees_what_all_counts_spend() {
        let stop = Arc::new(AtomicBool::new(false));
        let watch = Watch::stopped_by(stop.clone());
        let (one, other) = (Work::watched(100.0, watch.clone()), Work::watched(10.0, watch.clone()));
        one.add(40.0);
        other.add(5.0);
        assert!((one.spent() - 40.0).abs() < 1e-9 && (watch.counted() - 45.0).abs() < 1e-9);
        assert!(one.allows(60.0, "a") && one.goes_on("a") && !watch.is_stopped());
        stop.store(true, Ordering::Relaxed);
        assert!(!one.allows(0.0, "a") && !one.goes_on("b"));
        assert!((one.until(1.0) - 40.0).abs() < 1e-9 && one.affords(1.0, 1.0) == 0.0);
        assert_eq!(one.note().unwrap(), "for the interruption these were left out: a; b");
        assert!(other.is_stopped() && other.note().is_none());
    }
}
