//! Planned work beside counted work: how much of the whole is done.
//!
//! A plan says at which count the present part ends and how much follows it. It is made anew as
//! parts become known. The share done never goes back, and is one at the end.

use std::sync::{Arc, Mutex, PoisonError};

/// What was planned at a count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plan {
    /// Work counted as the plan was made.
    pub at: f64,
    /// Count at which the present part ends.
    pub end: f64,
    /// Work planned after it.
    pub then: f64,
}

impl Plan {
    /// Work of the whole once `counted` is spent: the present part may cost more than was planned,
    /// and what follows it then costs more, too, by the root of that factor, half way between as
    /// planned and in proportion.
    #[must_use]
    pub fn whole(&self, counted: f64) -> f64 {
        let (planned, spent) = (self.end - self.at, counted - self.at);
        let more = if planned > 0.0 { (spent / planned).max(1.0).sqrt() } else { 1.0 };
        counted.max(self.end) + more * self.then
    }
}

/// The plans of a command, in their order. Clones are the same.
#[derive(Clone, Debug, Default)]
pub(super) struct Plans(Arc<Mutex<Vec<Plan>>>);

impl Plans {
    /// Plans at the count `at`: `now` for the present part, `then` after it.
    pub fn make(&self, at: f64, now: f64, then: f64) {
        let plan = Plan { at, end: at + now.max(0.0), then: then.max(0.0) };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(plan);
    }

    /// Plans at the count `at` what the present part still costs; what follows stays.
    pub fn renew(&self, at: f64, now: f64) {
        let then = self.last().then;
        self.make(at, now, then);
    }

    pub fn last(&self) -> Plan {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).last().copied().unwrap_or_default()
    }

    pub fn all(&self) -> Vec<Plan> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Share done as `counted` of a whole is spent, by all plans made until then: the largest share
/// that any of them gave.
#[must_use]
pub fn share_done(plans: &[Plan], counted: f64) -> f64 {
    let mut best = 0.0f64;
    for (k, plan) in plans.iter().enumerate().take_while(|(_, plan)| plan.at <= counted) {
        let until = plans.get(k + 1).map_or(counted, |next| next.at.min(counted));
        // behind the end of a part the share may fall before it grows
        for at in [plan.end.min(until), until] {
            let whole = plan.whole(at);
            best = best.max(if whole > 0.0 { at / whole } else { 0.0 });
        }
    }
    best.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_never_goes_back_and_a_part_that_costs_more_makes_what_follows_dearer() {
        let plans = Plans::default();
        plans.make(0.0, 10.0, 30.0);
        assert!((share_done(&plans.all(), 10.0) - 0.25).abs() < 1e-12);
        // twice as much for the first part: what follows costs the root of two times as much
        let over = 20.0 / (20.0 + 30.0 * 2.0f64.sqrt());
        assert!((share_done(&plans.all(), 20.0) - over).abs() < 1e-12);
        plans.make(20.0, 40.0, 60.0);
        assert!((share_done(&plans.all(), 30.0) - over).abs() < 1e-12, "a longer plan takes nothing back");
        plans.renew(60.0, 0.0);
        assert!((share_done(&plans.all(), 60.0) - 0.5).abs() < 1e-12);
        plans.make(120.0, 0.0, 0.0);
        assert!((share_done(&plans.all(), 120.0) - 1.0).abs() < 1e-12);
    }
}
