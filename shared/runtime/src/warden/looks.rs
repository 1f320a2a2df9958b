//! What a process had waited and run when it was looked at: the begin of a silence is before it.

use crate::usage::Usage;
use std::time::Instant;

/// One look; before the first the process had done nothing.
#[derive(Clone, Copy)]
struct Look {
    at: Instant,
    wait_s: f64,
    run_s: f64,
}

/// The last two looks at a process: of a silence shorter than the time between two, one of them is
/// before it.
#[derive(Default)]
pub(super) struct Looks([Option<Look>; 2]);

impl Looks {
    pub fn note(&mut self, at: Instant, usage: &Usage) {
        self.0 = [self.0[1], Some(Look { at, wait_s: usage.wait_s, run_s: usage.run_s })];
    }

    /// Waiting and running time at the newest look that is not later than `since` \[s\]. A later
    /// one would hide what the process has waited since then; of a silence that is longer than both
    /// looks go back, the older look serves: what was waited in a whole life excuses no hang.
    pub fn before(&self, since: Option<Instant>) -> (f64, f64) {
        let is_before = |look: &&Look| since.is_some_and(|since| look.at <= since);
        let look = self.0.iter().flatten().rfind(is_before).or(self.0[0].as_ref());
        look.map_or((0.0, 0.0), |look| (look.wait_s, look.run_s))
    }
}

#[cfg(test)]
mod tests {
    use super::Looks;
    use crate::usage::Usage;
    use std::time::{Duration, Instant};

    #[test]
    fn a_look_within_a_silence_does_not_hide_what_was_waited_before_it() {
        let begin = Instant::now();
        let at = |ms| begin + Duration::from_millis(ms);
        let usage = |wait_s| Usage { wait_s, run_s: 0.1, ..Usage::default() };
        let mut looks = Looks::default();
        assert_eq!(looks.before(Some(at(500))), (0.0, 0.0), "none before the first look");
        looks.note(at(1000), &usage(0.2));
        // Silent since 1850 ms; looked at again at 1990 ms, when it had waited for 130 ms of that.
        looks.note(at(1990), &usage(0.35));
        assert_eq!(looks.before(Some(at(1850))), (0.2, 0.1));
        assert_eq!(looks.before(Some(at(1990))), (0.35, 0.1));
        assert_eq!(looks.before(Some(at(900))), (0.2, 0.1), "what it waited before the silence excuses no hang");
    }
}
