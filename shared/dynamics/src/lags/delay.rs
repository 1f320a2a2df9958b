//! A pure delay of commands that are held over a control period.
//!
//! A delay of `n` periods and a fraction f leaves two pieces in every period: until f the command
//! of n + 1 periods ago, then that of n periods ago.

use serde::{Deserialize, Serialize};

/// A delay as whole periods and a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldDelay {
    periods: usize,
    fraction_s: f64,
}

/// Past commands, a ring; zero before the first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldDelayState {
    past: Vec<f64>,
    newest: usize,
}

impl HeldDelay {
    /// Delay by `delay_s` of commands held for `period_s`; less than 1 ns beside an edge is the
    /// edge.
    pub fn new(delay_s: f64, period_s: f64) -> Self {
        assert!(delay_s >= 0.0 && delay_s.is_finite());
        assert!(period_s > 0.0 && period_s.is_finite());
        const EDGE_S: f64 = 1e-9;
        let periods = libm::floor((delay_s + EDGE_S) / period_s);
        let rest = delay_s - periods * period_s;
        Self { periods: periods as usize, fraction_s: if rest < EDGE_S { 0.0 } else { rest } }
    }

    /// Time after the beginning of each period at which the acting value changes; `None`: at the
    /// beginning.
    pub fn switch_s(&self) -> Option<f64> {
        (self.fraction_s > 0.0).then_some(self.fraction_s)
    }

    /// Nothing commanded yet; takes the memory that the delay needs.
    pub fn start(&self) -> HeldDelayState {
        HeldDelayState { past: vec![0.0; self.periods + 2], newest: 0 }
    }

    /// Takes the command of a new period.
    pub fn push(&self, state: &mut HeldDelayState, command: f64) {
        state.newest = if state.newest + 1 == state.past.len() { 0 } else { state.newest + 1 };
        state.past[state.newest] = command;
    }

    /// The output of the delay `since_s` after the beginning of the period of the newest command.
    pub fn at(&self, state: &HeldDelayState, since_s: f64) -> f64 {
        let age = self.periods + usize::from(since_s < self.fraction_s);
        let before = if age > state.newest { state.newest + state.past.len() } else { state.newest };
        state.past[before - age]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delayed_staircase_is_the_staircase_of_an_earlier_time() {
        let period = 0.01;
        for delay in [0.0, 0.003, 0.01, 0.0275, 0.03] {
            let filter = HeldDelay::new(delay, period);
            let mut state = filter.start();
            for k in 0..20u32 {
                filter.push(&mut state, f64::from(k + 1));
                for since in [0.0, 0.002, 0.0031, 0.0074, 0.0076, 0.0099] {
                    let earlier = ((f64::from(k) * period + since - delay) / period + 1e-7).floor();
                    assert_eq!(
                        filter.at(&state, since),
                        (earlier + 1.0).max(0.0),
                        "delay {delay}, period {k}, {since}"
                    );
                }
            }
        }
    }

    #[test]
    fn whole_periods_need_no_split() {
        assert_eq!(HeldDelay::new(0.03, 0.01).switch_s(), None);
        assert!((HeldDelay::new(0.0275, 0.01).switch_s().unwrap() - 0.0075).abs() < 1e-15);
    }
}
